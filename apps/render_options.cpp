// SPDX-License-Identifier: MPL-2.0
#include "apps/render_options.h"

#include "apps/parsed_option.h"
#include "apps/scene_keys.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/global_control.h>

#include <algorithm>

namespace isocast {

namespace {

gl::Backend offscreen_backend_from(std::string_view name) {
    if (name != "auto" && name != "egl" && name != "osmesa")
        throw UsageError(fmt::format("'{}' is not one of auto, egl, osmesa", name));
    return gl::backend_from_name(name);
}

/// Options that stand for keys of a scene.
struct KeyOptions {
    CLI::App& app;
    RenderCommand& command;

    /// The option's text sets `key`.
    CLI::Option* add(const std::string& option, const std::string& key, const std::string& help) {
        return add_override(
            option,
            [key](const std::string& text) {
                return [assignment = key + "=" + text](SceneFile& scene) {
                    set_key(scene, assignment);
                };
            },
            help);
    }

    /// parse(text) gives what is done to the scene. It is tried on an empty one, so that a wrong
    /// command is found before any file is read.
    template<class Parse>
    CLI::Option* add_override(const std::string& option, Parse parse, const std::string& help) {
        return app.add_option_function<std::string>(
            option,
            [this_command = &command, option, parse](const std::string& text) {
                try {
                    const std::function<void(SceneFile&)> change = parse(text);
                    SceneFile trial;
                    trial.objects.resize(1);
                    change(trial);
                    this_command->overrides.push_back(change);
                } catch (const std::exception& error) {
                    throw CLI::ValidationError(option, error.what());
                }
            },
            help);
    }

