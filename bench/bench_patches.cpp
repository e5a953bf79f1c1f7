// Bilinear patches and quadrics in tetrahedra: frames, patches and tetrahedra a second; and an
// isosurface as such quadrics against the ray caster's.
// SPDX-License-Identifier: MPL-2.0
#include "quadrics/quadratic_spline.h"
#include "quadrics/quadrics_bench.h"
#include "volume/analytic_fields.h"
#include "volume/files.h"
#include "volume/stopwatch.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace {

using namespace isocast;

Camera framed(Renderer& renderer, int w, int h) {
    return frame_box(renderer.surface_points_world(), {0.3, 0.4, 1}, double(w) / h, 30);
}

double seconds_of(Renderer& renderer, int w, int h, int repeats) {
    return median_frame_seconds(renderer, framed(renderer, w, h), w, h, repeats);
}

void load(Renderer& renderer, Primitives primitives) {
    renderer.load({.primitives = std::make_shared<Primitives>(std::move(primitives))});
}

/// A torus of about as many quads, twisted ones.
PatchMesh torus_of(int quads) {
    const int n = static_cast<int>(std::lround(std::sqrt(quads)));
    PatchMesh mesh;
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const double a = 2 * std::acos(-1.0) * (i + 0.5 * j) / n; // askew
            const double b = 2 * std::acos(-1.0) * j / n;
            mesh.vertices_world.emplace_back((1 + 0.4 * std::cos(b)) * std::cos(a),
                                             (1 + 0.4 * std::cos(b)) * std::sin(a),
                                             0.4 * std::sin(b));
        }
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            // Around once the tube, it is askew by half a turn.
            const int turn = j + 1 == n ? n / 2 : 0;
            const auto at = [&](int x, int y) { return (x % n) + n * (y % n); };
            mesh.quads.push_back(
                {at(i, j), at(i + 1, j), at(i + 1 + turn, j + 1), at(i + turn, j + 1)});
        }
    return mesh;
}

/// The same in two triangles a quad.
TriangleMesh halves_of(const PatchMesh& patches) {
    TriangleMesh mesh{.vertices_world = patches.vertices_world, .triangles = {}};
    for (const auto& [a, b, c, d] : patches.quads) {
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({a, c, d});
    }
    return mesh;
}

void run_patches(Renderer& renderer, int repeats) {
    fmt::print("patches: seconds a frame\nkind        count  1280x1024    512x512        2x2  "
               "1e6 a second at 2x2\n");
    for (const int quads : {100, 10000, 250000}) {
        const PatchMesh patches = torus_of(quads);
        for (const bool as_patches : {true, false}) {
            Primitives primitives;
            if (as_patches)
                primitives.patches = {patches};
            else
                primitives.meshes = {halves_of(patches)};
            const std::size_t count = primitives.count();
            load(renderer, std::move(primitives));
            const double tiny = seconds_of(renderer, 2, 2, repeats);
            fmt::print("{:<9} {:>7} {:>10.4f} {:>10.4f} {:>10.4f} {:>8.3f}\n",
                       as_patches ? "patches" : "triangles", count,
                       seconds_of(renderer, 1280, 1024, repeats),
                       seconds_of(renderer, 512, 512, repeats), tiny, double(count) / tiny / 1e6);
        }
    }
}

/// Of a built-in field, with so many tetrahedra at least.
TetrahedralMesh spline_of(const char* name, std::size_t count) {
    for (int n = 24;; n += 4) {
        TetrahedralMesh mesh = quadratic_spline(*sampled(builtin_field(name), n), 0);
        if (mesh.tetrahedra.size() >= count) return mesh;
    }
}

/// Stoll et al., table 3.
void run_table_3(Renderer& renderer, int repeats) {
    fmt::print("table 3: quadrics in tetrahedra, frames a second\nmodel  tetrahedra  1024x1280  "
               "512x512  1e6 a second at 2x2\n");
    for (const auto& [name, count] : {std::pair{"sphere", 137232}, {"marschner-lobb", 65844}}) {
        Primitives primitives{.tetrahedra = {spline_of(name, static_cast<std::size_t>(count))}};
        const std::size_t tetrahedra = primitives.count();
        load(renderer, std::move(primitives));
        const double large = seconds_of(renderer, 1280, 1024, repeats);
        const double small = seconds_of(renderer, 512, 512, repeats);
        const double tiny = seconds_of(renderer, 2, 2, repeats);
        fmt::print("{} {} {:.2f} {:.2f} {:.3f}\n", name, tetrahedra, 1 / large, 1 / small,
                   double(tetrahedra) / tiny / 1e6);
    }
}

