// SPDX-License-Identifier: MPL-2.0
#include "apps/octree_output.h"

#include "apps/console.h"
#include "apps/parsed_option.h"
#include "volume/errors.h"
#include "volume/files.h"
#include "volume/octree_band.h"
#include "volume/octree_file.h"

#include <fmt/format.h>

namespace isocast {

namespace {

/// A dry run builds an octree for so many times the error: where a surface is smooth, cells grow
/// with the root of the error, and their number falls as it grows.
constexpr double dry_run_share = 4;

std::int64_t write_grids(const std::shared_ptr<const HashedOctree>& tree, const GridSpace& space,
                         OctreeGrids grids, double half_width_voxels,
                         const std::map<std::string, std::string>& metadata,
                         const std::filesystem::path& path, const Progress& progress) {
    std::int64_t active_voxels = 0;
    const auto band = [&](int level) {
        SparseField field = band_of_octree(tree, space, level, half_width_voxels, progress);
        active_voxels += field.active_voxel_count();
        return field;
    };
    if (grids == OctreeGrids::Finest) {
        write_vdb(band(0), path, metadata);
    } else {
        // Beyond these a level has no block of its own.
        const int count = std::max(tree->depth() - 2, 1);
        write_vdb_levels(band, count, path, metadata);
    }
    return active_voxels;
}

std::size_t free_node_count(const HashedOctree& tree) {
    std::size_t count = 0;
    for (HashedOctree::NodeNumber node = 0; node < tree.node_count(); ++node)
        count += tree.is_constrained(node) ? 0 : 1;
    return count;
}

} // namespace

void add_octree_options(CLI::App& app, OctreeCommand& command) {
    add_choice<OctreeFilter>(
        app, "--interpolation", command.filter,
        {{"linear", OctreeFilter::Linear}, {"cubic", OctreeFilter::Cubic}},
        "Of --method octree: linear (default), or cubic, for smooth surfaces; else what "
        "--max-error is kept with: cubic (default), as pictures are, or linear")
        ->type_name("KIND");
    add_choice<OctreeGrids>(
        app, "--grids", command.grids,
        {{"finest", OctreeGrids::Finest}, {"levels", OctreeGrids::Levels}},
        "Of an octree to .vdb: a band of the finest cells (default), or one for each level")
        ->type_name("WHICH");
}

void convert_to_octree(const OctreeCommand& command, const CheckedMesh& mesh,
                       const std::optional<double>& max_error_world,
                       const std::optional<double>& voxel_size_world, double accurate_within_world,
                       bool is_dry_run, ConvertReport& report, const Progress& progress) {
    const double longest = bounding_box(mesh.mesh).size().maxCoeff();
    AdaptiveConvertOptions options{
        .max_error_world = max_error_world.value_or(longest / 1000),
        .voxel_size_world = voxel_size_world,
        .accurate_within_world = accurate_within_world,
        .filter = command.filter.value_or(OctreeFilter::Linear),
        .sign = report.options.sign,
        .memory_bytes = report.options.memory_bytes,
    };
    if (is_dry_run) {
        *options.max_error_world *= dry_run_share;
        if (voxel_size_world) *options.voxel_size_world *= dry_run_share;
    }
    Stopwatch step;
    AdaptiveConvertResult result = convert_adaptive(mesh, options, progress);
    const double share = is_dry_run ? dry_run_share : 1;
    report.take(result.sign_used, result.sign_reason, result.warnings);
    const auto tree = std::make_shared<const HashedOctree>(std::move(result.tree));
    report.octree = {.max_error_world = *options.max_error_world / share,
                     .finest_cell_world = result.space.voxel_size_world() / share,
                     .depth = tree->depth(),
                     .cells = share * static_cast<double>(tree->cell_count()),
                     .nodes = share * static_cast<double>(tree->node_count()),
                     .free_nodes = share * static_cast<double>(free_node_count(*tree)),
                     .bytes = share * static_cast<double>(tree->memory_bytes()),
                     .filter = options.filter,
                     .is_estimate = is_dry_run};
    report.seconds.prepare = result.prepare_seconds;
    report.seconds.transform = share * result.transform_seconds;
    if (is_dry_run) return;
    step.lap();
    progress("writing", 0);
    const std::map<std::string, std::string> metadata = {
        {"creator", "isocast " ISOCAST_VERSION},
        {"source", std::filesystem::path(report.input).filename().string()},
        {"sign_method", std::string(name_of(report.sign))},
        {"max_error", fmt::format("{}", *options.max_error_world)}};
    if (is_octree_file(report.output))
        write_octree(*tree, result.space, metadata, report.output);
    else
        report.active_voxels =
            write_grids(tree, result.space, command.grids, report.options.half_width_voxels,
                        metadata, report.output, progress);
    report.seconds.write = step.lap();
}

std::int64_t export_octree(const std::filesystem::path& from, const std::filesystem::path& to,
                           OctreeGrids grids, double half_width_voxels, const Progress& progress) {
    OctreeFile file = read_octree(from);
    return write_grids(std::make_shared<const HashedOctree>(std::move(file.tree)), file.space,
                       grids, half_width_voxels, file.provenance, to, progress);
}

} // namespace isocast
