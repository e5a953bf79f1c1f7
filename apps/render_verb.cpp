// SPDX-License-Identifier: MPL-2.0
#include "apps/verbs.h"

#include "apps/camera_spec.h"
#include "apps/console.h"
#include "apps/exr_layers.h"
#include "apps/inputs.h"
#include "apps/parsed_option.h"
#include "apps/verdict_json.h"
#include "distance_transform/convert.h"
#include "raycaster/fetch_choice.h"
#include "volume/errors.h"
#include "volume/histogram.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <tbb/global_control.h>

#include <algorithm>
#include <charconv>

namespace isocast {

namespace {

struct Size {
    int width = 1024;
    int height = 1024;
};

struct RenderCommand {
    std::string input;
    std::filesystem::path output;
    Size size;
    CameraSpec camera;
    std::optional<double> iso_world;
    Filter filter = Filter::Interpolating;
    Traversal traversal = Quality{}.traversal;
    std::optional<Filter> derivative_filter;
    double guarantee_voxels = Quality{}.guarantee_voxels;
    std::optional<double> rate;
    int rate_factor = Quality{}.rate_factor;
    StorageOptions storage;
    std::optional<Fetch> fetch; // the fastest
    std::optional<double> memory_bytes;
    std::optional<int> resolution; // of meshes
    gl::Backend backend = gl::Backend::Auto;
    std::optional<ExrLayers> layers;
    int repeat = 1;
    bool explain = false;
    std::size_t threads =
        tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
    bool json = false;
};

struct Seconds {
    double field = 0;   // reading, and for meshes converting
    double context = 0; // OpenGL
    double load = 0;    // active blocks, bricks to the GPU
    double draw = 0;    // all frames
    double write = 0;
    double total = 0;
};

Size size_from(std::string_view text) {
    Size size;
    const char* end = text.data() + text.size();
    const auto [x, no_width] = std::from_chars(text.data(), end, size.width);
    if (no_width == std::errc{} && x != end && *x == 'x') {
        const auto [rest, no_height] = std::from_chars(x + 1, end, size.height);
        if (no_height == std::errc{} && rest == end && size.width > 0 && size.height > 0)
            return size;
    }
    throw UsageError(fmt::format("'{}' is not WxH in pixels, like 1024x768", text));
}

gl::Backend offscreen_backend_from(std::string_view name) {
    if (name != "auto" && name != "egl" && name != "osmesa")
        throw UsageError(fmt::format("'{}' is not one of auto, egl, osmesa", name));
    return gl::backend_from_name(name);
}

double guarantee_from(std::string_view text) {
    const double size = number_from(text);
    // 1e-4: a few steps of float coordinates; 1: a voxel, beyond which samples alone would see
    // less.
    if (!(size >= 1e-4 && size <= 1))
        throw UsageError(fmt::format("{} does not lie between 0.0001 and 1", text));
    return size;
}

double rate_from(std::string_view text) {
    const double rate = number_from(text);
    // 64: beyond 512 fine samples per voxel float positions do not resolve them.
    if (!(rate > 0 && rate <= 64))
        throw UsageError(fmt::format("{} does not lie above 0 and up to 64", text));
    return rate;
}

/// A name from the command line: what is wrong with it is wrong with the command.
template<auto from_name>
auto named(std::string_view name) {
    try {
        return from_name(name);
    } catch (const InputError& error) {
        throw UsageError(error.what());
    }
}

std::optional<Fetch> fetch_or_auto_from(std::string_view name) {
    if (name == "auto") return std::nullopt;
    try {
        return fetch_from_name(name);
    } catch (const InputError& error) {
        throw UsageError(fmt::format("{}, auto", error.what()));
    }
}

std::int64_t mebibytes_from(std::string_view text) {
    const double mebibytes = number_from(text);
    if (!(mebibytes > 0 && mebibytes <= 1 << 20))
        throw UsageError(fmt::format("{} does not lie above 0 and up to 2^20", text));
    return static_cast<std::int64_t>(mebibytes * (1 << 20));
}

/// The last frame's report, with median pass times over all frames.
FrameReport draw_frames(Renderer& renderer, const Camera& camera, const RenderCommand& command,
                        const ImageSet& wanted, const Progress& progress) {
    FrameReport report;
    std::vector<std::vector<double>> times;
    for (int frame = 0; frame < command.repeat; ++frame) {
        progress("drawing", double(frame) / command.repeat);
        report = renderer.draw(camera, command.size.width, command.size.height, wanted);
        times.resize(report.passes.size());
        for (std::size_t i = 0; i < times.size(); ++i)
            times[i].push_back(report.passes[i].milliseconds);
    }
    for (std::size_t i = 0; i < times.size(); ++i) {
        auto middle = times[i].begin() + command.repeat / 2;
        std::nth_element(times[i].begin(), middle, times[i].end());
        report.passes[i].milliseconds = *middle;
    }
    return report;
}

void write(const RenderCommand& command, const Renderer& renderer, const Camera& camera,
           const Scene& scene, const gl::DriverInfo& driver) {
    Image beauty = renderer.read(FrameImage::Beauty);
    if (command.output.extension() == ".png") {
        write_png(beauty, command.output);
        return;
    }
    const ExrLayers layers = command.layers.value_or(ExrLayers{});
    const FrameImages images{std::move(beauty), renderer.read(FrameImage::Hit),
                             layers.normal ? renderer.read(FrameImage::Gradient) : Image{},
                             layers.curvature ? renderer.read(FrameImage::Curvature) : Image{}};
    ExrImage exr = exr_image(images, camera, layers);
    exr.floats = {{"iso", static_cast<float>(scene.iso_world)},
                  {"voxelSize", static_cast<float>(scene.field->space().voxel_size_world())}};
    exr.strings = {{"filter", std::string(filter_name(scene.filter))},
                   {"glRenderer", driver.renderer},
                   {"source", command.input}};
    if (scene.derivative_filter)
        exr.strings["derivativeFilter"] = filter_name(*scene.derivative_filter);
    write_exr(exr, command.output);
}

void report_json(const RenderCommand& command, const gl::DriverInfo& driver,
                 const Renderer& renderer, const FetchChoice& fetch, const FrameReport& frame,
                 const std::vector<std::string>& warnings, const Seconds& seconds) {
    nlohmann::ordered_json passes = nlohmann::ordered_json::array();
    for (const PassReport& pass : frame.passes)
        if (pass.ran)
            passes.push_back({{"name", pass.name},
                              {"ms", pass.milliseconds},
                              {"bytes", pass.texture_bytes},
                              {"asked_by", pass.asked_by},
                              {"drawn_by", pass.drawn_by}});
    const BrickPool& pool = renderer.pool();
    nlohmann::ordered_json coarse; // null unless bricks were coarsened
    if (const auto& bricks = renderer.coarse_bricks())
        coarse = {{"count", bricks->coarse_count()},
                  {"of", bricks->block_count()},
                  {"levels", bricks->counts},                        // bricks of 8, 4, 2, 1 cells
                  {"greatest_residual", bricks->greatest_residual}}; // world units
    print_json({{"input", command.input},
                {"output", command.output.string()},
                {"gl",
                 {{"backend", driver.backend},
                  {"vendor", driver.vendor},
                  {"renderer", driver.renderer},
                  {"version", driver.version}}},
                {"size", {command.size.width, command.size.height}},
                {"passes", passes},
                {"programs", frame.programs_compiled},
                {"texture_bytes", frame.image_bytes + frame.field_bytes},
                {"bricks",
                 {{"resident", pool.resident_count()},
                  {"active", pool.brick_count()},
                  {"loaded", pool.loaded_count()}}},
                {"fetch", fetch_name(fetch.fetch)},
                {"coarse_bricks", coarse},
                {"storage_error", pool.storage_error()}, // of a sample, world units
                {"seconds",
                 {{"field", seconds.field},
                  {"context", seconds.context},
                  {"load", seconds.load},
                  {"draw", seconds.draw},
                  {"write", seconds.write},
                  {"total", seconds.total}}},
                {"warnings", warnings}});
}

void explain(const FrameReport& frame, const Renderer& renderer, double voxel_size_world) {
    const BrickPool& pool = renderer.pool();
    constexpr double mib = 1 << 20;
    fmt::print("{:<12} {:>10} {:>10}  {}\n", "pass", "ms", "MiB", "asked by");
    for (const PassReport& pass : frame.passes)
        if (pass.ran)
            fmt::print("{:<12} {:>10.3f} {:>10.2f}  {}{}\n", pass.name, pass.milliseconds,
                       double(pass.texture_bytes) / mib, pass.asked_by,
                       pass.drawn_by.empty() ? "" : fmt::format(" (drawn by {})", pass.drawn_by));
        else
            fmt::print("{:<12} {:>10} {:>10}  {}\n", pass.name, "-", "-",
                       pass.is_kept ? pass.asked_by + " (kept from the frame before)"
                                    : "nothing: does not run");
    fmt::print("{} programs; images {:.2f} MiB, field {:.2f} MiB\n", frame.programs_compiled,
               double(frame.image_bytes) / mib, double(frame.field_bytes) / mib);
    fmt::print(
        "{} of {} bricks on the GPU, {} loaded; stored samples err by {:.2g} voxel at most\n",
        pool.resident_count(), pool.brick_count(), pool.loaded_count(),
        pool.storage_error() / voxel_size_world);
    if (const auto& coarse = renderer.coarse_bricks())
        fmt::print(
            "{} bricks of 8^3 cells, {} of 4^3, {} of 2^3, {} of 1: the field errs by {:.2g} "
            "voxel at most near the surface\n",
            coarse->counts[0], coarse->counts[1], coarse->counts[2], coarse->counts[3],
            coarse->greatest_residual / voxel_size_world);
}

void report(const RenderCommand& command, const gl::DriverInfo& driver, const Renderer& renderer,
            const Seconds& seconds) {
    fmt::print("{}: {} x {} pixels by {} ({}), {} bricks\n", command.output.string(),
               command.size.width, command.size.height, driver.renderer, driver.backend,
               renderer.pool().brick_count());
    fmt::print("{:.2f} s: field {:.2f}, context {:.2f}, load {:.2f}, draw {:.2f}, write {:.2f}\n",
               seconds.total, seconds.field, seconds.context, seconds.load, seconds.draw,
               seconds.write);
}

void run(const RenderCommand& command, const std::vector<std::filesystem::path>& shader_folders,
         Console& console) {
    const Stopwatch total;
    const bool is_png = command.output.extension() == ".png";
    const Input input = input_from(command.input);
    check_output(command.output, {".png", ".exr"});
    if (is_png && command.layers)
        throw UsageError(fmt::format("--aov: {}: a PNG holds the picture only; write an .exr",
                                     command.output.string()));
    if (!input.is_mesh() && command.resolution)
        throw UsageError(fmt::format("--resolution: {} is a field already", command.input));
    if (command.storage.over_budget == OverBudget::Coarsen &&
        kernel_of(command.filter) != Kernel::BSpline)
        throw UsageError(fmt::format("--over-budget coarsen: only cubic B-splines can be coarsened "
                                     "(--filter interpolating, bspline, exact), not {}",
                                     filter_name(command.filter)));
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                      command.threads);
    const Progress progress = console.progress();
    std::vector<std::string> warnings;
    const auto warn = [&](const std::string& warning) {
        console.warn(fmt::format("{}: {}", command.input, warning));
        warnings.push_back(warning);
    };

