// SPDX-License-Identifier: MPL-2.0
#include "apps/verbs.h"

#include "apps/console.h"
#include "apps/inputs.h"
#include "apps/parsed_option.h"
#include "apps/verdict_json.h"
#include "distance_transform/convert.h"
#include "volume/files.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <tbb/global_control.h>

namespace isocast {

namespace {

struct ConvertCommand {
    std::string input;
    std::filesystem::path output;
    std::optional<double> voxel_size_world;
    int resolution = 256;
    double band_voxels = 3;
    std::optional<double> band_world;
    SignMethod sign = SignMethod::Auto;
    std::size_t threads =
        tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
    bool json = false;
};

struct Seconds {
    double read, prepare, transform, write, total;
};

void report_json(const ConvertCommand& command, const CheckedMesh& mesh,
                 const ConvertOptions& options, const ConvertResult& result,
                 const std::vector<std::string>& warnings, const Seconds& seconds) {
    print_json({{"input", command.input},
                {"output", command.output.string()},
                {"triangles", mesh.verdict.triangles},
                {"verdict", to_json(mesh.verdict)},
                {"sign", name_of(result.sign_used)},
                {"voxel_size", options.voxel_size_world},
                {"half_width_voxels", options.half_width_voxels},
                {"active_voxels", result.field.active_voxel_count()},
                {"seconds",
                 {{"read", seconds.read},
                  {"prepare", seconds.prepare},
                  {"transform", seconds.transform},
                  {"write", seconds.write},
                  {"total", seconds.total}}},
                {"peak_bytes", peak_memory_bytes()},
                {"warnings", warnings}});
}

void report(const ConvertCommand& command, const CheckedMesh& mesh, const ConvertOptions& options,
            const ConvertResult& result, const Seconds& seconds) {
    const Index3 size = result.field.extent().size();
    fmt::print("{}: {} triangles, {}\n", command.input, mesh.verdict.triangles,
               mesh.verdict.summary());
    fmt::print("{}: {} active voxels of {:.6g} in {} x {} x {}, band of {:.4g} voxels on either "
               "side, signs by {}\n",
               command.output.string(), result.field.active_voxel_count(), options.voxel_size_world,
               size.x(), size.y(), size.z(), options.half_width_voxels, name_of(result.sign_used));
    fmt::print("{:.2f} s: read {:.2f}, prepare {:.2f}, transform {:.2f}, write {:.2f}\n",
               seconds.total, seconds.read, seconds.prepare, seconds.transform, seconds.write);
}

void run(const ConvertCommand& command, Console& console) {
    const Stopwatch total;
    const Input input = input_from(command.input);
    check_output(command.output, {".vdb"});
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                      command.threads);
    const Progress progress = console.progress();

    Stopwatch step;
    progress("reading", 0);
    const CheckedMesh mesh = read_checked_mesh(input);
    Seconds seconds{};
    seconds.read = step.lap();

    ConvertOptions options{.sign = command.sign};
    options.voxel_size_world =
        command.voxel_size_world
            ? *command.voxel_size_world
            : voxel_size_for_resolution(bounding_box(mesh.mesh), command.resolution);
    options.half_width_voxels =
        command.band_world ? *command.band_world / options.voxel_size_world : command.band_voxels;
    const ConvertResult result = convert(mesh, options, progress);
    seconds.prepare = result.time.prepare_seconds;
    seconds.transform = result.time.transform_seconds;

    step.lap();
    progress("writing", 0);
    write_vdb(result.field, command.output,
              {{"creator", "isocast " ISOCAST_VERSION},
               {"source", command.input},
               {"sign_method", std::string(name_of(result.sign_used))},
               {"half_width_voxels", fmt::format("{}", options.half_width_voxels)}});
    seconds.write = step.lap();
    seconds.total = total.seconds();

    console.end_progress();
    std::vector<std::string> warnings = mesh.warnings;
    warnings.insert(warnings.end(), result.warnings.begin(), result.warnings.end());
    for (const std::string& warning : warnings)
        console.warn(fmt::format("{}: {}", command.input, warning));
    if (command.json)
        report_json(command, mesh, options, result, warnings, seconds);
    else
        report(command, mesh, options, result, seconds);
}

} // namespace

Verb convert_verb(CLI::App& program) {
    CLI::App* app = program.add_subcommand("convert", "Turn a mesh into a signed distance field");
    const auto command = std::make_shared<ConvertCommand>();
    app->add_option("IN", command->input, "Mesh file (.obj .ply .stl .off) or mesh:NAME")
        ->required();
    app->add_option("-o,--output", command->output, "Level set to write (.vdb)")
        ->required()
        ->type_name("FILE");
    auto* voxel_size = add_parsed(*app, "--voxel-size", command->voxel_size_world, number_from,
                                  "Edge of a voxel, in units of the mesh")
                           ->type_name("H");
    add_parsed(*app, "--resolution", command->resolution, integer_from,
               "Voxels along the longest side of the mesh (default 256)")
        ->type_name("N")
        ->excludes(voxel_size);
    auto* band = add_parsed(*app, "--band", command->band_voxels, number_from,
                            "Half width of the band, in voxels (default 3)")
                     ->type_name("B");
    add_parsed(*app, "--band-world", command->band_world, number_from,
               "Half width of the band, in units of the mesh")
        ->type_name("D")
        ->excludes(band);
    add_parsed(*app, "--sign", command->sign, sign_method_from_name,
               "How inside is told from outside: auto, normal (closed meshes), winding")
        ->type_name("METHOD");
    add_threads(*app, command->threads);
    app->add_flag("--json", command->json, "Report as JSON");
    app->footer("Example: isocast convert bunny.obj -o bunny.vdb --resolution 512");
    return {app, [command](Console& console) { run(*command, console); }};
}

} // namespace isocast
