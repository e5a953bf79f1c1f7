// Field to picture: isocast beside other renderers, and what each of its settings costs.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/convert.h"
#include "distance_transform/mesh_files.h"
#include "filtering/filter.h"
#include "peers/child.h"
#include "peers/peer_frame.h"
#include "raycast/raycast_bench.h"
#include "volume/analytic_fields.h"
#include "volume/errors.h"
#include "volume/files.h"
#include "volume/histogram.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <sstream>

namespace {

using namespace isocast;

const std::filesystem::path shader_folder = std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders";

Camera camera_of(const PeerScene& scene) {
    return {.eye_world = scene.eye_world,
            .target_world = scene.target_world,
            .up = scene.up,
            .fov_y_degrees = scene.fov_degrees};
}

/// The voxel size of the published comparisons: longest side / (N - 9).
std::shared_ptr<const SparseField> field_of(const CheckedMesh& mesh, int resolution) {
    const double voxel = bounding_box(mesh.mesh).size().maxCoeff() / (resolution - 9);
    return std::make_shared<SparseField>(convert(mesh, {.voxel_size_world = voxel}).field);
}

struct Peer {
    const char* name;
    PeerFrame (*draw)(const PeerScene&);
    bool is_slow; // drawn in the first turn only
};

constexpr std::array all_peers{Peer{"openvdb", openvdb_peer, false},
                               Peer{"embree", embree_peer, false}, Peer{"vtk", vtk_peer, true},
                               Peer{"teem", teem_peer, true}};

int differing(const std::vector<bool>& a, const std::vector<bool>& b) {
    int count = 0;
    for (std::size_t i = 0; i < a.size(); ++i) count += a[i] != b[i];
    return count;
}

std::vector<bool> covered_by(const Renderer& renderer) {
    const Image hit = renderer.read(FrameImage::Hit);
    std::vector<bool> covered;
    for (std::size_t i = 3; i < hit.rgba.size(); i += 4) covered.push_back(hit.rgba[i] != 0);
    return covered;
}

/// Ours and the peers in turn; each draws once to warm up and once timed.
void run_frames(Renderer& renderer, const std::shared_ptr<const SparseField>& field, int resolution,
                int size, int repeats, const std::vector<std::string>& names) {
    PeerScene scene = scene_of_the_table(*field, resolution);
    scene.size = size;
    scene.repeats = 1;
    const Camera camera = camera_of(scene);
    renderer.load({.field = field});
    std::vector<double> ours;
    std::vector<double> ours_with_curvature;
    FrameReport report;
    FrameReport curvature_report;
    std::map<std::string, std::vector<double>> theirs;
    std::map<std::string, PeerFrame> last;
    for (int turn = 0; turn < repeats; ++turn) {
        frame_seconds(renderer, camera, size, report);
        ours.push_back(frame_seconds(renderer, camera, size, report));
        const ImageSet with_curvature{FrameImage::Beauty, FrameImage::Curvature};
        frame_seconds(renderer, camera, size, curvature_report, with_curvature);
        ours_with_curvature.push_back(
            frame_seconds(renderer, camera, size, curvature_report, with_curvature));
        for (const Peer& peer : all_peers) {
            if (std::ranges::find(names, peer.name) == names.end()) continue;
            if (peer.is_slow && turn > 0) continue;
            PeerFrame frame;
            try {
                frame = peer.draw(scene);
            } catch (const ResourceError& error) { // the others still count
                frame = {.name = peer.name, .note = error.what()};
            }
            if (frame.was_drawn()) theirs[peer.name].push_back(frame.frame_seconds);
            last[peer.name] = std::move(frame);
        }
    }
    const Timing own = timing_of(ours);
    const std::vector<bool> covered = covered_by(renderer);
    const auto count = std::ranges::count(covered, true);
    fmt::print("{:<10} {:<34} {:>8.4f} {:>8.4f} {:>7} {:>7.2f} {:>7}  passes [ms]:",
               fmt::format("{}@{}", resolution, size), "isocast, interpolating spline", own.median,
               own.least, "", 100.0 * double(count) / double(covered.size()), "");
    const auto print_passes = [](const FrameReport& of) {
        for (const PassReport& pass : of.passes)
            if (pass.ran) fmt::print(" {} {:.1f}", pass.name, pass.milliseconds);
        fmt::print("\n");
    };
    print_passes(report);
    const Timing second = timing_of(ours_with_curvature);
    fmt::print("{:<10} {:<34} {:>8.4f} {:>8.4f} {:>23}  passes [ms]:", "",
               "isocast, the same and k1, k2", second.median, second.least, "");
    print_passes(curvature_report);
    for (const Peer& peer : all_peers) {
        const auto found = last.find(peer.name);
        if (found == last.end()) continue;
        const PeerFrame& frame = found->second;
        if (!frame.was_drawn()) {
            fmt::print("{:<10} {:<34} {}\n", "", frame.name, frame.note);
            continue;
        }
        const Timing t = timing_of(theirs[peer.name]);
        fmt::print("{:<10} {:<34} {:>8.4f} {:>8.4f} {:>7.2f} {:>7.2f} {:>7}  {}\n", "", frame.name,
                   t.median, t.least, t.median / own.median, 100 * frame.covered_fraction,
                   differing(covered, frame.covered), frame.note);
    }
    std::fflush(stdout);
}

void print_cases(const char* title, const std::vector<DrawCase>& cases,
                 const std::vector<DrawResult>& results) {
    fmt::print("\n{}\n{:<24} {:>8} {:>8} {:>8} {:>8} {:>10}\n", title, "", "frame", "least", "load",
               "least", "field MB");
    for (std::size_t i = 0; i < cases.size(); ++i) {
        const DrawResult& r = results[i];
        fmt::print("{:<24} {:>8.4f} {:>8.4f} {:>8.4f} {:>8.4f} {:>10.2f}\n", cases[i].name,
                   r.frame.median, r.frame.least, r.load.median, r.load.least,
                   double(r.report.field_bytes) / 1e6);
    }
    std::fflush(stdout);
}

std::vector<DrawCase> guarantee_cases(const std::shared_ptr<const SparseField>& field) {
    std::vector<DrawCase> cases;
    for (const double size : {0.1, 0.01, 0.001})
        cases.push_back({fmt::format("guarantee {}", size),
                         {.field = field, .quality = {.guarantee_voxels = size}}});
    return cases;
}

std::vector<DrawCase> storage_cases(const std::shared_ptr<const SparseField>& field) {
    std::vector<DrawCase> cases;
    for (const auto& [fetch_name, fetch] :
         {std::pair{"rows", Fetch::Rows}, std::pair{"samples", Fetch::Samples},
          std::pair{"linear", Fetch::Linear}})
        for (const auto& [name, format] : {std::pair{"float32", SampleFormat::Float32},
                                           std::pair{"float16", SampleFormat::Float16},
                                           std::pair{"norm16", SampleFormat::Norm16}})
            for (const int brick : {8, 32}) {
                if (brick != 8 && format != SampleFormat::Float32) continue;
                cases.push_back(
                    {fmt::format("{} {}, bricks of {}", name, fetch_name, brick),
                     {.field = field,
                      .storage = {.fetch = fetch, .format = format, .brick_size = brick}}});
            }
    return cases;
}

std::vector<DrawCase> filter_cases(const std::shared_ptr<const SparseField>& field) {
    std::vector<DrawCase> cases;
    for (const Filter filter :
         {Filter::Interpolating, Filter::BSpline, Filter::CatmullRom, Filter::Linear})
        cases.push_back({std::string(filter_name(filter)), {.field = field, .filter = filter}});
    return cases;
}

/// The first frame of a new process: prints seconds of its parts.
void first_frame(const std::string& path, int resolution, int size, gl::Backend backend) {
    const auto start = std::chrono::steady_clock::now();
    auto lap_start = start;
    const auto lap = [&] {
        const double seconds = seconds_since(lap_start);
        lap_start = std::chrono::steady_clock::now();
        return seconds;
    };
    const std::shared_ptr<const FieldSource> field = read_field(path);
    const double read = lap();
    const auto context = gl::make_context({.backend = backend});
    Renderer renderer(*context, shader_folder);
    const double make_context = lap();
    renderer.load({.field = field});
    const double load = lap();
    const Camera camera =
        camera_of(scene_of_the_table(dynamic_cast<const SparseField&>(*field), resolution));
    FrameReport report;
    const double first = frame_seconds(renderer, camera, size, report);
    const double total = seconds_since(start);
    double second = first;
    for (int i = 0; i < 3; ++i)
        second = std::min(second, frame_seconds(renderer, camera, size, report));
    const auto control = control_samples(field, Filter::Interpolating);
    lap();
    find_block_ranges(*control, kernel_of(Filter::Interpolating));
    const double blocks = lap();
    fmt::print("{} {} {} {} {} {} {}\n", total, read, make_context, blocks, load - blocks,
               first - second, second);
}

/// New processes in turn: shaders compiled and not kept, compiled and kept, found kept.
void run_first_frame(const std::string& self, const CheckedMesh& mesh, int resolution, int size,
                     int repeats, const std::string& backend) {
    const ScratchFolder folder;
    const std::string path = folder / "field.vdb";
    write_vdb(*field_of(mesh, resolution), path);
    const std::string command =
        fmt::format("'{}' --first-frame '{}' --resolution {} --size {} --backend {}", self, path,
                    resolution, size, backend);
    constexpr std::array names{"no cache", "cache, cold", "cache, warm"};
    constexpr std::array parts{"process", "total",  "read",    "context",
                               "blocks",  "bricks", "compile", "draw"};
    std::array<std::array<std::vector<double>, parts.size()>, names.size()> taken;
    for (int turn = 0; turn < repeats; ++turn) {
        const std::string cache =
            fmt::format("MESA_SHADER_CACHE_DIR='{}'", folder / fmt::format("cache{}", turn));
        const std::array environments{std::string("MESA_SHADER_CACHE_DISABLE=true"), cache, cache};
        for (std::size_t i = 0; i < names.size(); ++i) {
            const auto start = std::chrono::steady_clock::now();
            std::istringstream output(run_child(environments[i] + " " + command));
            taken[i][0].push_back(seconds_since(start));
            for (std::size_t part = 1; part < parts.size(); ++part) {
                double seconds = NAN;
                output >> seconds;
                taken[i][part].push_back(seconds);
            }
        }
    }
    fmt::print("\nFirst frame of a new process, {}^3 @ {}^2, from a .vdb file: medians of seconds. "
               "Process: with start and end; blocks: finding the active ones; compile: the first "
               "frame less the best of three more\n{:<14}",
               resolution, size, "");
    for (const char* part : parts) fmt::print(" {:>8}", part);
    fmt::print(" {:>12}\n", "total least");
    for (std::size_t i = 0; i < names.size(); ++i) {
        fmt::print("{:<14}", names[i]);
        for (const auto& seconds : taken[i]) fmt::print(" {:>8.4f}", timing_of(seconds).median);
        fmt::print(" {:>12.4f}\n", timing_of(taken[i][1]).least);
    }
    std::fflush(stdout);
}

} // namespace

