// Scan conversion of convex polyhedra: which samples of a block lie inside.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/mesh.h"
#include "volume/sparse_field.h"

#include <span>
#include <vector>

namespace isocast {

/// The points with normal · p <= offset, in voxels.
struct HalfSpace {
    Vec3d normal; // unit, outward
    double offset;
};

/// Half-spaces are wider by this [voxels], so that polyhedra that touch leave no sample between
/// them: far above rounding for coordinates below 2^17 voxels (1e-11), and the greatest error of
/// the distance to a plane or a line of a sample that the slack lets in.
inline constexpr double scan_slack = 1e-9;

/// Samples first.x() + begin … first.x() + end - 1 of a row; none if end <= begin.
struct RowInterval {
    int begin;
    int end;
};

/// The samples first + (i, 0, 0), 0 <= i < count, inside all half-spaces, scan_slack allowed.
RowInterval clip_row(std::span<const HalfSpace> polyhedron, const Index3& first, int count);

/// The blocks [block coordinates] that hold samples of `box`, less those that lie outside one of
/// the half-spaces.
std::vector<Index3> blocks_meeting(std::span<const HalfSpace> polyhedron, const WorldBox& box);

/// Calls at_sample(index, i) for each sample of `block` inside the polyhedron, i being its place in
/// the block.
template<class AtSample>
void scan_block(std::span<const HalfSpace> polyhedron, const Index3& block,
                const AtSample& at_sample) {
    for (int z = 0; z < block_size; ++z) {
        for (int y = 0; y < block_size; ++y) {
            const Index3 first = block_size * block + Index3(0, y, z);
            const auto [begin, end] = clip_row(polyhedron, first, block_size);
            for (int x = begin; x < end; ++x)
                at_sample(Index3(first + Index3(x, 0, 0)), x + block_size * (y + block_size * z));
        }
    }
}

} // namespace isocast
