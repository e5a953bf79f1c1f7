// SPDX-License-Identifier: MPL-2.0
#include "apps/convert_report.h"

#include "apps/console.h"
#include "apps/verdict_json.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace isocast {

namespace {

/// From triangles or points in memory to the field: what bench_convert and bench_points measure on
/// a virtual EPYC with one thread, 1 us a triangle and 20 ns a sample; 20 us a point, of which no
/// other thread takes a part, and 5 us a sample.
double expected_seconds(const ConvertReport& report, std::size_t threads) {
    const double samples = report.expected->active_voxels;
    const auto shared = static_cast<double>(std::max<std::size_t>(threads, 1));
    if (report.points)
        return 2e-5 * static_cast<double>(report.points->count) + 5e-6 * samples / shared;
    return (1e-6 * report.verdict.triangles + 2e-8 * samples) / shared;
}

} // namespace

void print(const ConvertReport& report, std::size_t threads) {
    if (report.is_export) {
        fmt::print("{}: {} active voxels, {:.2f} s\n", report.output.string(), report.active_voxels,
                   report.seconds.total);
        return;
    }
    if (report.points)
        fmt::print("{}: {} points {:.4g} apart, normals {}\n", report.input, report.points->count,
                   report.points->median_spacing_world,
                   report.points->normals_given ? "given" : "estimated");
    else
        fmt::print("{}: {} triangles, {}\n", report.input, report.verdict.triangles,
                   report.verdict.summary());
    if (report.octree) {
        const ConvertReport::Octree& octree = *report.octree;
        fmt::print(
            "{}{:.6g} cells, the finest of {:.6g} in {} levels; {:.6g} nodes, of which {:.6g} "
            "were sampled; {:.4g} MiB; {} to within {:.4g} at the surface; signs: {} ({})\n",
            octree.is_estimate ? "about " : report.output.string() + ": ", octree.cells,
            octree.finest_cell_world, octree.depth + 1, octree.nodes, octree.free_nodes,
            octree.bytes / 0x1p20, octree.filter == OctreeFilter::Linear ? "linear" : "cubic",
            octree.max_error_world, name_of(report.sign), report.sign_reason);
        fmt::print("{:.2f} s: read {:.2f}, prepare {:.2f}, transform {:.2f}, write {:.2f}\n",
                   report.seconds.total, report.seconds.read, report.seconds.prepare,
                   report.seconds.transform, report.seconds.write);
        return;
    }
    if (report.expected) {
        constexpr double mebibyte = 0x1p20;
        fmt::print("about {:.3g} active voxels of {:.6g}, {:.4g} MiB of field, {:.4g} MiB at most, "
                   "{:.2g} s on {} threads\n",
                   report.expected->active_voxels, report.options.voxel_size_world,
                   report.expected->field_bytes / mebibyte, report.expected->peak_bytes / mebibyte,
                   expected_seconds(report, threads), threads);
        return;
    }
    fmt::print("{}: {} active voxels of {:.6g} in {} x {} x {}, band of {:.4g} voxels on either "
               "side, signs: {} ({})\n",
               report.output.string(), report.active_voxels, report.options.voxel_size_world,
               report.size.x(), report.size.y(), report.size.z(), report.options.half_width_voxels,
               name_of(report.sign), report.sign_reason);
    if (report.promise)
        fmt::print("{} voxels promise an error of {:.2g} when drawn with --filter {}\n",
                   *report.promise->resolution, report.promise->error_world,
                   filter_name(report.promise->filter));
    fmt::print("{:.2f} s: read {:.2f}, prepare {:.2f}, transform {:.2f}, write {:.2f}\n",
               report.seconds.total, report.seconds.read, report.seconds.prepare,
               report.seconds.transform, report.seconds.write);
}

nlohmann::ordered_json to_json(const ConvertReport& report, std::size_t threads) {
    nlohmann::ordered_json json = {{"input", report.input}, {"output", report.output.string()}};
    if (report.is_export) {
        json["active_voxels"] = report.active_voxels;
        json["seconds"] = {{"total", report.seconds.total}};
        json["warnings"] = report.warnings;
        return json;
    }
    if (report.points) {
        const ConvertReport::Points& points = *report.points;
        json["points"] = points.count;
        json["normals"] = points.normals_given ? "given" : "estimated";
        json["spacing"] = points.median_spacing_world;
        json["point_method"] = name_of(points.meshless.method);
        json["neighbours"] = points.meshless.neighbours;
        json["approximation"] = points.meshless.approximation;
    } else {
        json["triangles"] = report.verdict.triangles;
        json["verdict"] = to_json(report.verdict);
    }
    if (report.octree) {
        const ConvertReport::Octree& octree = *report.octree;
        json["octree"] = {
            {"estimate", octree.is_estimate},
            {"max_error", octree.max_error_world},
            {"finest_cell", octree.finest_cell_world},
            {"depth", octree.depth},
            {"cells", std::llround(octree.cells)},
            {"nodes", std::llround(octree.nodes)},
            {"sampled_nodes", std::llround(octree.free_nodes)},
            {"bytes", std::llround(octree.bytes)},
            {"interpolation", octree.filter == OctreeFilter::Linear ? "linear" : "cubic"}};
    }
    if (report.promise)
        json["promise"] = {{"resolution", *report.promise->resolution},
                           {"error", report.promise->error_world},
                           {"filter", filter_name(report.promise->filter)}};
    json["voxel_size"] = report.options.voxel_size_world;
    json["half_width_voxels"] = report.options.half_width_voxels;
    if (report.expected) {
        json["expected"] = {{"active_voxels", report.expected->active_voxels},
                            {"field_bytes", report.expected->field_bytes},
                            {"peak_bytes", report.expected->peak_bytes},
                            {"seconds", expected_seconds(report, threads)}};
    } else {
        json["sign"] = name_of(report.sign);
        json["sign_reason"] = report.sign_reason;
        json["active_voxels"] = report.active_voxels;
        json["seconds"] = {{"read", report.seconds.read},
                           {"prepare", report.seconds.prepare},
                           {"transform", report.seconds.transform},
                           {"write", report.seconds.write},
                           {"total", report.seconds.total}};
        json["peak_bytes"] = peak_memory_bytes();
    }
    json["warnings"] = report.warnings;
    return json;
}

} // namespace isocast
