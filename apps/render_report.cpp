// SPDX-License-Identifier: MPL-2.0
#include "apps/render_report.h"

#include "apps/scene_objects.h"
#include "apps/verdict_json.h"
#include "raycaster/shading.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace isocast {

namespace {

/// Of all objects together.
struct BrickTotals {
    std::int64_t resident = 0;
    std::int64_t active = 0;
    std::int64_t loaded = 0;
    float storage_error = 0;         // of a sample, world units
    double storage_error_voxels = 0; // in those of its object
    int coarse_count = 0;
    int coarse_of = 0; // 0 unless bricks were coarsened
    LevelCounts coarse_levels{};
    float coarse_residual = 0;
    double coarse_residual_voxels = 0;
};

BrickTotals totals_of(const RenderReport& report) {
    BrickTotals total;
    if (!report.renderer) return total;
    for (std::size_t i = 0; i < report.loaded.objects.size(); ++i) {
        const double voxel_world = report.loaded.objects[i].field->space().voxel_size_world();
        const BrickPool& pool = report.renderer->pool(static_cast<int>(i));
        total.resident += pool.resident_count();
        total.active += pool.brick_count();
        total.loaded += pool.loaded_count();
        total.storage_error = std::max(total.storage_error, pool.storage_error());
        total.storage_error_voxels =
            std::max(total.storage_error_voxels, pool.storage_error() / voxel_world);
        const auto& coarse = report.renderer->coarse_bricks(static_cast<int>(i));
        if (!coarse) continue;
        total.coarse_count += coarse->coarse_count();
        total.coarse_of += coarse->block_count();
        for (std::size_t level = 0; level < coarse->counts.size(); ++level)
            total.coarse_levels[level] += coarse->counts[level];
        total.coarse_residual = std::max(total.coarse_residual, coarse->greatest_residual);
        total.coarse_residual_voxels =
            std::max(total.coarse_residual_voxels, coarse->greatest_residual / voxel_world);
    }
    return total;
}

} // namespace

std::vector<std::string> asked_for(const SceneFile& scene) {
    const OutputSpec& output = scene.output;
    std::vector<std::string> asked;
    if (const std::size_t count = composition_of(scene).parts.size(); count > 1)
        asked.push_back(fmt::format("{} objects", count));
    if (output.has_beauty)
        asked.push_back(output.samples == 1
                            ? "beauty"
                            : fmt::format("beauty of {} samples a pixel", output.samples));
    if (output.layers)
        for (const FrameImage image : images_of(*output.layers))
            asked.push_back(fmt::format("image '{}'", name_of(image)));
    if (!output.has_beauty) return asked;
    for (const Layer& layer : layers_of(scene.look))
        if (layer.strength > 0)
            asked.push_back(fmt::format("{} at strength {}", name_of(layer.image), layer.strength));
    if (scene.look.shows_environment) asked.emplace_back("environment as the background");
    return asked;
}

void print_json(const RenderReport& report) {
    using Json = nlohmann::ordered_json;
    const FrameReport& frame = report.frame;
    Json passes = Json::array();
    Json idle = Json::array();
    for (const PassReport& pass : frame.passes)
        if (pass.ran)
            passes.push_back({{"name", pass.name},
                              {"ms", pass.milliseconds},
                              {"bytes", pass.texture_bytes},
                              {"asked_by", pass.asked_by},
                              {"drawn_by", pass.drawn_by}});
        else
            idle.push_back(pass.name);
    Json objects = Json::array(); // in the order of their numbers
    const std::vector<ScenePart> parts = composition_of(report.scene).parts;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const FieldObject& object = report.loaded.objects[i];
        objects.push_back({{"name", parts[i].plane ? fmt::format("cut.plane.{}", *parts[i].plane)
                                                   : name_of(report.scene, parts[i].object)},
                           {"iso", object.iso_world},
                           {"voxel_size", object.field->space().voxel_size_world()},
                           {"filter", filter_name(object.filter)}});
    }
    Json primitives; // null without any
    if (report.loaded.primitives)
        primitives = {{"spheres", report.loaded.primitives->spheres.size()},
                      {"cylinders", report.loaded.primitives->cylinders.size()},
                      {"triangles", report.loaded.primitives->triangle_count()},
                      {"patches", report.loaded.primitives->patch_count()},
                      {"tetrahedra", report.loaded.primitives->tetrahedron_count()},
                      {"slim_patches", report.loaded.primitives->slim_count()}};
    const BrickTotals bricks = totals_of(report);
    Json coarse; // null unless bricks were coarsened
    if (bricks.coarse_of > 0)
        coarse = {{"count", bricks.coarse_count},
                  {"of", bricks.coarse_of},
                  {"levels", bricks.coarse_levels},               // bricks of 8, 4, 2, 1 cells
                  {"greatest_residual", bricks.coarse_residual}}; // world units
    Json gl;                                                      // null of the reference
    if (const gl::DriverInfo* driver = report.driver)
        gl = {{"backend", driver->backend},
              {"vendor", driver->vendor},
              {"renderer", driver->renderer},
              {"version", driver->version}};
    const RenderSeconds& seconds = report.seconds;
    print_json(Json{
        {"input", report.command.input()},
        {"output", report.command.output.string()},
        {"gl", gl},
        {"size", {report.scene.output.width, report.scene.output.height}},
        {"views", report.scene.camera.is_stereo ? 2 : 1},
        {"frames", report.frame_count},
        {"objects", objects},
        {"primitives", primitives},
        {"asked", asked_for(report.scene)},
        {"passes", passes},
        {"idle_passes", idle},
        {"programs", frame.programs_compiled},
        {"texture_bytes",
         frame.image_bytes + frame.field_bytes + frame.splat_bytes + frame.look_bytes},
        {"look_bytes", frame.look_bytes},
        {"notes", frame.notes},
        {"bricks",
         {{"resident", bricks.resident}, {"active", bricks.active}, {"loaded", bricks.loaded}}},
        {"fetch", report.fetch ? Json(fetch_name(report.fetch->fetch)) : Json()},
        {"coarse_bricks", coarse},
        {"storage_error", bricks.storage_error}, // of a sample, world units
        {"seconds",
         {{"field", seconds.field},
          {"context", seconds.context},
          {"load", seconds.load},
          {"draw", seconds.draw},
          {"write", seconds.write},
          {"total", seconds.total}}},
        {"warnings", report.warnings}});
}

