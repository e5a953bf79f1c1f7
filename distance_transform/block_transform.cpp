// Exact signed distances at the samples of one block, from the triangles that the kernel finds.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/block_transform.h"

#include "distance_transform/block_signs.h"

#include <bit>

namespace isocast {

namespace {

/// The band's border [voxels] is this much wider than asked, far above rounding: samples exactly on
/// it are all active, and the neighbours of an inactive sample are surely not on the surface.
constexpr double border_slack = 1e-9;

} // namespace

std::int64_t BlockTransform::run(FieldBlock& block, std::span<const int> triangles,
                                 DescentWorkspace& workspace) const {
    const Vec3d origin = block_size * block.coordinate.cast<double>();
    const DescentInput input{.frames = frames_.data(),
                             .candidates = triangles.data(),
                             .candidate_count = static_cast<int>(triangles.size()),
                             .first_sample = {origin.x(), origin.y(), origin.z()},
                             .half_width = half_width_ + border_slack};
    DescentOutput nearest;
    const std::int64_t evaluations = kernels_.descend(input, workspace, nearest);
    BlockBits rows;
    kernels_.finish(nearest, half_width_, voxel_size_, block.values.data(), rows);

    SampleBits active = bits_of_rows(rows.active);
    SampleBits negative = bits_of_rows(rows.negative);
    if (const auto* normals = std::get_if<Pseudonormals>(&sign_)) {
        for_each_bit(bits_of_rows(rows.unsure), [&](int i) {
            const Vec3d point = origin + sample_of(i).cast<double>();
            const int triangle = triangles[nearest.triangle[i]];
            const LocalClosest closest = closest_feature(frames_[triangle], point);
            if (closest.offset.dot(normals->at(triangle, closest.feature)) < 0)
                negative.set(i);
        });
    } else {
        const auto& winding = std::get<WindingNumber>(sign_);
        negative = winding_signs(block.values, active, voxel_size_, winding, origin);
    }
    spread(active, negative);
    apply_signs(block, active, negative, static_cast<float>(voxel_size_ * half_width_));
    return evaluations;
}

} // namespace isocast
