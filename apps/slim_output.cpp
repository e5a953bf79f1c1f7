// SPDX-License-Identifier: MPL-2.0
#include "apps/slim_output.h"

#include "apps/inputs.h"
#include "apps/verdict_json.h"
#include "quadrics/slim_cover.h"
#include "quadrics/slim_file.h"
#include "volume/stopwatch.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <ranges>

namespace isocast {

namespace {

nlohmann::ordered_json levels_of(const SlimSurface& surface) {
    auto levels = nlohmann::ordered_json::array();
    for (const SlimLevel& level : surface.levels)
        levels.push_back({{"patches", level.patches.size()}, {"max_error", level.max_error_world}});
    return levels;
}

} // namespace

void convert_to_slim(const std::string& input, const CheckedMesh& mesh,
                     const std::optional<double>& max_error, const std::filesystem::path& output,
                     bool is_json, const Progress& progress) {
    const double share = max_error.value_or(1e-3);
    if (!(share > 0 && share <= 0.1))
        throw UsageError(fmt::format(
            "--max-error {}: of a .slim it is a part of the box's diagonal, 0.1 at most", share));
    const double diagonal = bounding_box(mesh.mesh).size().norm();
    const Stopwatch total;
    std::vector<SlimReport> reports;
    const SlimSurface surface =
        slim_of({.vertices_world = mesh.mesh.vertices_world, .triangles = mesh.mesh.triangles},
                {.max_error_world = share * diagonal}, reports, progress);
    const SlimReport& report = reports.front();
    const double seconds = total.seconds();
    write_slim(surface, output);
    if (is_json) {
        auto levels = levels_of(surface);
        for (std::size_t i = 0; i < reports.size(); ++i)
            levels[i].update(
                {{"over_bound", reports[i].over_bound}, {"seconds", reports[i].seconds}});
        print_json({{"input", input},
                    {"output", output.string()},
                    {"triangles", mesh.mesh.triangles.size()},
                    {"patches", surface.patch_count()},
                    {"with_planes", report.with_planes},
                    {"over_bound", report.over_bound},
                    {"max_error", surface.levels.front().max_error_world},
                    {"greatest_error", report.greatest_error_world},
                    {"levels", levels},
                    {"closed", surface.is_closed},
                    {"seconds", seconds}});
        return;
    }
    fmt::print("{}: {} patches of {} triangles, {} cut by planes; off by {:.4g} at most, asked "
               "{:.4g}\n",
               output.string(), surface.levels.front().patches.size(), mesh.mesh.triangles.size(),
               report.with_planes, report.greatest_error_world,
               surface.levels.front().max_error_world);
    if (report.over_bound > 0)
        fmt::print("{} patches of the least size are planes that are off by more\n",
                   report.over_bound);
    for (std::size_t i = 1; i < reports.size(); ++i)
        fmt::print(
            "  coarser: {} patches for an error of {:.4g}, {} of them off by more, {:.2f} s\n",
            surface.levels[i].patches.size(), surface.levels[i].max_error_world,
            reports[i].over_bound, reports[i].seconds);
    fmt::print("{:.2f} s\n", seconds);
}

void describe_slim(const std::string& path, bool is_json) {
    const SlimSurface surface = read_slim(path);
    const SlimLevel& finest = surface.levels.front();
    const auto cut = std::ranges::count_if(
        finest.patches, [](const SlimPatch& patch) { return patch.plane_count > 0; });
    std::vector<double> radii;
    for (const SlimPatch& patch : finest.patches) radii.push_back(patch.radius_world);
    std::ranges::sort(radii);
    const auto radius = [&](double share) {
        return radii.empty()
                   ? 0.0
                   : radii[static_cast<std::size_t>(share * static_cast<double>(radii.size() - 1))];
    };
    if (is_json) {
        print_json(
            {{"input", path},
             {"kind", "SLIM surface"},
             {"patches", surface.patch_count()},
             {"with_planes", cut},
             {"max_error", finest.max_error_world},
             {"levels", levels_of(surface)},
             {"closed", surface.is_closed},
             {"radius", {{"least", radius(0)}, {"median", radius(0.5)}, {"greatest", radius(1)}}}});
        return;
    }
    fmt::print("{}: a {} SLIM surface of {} patches, {} of them cut by planes\n", path,
               surface.is_closed ? "closed" : "open", finest.patches.size(), cut);
    fmt::print(
        "  radii {:.4g} ... {:.4g}, half of them up to {:.4g}; made for an error of {:.4g}\n",
        radius(0), radius(1), radius(0.5), finest.max_error_world);
    for (const SlimLevel& level : surface.levels | std::views::drop(1))
        fmt::print("  coarser: {} patches for an error of {:.4g}\n", level.patches.size(),
                   level.max_error_world);
}

} // namespace isocast
