// The scenes of bench_quadrics.
// SPDX-License-Identifier: MPL-2.0
#include "quadrics/quadrics_bench.h"

#include "quadrics/molecule_styles.h"

#include <Eigen/Geometry>
#include <glad/gl.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <random>

namespace isocast {

namespace {

const std::filesystem::path shared_data =
    std::filesystem::path(ISOCAST_SOURCE_DIR) / "../shared/data";

using Random = std::mt19937;

double uniform(Random& random, double lo, double hi) {
    return std::uniform_real_distribution(lo, hi)(random);
}

Vec3d in_ball(Random& random) {
    for (;;) {
        const double x = uniform(random, -1, 1);
        const double y = uniform(random, -1, 1);
        const Vec3d p(x, y, uniform(random, -1, 1));
        if (p.norm() < 1) return p;
    }
}

Vec3d some_colour(Random& random) {
    const double r = uniform(random, 0.2, 1);
    const double g = uniform(random, 0.2, 1);
    return {r, g, uniform(random, 0.2, 1)};
}

/// Spheres of one size at random in a ball, so many and so large that a ray through the middle of
/// the picture of the ball meets `depth` of them on average over the ball's disc.
Primitives ball_of_spheres(int count, double depth) {
    Random random(1);
    Primitives primitives;
    for (int i = 0; i < count; ++i)
        primitives.spheres.push_back({.centre_world = in_ball(random),
                                      .radius_world = std::sqrt(depth / count),
                                      .colour = some_colour(random)});
    return primitives;
}

/// Atoms on a shaken lattice in a ball, each bonded to three neighbours where they are there too:
/// about two half sticks for each atom and each bond's end.
Primitives ball_of_sticks(int atoms) {
    Random random(2);
    const double spacing = std::cbrt(4.0 / 3 * std::acos(-1.0) / atoms);
    const int n = static_cast<int>(1 / spacing) + 1;
    std::map<std::array<int, 3>, std::pair<Vec3d, Vec3d>> places; // and colours
    for (int z = -n; z <= n; ++z)
        for (int y = -n; y <= n; ++y)
            for (int x = -n; x <= n; ++x) {
                const Vec3d p = spacing * (Vec3d(x, y, z) + 0.2 * in_ball(random));
                if (p.norm() < 1) places[{x, y, z}] = {p, some_colour(random)};
            }
    Primitives primitives;
    for (const auto& [at, atom] : places) {
        primitives.spheres.push_back(
            {.centre_world = atom.first, .radius_world = 0.25 * spacing, .colour = atom.second});
        const int axis = std::uniform_int_distribution(0, 2)(random);
        auto next = at;
        ++next[static_cast<std::size_t>(axis)];
        const auto other = places.find(next);
        if (other == places.end()) continue;
        const Vec3d middle = (atom.first + other->second.first) / 2;
        for (const auto& [end, colour] : {atom, other->second})
            primitives.cylinders.push_back({.a_world = end,
                                            .b_world = middle,
                                            .radius_world = 0.1 * spacing,
                                            .colour = colour});
    }
    return primitives;
}

Primitives molecule(const char* file, MoleculeStyle style, bool for_peers) {
    const MoleculePrimitives drawn = primitives_of(
        read_molecule(shared_data / file), {.style = style, .ends_sticks_in_balls = !for_peers});
    Primitives primitives{.spheres = drawn.spheres};
    if (!for_peers) primitives.cylinders = drawn.sticks;
    if (for_peers)
        for (const Cylinder& stick : drawn.sticks) {
            const Vec3d middle = (stick.a_world + stick.b_world) / 2;
            const Vec3d colour_b = stick.colour_b.value_or(stick.colour);
            primitives.cylinders.push_back(
                {stick.a_world, middle, stick.radius_world, false, stick.colour});
            primitives.cylinders.push_back(
                {stick.b_world, middle, stick.radius_world, false, colour_b});
        }
    return primitives;
}

Mat3d rotation(Random& random) {
    std::normal_distribution<double> normal;
    const double w = normal(random);
    const double x = normal(random);
    const double y = normal(random);
    return Eigen::Quaterniond(w, x, y, normal(random)).normalized().toRotationMatrix();
}

void add(Primitives& to, Specimen specimen, const Vec3d& centre, double r, Random& random) {
    const Mat3d turned = r * rotation(random);
    const auto from_centre = [&](double x, double y, double z) -> Vec3d {
        return centre + turned * Vec3d(x, y, z);
    };
    const Vec3d colour = some_colour(random);
    switch (specimen) {
    case Specimen::Sphere:
        to.spheres.push_back({.centre_world = centre, .radius_world = r, .colour = colour});
        break;
    case Specimen::Ellipsoid:
        to.ellipsoids.push_back({.centre_world = centre,
                                 .axes_world = turned * Vec3d(1, 0.6, 0.4).asDiagonal(),
                                 .colour = colour});
        break;
    case Specimen::Cylinder: // 0.98^2 + 0.2^2 = 1
        to.cylinders.push_back({.a_world = from_centre(0, 0, -0.98),
                                .b_world = from_centre(0, 0, 0.98),
                                .radius_world = 0.2 * r,
                                .colour = colour});
        break;
    case Specimen::Cone: // 0.6^2 + 0.8^2 = 1
        to.cones.push_back({.a_world = from_centre(0, 0, -0.8),
                            .b_world = from_centre(0, 0, 1),
                            .radius_a_world = 0.6 * r,
                            .radius_b_world = 0,
                            .colour = colour});
        break;
    case Specimen::General: // a hyperboloid of one sheet in a cube
        to.quadrics.push_back({.centre_world = centre,
                               .axes_world = turned / std::sqrt(3),
                               .a = Vec3d(1, 1, -0.6).asDiagonal(),
                               .b = Vec3d::Zero(),
                               .c = -0.3,
                               .colour = colour});
        break;
    case Specimen::Superquadric:
        to.superquadrics.push_back({.centre_world = centre,
                                    .axes_world = turned * Vec3d(0.7, 0.6, 0.5).asDiagonal(),
                                    .alpha = 0.6,
                                    .beta = 0.4,
                                    .colour = colour});
        break;
    case Specimen::Triangle: {
        if (to.meshes.empty()) to.meshes.emplace_back();
        TriangleMesh& mesh = to.meshes[0];
        const int first = static_cast<int>(mesh.vertices_world.size());
        for (const double angle : {0.0, 2.0, 4.0})
            mesh.vertices_world.push_back(from_centre(std::cos(angle), std::sin(angle), 0));
        mesh.triangles.push_back({first, first + 1, first + 2});
        break;
    }
    }
}

} // namespace

std::vector<BenchScene> bench_scenes(const std::string& only) {
    std::vector<BenchScene> scenes{
        {"1tii space-filling",
         [](bool halves) { return molecule("1tii.pdb", MoleculeStyle::SpaceFilling, halves); }},
        {"1tii balls and sticks",
         [](bool halves) { return molecule("1tii.pdb", MoleculeStyle::BallsAndSticks, halves); }},
        {"52 k spheres in a ball", [](bool) { return ball_of_spheres(52000, 45); }},
        {"99 k + 198 k", [](bool) { return ball_of_sticks(99000); }}};
    std::erase_if(scenes, [&](const BenchScene& scene) {
        return scene.name.find(only) == std::string::npos;
    });
    return scenes;
}

Camera camera_of(Renderer& renderer) {
    return frame_box(renderer.surface_points_world(), {0.3, 0.4, 1}, double(width) / height, 30);
}

TimedFrame draw(Renderer& renderer, const Camera& camera, int w, int h) {
    const auto start = std::chrono::steady_clock::now();
    FrameReport report = renderer.draw(camera, w, h, {FrameImage::Beauty});
    glFinish();
    return {std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(),
            std::move(report)};
}

double median_frame_seconds(Renderer& renderer, Camera camera, int w, int h, int repeats) {
    std::vector<double> seconds;
    for (int frame = 0; frame <= repeats; ++frame) {
        camera.eye_world.x() *= 1 + 1e-4;
        const TimedFrame drawn = draw(renderer, camera, w, h);
        if (frame > 0) seconds.push_back(drawn.seconds); // the first one warms up
    }
    return median(std::move(seconds));
}

Specimens specimens(Specimen specimen, double radius_pixels) {
    Specimens some;
    const double distance = 100 * specimens_height; // so that all are seen from one side
    some.camera = {.eye_world = {0, 0, distance}, .target_world = Vec3d::Zero()};
    some.camera.fov_y_degrees =
        2 * std::atan(specimens_height / 2.0 / distance) * 180 / std::numbers::pi;
    const double spacing = 2 * radius_pixels + 1;
    Random random(3);
    for (double y = spacing / 2; y + spacing / 2 <= specimens_height; y += spacing)
        for (double x = spacing / 2; x + spacing / 2 <= specimens_width; x += spacing) {
            const Vec3d centre(x - specimens_width / 2.0, y - specimens_height / 2.0, 0);
            add(some.primitives, specimen, centre, radius_pixels, random);
            some.centres_pixels.emplace_back(static_cast<float>(x), static_cast<float>(y));
        }
    return some;
}

} // namespace isocast
