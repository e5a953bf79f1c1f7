// From mesh to adaptive distance field: lattice, signs, octree.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/convert_adaptive.h"

#include "distance_transform/lattice.h"
#include "distance_transform/mesh_distance.h"
#include "distance_transform/sign_choice.h"
#include "volume/available_memory.h"
#include "volume/errors.h"
#include "volume/sparse_field.h"
#include "volume/stopwatch.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

namespace isocast {

namespace {

/// Along the mesh, of the band that tells whether normals contradict each other: fine enough to
/// take a tenth of a second.
constexpr double band_voxels = 128;

double finest_cell_world(const AdaptiveConvertOptions& options) {
    const auto is_length = [](double x) { return x > 0 && std::isfinite(x); };
    if (options.max_error_world && !is_length(*options.max_error_world))
        throw InputError(
            fmt::format("a greatest error of {} is not a length", *options.max_error_world));
    if (options.voxel_size_world) require_voxel_size(*options.voxel_size_world);
    if (!(options.accurate_within_world >= 0 && std::isfinite(options.accurate_within_world)))
        throw InputError(fmt::format("a width of {} within which the error is kept is not a length",
                                     options.accurate_within_world));
    if (options.voxel_size_world) return *options.voxel_size_world;
    if (!options.max_error_world)
        throw InputError("an adaptive field needs a greatest error or a voxel size");
    return 2 / std::numbers::sqrt3 * *options.max_error_world;
}

} // namespace

AdaptiveConvertResult convert_adaptive(const CheckedMesh& input,
                                       const AdaptiveConvertOptions& options,
                                       const Progress& progress) {
    const Stopwatch time;
    const double cell = finest_cell_world(options);
    const double margin = std::ceil(options.accurate_within_world / cell) + 2;
    const double longest = bounding_box(input.mesh).size().maxCoeff();
    const double across = longest / cell + 2 * margin;
    if (!(across <= 1 << greatest_octree_depth))
        throw ResourceError(fmt::format("{:.3g} cells of {:.3g} across the mesh are more than the "
                                        "{} that an octree can have",
                                        across, cell, 1 << greatest_octree_depth));
    // One more for the root's corner, which lies on the lattice.
    const int depth =
        static_cast<int>(std::bit_width(static_cast<unsigned>(std::ceil(across + 1)) - 1));
    SignChoice sign = sign_by_band(input, options.sign, std::max(cell, longest / band_voxels),
                                   options.memory_bytes, progress);
    if (sign.method == SignMethod::Unsigned)
        throw InputError(
            fmt::format("an adaptive field needs signs, and {}",
                        options.sign == SignMethod::Auto ? sign.reason : "none were asked for"));
    LatticeMesh lattice = on_lattice(input.mesh, cell, margin);
    const Vec3d middle = (lattice.box.min + lattice.box.max) / 2;
    const Index3 lo = (middle.array() - (1 << depth) / 2.0).floor().cast<int>().matrix();
    for (Vec3d& vertex : lattice.mesh.vertices_world) vertex -= lo.cast<double>();

    std::optional<WindingNumber> winding;
    if (sign.method == SignMethod::Winding)
        winding.emplace(lattice.mesh, input.verdict.is_closed() && input.verdict.is_oriented());
    const MeshDistance distance(lattice.mesh, input.topology, winding ? &*winding : nullptr);
    const double prepare_seconds = time.seconds();
    AdaptiveOptions built{.depth = depth,
                          .filter = options.filter,
                          .accurate_within_cells = options.accurate_within_world / cell,
                          .memory_bytes = std::min(options.memory_bytes, available_memory_bytes())};
    built.max_error_cells =
        options.max_error_world ? std::optional(*options.max_error_world / cell) : std::nullopt;
    // A distance changes no faster than its argument: half a cell's diagonal.
    if (options.max_error_world &&
        std::numbers::sqrt3 / 2 * cell > 1.001 * *options.max_error_world)
        sign.warnings.push_back(
            fmt::format("Finest cells of {:.4g} can err by {:.4g}, which is more than {:.4g}.",
                        cell, std::numbers::sqrt3 / 2 * cell, *options.max_error_world));
    HashedOctree tree = build_adaptive(distance, built, progress);
    for (HashedOctree::NodeNumber node = 0; node < tree.node_count(); ++node)
        for (float& value : tree.data_of(node)) value = static_cast<float>(value * cell);
    GridSpace space = lattice.space;
    space.world_from_index.translate((lattice.anchor + lo).cast<double>());
    return {.tree = std::move(tree),
            .space = space,
            .sign_used = sign.method,
            .sign_reason = std::move(sign.reason),
            .prepare_seconds = prepare_seconds,
            .transform_seconds = time.seconds() - prepare_seconds,
            .warnings = std::move(sign.warnings)};
}

} // namespace isocast
