// SPDX-License-Identifier: MPL-2.0
#include "apps/verbs.h"

#include "apps/console.h"
#include "apps/convert_report.h"
#include "apps/gpu_scanner.h"
#include "apps/inputs.h"
#include "apps/mesh_repair.h"
#include "apps/octree_output.h"
#include "apps/parsed_option.h"
#include "apps/points_input.h"
#include "apps/slim_output.h"
#include "apps/verdict_json.h"
#include "distance_transform/convert.h"
#include "quadrics/slim_file.h"
#include "volume/errors.h"
#include "volume/files.h"
#include "volume/sparsify.h"
#include "volume/sweep.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <tbb/global_control.h>

#include <set>

namespace isocast {

namespace {

enum class Method { Prism, Csc, KdTree, Octree, Points };
enum class PrismKind { Exact, Printed };
enum class Extend { None, Full, Exact };
enum class Device { Cpu, Gl };

struct ConvertCommand {
    std::vector<std::string> inputs;
    std::filesystem::path output;
    std::filesystem::path out_dir;
    std::optional<double> voxel_size_world;
    std::optional<int> resolution;   // 256 if nothing says how fine
    std::optional<double> max_error; // [world]; of a .slim by the diagonal of the mesh's box
    double band_voxels = 3;
    std::optional<double> band_world;
    SignMethod sign = SignMethod::Auto;
    Method method = Method::Prism;
    MeshlessOptions meshless;
    OctreeCommand octree;
    PrismKind prism = PrismKind::Exact;
    Extend extend = Extend::None;
    Device device = Device::Cpu;
    bool closest = false;
    bool repair = false;
    bool dry_run = false;
    double memory_bytes = std::numeric_limits<double>::infinity();
    std::size_t threads =
        tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
    bool json = false;
    std::vector<std::filesystem::path> shader_folders = {};
    std::vector<std::filesystem::path> data_folders = {};

