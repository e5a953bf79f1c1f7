// From mesh to distance field: lattice, sites, blocks, distances, signs.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/convert.h"

#include "distance_transform/band_tiles.h"
#include "distance_transform/csc.h"
#include "distance_transform/kd_dense.h"
#include "distance_transform/lattice.h"
#include "distance_transform/open_mesh_signs.h"
#include "distance_transform/printed_prisms.h"
#include "distance_transform/progress_meter.h"
#include "distance_transform/sign_check.h"
#include "distance_transform/sign_choice.h"
#include "distance_transform/tile_transform.h"
#include "volume/available_memory.h"
#include "volume/errors.h"
#include "volume/stopwatch.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>

namespace isocast {

namespace {

struct SignName {
    std::string_view name;
    SignMethod method;
};

constexpr std::array sign_names = {
    SignName{"auto", SignMethod::Auto}, SignName{"normal", SignMethod::Normal},
    SignName{"winding", SignMethod::Winding}, SignName{"unsigned", SignMethod::Unsigned}};

/// Whether rounding to voxels has made one of two neighbouring vertices.
bool has_merged_vertices(const Mesh& mesh) {
    return std::ranges::any_of(mesh.triangles, [&](const std::array<int, 3>& t) {
        const auto& at = mesh.vertices_world;
        return at[t[0]] == at[t[1]] || at[t[1]] == at[t[2]] || at[t[2]] == at[t[0]];
    });
}

/// Item from[i] becomes item i, without a second copy of them all.
void reorder(std::vector<ClosestBlock>& items, std::vector<std::uint32_t> from) {
    for (std::uint32_t start = 0; start < from.size(); ++start) {
        if (from[start] == start) continue;
        const ClosestBlock first = items[start];
        std::uint32_t to = start;
        while (from[to] != start) {
            items[to] = items[from[to]];
            to = std::exchange(from[to], to);
        }
        items[to] = first;
        from[to] = to;
    }
}

struct Band {
    BandSamples samples = {};
    double prepare_seconds = 0;
    std::int64_t distance_evaluations = 0;
};

Band scan_band(const LatticeMesh& lattice, const MeshTopology& topology,
               const ConvertOptions& options, double memory_bytes, BandSigns signs,
               const Progress& progress) {
    const Stopwatch time;
    const Sites sites(lattice.mesh, topology, options.half_width_voxels);
    const BandTiles found = find_band_tiles(sites, memory_bytes, progress);
    Band band{.prepare_seconds = time.seconds()};
    if (options.scanner) {
        band.samples.blocks = options.scanner(sites, found, signs.winding, options.voxel_size_world,
                                              band.distance_evaluations, progress);
        return band;
    }
    TileTransform transform(sites, signs, options.voxel_size_world, found.block_count,
                            options.closest);
    ProgressMeter meter(progress, "transform", static_cast<double>(found.tiles.size()), 16);
    std::atomic<std::int64_t> evaluations = 0;
    tbb::parallel_for(std::size_t{0}, found.tiles.size(), [&](std::size_t i) {
        evaluations += transform.run(found.tiles[i], found.sites_of(found.tiles[i]));
        meter.add(1);
    });
    band.samples = transform.take();
    band.distance_evaluations = evaluations;
    return band;
}

Band reference_band(const LatticeMesh& lattice, const ConvertOptions& options, double memory_bytes,
                    const Progress& progress) {
    ReferenceBand band = options.method == BandMethod::Csc
                             ? characteristics_scan_conversion(lattice, options.half_width_voxels,
                                                               memory_bytes, progress)
                             : scan_convert_prisms(lattice, options.half_width_voxels, Gaps::Close,
                                                   memory_bytes, progress);
    return {.samples = {.blocks = std::move(band.blocks)},
            .distance_evaluations = band.distance_evaluations};
}

} // namespace

void require_usable(const ConvertOptions& options) {
    require_band(options.voxel_size_world, options.half_width_voxels, "; scale the mesh");
    if (options.closest && (options.method != BandMethod::Scan || options.scanner))
        throw InputError("only scan conversion on the CPU finds closest points");
    if (options.scanner && options.sign == SignMethod::Unsigned)
        throw InputError("unsigned distances come from the CPU");
}

SignMethod sign_method_from_name(std::string_view name) {
    for (const SignName& known : sign_names)
        if (known.name == name) return known.method;
    throw InputError(
        fmt::format("unknown sign method '{}' (known: auto, normal, winding, unsigned)", name));
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
    const Stopwatch time;
    const double half_width = options.half_width_voxels;
    const double background = half_width * options.voxel_size_world;
    const double memory = std::min(options.memory_bytes, available_memory_bytes());
    LatticeMesh lattice = on_lattice(input.mesh, options.voxel_size_world, half_width);
    bool is_merged = false;
    double least_bytes = 0;
    tbb::parallel_invoke([&] { is_merged = has_merged_vertices(lattice.mesh); },
                         [&] { least_bytes = least_field_bytes(lattice.mesh, half_width); });
    if (least_bytes > memory) refuse_memory(least_bytes, memory);
    // Vertices nearer to each other than to the lattice's anchor by 2^53 are cleaned once more.
    std::optional<CheckedMesh> merged;
    if (is_merged) {
        merged = check(lattice.mesh);
        lattice.mesh = merged->mesh;
    }
    const MeshTopology& topology = merged ? merged->topology : input.topology;
    const MeshVerdict& verdict = merged ? merged->verdict : input.verdict;
    if (std::isfinite(options.memory_bytes)) {
        const double expected = estimate(input, options).peak_bytes;
        if (expected > options.memory_bytes) refuse_memory(expected, options.memory_bytes);
    }

    SignChoice sign = chosen_sign(verdict, options.sign);
    if (options.method != BandMethod::Scan) {
        if (options.sign != SignMethod::Auto && options.sign != SignMethod::Normal)
            throw InputError(fmt::format("the methods kept for comparison find signs by normals, "
                                         "not '{}'",
                                         name_of(options.sign)));
        sign = {SignMethod::Normal, "the method has no other"};
    }
    const bool is_closed = verdict.is_closed() && verdict.is_oriented();
    std::optional<WindingNumber> winding;
    if (sign.method == SignMethod::Winding) winding.emplace(lattice.mesh, is_closed);
    const BandSigns band_signs{.is_signed = sign.method != SignMethod::Unsigned,
                               .winding = winding ? &*winding : nullptr};
    Band band = options.method == BandMethod::Scan
                    ? scan_band(lattice, topology, options, memory, band_signs, progress)
                    : reference_band(lattice, options, memory, progress);

    FieldBlocks& blocks = band.samples.blocks;
    if (options.sign == SignMethod::Auto && sign.method == SignMethod::Normal &&
        !signs_are_consistent(blocks, band.samples.negative, options.voxel_size_world)) {
        sign.method = SignMethod::Winding;
        sign.reason = "those of normals contradict each other";
        sign.warnings.push_back("Signs come from the winding number, since those of normals "
                                "contradict each other: the mesh intersects itself, or a part is "
                                "inside out.");
        sign_by_winding_number(blocks, WindingNumber(lattice.mesh, is_closed),
                               options.voxel_size_world, static_cast<float>(background), progress);
    }
    if (sign.method == SignMethod::Winding && !is_closed && !blocks.empty()) {
        const std::size_t count = blocks.size();
        store_outside_signs(blocks, *winding, static_cast<float>(background), memory, progress);
        if (options.closest && blocks.size() > count)
            throw InputError("closest points of a mesh that is not closed need --sign unsigned: "
                             "the signs reach beyond the band");
    }
    tbb::parallel_for(std::size_t{0}, blocks.size(),
                      [&](std::size_t i) { blocks[i].coordinate += lattice.anchor / block_size; });
    if (options.closest) reorder(band.samples.closest, zyx_order(blocks));
    const Outside outside =
        sign.method == SignMethod::Unsigned ? Outside::Background : Outside::SignedBackground;
    return {
        .field = SparseField(lattice.space, background, outside, std::move(blocks)),
        .sign_used = sign.method,
        .sign_reason = std::move(sign.reason),
        .closest = std::move(band.samples.closest),
        .time = {.prepare_seconds = band.prepare_seconds,
                 .transform_seconds = time.seconds() - band.prepare_seconds},
        .distance_evaluations = band.distance_evaluations,
        .warnings = std::move(sign.warnings),
    };
}

ConvertEstimate estimate(const CheckedMesh& input, const ConvertOptions& options) {
    require_usable(options);
    const double voxel = options.voxel_size_world;
    // A slab of normal n and thickness 2 w over an area A meets, of cubes of edge s that stand e
    // apart, A (s |n|_1 + 2 w) / e^3. The samples of a block span one voxel less than it.
    const double span = (block_size - 1) * voxel;
    const double volume = std::pow(block_size * voxel, 3);
    const double thickness = 2 * options.half_width_voxels * voxel;
    ConvertEstimate result;
    for (const auto& [a, b, c] : input.mesh.triangles) {
        const Vec3d& p = input.mesh.vertices_world[a];
        const Vec3d area_normal =
            (input.mesh.vertices_world[b] - p).cross(input.mesh.vertices_world[c] - p) / 2;
        result.blocks +=
            (span * area_normal.cwiseAbs().sum() + thickness * area_normal.norm()) / volume;
        result.active_voxels += area_normal.norm() * thickness / (voxel * voxel * voxel);
    }
    const auto triangles = static_cast<double>(input.mesh.triangles.size());
    const double closest = options.closest ? sizeof(ClosestBlock) : 0;
    result.field_bytes = result.blocks * (sizeof(FieldBlock) + closest);
    // A face, an edge and a half, half a vertex; each in two tiles, by number and as a pair.
    const double site_bytes = sizeof(FaceNormal) + 1.5 * sizeof(EdgeData) + 0.5 * sizeof(FanData) +
                              3 * 2 * 3 * sizeof(std::int32_t);
    const double per_block = sizeof(std::uint32_t);
    result.peak_bytes =
        result.field_bytes + triangles * (site_bytes + 200) + result.blocks * per_block;
    return result;
}

IndexBox dense_box(const CheckedMesh& input, const ConvertOptions& options) {
    const LatticeMesh lattice =
        on_lattice(input.mesh, options.voxel_size_world, options.half_width_voxels);
    const double margin = options.half_width_voxels;
    const Index3 lo =
        (lattice.box.min.array() - margin).floor().cast<int>().matrix() + lattice.anchor;
    const Index3 hi =
        (lattice.box.max.array() + margin).ceil().cast<int>().matrix() + lattice.anchor;
    return {lo, (hi.array() + 1).matrix()};
}

DenseConvertResult convert_dense(const CheckedMesh& input, const ConvertOptions& options,
                                 const Progress& progress) {
    require_usable(options);
    const Stopwatch time;
    const LatticeMesh lattice =
        on_lattice(input.mesh, options.voxel_size_world, options.half_width_voxels);
    SignChoice sign =
        sign_by_band(input, options.sign, options.voxel_size_world, options.memory_bytes, progress);
    if (sign.method == SignMethod::Unsigned)
        throw InputError(
            fmt::format("a full field needs signs, and {}",
                        options.sign == SignMethod::Auto ? sign.reason : "none were asked for"));
    const bool is_closed = input.verdict.is_closed() && input.verdict.is_oriented();
    std::optional<WindingNumber> winding;
    if (sign.method == SignMethod::Winding) winding.emplace(lattice.mesh, is_closed);
    KdDenseResult dense =
        dense_distances(lattice, input.topology, KdTree(lattice.mesh),
                        {.box = dense_box(input, options),
                         .winding = winding ? &*winding : nullptr,
                         .memory_bytes = std::min(options.memory_bytes, available_memory_bytes())},
                        progress);
    return {.field = std::move(dense.field),
            .sign_used = sign.method,
            .sign_reason = std::move(sign.reason),
            .seconds = time.seconds(),
            .distance_evaluations = dense.distance_evaluations,
            .warnings = std::move(sign.warnings)};
}

} // namespace isocast