    // What is wrong with the input is said before OpenGL is tried, and that before the long work.
    Seconds seconds;
    Stopwatch step;
    progress("reading", 0);
    std::optional<CheckedMesh> mesh;
    Scene scene;
    scene.filter = command.filter;
    scene.derivative_filter = command.derivative_filter;
    scene.storage = command.storage;
    scene.quality.traversal = command.traversal;
    scene.quality.guarantee_voxels = command.guarantee_voxels;
    scene.quality.rate = command.rate;
    scene.quality.rate_factor = command.rate_factor;
    if (input.is_mesh())
        mesh = read_checked_mesh(input);
    else
        scene.field = read_field(input, command.memory_bytes.value_or(default_field_bytes()));
    // A file may hold anything; meshes and built-in fields have their surface at 0.
    scene.iso_world = command.iso_world.value_or(
        input.kind == Input::Kind::FieldFile ? suggested_iso(*scene.field).iso : 0);
    seconds.field = step.lap();

    const auto context = gl::make_context({.backend = command.backend});
    Renderer renderer(*context, first_folder_of(shader_folders));
    seconds.context = step.lap();

    if (mesh) {
        const ConvertOptions options{
            .voxel_size_world = voxel_size_for_resolution(bounding_box(mesh->mesh),
                                                          command.resolution.value_or(256)),
            .memory_bytes = command.memory_bytes.value_or(ConvertOptions{}.memory_bytes)};
        ConvertResult result = convert(*mesh, options, progress);
        for (const auto& warning : mesh->warnings) warn(warning);
        for (const auto& warning : result.warnings) warn(warning);
        scene.field = std::make_shared<SparseField>(std::move(result.field));
    }
    seconds.field += step.lap();

