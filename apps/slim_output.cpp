// SPDX-License-Identifier: MPL-2.0
#include "apps/slim_output.h"

#include "apps/inputs.h"
#include "apps/verdict_json.h"
#include "quadrics/slim_cover.h"
#include "quadrics/slim_file.h"
#include "quadrics/slim_points.h"
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

/// Of the box's diagonal.
double checked_share(const std::optional<double>& max_error) {
    const double share = max_error.value_or(1e-3);
    if (!(share > 0 && share <= 0.1))
        throw UsageError(fmt::format(
            "--max-error {}: of a .slim it is a part of the box's diagonal, 0.1 at most", share));
    return share;
}

struct Made {
    std::string of; // what, in words
    nlohmann::ordered_json of_json;
    SlimSurface surface;
    std::vector<SlimReport> reports;
    double seconds = 0;
};

void print(const Made& made, const std::string& input, const std::filesystem::path& output,
           bool is_json) {
    const SlimLevel& finest = made.surface.levels.front();
    const SlimReport& report = made.reports.front();
    if (is_json) {
        auto levels = levels_of(made.surface);
        for (std::size_t i = 0; i < made.reports.size(); ++i)
            levels[i].update(
                {{"over_bound", made.reports[i].over_bound}, {"seconds", made.reports[i].seconds}});
        nlohmann::ordered_json json = {{"input", input}, {"output", output.string()}};
        json.update(made.of_json);
        json.update({{"patches", made.surface.patch_count()},
                     {"with_planes", report.with_planes},
                     {"over_bound", report.over_bound},
                     {"max_error", finest.max_error_world},
                     {"greatest_error", report.greatest_error_world},
                     {"levels", levels},
                     {"closed", made.surface.is_closed},
                     {"seconds", made.seconds}});
        print_json(json);
        return;
    }
    fmt::print("{}: {} patches of {}, {} cut by planes; off by {:.4g} at most, asked {:.4g}\n",
               output.string(), finest.patches.size(), made.of, report.with_planes,
               report.greatest_error_world, finest.max_error_world);
    if (report.over_bound > 0)
        fmt::print("{} patches of the least size are off by more\n", report.over_bound);
    for (std::size_t i = 1; i < made.reports.size(); ++i)
        fmt::print(
            "  coarser: {} patches for an error of {:.4g}, {} of them off by more, {:.2f} s\n",
            made.surface.levels[i].patches.size(), made.surface.levels[i].max_error_world,
            made.reports[i].over_bound, made.reports[i].seconds);
    fmt::print("{:.2f} s\n", made.seconds);
}

} // namespace

void convert_to_slim(const std::string& input, const CheckedMesh& mesh,
                     const std::optional<double>& max_error, const std::filesystem::path& output,
                     bool is_json, const Progress& progress) {
    const double error = checked_share(max_error) * bounding_box(mesh.mesh).size().norm();
    const std::size_t count = mesh.mesh.triangles.size();
    Made made{.of = fmt::format("{} triangles", count), .of_json = {{"triangles", count}}};
    const Stopwatch total;
    made.surface =
        slim_of({.vertices_world = mesh.mesh.vertices_world, .triangles = mesh.mesh.triangles},
                {.max_error_world = error}, made.reports, progress);
    made.seconds = total.seconds();
    write_slim(made.surface, output);
    print(made, input, output, is_json);
}

void convert_to_slim(const std::string& input, const CheckedPoints& points,
                     const std::optional<double>& max_error, const std::filesystem::path& output,
                     bool is_json, const Progress& progress) {
    const double error = checked_share(max_error) * bounding_box(points).size().norm();
    const std::size_t count = points.cloud.points_world.size();
    const char* normals = points.normals_given ? "given" : "estimated";
    Made made{.of = fmt::format("{} points {:.4g} apart, normals {}", count,
                                points.median_spacing_world, normals),
              .of_json = {{"points", count},
                          {"normals", normals},
                          {"spacing", points.median_spacing_world}}};
    const Stopwatch total;
    made.surface =
        slim_of_points({points.cloud.points_world, points.cloud.normals, points.spacing_world},
                       error, made.reports, progress);
    made.seconds = total.seconds();
    write_slim(made.surface, output);
    print(made, input, output, is_json);
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