    void add_flag(const std::string& flag, const std::string& assignment, const std::string& help) {
        app.add_flag_callback(
            flag,
            [this_command = &command, assignment] {
                this_command->overrides.push_back(
                    [assignment](SceneFile& scene) { set_key(scene, assignment); });
            },
            help);
    }
};

void add_scene_options(KeyOptions& keys) {
    keys.app
        .add_option("--set", keys.command.settings,
                    "Set any key of a scene, e.g. effects.contours.strength=1 or "
                    "light.0.shadow=soft (--keys lists them)")
        ->type_name("KEY=VALUE")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    keys.app.add_flag_callback(
        "--keys",
        [] {
            fmt::print("{}", scene_reference());
            throw CLI::Success();
        },
        "List the keys of a scene, and end");
    keys.add_override(
            "--camera",
            [](const std::string& text) {
                return [spec = camera_spec_from(text)](SceneFile& scene) { scene.camera = spec; };
            },
            "key=value pairs joined by ';': eye=x,y,z  target=x,y,z  direction=x,y,z (from the "
            "object to the eye; the object then fills the picture)  up=x,y,z  fov=degrees  "
            "height=H (orthographic)")
        ->type_name("SPEC");
    keys.add_override(
            "--iso",
            [](const std::string& text) {
                return [text](SceneFile& scene) {
                    for (std::size_t i = 0; i < scene.objects.size(); ++i)
                        if (!scene.objects[i].csg)
                            set_key(scene, fmt::format("object.{}.iso={}", i, text));
                };
            },
            "Iso value of all objects (default: 0 for distances; for other files what `isocast "
            "info` suggests)")
        ->type_name("V");
    add_parsed(keys.app, "--resolution", keys.command.resolution, integer_from,
               "Meshes: voxels along the longest side (default 256)")
        ->type_name("N");
}

void add_quality_options(KeyOptions& keys) {
    keys.add_override(
            "--filter",
            [](const std::string& text) {
                return [text](SceneFile& scene) {
                    set_key(scene, "quality.filter=" + text);
                    for (SceneObject& object : scene.objects) object.filter.reset();
                };
            },
            "From samples to a smooth function: interpolating (cubic B-spline through the samples, "
            "default), bspline (smooths), exact, catmull-rom, linear")
        ->type_name("NAME");
    keys.add("--derivative-filter", "quality.derivative_filter",
             "Filter of the gradient, and so of the shading (default: that of --filter); one "
             "that smooths goes well with a value that interpolates")
        ->type_name("NAME");
    keys.add("--guarantee", "quality.guarantee",
             "No ray passes through more than this of the object unseen [voxels] (default 0.01)")
        ->type_name("SIZE");
    keys.add("--rate", "quality.rate",
             "Take R samples per voxel instead of certified steps; thin pieces may be missed")
        ->type_name("R");
    add_parsed(keys.app, "--max-error", keys.command.max_error_world, number_from,
               "Choose the filter, and the resolution of a mesh or a built-in field, that draw the "
               "surface within E of the true one in the least time, by what `isocast accuracy "
               "--calibrate` measured")
        ->type_name("E")
        ->excludes("--filter")
        ->excludes("--resolution")
        ->excludes("--rate");
    keys.add("--rate-factor", "quality.rate_factor",
             "With --rate: N times as many samples within a voxel of the surface (default 1)")
        ->type_name("N");
    keys.add("--traversal", "quality.traversal",
             "How rays find what to search; for comparison: lists (default, fastest), drawn "
             "(blocks as geometry), bounds (bounding geometry), walk (of the grid of blocks)")
        ->type_name("NAME");
    keys.add("--storage", "quality.storage",
             "Samples on the GPU: float32 (default), float16, norm16 (16 bits in even steps)")
        ->type_name("FORMAT");
    keys.add("--fetch", "quality.fetch",
             "How shaders read samples: rows (four a texel), samples (one: a quarter of the "
             "memory), linear (the same, eight by one filtered fetch where that is exact enough) "
             "or auto (default: the fastest, by a short measurement on GPUs)")
        ->type_name("NAME");
    keys.add("--brick-size", "quality.brick_size",
             "Cells along the edge of a brick: 8 (default), 16, 32; none: all of the volume in one "
             "array, for comparison")
        ->type_name("N");
    keys.add("--texture-memory", "quality.texture_memory",
             "Most memory for samples on the GPU (default 1024)")
        ->type_name("MIB");
    keys.add("--over-budget", "quality.over_budget",
             "Beyond that memory: stream (default: samples are loaded as rays ask for them; exact, "
             "slower) or coarsen (half the resolution, or less, where that shows least)")
        ->type_name("NAME");
    keys.add("--max-memory", "quality.max_memory",
             "Memory for a field's samples, e.g. 8G or 500M (default: half of what is available); "
             "beyond it a file's lie in a scratch file in TMPDIR, or in /var/tmp, and a mesh's are "
             "refused")
        ->type_name("SIZE");
}

void add_output_options(KeyOptions& keys) {
    keys.add("--size", "output.size", "Width and height in pixels (default 1024x1024)")
        ->type_name("WxH");
    keys.add("--samples", "output.samples", "Rays through each pixel: 1 (default), 2, 4 ... 64")
        ->type_name("N");
    keys.add_flag("--transparent", "output.transparent=true",
                  "PNG with alpha; OpenEXR has it anyway");
    keys.add("--aov", "output.aov",
             "More channels for an .exr, joined by ',': P (position), N (normal), curvature (k1, "
             "k2, mean, gauss, shapeIndex, curvedness, flag), T (principal directions), AO, "
             "shadow, id, steps (how often each ray looked at the field)")
        ->type_name("LIST");
    keys.add_flag("--no-beauty", "output.beauty=false",
                  "An .exr of these alone: nothing is shaded");
    keys.add("--frames", "output.frames",
             "A sequence of N frames, or those from A to B; the output's name holds %04d")
        ->type_name("N|A..B");
    keys.add("--tile", "output.tile",
             "Draw in tiles of N^2 pixels, for less memory (default: only pictures of more than "
             "2^24 pixels)")
        ->type_name("N");
}

} // namespace

CLI::App* add_render_options(CLI::App& program, RenderCommand& command) {
    CLI::App* app =
        program.add_subcommand("render", "Draw a scene, or the isosurfaces of fields and meshes");
    app->add_option(
           "IN", command.inputs,
           "Scene (.toml); or fields (.vdb .nrrd .nhdr .mhd .mha .nii .nii.gz, "
           "FILE.vdb:GRID, field:NAME@N), meshes (.obj .ply .stl .off, mesh:NAME), "
           "which are converted on the way, molecules (.pdb .ent .cif .mmcif .xyz), and SLIM "
           "surfaces (.slim), all in one picture")
        ->required();
    app->add_option("-o,--output", command.output, "Picture to write (.png, .exr)")
        ->required()
        ->type_name("FILE");
    KeyOptions keys{*app, command};
    add_output_options(keys);
    add_scene_options(keys);
    add_quality_options(keys);
    add_parsed(*app, "--backend", command.backend, offscreen_backend_from,
               "OpenGL through: auto (egl, then osmesa), egl, osmesa")
        ->type_name("NAME");
    app->add_flag(
        "--reference", command.reference,
        "Draw in double on the processor, without OpenGL: slow, and what the GPU's pictures "
        "are compared with (docs/raycasting.md says what it does not draw)");
    app->add_option("--repeat", command.repeat, "Draw each frame N times and report median times")
        ->check(CLI::Range(1, 10000))
        ->type_name("N");
    app->add_flag(
        "--explain", command.explain,
        "Show what was asked for, and each pass: what asked for it, its time, its memory");
    command.threads =
        tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
    add_threads(*app, command.threads);
    app->add_flag("--json", command.json, "Report as JSON");
    app->footer("Example: isocast render bunny.vdb -o bunny.png --camera \"direction=1,0.5,1\"");
    return app;
}

std::string RenderCommand::input() const {
    return fmt::format("{}", fmt::join(inputs, ", "));
}

SceneFile scene_of(const RenderCommand& command) {
    SceneFile scene;
    const auto scene_file = std::ranges::find_if(
        command.inputs, [](const std::string& input) { return input.ends_with(".toml"); });
    if (scene_file != command.inputs.end()) {
        if (command.inputs.size() > 1)
            throw UsageError(fmt::format("{}: a scene stands alone; its [[object]]s are drawn "
                                         "together",
                                         *scene_file));
        scene = read_scene_file(*scene_file);
    } else {
        for (const std::string& input : command.inputs) {
            SceneObject& object = scene.objects.emplace_back();
            source_of(object, input_from(input)) = input;
        }
        if (command.resolution &&
            std::ranges::all_of(scene.objects, &std::string::empty, &SceneObject::mesh))
            throw UsageError(fmt::format("--resolution: {} is no mesh", command.input()));
    }
    for (const std::string& setting : command.settings) {
        try {
            set_key(scene, setting);
        } catch (const UsageError& error) {
            throw UsageError(fmt::format("--set {}", error.what()));
        }
    }
    for (const auto& change : command.overrides) change(scene);
    if (command.resolution)
        for (SceneObject& object : scene.objects)
            if (!object.mesh.empty()) object.resolution = command.resolution;
    check_scene(scene);
    return scene;
}

} // namespace isocast