    FetchChoice fetch{command.fetch.value_or(Fetch::Rows), "asked for"};
    if (!command.fetch)
        fetch = choose_fetch(renderer, context->driver(), scene.filter, scene.storage);
    scene.storage.fetch = fetch.fetch;
    renderer.load(scene, progress);
    seconds.load = step.lap();
    if (const auto& coarse = renderer.coarse_bricks()) {
        warn(fmt::format(
            "over the texture budget: {} of {} bricks were coarsened; the surface moves "
            "by up to {:.2g} voxel where the field's slope is one",
            coarse->coarse_count(), coarse->block_count(),
            coarse->greatest_residual / scene.field->space().voxel_size_world()));
    }
    if (!renderer.has_surface()) {
        const ValueRange range = scene.field->value_range(scene.field->extent());
        warn(fmt::format("the field never crosses the iso value {}: its values lie in {} ... {}",
                         scene.iso_world, range.min, range.max));
    }

    ImageSet wanted{FrameImage::Beauty};
    if (!is_png) wanted.insert(FrameImage::Hit);
    if (command.layers && command.layers->normal) wanted.insert(FrameImage::Gradient);
    if (command.layers && command.layers->curvature) wanted.insert(FrameImage::Curvature);
    const Camera camera = camera_from(command.camera, renderer.surface_box_world(),
                                      double(command.size.width) / command.size.height);
    const FrameReport frame = draw_frames(renderer, camera, command, wanted, progress);
    seconds.draw = step.lap();
    write(command, renderer, camera, scene, context->driver());
    seconds.write = step.lap();
    seconds.total = total.seconds();

