// From mesh to narrow-band distance field: lattice, blocks, distances, signs.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/convert.h"

#include "distance_transform/band_blocks.h"
#include "distance_transform/block_transform.h"
#include "distance_transform/lattice.h"
#include "distance_transform/open_mesh_signs.h"
#include "distance_transform/progress_meter.h"
#include "distance_transform/sign_check.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <fstream>
#include <limits>

namespace isocast {

namespace {

struct SignName {
    std::string_view name;
    SignMethod method;
};

constexpr std::array sign_names = {SignName{"auto", SignMethod::Auto},
                                   SignName{"normal", SignMethod::Normal},
                                   SignName{"winding", SignMethod::Winding}};

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// What the system says may still be taken; infinity where it says nothing.
double available_memory_bytes() {
    std::ifstream file("/proc/meminfo");
    std::string key;
    double kibibytes = 0;
    for (std::string unit; file >> key >> kibibytes; std::getline(file, unit))
        if (key == "MemAvailable:") return kibibytes * 1024;
    return std::numeric_limits<double>::infinity();
}

void require_usable(const ConvertOptions& options) {
    if (!(options.voxel_size_world > 0) || !std::isfinite(options.voxel_size_world))
        throw InputError(
            fmt::format("voxel size {} is not a positive number", options.voxel_size_world));
    if (!(options.half_width_voxels >= 1) || !std::isfinite(options.half_width_voxels))
        throw InputError(fmt::format("half width {} is below 1 voxel", options.half_width_voxels));
}

SignMethod chosen_sign(const MeshVerdict& verdict, SignMethod wanted,
                       std::vector<std::string>& warnings) {
    const bool has_normals = verdict.is_closed() && verdict.is_oriented();
    if (wanted == SignMethod::Auto && !has_normals)
        warnings.push_back(fmt::format(
            "Signs come from the winding number, since the mesh is not closed and oriented ({}).",
            verdict.summary()));
    if (wanted == SignMethod::Normal && !has_normals)
        warnings.push_back(fmt::format("Signs come from normals as asked, and can be wrong since "
                                       "the mesh is not closed and oriented ({}).",
                                       verdict.summary()));
    if (wanted != SignMethod::Auto) return wanted;
    return has_normals ? SignMethod::Normal : SignMethod::Winding;
}

/// Removes blocks without an active sample; few are, so that most of the array is moved.
void remove_empty(FieldBlocks& blocks) {
    std::erase_if(blocks, [](const FieldBlock& block) { return block.active.none(); });
}

} // namespace

SignMethod sign_method_from_name(std::string_view name) {
    for (const SignName& known : sign_names)
        if (known.name == name) return known.method;
    throw InputError(fmt::format("unknown sign method '{}' (known: auto, normal, winding)", name));
}

std::string_view name_of(SignMethod method) {
    for (const SignName& known : sign_names)
        if (known.method == method) return known.name;
    return {};
}

double voxel_size_for_resolution(const WorldBox& box, int resolution) {
    constexpr int greatest = 1 << 20;
    if (resolution < 1 || resolution > greatest)
        throw InputError(
            fmt::format("resolution {} is not between 1 and {}", resolution, greatest));
    const double longest = box.size().maxCoeff();
    if (!(longest > 0) || !std::isfinite(longest))
        throw InputError("the box of the mesh has no size from which a voxel size could follow");
    return longest / resolution;
}

ConvertResult convert(const CheckedMesh& input, const ConvertOptions& options,
                      const Progress& progress) {
    require_usable(options);
    const auto start = std::chrono::steady_clock::now();
    std::vector<std::string> warnings;
    SignMethod method = chosen_sign(input.verdict, options.sign, warnings);
    const double half_width = options.half_width_voxels;
    const double memory = available_memory_bytes();
    const LatticeMesh lattice = on_lattice(input.mesh, options.voxel_size_world, half_width);
    if (const double least = least_field_bytes(lattice.mesh, half_width); least > memory)
        refuse_memory(least, memory);
    const bool is_closed = input.verdict.is_closed() && input.verdict.is_oriented();
    std::optional<WindingNumber> winding;
    if (method == SignMethod::Winding) winding.emplace(lattice.mesh, is_closed);
    const Sites sites = voronoi_sites(lattice.mesh, input.topology, half_width);
    const BandBlocks band = find_band_blocks(sites, memory, progress);
    const double prepare_seconds = seconds_since(start);

    const auto transform_start = std::chrono::steady_clock::now();
    FieldBlocks blocks(band.blocks.size());
    const BlockTransform transform(sites.arrays(), winding ? &*winding : nullptr, half_width,
                                   options.voxel_size_world);
    ProgressMeter meter(progress, "transform", static_cast<double>(blocks.size()), 16);
    std::atomic<std::int64_t> evaluations = 0;
    tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t i) {
        FieldBlock& block = *std::construct_at(&blocks[band.blocks[i].place]);
        block.coordinate = band.blocks[i].coordinate;
        evaluations += transform.run(block, band.sites(band.blocks[i]));
        meter.add(1);
    });
    remove_empty(blocks);

    const double background = half_width * options.voxel_size_world;
    if (options.sign == SignMethod::Auto && method == SignMethod::Normal &&
        !signs_are_consistent(blocks, options.voxel_size_world)) {
        method = SignMethod::Winding;
        warnings.push_back("Signs come from the winding number, since those of normals contradict "
                           "each other: the mesh intersects itself, or a part is inside out.");
        sign_by_winding_number(blocks, WindingNumber(lattice.mesh, is_closed),
                               options.voxel_size_world, static_cast<float>(background), progress);
    }
    if (method == SignMethod::Winding && !is_closed && !blocks.empty())
        store_outside_signs(blocks, *winding, static_cast<float>(background),
                            memory, progress);
    for (FieldBlock& block : blocks) block.coordinate += lattice.anchor / block_size;
    return {.field = SparseField(lattice.space, background, Outside::SignedBackground,
                                 std::move(blocks)),
            .sign_used = method,
            .time = {.prepare_seconds = prepare_seconds,
                     .transform_seconds = seconds_since(transform_start)},
            .distance_evaluations = evaluations,
            .warnings = std::move(warnings)};
}

} // namespace isocast
