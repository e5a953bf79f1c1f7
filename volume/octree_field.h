// An octree as a field source: samples at any level, without a dense grid.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/field_source.h"
#include "volume/hashed_octree.h"

namespace isocast {

/// The interpolant of an octree at the corners of its finest cells, within a band: values are
/// clamped to ± its half width.
class OctreeField final : public FieldSource {
public:
    /// half_width_world  > 0
    OctreeField(HashedOctree tree, GridSpace space, double half_width_world);

    const HashedOctree& tree() const { return tree_; }
    const GridSpace& space() const override { return space_; }
    IndexBox extent() const override;
    std::optional<double> half_width_world() const override { return half_width_world_; }
    /// The leaves that hold a sample within the band.
    std::vector<IndexBox> active_boxes() const override;
    int finest_level(const IndexBox& box) const override;
    ValueRange value_range(const IndexBox& box) const override;
    void copy_box(const IndexBox& box, int level, std::span<float> out) const override;

private:
    HashedOctree tree_;
    GridSpace space_;
    double half_width_world_;
};

} // namespace isocast
