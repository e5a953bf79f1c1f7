// Exact signed distances at the samples of one block, by scan conversion of its sites.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/block_transform.h"

#include "distance_transform/block_signs.h"

namespace isocast {

namespace {

/// The point of a site that is nearest to a sample in its region.
Vec3d point_of(const SiteArrays& sites, std::int32_t site, const Vec3d& p) {
    using Vector = Eigen::Map<const Vec3d>;
    if (site < sites.face_count) {
        const FaceSite& face = sites.faces[site];
        const Vector normal(face.t);
        return p - normal.dot(p - Vector(face.origin)) * normal;
    }
    if (site < sites.face_count + sites.edge_count) {
        const EdgeSite& edge = sites.edges[site - sites.face_count];
        const Vector along(edge.e);
        return Vector(edge.origin) + along.dot(p - Vector(edge.origin)) * along;
    }
    return Vector(sites.vertices[site - sites.face_count - sites.edge_count].origin);
}

} // namespace

std::int64_t BlockTransform::run(FieldBlock& block, std::span<const std::int32_t> list,
                                 ClosestBlock* closest) const {
    const Vec3d origin = block_size * block.coordinate.cast<double>();
    const ScanInput input{.sites = &sites_,
                          .list = list.data(),
                          .count = static_cast<std::int32_t>(list.size()),
                          .first_sample = {origin.x(), origin.y(), origin.z()},
                          .half_width = half_width_,
                          .scale = voxel_size_,
                          .with_sites = closest != nullptr};
    ScanOutput scanned;
    const std::int64_t evaluations = scan_(input, scanned);
    std::ranges::copy(scanned.distance, block.values.begin());
    const SampleBits active = bits_of_rows(scanned.active);
    SampleBits negative;
    if (signs_.is_signed) {
        negative = signs_.winding
                       ? winding_signs(block.values, active, voxel_size_, *signs_.winding, origin)
                       : bits_of_rows(scanned.negative);
        spread(active, negative);
    }
    apply_signs(block, active, negative, static_cast<float>(voxel_size_ * half_width_));
    if (closest) find_closest(origin, scanned, *closest);
    return evaluations;
}

void BlockTransform::find_closest(const Vec3d& origin, const ScanOutput& scanned,
                                  ClosestBlock& closest) const {
    closest.offset_world.fill(Eigen::Vector3f::Zero());
    closest.feature.fill(-1);
    for_each_bit(bits_of_rows(scanned.active), [&](int i) {
        const Vec3d p = origin + sample_of(i).cast<double>();
        closest.offset_world[i] =
            (voxel_size_ * (point_of(sites_, scanned.site[i], p) - p)).cast<float>();
        const std::int32_t before_vertices = sites_.face_count + sites_.edge_count;
        const std::int32_t site = scanned.site[i];
        closest.feature[i] = site < before_vertices
                                 ? site
                                 : before_vertices + sites_.vertices[site - before_vertices].number;
    });
}

} // namespace isocast
