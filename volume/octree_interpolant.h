// How an octree's cell is filled in between its corners: linear, or cubic with derivatives.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/grid_space.h"

#include <array>
#include <span>

namespace isocast {

/// What a node of an octree holds.
enum class OctreeFilter {
    Linear, // the value
    Cubic   // the value and its derivatives f fx fy fxy fz fxz fyz fxyz
};

/// Floats a node. Derivative i is by x if bit 0 of i is set, by y if bit 1, by z if bit 2; by index
/// coordinates [world / finest cell, to that power].
constexpr int components_of(OctreeFilter filter) {
    return filter == OctreeFilter::Linear ? 1 : 8;
}

/// The eight corners of a cell, corner i at the upper end of x if bit 0 is set, …
/// data  components_of(filter) floats each
using CornerData = std::array<const float*, 8>;

/// Value in a cell of edge `size` [finest cells], at `t` in [0, 1]^3 of the cell.
///
/// Linear: trilinear. Cubic: the tensor product of Hermite's cubics, which has continuous first
/// derivatives, over cells of several sizes too if hanging nodes hold what `midpoint` says.
float interpolate(OctreeFilter filter, const CornerData& corners, double size, const Vec3d& t);

/// The interpolant along a line through a cell, parallel to x: linear, or a cubic of Hermite.
struct CellRow {
    double f0, f1;         // at both ends
    double slope0, slope1; // [per edge]; 0 in linear cells

    /// x  in [0, 1] of the cell
    float linear_at(double x) const { return static_cast<float>((1 - x) * f0 + x * f1); }
    float cubic_at(double x) const {
        const double u = 1 - x;
        return static_cast<float>(u * u * (1 + 2 * x) * f0 + x * x * (3 - 2 * x) * f1 +
                                  x * u * (u * slope0 - x * slope1));
    }
};
CellRow row_of(OctreeFilter filter, const CornerData& corners, double size, double y, double z);

/// What a node half way between two others holds if it hangs, that is, if a cell that is not
/// divided has the three of them on an edge. The middle of a face is half way between two such
/// nodes. `a`, `b` and `out` hold components_of(filter) floats.
///
/// axis    of the edge
/// length  from a to b [finest cells]
void midpoint(OctreeFilter filter, std::span<const float> a, std::span<const float> b, int axis,
              double length, std::span<float> out);

} // namespace isocast