    /// A full grid instead of a band, computed sample by sample.
    bool is_dense() const { return method == Method::KdTree || extend == Extend::Exact; }
};

/// One mesh on its way to one file.
struct Job {
    std::string input;
    std::filesystem::path output;
};

std::vector<Job> jobs_of(const ConvertCommand& command) {
    if (command.out_dir.empty()) {
        if (command.inputs.size() > 1)
            throw UsageError("several inputs need --out-dir instead of -o");
        if (command.output.empty() && !command.dry_run)
            throw UsageError("an output is needed: -o FILE, or --out-dir DIR");
        return {{command.inputs.front(), command.output}};
    }
    if (!command.output.empty()) throw UsageError("-o and --out-dir exclude each other");
    std::vector<Job> jobs;
    std::set<std::filesystem::path> outputs;
    for (const std::string& text : command.inputs) {
        const Input input = input_from(text);
        const std::filesystem::path output =
            command.out_dir / (std::filesystem::path(input.name).stem().string() +
                               (command.method == Method::Octree ? ".hoct" : ".vdb"));
        if (!outputs.insert(output).second)
            throw UsageError(fmt::format("two inputs would become {}", output.string()));
        jobs.push_back({text, output});
    }
    return jobs;
}

void check_command(const ConvertCommand& command) {
    if (command.prism == PrismKind::Printed && command.method != Method::Prism)
        throw UsageError("--prism printed is a kind of --method prism");
    if (command.device == Device::Gl &&
        (command.method != Method::Prism || command.prism != PrismKind::Exact))
        throw UsageError("--device gl goes with the default method");
    if (command.closest && (command.method != Method::Prism || command.extend != Extend::None ||
                            command.prism != PrismKind::Exact))
        throw UsageError("--closest goes with the default method and no --extend");
    if (command.method != Method::Points && command.meshless != MeshlessOptions{})
        throw UsageError("--neighbours, --point-method, --approximation need --method points");
    const bool is_octree = command.method == Method::Octree;
    if (!is_octree && !command.max_error && command.octree.filter)
        throw UsageError("--interpolation needs --method octree or --max-error");
    if (!is_octree && command.max_error && !is_slim_file(command.output) &&
        (command.voxel_size_world || command.resolution || command.method == Method::Points ||
         command.prism == PrismKind::Printed))
        throw UsageError("--max-error chooses the resolution of a mesh's exact distances: no "
                         "--resolution, --voxel-size, --method points or --prism printed");
    if (command.method == Method::Octree && command.extend != Extend::None)
        throw UsageError("--method octree has no --extend: its field has a value everywhere");
    if (command.method == Method::Points &&
        (command.extend != Extend::None || command.sign != SignMethod::Auto || command.repair))
        throw UsageError("--method points has no --extend, --sign or --repair");
}

ConvertOptions options_for(const ConvertCommand& command, const WorldBox& box,
                           int usual_resolution = 256) {
    ConvertOptions options{.sign = command.sign,
                           .method = command.method == Method::Csc ? BandMethod::Csc
                                     : command.prism == PrismKind::Exact
                                         ? BandMethod::Scan
                                         : BandMethod::PrintedPrisms,
                           .closest = command.closest,
                           .memory_bytes = command.memory_bytes};
    options.voxel_size_world =
        command.voxel_size_world
            ? *command.voxel_size_world
            : voxel_size_for_resolution(box, command.resolution.value_or(usual_resolution));
    options.half_width_voxels =
        command.band_world ? *command.band_world / options.voxel_size_world : command.band_voxels;
    if (command.device == Device::Gl) options.scanner = gpu_scanner(command.shader_folders);
    return options;
}

std::map<std::string, std::string> metadata_of(const ConvertReport& report) {
    return {{"creator", "isocast " ISOCAST_VERSION},
            {"source", std::filesystem::path(report.input).filename().string()},
            {"sign_method", std::string(name_of(report.sign))},
            {"half_width_voxels", fmt::format("{}", report.options.half_width_voxels)}};
}

void write_full(const DenseField& field, const ConvertReport& report, const Progress& progress) {
    if (is_dense_file(report.output))
        write_dense(field, report.output, progress);
    else
        write_vdb(to_sparse(field, progress), report.output, metadata_of(report));
}

void write_band(const ConvertResult& result, const ConvertReport& report,
                const Progress& progress) {
    if (is_dense_file(report.output)) {
        write_dense(result.field, report.output, progress);
        return;
    }
    ClosestGrids closest;
    if (!result.closest.empty()) {
        closest.offset_world = [&](std::size_t block, int sample) {
            return result.closest[block].offset_world[sample];
        };
        closest.feature = [&](std::size_t block, int sample) {
            return result.closest[block].feature[sample];
        };
    }
    write_vdb(result.field, report.output, metadata_of(report), closest);
}

void convert_to_full(const ConvertCommand& command, const CheckedMesh& mesh, ConvertReport& report,
                     const Progress& progress) {
    Stopwatch step;
    if (command.is_dense()) {
        DenseConvertResult result = convert_dense(mesh, report.options, progress);
        report.take(result.sign_used, result.sign_reason, result.warnings);
        report.active_voxels = result.field.extent().sample_count();
        report.size = result.field.extent().size();
        report.seconds.transform = result.seconds;
        step.lap();
        write_full(result.field, report, progress);
    } else {
        const ConvertResult result = convert(mesh, report.options, progress);
        report.take(result.sign_used, result.sign_reason, result.warnings);
        report.seconds.prepare = result.time.prepare_seconds;
        report.seconds.transform = result.time.transform_seconds;
        progress("extending", 0);
        const DenseField full = extend_by_sweeping(result.field, dense_box(mesh, report.options));
        report.active_voxels = full.extent().sample_count();
        report.size = full.extent().size();
        report.seconds.transform = step.lap() - report.seconds.prepare;
        write_full(full, report, progress);
    }
    report.seconds.write = step.lap();
}

void take_band(const ConvertResult& result, ConvertReport& report, const Progress& progress) {
    report.take(result.sign_used, result.sign_reason, result.warnings);
    report.active_voxels = result.field.active_voxel_count();
    report.size = result.field.extent().size();
    report.seconds.prepare = result.time.prepare_seconds;
    report.seconds.transform = result.time.transform_seconds;
    Stopwatch step;
    progress("writing", 0);
    write_band(result, report, progress);
    report.seconds.write = step.lap();
}

ConvertReport points_job(const ConvertCommand& command, const Job& job, const Input& input,
                         const Progress& progress) {
    Stopwatch step;
    const CheckedPoints points = read_checked_points(input, command.meshless.neighbours);
    ConvertReport report{.input = job.input,
                         .output = job.output,
                         .options = options_for(command, bounding_box(points)),
                         .points = report_of(points, command.meshless),
                         .warnings = points.warnings};
    report.seconds.read = step.lap();
    if (command.dry_run)
        report.expected = estimate(points, report.options);
    else
        take_band(convert_points(points, report.options, command.meshless, progress), report,
                  progress);
    return report;
}

/// The coarsest field that keeps --max-error, drawn as `isocast render` does, or linearly.
Promise promise_of(const ConvertCommand& command, const CheckedMesh& mesh,
                   const Progress& progress) {
    const Filter filter =
        command.octree.filter == OctreeFilter::Linear ? Filter::Linear : Filter::Interpolating;
    return promise_for(mesh, *command.max_error, read_front(command.data_folders), progress,
                       std::array{filter});
}

ConvertReport mesh_job(const ConvertCommand& command, const Job& job, const Input& input,
                       const Progress& progress) {
    Stopwatch step;
    CheckedMesh mesh = read_checked_mesh(input);
    if (command.repair) {
        progress("repairing", 0);
        mesh = repaired(mesh);
    }
    ConvertReport report{.input = job.input,
                         .output = job.output,
                         .verdict = mesh.verdict,
                         .warnings = mesh.warnings};
    if (command.max_error && command.method != Method::Octree)
        report.promise = promise_of(command, mesh, progress);
    report.options = options_for(command, bounding_box(mesh.mesh),
                                 report.promise ? *report.promise->resolution : 256);
    report.seconds.read = step.lap();
    if (command.method == Method::Octree)
        convert_to_octree(command.octree, mesh, command.max_error,
                          command.voxel_size_world || command.resolution
                              ? std::optional(report.options.voxel_size_world)
                              : std::nullopt,
                          command.band_world.value_or(0), command.dry_run, report, progress);
    else if (command.dry_run)
        report.expected = estimate(mesh, report.options);
    else if (command.is_dense() || command.extend == Extend::Full)
        convert_to_full(command, mesh, report, progress);
    else
        take_band(convert(mesh, report.options, progress), report, progress);
    return report;
}

/// From one kind of field file to another.
ConvertReport octree_job(const ConvertCommand& command, const Job& job, const Input& input,
                         const Progress& progress) {
    if (job.output.extension() != ".vdb" || command.dry_run)
        throw UsageError(fmt::format("{} is an octree: it can become a .vdb file", job.input));
    ConvertReport report{.input = job.input, .output = job.output};
    report.options.half_width_voxels = command.band_voxels;
    Stopwatch step;
    report.active_voxels =
        export_octree(input.name, job.output, command.octree.grids, command.band_voxels, progress);
    report.seconds.write = step.lap();
    report.is_export = true;
    return report;
}

ConvertReport run_job(const ConvertCommand& command, const Job& job, Console& console) {
    const Stopwatch total;
    const Input input = input_from(job.input);
    if (!command.dry_run) {
        if (command.method == Method::Octree)
            check_output(job.output, {".hoct", ".vdb"});
        else
            check_output(job.output, {".vdb", ".nrrd", ".mhd", ".vti"});
    }
    const Progress progress = console.progress();
    progress("reading", 0);
    const bool is_octree = input.kind == Input::Kind::FieldFile && is_octree_file(input.name);
    ConvertReport report = is_octree ? octree_job(command, job, input, progress)
                           : command.method == Method::Points
                               ? points_job(command, job, input, progress)
                               : mesh_job(command, job, input, progress);
    report.seconds.total = total.seconds();
    console.end_progress();
    for (const std::string& warning : report.warnings)
        console.warn(fmt::format("{}: {}", job.input, warning));
    return report;
}

/// A surface of pieces of quadrics, no field.
void run_slim(const ConvertCommand& command, const Job& job, Console& console) {
    const bool takes_points = command.method == Method::Points;
    if ((command.method != Method::Prism && !takes_points) || command.prism != PrismKind::Exact ||
        command.voxel_size_world || command.resolution || command.extend != Extend::None ||
        command.device != Device::Cpu || command.closest || command.dry_run ||
        command.sign != SignMethod::Auto || command.octree.filter || command.band_world ||
        command.meshless != MeshlessOptions{.neighbours = command.meshless.neighbours})
        throw UsageError("a .slim is no field: it has --max-error, --repair, --threads, and of "
                         "--method points --neighbours alone");
    check_output(job.output, {".slim"});
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                      command.threads);
    const Progress progress = console.progress();
    progress("reading", 0);
    const auto convert = [&](const auto& read) {
        for (const std::string& warning : read.warnings)
            console.warn(fmt::format("{}: {}", job.input, warning));
        convert_to_slim(job.input, read, command.max_error, job.output, command.json,
                        [&](std::string_view stage, double fraction) {
                            progress(stage, fraction);
                            if (fraction >= 1) console.end_progress();
                        });
    };
    const Input input = input_from(job.input);
    if (takes_points) {
        convert(read_checked_points(input, command.meshless.neighbours));
        return;
    }
    const CheckedMesh mesh = read_checked_mesh(input);
    convert(command.repair ? repaired(mesh) : mesh);
}

void run(const ConvertCommand& command, Console& console) {
    check_command(command);
    const std::vector<Job> jobs = jobs_of(command);
    if (jobs.size() == 1 && is_slim_file(jobs.front().output)) {
        run_slim(command, jobs.front(), console);
        return;
    }
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                      command.threads);
    if (jobs.size() == 1) {
        const ConvertReport report = run_job(command, jobs.front(), console);
        if (command.json)
            print_json(to_json(report, command.threads));
        else
            print(report, command.threads);
        return;
    }
    // A batch goes on after a mesh that fails, and fails in the end as the first of those did.
    nlohmann::ordered_json all = nlohmann::ordered_json::array();
    std::exception_ptr first_failure;
    for (const Job& job : jobs) {
        try {
            const ConvertReport report = run_job(command, job, console);
            if (command.json)
                all.push_back(to_json(report, command.threads));
            else
                print(report, command.threads);
        } catch (const Interrupted&) {
            throw;
        } catch (const std::exception& error) {
            console.end_progress();
            if (first_failure)
                console.error(error.what());
            else
                first_failure = std::current_exception();
        }
    }
    if (command.json) print_json(all);
    if (first_failure) std::rethrow_exception(first_failure);
}

