// Octrees as `convert --method octree` makes, reports and writes them.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/convert_report.h"
#include "distance_transform/convert_adaptive.h"

#include <CLI/CLI.hpp>

namespace isocast {

/// What of an octree goes to a .vdb file.
enum class OctreeGrids {
    Finest, // a narrow band on the lattice of the finest cells
    Levels  // one for each level
};

struct OctreeCommand {
    std::optional<OctreeFilter> filter; // linear if empty
    OctreeGrids grids = OctreeGrids::Finest;
};

/// --interpolation and --grids.
void add_octree_options(CLI::App& app, OctreeCommand& command);

/// Builds the octree, writes it to report.output, and fills in the report. For a dry run it only
/// estimates.
///
/// max_error_world        a thousandth of the mesh's longest side if empty
/// voxel_size_world       edge of the finest cells, if given
/// accurate_within_world  AdaptiveConvertOptions'
void convert_to_octree(const OctreeCommand& command, const CheckedMesh& mesh,
                       const std::optional<double>& max_error_world,
                       const std::optional<double>& voxel_size_world, double accurate_within_world,
                       bool is_dry_run, ConvertReport& report, const Progress& progress);

/// An octree file to a .vdb file. returns  the active voxels of all grids
std::int64_t export_octree(const std::filesystem::path& from, const std::filesystem::path& to,
                           OctreeGrids grids, double half_width_voxels, const Progress& progress);

} // namespace isocast