void explain(const RenderReport& report) {
    const FrameReport& frame = report.frame;
    const BrickTotals bricks = totals_of(report);
    constexpr double mib = 1 << 20;
    fmt::print("asked for: {}\n", fmt::join(asked_for(report.scene), ", "));
    fmt::print("{:<16} {:>10} {:>10}  {}\n", "pass", "ms", "MiB", "asked by");
    for (const PassReport& pass : frame.passes)
        if (pass.ran)
            fmt::print("{:<16} {:>10.3f} {:>10.2f}  {}{}\n", pass.name, pass.milliseconds,
                       double(pass.texture_bytes) / mib, pass.asked_by,
                       pass.drawn_by.empty() ? "" : fmt::format(" (drawn by {})", pass.drawn_by));
        else
            fmt::print("{:<16} {:>10} {:>10}  {}\n", pass.name, "-", "-",
                       pass.is_kept ? pass.asked_by + " (kept from the frame before)"
                                    : "nothing: does not run");
    fmt::print(
        "{} programs; images {:.2f} MiB, field {:.2f} MiB, environment, maps and noise {:.2f} "
        "MiB\n",
        frame.programs_compiled, double(frame.image_bytes) / mib, double(frame.field_bytes) / mib,
        double(frame.look_bytes) / mib);
    for (const std::string& note : frame.notes) fmt::print("{}\n", note);
    if (report.loaded.primitives)
        fmt::print(
            "{} spheres, {} cylinders, {} triangles, {} patches, {} tetrahedra, {} SLIM patches: "
            "{:.2f} MiB on the GPU of those that can be seen\n",
            report.loaded.primitives->spheres.size(), report.loaded.primitives->cylinders.size(),
            report.loaded.primitives->triangle_count(), report.loaded.primitives->patch_count(),
            report.loaded.primitives->tetrahedron_count(), report.loaded.primitives->slim_count(),
            double(frame.splat_bytes) / mib);
    if (!report.loaded.objects.empty())
        fmt::print(
            "{} of {} bricks on the GPU, {} loaded; stored samples err by {:.2g} voxel at most\n",
            bricks.resident, bricks.active, bricks.loaded, bricks.storage_error_voxels);
    if (bricks.coarse_of > 0)
        fmt::print(
            "{} bricks of 8^3 cells, {} of 4^3, {} of 2^3, {} of 1: the field errs by {:.2g} "
            "voxel at most near the surface\n",
            bricks.coarse_levels[0], bricks.coarse_levels[1], bricks.coarse_levels[2],
            bricks.coarse_levels[3], bricks.coarse_residual_voxels);
    if (report.fetch)
        fmt::print("fetches {}: {}\n", fetch_name(report.fetch->fetch), report.fetch->reason);
}

void print(const RenderReport& report) {
    const RenderSeconds& seconds = report.seconds;
    const OutputSpec& output = report.scene.output;
    std::vector<std::string> drawn;
    if (!report.loaded.objects.empty() && report.renderer)
        drawn.push_back(fmt::format("{} bricks", totals_of(report).active));
    if (report.loaded.primitives)
        drawn.push_back(fmt::format("{} primitives", report.loaded.primitives->count()));
    if (!report.renderer) drawn.push_back(fmt::format("{} fields", report.loaded.objects.size()));
    fmt::print("{}: {}{}{} x {} pixels by {}, {}\n", report.command.output.string(),
               output.frames ? fmt::format("{} frames of ", report.frame_count) : "",
               report.scene.camera.is_stereo ? "two views of " : "", output.width, output.height,
               report.driver
                   ? fmt::format("{} ({})", report.driver->renderer, report.driver->backend)
                   : "the double reference",
               fmt::join(drawn, ", "));
    fmt::print("{:.2f} s: field {:.2f}, context {:.2f}, load {:.2f}, draw {:.2f}, write {:.2f}\n",
               seconds.total, seconds.field, seconds.context, seconds.load, seconds.draw,
               seconds.write);
}

} // namespace isocast
