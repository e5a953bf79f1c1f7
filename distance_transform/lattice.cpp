// The lattice of samples, and the mesh measured in its voxels.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/lattice.h"

#include "volume/errors.h"
#include "volume/sparse_field.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <cmath>

namespace isocast {

LatticeMesh on_lattice(const Mesh& mesh, double voxel_size_world, double half_width_voxels) {
    const WorldBox box = bounding_box(mesh);
    LatticeMesh result;
    Vec3d translation_world = Vec3d::Zero();
    for (int k = 0; k < 3; ++k) {
        const double middle = (box.min[k] + box.size()[k] / 2) / voxel_size_world;
        const double reach = box.size()[k] / voxel_size_world / 2 + half_width_voxels +
                             2 * block_size; // blocks that stick out, and the anchor's rounding
        if (!(reach < greatest_index))
            throw ResourceError(
                fmt::format("voxel size {} is too small: the mesh would span {:.3g} voxels",
                            voxel_size_world, 2 * reach));
        // Beyond 2^53 voxels neighbouring samples are the same double.
        if (!(std::abs(middle) + reach < 0x1p53))
            throw InputError(fmt::format(
                "voxel size {} is too small for a mesh that lies {:.3g} from the origin: double "
                "precision cannot tell its voxels apart",
                voxel_size_world, std::abs(middle) * voxel_size_world));
        const bool is_far = std::abs(middle) + reach > greatest_index;
        const double shift = is_far ? std::floor(middle) : 0;
        translation_world[k] = shift * voxel_size_world;
        result.anchor[k] = block_size * static_cast<int>(std::floor((middle - shift) / block_size));
    }
    result.space = GridSpace::uniform(voxel_size_world, translation_world);

    const Vec3d anchor_world = result.space.to_world(result.anchor.cast<double>());
    const auto in_voxels = [&](const Vec3d& p_world) -> Vec3d {
        return (p_world - anchor_world) / voxel_size_world;
    };
    result.mesh.triangles = mesh.triangles;
    result.mesh.vertices_world.resize(mesh.vertices_world.size());
    tbb::parallel_for(std::size_t{0}, mesh.vertices_world.size(), [&](std::size_t v) {
        result.mesh.vertices_world[v] = in_voxels(mesh.vertices_world[v]);
    });
    // Rounding keeps the order of coordinates, so that this is the box of the rounded vertices.
    result.box = {in_voxels(box.min), in_voxels(box.max)};
    return result;
}

} // namespace isocast
