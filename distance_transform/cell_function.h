// What an octree's cell makes of its corners, with bounds on how it can change inside.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/cell_bounds.h"

namespace isocast {

/// What a node holds; of a linear one the value alone.
using NodeData = std::array<float, 8>;

/// The interpolant in one cell.
class CellFunction {
public:
    /// lo, size  of the cell [finest cells]
    /// corners   must outlive this
    CellFunction(OctreeFilter filter, const Vec3d& lo, double size,
                 const std::array<NodeData, 8>& corners)
        : filter_(filter), lo_(lo), size_(size) {
        for (std::size_t i = 0; i < 8; ++i) corners_[i] = corners[i].data();
        bounds_ = bounds_of(filter, corners_, size);
    }

    double at(const Vec3d& p) const {
        return interpolate(filter_, corners_, size_, (p - lo_) / size_);
    }
    const CellBounds& bounds() const { return bounds_; }

private:
    OctreeFilter filter_;
    Vec3d lo_;
    double size_;
    CornerData corners_;
    CellBounds bounds_;
};

} // namespace isocast