int main(int argc, char** argv) {
    CLI::App app("Field to picture: isocast beside other renderers");
    std::string mesh_path;
    int repeats = 7;
    std::vector<std::string> sizes{"256@512", "512@1024"};
    std::vector<std::string> peers{"openvdb", "embree"};
    std::string only;
    std::string backend = "auto";
    std::string field_path;
    std::string figure_folder;
    std::string volume_path;
    int resolution = 256;
    int size = 512;
    int threads = 2;
    app.add_option("MESH", mesh_path, "Mesh file");
    app.add_option("--repeats", repeats, "Turns");
    app.add_option("--sizes", sizes, "Voxels along the longest side, and nine, @ pixels")
        ->delimiter(',');
    app.add_option("--peers", peers, "openvdb, embree; vtk, teem: minutes")->delimiter(',');
    app.add_option(
        "--only", only,
        "A section: frames, first, storage, guarantee, filters, sizes, coarse, accuracy, fetches, "
        "rate, iso; of the "
        "thesis: table-6.1, table-6.2, silhouettes");
    app.add_option("--figures", figure_folder, "Folder for figures 6.3 and 6.8 of the thesis");
    app.add_option("--backend", backend, "auto, egl, osmesa");
    app.add_option("--threads", threads,
                   "Of the CPU parts and the peers; LP_NUM_THREADS is the GL's");
    app.add_option("--resolution", resolution, "Of all sections but frames");
    app.add_option("--size", size, "Of all sections but frames");
    app.add_option("--volume", volume_path, "A volume for the section iso");
    app.add_option("--first-frame", field_path)->group(""); // what run_first_frame calls
    CLI11_PARSE(app, argc, argv);
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism,
                                      static_cast<std::size_t>(threads));
    if (!field_path.empty()) {
        first_frame(field_path, resolution, size, gl::backend_from_name(backend));
        return 0;
    }

    const auto asked = [&](const char* section) { return only.empty() || only == section; };
    const auto context = gl::make_context({.backend = gl::backend_from_name(backend)});
    Renderer renderer(*context, shader_folder);
    fmt::print("{}, {} threads, medians and least of {} turns, seconds\n",
               context->driver().renderer, threads, repeats);
    std::optional<CheckedMesh> mesh;
    if (!mesh_path.empty()) mesh = check(read_mesh(mesh_path));

    if (mesh && asked("frames")) {
        fmt::print("\nFull picture: hit, normal, shading. Ratio: theirs over ours, of medians; "
                   "differ: pixels covered by one of the two\n"
                   "{:<10} {:<34} {:>8} {:>8} {:>7} {:>7} {:>7}\n",
                   "case", "", "median", "least", "ratio", "cover %", "differ");
        for (const std::string& text : sizes) {
            const auto at = text.find('@');
            const int n = std::stoi(text.substr(0, at));
            const int pixels = std::stoi(text.substr(at + 1));
            run_frames(renderer, field_of(*mesh, n), n, pixels, repeats, peers);
        }
    }
    if (mesh && (asked("storage") || asked("guarantee") || asked("filters"))) {
        const auto field = field_of(*mesh, resolution);
        const Camera camera = camera_of(scene_of_the_table(*field, resolution));
        const auto section = [&](const char* name, const std::string& title,
                                 const std::vector<DrawCase>& cases) {
            if (asked(name))
                print_cases(fmt::format("{}, {}^3 @ {}^2", title, resolution, size).c_str(), cases,
                            draw_in_turns(renderer, cases, camera, size, repeats));
        };
        section("storage", "Storage", storage_cases(field));
        section("guarantee", "Guarantee", guarantee_cases(field));
        section("filters", "Filters", filter_cases(field));
    }
    if (mesh && asked("sizes")) {
        for (const int n : {256, 512, 1024, 2048}) {
            const auto field = field_of(*mesh, n);
            std::vector<DrawCase> cases;
            for (const Fetch fetch : {Fetch::Rows, Fetch::Samples})
                cases.push_back({fmt::format("{}, float16", fetch_name(fetch)),
                                 {.field = field,
                                  .storage = {.fetch = fetch, .format = SampleFormat::Float16}}});
            print_cases(fmt::format("Sizes, {}^3 @ {}^2", n, size).c_str(), cases,
                        draw_in_turns(renderer, cases, camera_of(scene_of_the_table(*field, n)),
                                      size, std::min(repeats, 3)));
        }
    }
    if (mesh && asked("coarse")) {
        const auto field = field_of(*mesh, resolution);
        run_coarse(renderer, field, camera_of(scene_of_the_table(*field, resolution)), size,
                   repeats);
    }
    if (mesh && asked("first")) run_first_frame(argv[0], *mesh, resolution, size, repeats, backend);
    if (mesh && (asked("table-6.1") || asked("table-6.2") || !figure_folder.empty())) {
        const auto field = field_of(*mesh, resolution);
        const Camera camera = camera_of(scene_of_the_table(*field, resolution));
        if (asked("table-6.1")) {
            std::vector<TableField> fields;
            const auto add = [&](const std::string& name, std::shared_ptr<const FieldSource> f,
                                 const Camera& c) {
                fields.push_back({name, std::move(f), c});
            };
            const Camera from_front{.eye_world = {2.9, 2.2, 5.2}, .target_world = {0, 0, 0}};
            add("torus", sampled(builtin_field("torus"), 64), from_front);
            add("gyroid", sampled(builtin_field("gyroid"), 128), from_front);
            for (const int n : {128, 256, 512}) {
                const auto of_mesh = field_of(*mesh, n);
                add(std::filesystem::path(mesh_path).filename(), of_mesh,
                    camera_of(scene_of_the_table(*of_mesh, n)));
            }
            run_table_6_1(renderer, fields, size, repeats);
        }
        if (asked("table-6.2")) run_table_6_2(renderer, field, camera, size, repeats);
        if (!figure_folder.empty()) write_figures(renderer, field, camera, figure_folder);
    }
    if (asked("silhouettes")) run_silhouettes(renderer);
    if (asked("iso")) {
        // Its surface moves by a hundredth of a voxel and by one; the volume's by a thousandth of
        // the iso value that is suggested, and by a tenth.
        if (mesh) {
            const auto field = field_of(*mesh, resolution);
            const double voxel = field->space().voxel_size_world();
            run_moving_iso(renderer, fmt::format("the mesh at {}^3", resolution), {.field = field},
                           0.01 * voxel, voxel, repeats);
        }
        if (!volume_path.empty()) {
            const std::shared_ptr<const FieldSource> field = read_field(volume_path);
            const double iso = suggested_iso(*field).iso;
            run_moving_iso(renderer, volume_path, {.field = field, .iso_world = iso}, 0.001 * iso,
                           0.1 * iso, repeats);
        }
    }
    if (asked("accuracy")) run_accuracy(renderer);
    if (asked("fetches")) run_fetches(renderer, repeats);
    if (asked("rate")) run_filter_rate(repeats);
}