void add_accuracy_options(CLI::App& app, ConvertCommand& command) {
    auto* voxel_size = add_parsed(app, "--voxel-size", command.voxel_size_world, number_from,
                                  "Edge of a voxel, in units of the mesh")
                           ->type_name("H");
    add_parsed(app, "--resolution", command.resolution, integer_from,
               "Voxels along the longest side of the mesh (default 256)")
        ->type_name("N")
        ->excludes(voxel_size);
    auto* band = add_parsed(app, "--band", command.band_voxels, number_from,
                            "Half width of the band, in voxels (default 3)")
                     ->type_name("B");
    add_parsed(app, "--band-world", command.band_world, number_from,
               "Half width of the band, in units of the mesh; of --method octree: how far from the "
               "surface the error is kept")
        ->type_name("D")
        ->excludes(band);
    add_parsed(app, "--max-error", command.max_error, number_from,
               "What the surface may be off by, in units of the mesh: chooses the resolution, by "
               "`isocast accuracy`; of --method octree: the cells (default a thousandth of the "
               "longest side). Of a .slim a part of the box's diagonal (default 1e-3)")
        ->type_name("E");
}

void add_method_options(CLI::App& app, ConvertCommand& command) {
    add_parsed(app, "--sign", command.sign, sign_method_from_name,
               "How inside is told from outside: auto, normal (closed meshes), winding, unsigned")
        ->type_name("METHOD");
    add_choice<Method>(
        app, "--method", command.method,
        {{"octree", Method::Octree},
         {"prism", Method::Prism},
         {"csc", Method::Csc},
         {"kdtree", Method::KdTree},
         {"points", Method::Points}},
        "prism (default), csc (reference, one thread), kdtree (every sample), octree (adaptive), "
        "points (vertices alone)")
        ->type_name("METHOD");
    add_point_options(app, command.meshless);
    add_octree_options(app, command.octree);
    add_choice<PrismKind>(app, "--prism", command.prism,
                          {{"exact", PrismKind::Exact}, {"printed", PrismKind::Printed}},
                          "exact (default), or printed as in the thesis, for comparison")
        ->type_name("KIND");
    add_choice<Extend>(app, "--extend", command.extend,
                       {{"none", Extend::None}, {"full", Extend::Full}, {"exact", Extend::Exact}},
                       "Beyond the band: none (default), full by fast sweeping, exact by kD-tree")
        ->type_name("HOW");
    add_choice<Device>(app, "--device", command.device, {{"cpu", Device::Cpu}, {"gl", Device::Gl}},
                       "Where bands are scan converted: cpu (default), or gl, with the same result")
        ->type_name("DEVICE");
    app.add_flag("--closest", command.closest,
                 "Also store the vector to the closest point, and the number of its feature");
}

} // namespace

