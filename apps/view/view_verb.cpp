// SPDX-License-Identifier: MPL-2.0
#include "apps/verbs.h"

#include "apps/console.h"
#include "apps/parsed_option.h"
#include "apps/render_options.h"
#include "apps/view/window.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <tbb/global_control.h>

namespace isocast {

namespace {

struct ViewCommand {
    RenderCommand scene; // inputs, --set, --resolution
    view::Controls controls = view::Controls::Paraview;
    double target_milliseconds = 33;
    int width = 1280;
    int height = 800;
    std::filesystem::path trace;
};

void view_scene(const ViewCommand& command, Console& console,
                const std::vector<std::filesystem::path>& shader_folders,
                const std::vector<std::filesystem::path>& data_folders) {
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                      command.scene.threads);
    // What is wrong with the command is said before a window opens.
    SceneFile scene;
    if (!command.scene.inputs.empty()) scene = scene_of(command.scene);
    std::unique_ptr<gl::Context> context;
    try {
        context = gl::make_context({.backend = gl::Backend::Window,
                                    .window_width = command.width,
                                    .window_height = command.height,
                                    .window_title = "isocast"});
    } catch (const gl::GlError& error) {
        throw gl::NoContextError(fmt::format(
            "{}\nno window can be opened; `isocast render` draws without a display", error.what()));
    }
    const Progress until_interrupted = console.progress();
    view::Window window(*context, first_folder_of(shader_folders),
                        {.controls = command.controls,
                         .viewer = {.data_folders = data_folders,
                                    .target_milliseconds = command.target_milliseconds},
                         .config_folder = config_folder(),
                         .trace = command.trace});
    if (!scene.objects.empty()) window.viewer().open(std::move(scene));
    window.run([&] {
        try {
            until_interrupted("", 0);
        } catch (const Interrupted&) {
            return true;
        }
        return false;
    });
    until_interrupted("", 0); // whose exit code is another than that of a closed window
}

} // namespace

Verb view_verb(CLI::App& program, std::vector<std::filesystem::path> shader_folders,
               std::vector<std::filesystem::path> data_folders) {
    CLI::App* app =
        program.add_subcommand("view", "Explore scenes, fields, meshes and molecules in a window");
    const auto command = std::make_shared<ViewCommand>();
    app->add_option("IN", command->scene.inputs,
                    "As of `isocast render`; more can be dropped on the window");
    app->add_option("--set", command->scene.settings, "Set any key of a scene (render --keys)")
        ->type_name("KEY=VALUE")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    add_parsed(*app, "--resolution", command->scene.resolution, integer_from,
               "Meshes: voxels along the longest side (default 256)")
        ->type_name("N");
    add_choice<view::Controls>(
        *app, "--controls", command->controls,
        {{"paraview", view::Controls::Paraview}, {"blender", view::Controls::Blender}},
        "What mouse buttons do: paraview (default; left rotates, middle pans, right zooms), "
        "blender (middle rotates, with Shift pans, with Ctrl zooms)")
        ->type_name("WHOSE");
    add_parsed(*app, "--frame-time", command->target_milliseconds, number_from,
               "What a picture may take while something moves [ms] (default 33)")
        ->type_name("MS");
    app->add_option("--width", command->width, "Of the window")->check(CLI::Range(320, 16384));
    app->add_option("--height", command->height, "Of the window")->check(CLI::Range(240, 16384));
    app->add_option("--trace", command->trace,
                    "Write a line of JSON for each step that is drawn: its passes and times")
        ->type_name("FILE");
    command->scene.threads =
        tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
    add_threads(*app, command->scene.threads);
    app->footer("Example: isocast view field:gyroid@64");
    return {app, [command, shader_folders = std::move(shader_folders),
                  data_folders = std::move(data_folders)](Console& console) {
                view_scene(*command, console, shader_folders, data_folders);
            }};
}

} // namespace isocast