struct Drawn {
    Image hits;
    double seconds = 0;
    double mib = 0;
};
Drawn drawn(Renderer& renderer, const Camera& camera, int repeats) {
    Drawn out;
    std::vector<double> seconds;
    for (int frame = 0; frame <= repeats; ++frame) {
        const TimedFrame timed = draw(renderer, camera, 512, 512);
        if (frame > 0) seconds.push_back(timed.seconds);
        out.mib = double(timed.report.field_bytes + timed.report.splat_bytes) / (1 << 20);
    }
    out.seconds = median(seconds);
    renderer.draw(camera, 512, 512, {FrameImage::Hit});
    out.hits = renderer.read(FrameImage::Hit);
    return out;
}

/// The spline against the cubic filter, both of the same samples, and the signal itself if that is
/// known.
void compare_isosurface(Renderer& renderer, const std::string& name,
                        const std::shared_ptr<const FieldSource>& field, double iso,
                        const AnalyticField* signal, int repeats) {
    const double voxel = field->space().voxel_size_world();
    const Stopwatch time;
    TetrahedralMesh mesh = quadratic_spline(*field, iso);
    const double made = time.seconds();
    const std::size_t count = mesh.tetrahedra.size();
    renderer.load({.field = field, .iso_world = iso});
    const Camera camera = frame_box(renderer.surface_points_world(), {0.2, -0.6, 1}, 1, 30);
    const Drawn rays = drawn(renderer, camera, repeats);
    load(renderer, {.tetrahedra = {std::move(mesh)}});
    const Drawn spline = drawn(renderer, camera, repeats);
    std::vector<double> apart;
    std::vector<double> off_spline;
    std::vector<double> off_rays;
    std::size_t one_alone = 0;
    for (std::size_t i = 0; i < rays.hits.rgba.size(); i += 4) {
        const bool is_hit = rays.hits.rgba[i + 3] != 0;
        one_alone += is_hit != (spline.hits.rgba[i + 3] != 0) ? 1 : 0;
        if (!is_hit || spline.hits.rgba[i + 3] == 0) continue;
        const auto at = [&](const Image& hits) {
            return Vec3d(Eigen::Map<const Eigen::Vector3f>(&hits.rgba[i]).cast<double>());
        };
        apart.push_back((at(rays.hits) - at(spline.hits)).norm() / voxel);
        if (signal == nullptr) continue;
        const auto off = [&](const Image& hits) {
            const Jet jet = signal->jet(camera.eye_world + at(hits));
            return std::abs(jet.value) / jet.gradient.norm() / voxel;
        };
        off_spline.push_back(off(spline.hits));
        off_rays.push_back(off(rays.hits));
    }
    std::ranges::sort(apart);
    fmt::print("{} {} {:.2f} {:.3f} {:.3f} {:.1f} {:.1f} {:.4f} {:.4f} {:.2f}", name, count, made,
               spline.seconds, rays.seconds, spline.mib, rays.mib, apart[apart.size() / 2],
               apart[apart.size() * 99 / 100],
               100 * double(one_alone) / double(apart.size() + one_alone));
    if (signal != nullptr) fmt::print(" {:.4f} {:.4f}", median(off_spline), median(off_rays));
    fmt::print("\n");
}

void run_isosurface(Renderer& renderer, const std::vector<std::string>& volumes, double iso,
                    int repeats) {
    fmt::print(
        "isosurfaces at 512x512, spline and ray caster: tetrahedra, seconds to make; seconds "
        "a frame of both; MiB of both; voxels between their hits, median and 99 %; % of "
        "pixels that one alone hits; voxels off a known signal, both\n");
    const AnalyticField signal = builtin_field("marschner-lobb");
    for (const int n : {32, 64, 128})
        compare_isosurface(renderer, fmt::format("marschner-lobb@{}", n), sampled(signal, n), 0,
                           &signal, repeats);
    for (const std::string& path : volumes)
        compare_isosurface(renderer, std::filesystem::path(path).filename().string(),
                           read_field(path), iso, nullptr, repeats);
}

} // namespace

int main(int argc, char** argv) try {
    CLI::App app("What patches and quadrics in tetrahedra cost");
    int repeats = 3;
    std::string only;
    std::vector<std::string> volumes;
    double iso = 0;
    app.add_option("--repeats", repeats);
    app.add_option("--only", only, "patches, table-3 or isosurface");
    app.add_option("VOLUME", volumes, "Fields from files, for isosurface");
    app.add_option("--iso", iso, "Theirs");
    CLI11_PARSE(app, argc, argv);
    const auto context = gl::make_context({.backend = gl::Backend::Osmesa});
    Renderer renderer(*context, std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders");
    if (only.empty() || only == "patches") run_patches(renderer, repeats);
    if (only.empty() || only == "table-3") run_table_3(renderer, repeats);
    if (only.empty() || only == "isosurface") run_isosurface(renderer, volumes, iso, repeats);
    return 0;
} catch (const std::exception& error) {
    fmt::print(stderr, "bench_patches: {}\n", error.what());
    return 1;
}