Verb convert_verb(CLI::App& program, std::vector<std::filesystem::path> shader_folders,
                  std::vector<std::filesystem::path> data_folders) {
    CLI::App* app = program.add_subcommand("convert", "Turn meshes into signed distance fields");
    const auto command = std::make_shared<ConvertCommand>();
    command->shader_folders = std::move(shader_folders);
    command->data_folders = std::move(data_folders);
    app->add_option("IN", command->inputs,
                    "Mesh files (.obj .ply .stl .off) or mesh:NAME; points: also .xyz; or a .hoct")
        ->required();
    app->add_option(
           "-o,--output", command->output,
           "Field to write (.vdb; dense: .nrrd .mhd .vti; octree: .hoct), or pieces of quadrics "
           "(.slim)")
        ->type_name("FILE");
    app->add_option("--out-dir", command->out_dir,
                    "Folder for one .vdb (octree: .hoct) for each input")
        ->type_name("DIR");
    add_accuracy_options(*app, *command);
    add_method_options(*app, *command);
    app->add_flag("--repair", command->repair,
                  "First close holes and orient triangles (builds with ISOCAST_REPAIR)");
    app->add_flag("--dry-run", command->dry_run,
                  "Only say what it would take, in memory and in time");
    add_parsed(*app, "--max-memory", command->memory_bytes, bytes_from,
               "Refuse to take more, e.g. 8G or 500M")
        ->type_name("SIZE");
    add_threads(*app, command->threads);
    app->add_flag("--json", command->json, "Report as JSON");
    app->footer("Example: isocast convert bunny.obj -o bunny.vdb --resolution 512");
    return {app, [command](Console& console) { run(*command, console); }};
}

} // namespace isocast