    console.end_progress();
    if (command.json) {
        report_json(command, context->driver(), renderer, fetch, frame, warnings, seconds);
        return;
    }
    if (command.explain) {
        explain(frame, renderer, scene.field->space().voxel_size_world());
        fmt::print("fetches {}: {}\n", fetch_name(fetch.fetch), fetch.reason);
    }
    report(command, context->driver(), renderer, seconds);
}

} // namespace

Verb render_verb(CLI::App& program, std::vector<std::filesystem::path> shader_folders) {
    CLI::App* app = program.add_subcommand("render", "Draw the isosurface of a field or mesh");
    const auto command = std::make_shared<RenderCommand>();
    app->add_option("IN", command->input,
                    "Field (.vdb .nrrd .nhdr .mhd .mha .nii .nii.gz, FILE.vdb:GRID, field:NAME@N) "
                    "or mesh (.obj .ply .stl .off, "
                    "mesh:NAME), which is converted on the way")
        ->required();
    app->add_option("-o,--output", command->output, "Picture to write (.png, .exr)")
        ->required()
        ->type_name("FILE");
    add_parsed(*app, "--size", command->size, size_from,
               "Width and height in pixels (default 1024x1024)")
        ->type_name("WxH");
    add_parsed(*app, "--camera", command->camera, camera_spec_from,
               "key=value pairs joined by ';': eye=x,y,z  target=x,y,z  direction=x,y,z (from the "
               "object to the eye; the object then fills the picture)  up=x,y,z  fov=degrees  "
               "height=H (orthographic)")
        ->type_name("SPEC");
    add_parsed(*app, "--iso", command->iso_world, number_from,
               "Iso value (default: 0 for distances; for other files what `isocast info` suggests)")
        ->type_name("V");
    add_parsed(
        *app, "--filter", command->filter, named<filter_from_name>,
        "From samples to a smooth function: interpolating (cubic B-spline through the samples, "
        "default), bspline (smooths), exact, catmull-rom, linear")
        ->type_name("NAME");
    add_parsed(*app, "--derivative-filter", command->derivative_filter, named<filter_from_name>,
               "Filter of the gradient, and so of the shading (default: that of --filter); one "
               "that smooths goes well with a value that interpolates")
        ->type_name("NAME");
    add_parsed(*app, "--guarantee", command->guarantee_voxels, guarantee_from,
               "No ray passes through more than this of the object unseen [voxels] (default 0.01)")
        ->type_name("SIZE");
    add_parsed(*app, "--rate", command->rate, rate_from,
               "Take R samples per voxel instead of certified steps; thin pieces may be missed")
        ->type_name("R");
    app->add_option(
           "--rate-factor", command->rate_factor,
           "With --rate: N times as many samples within a voxel of the surface (default 1)")
        ->check(CLI::Range(1, 64))
        ->type_name("N");
    add_parsed(
        *app, "--traversal", command->traversal, named<traversal_from_name>,
        "How rays find what to search; for comparison: lists (default, fastest), drawn (blocks "
        "as geometry), bounds (bounding geometry), walk (of the grid of blocks)")
        ->type_name("NAME");
    add_parsed(*app, "--storage", command->storage.format, named<sample_format_from_name>,
               "Samples on the GPU: float32 (default), float16, norm16 (16 bits in even steps)")
        ->type_name("FORMAT");
    add_parsed(*app, "--fetch", command->fetch, fetch_or_auto_from,
               "How shaders read samples: rows (four a texel), samples (one: a quarter of the "
               "memory), linear (the same, eight by one filtered fetch where that is exact enough) "
               "or auto (default: the fastest, by a short measurement on GPUs)")
        ->type_name("NAME");
    add_parsed(
        *app, "--brick-size", command->storage.brick_size, named<brick_size_from_name>,
        "Cells along the edge of a brick: 8 (default), 16, 32; none: all of the volume in one "
        "array, for comparison")
        ->type_name("N");
    add_parsed(*app, "--texture-memory", command->storage.budget_bytes, mebibytes_from,
               "Most memory for samples on the GPU (default 1024)")
        ->type_name("MIB");
    add_parsed(
        *app, "--over-budget", command->storage.over_budget, named<over_budget_from_name>,
        "Beyond that memory: stream (default: samples are loaded as rays ask for them; exact, "
        "slower) or coarsen (half the resolution, or less, where that shows least)")
        ->type_name("NAME");
    add_field_memory(*app, command->memory_bytes);
    add_parsed(*app, "--resolution", command->resolution, integer_from,
               "Meshes: voxels along the longest side (default 256)")
        ->type_name("N");
    add_parsed(*app, "--backend", command->backend, offscreen_backend_from,
               "OpenGL through: auto (egl, then osmesa), egl, osmesa")
        ->type_name("NAME");
    add_parsed(
        *app, "--aov", command->layers, exr_layers_from,
        "More channels for an .exr, joined by ',': P (position), N (normal), curvature (k1, k2, "
        "mean, gauss, shapeIndex, curvedness)")
        ->type_name("LIST");
    app->add_option("--repeat", command->repeat, "Draw N frames and report median times")
        ->check(CLI::Range(1, 10000))
        ->type_name("N");
    app->add_flag("--explain", command->explain,
                  "Show each pass: what asked for it, its time, its memory");
    add_threads(*app, command->threads);
    app->add_flag("--json", command->json, "Report as JSON");
    app->footer("Example: isocast render bunny.vdb -o bunny.png --camera \"direction=1,0.5,1\"");
    return {app, [command, folders = std::move(shader_folders)](Console& console) {
                run(*command, folders, console);
            }};
}

} // namespace isocast
