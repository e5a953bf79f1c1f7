// SPDX-License-Identifier: MPL-2.0
#include "stability/hard_meshes.h"

#include "distance_transform/sample_meshes.h"
#include "stability/shapes.h"

#include <numbers>

namespace isocast::stability {

HardMesh noisy(unsigned seed, double scale, const Vec3d& shift) {
    return {moved(scaled(noisy_sphere(seed, 2), scale), shift), 0.17 * scale};
}

HardMesh with_hole() {
    Mesh mesh = noisy_sphere(10, 3);
    const auto height = [&](const Triangle& t) {
        double sum = 0;
        for (const int i : t) sum += mesh.vertices_world[static_cast<std::size_t>(i)].z();
        return sum;
    };
    std::ranges::sort(mesh.triangles, {}, height);
    mesh.triangles.resize(mesh.triangles.size() * 92 / 100);
    return {mesh, 0.2, {}, Sides::Open, SignMethod::Winding};
}

namespace {

HardMesh repeated() {
    const Mesh solid = noisy_sphere(6, 2);
    Mesh mesh = solid;
    for (std::size_t t = 0; t < solid.triangles.size(); t += 2) {
        const auto& [a, b, c] = solid.triangles[t];
        mesh.triangles.push_back({b, c, a});
    }
    return {mesh, 0.17, solid};
}

HardMesh wedge() {
    const double thickness = std::tan(0.01 * std::numbers::pi / 180);
    return {tilted(mapped(box({0, -0.5, 0}, {1, 0.5, 1}),
                          [&](const Vec3d& p) {
                              return Vec3d(p.x(), p.y(), p.z() * (1 - p.x()) * thickness);
                          })),
            0.07};
}

HardMesh fan() {
    std::vector<Vec3d> rim;
    for (int i = 0; i < 1000; ++i)
        rim.emplace_back(std::cos(2 * std::numbers::pi * i / 1000),
                         std::sin(2 * std::numbers::pi * i / 1000), 0);
    return {double_cone(rim, {0, 0, 0.8}, {0, 0, -0.5}), 0.35};
}

HardMesh on_samples() {
    return {
        mapped(noisy_sphere(20, 2), [](const Vec3d& p) { return Vec3d((6 * p).array().round()); }),
        1};
}

} // namespace

std::vector<NamedMesh> hard_meshes() {
    const Mesh ball = sphere(2);
    const Mesh first = tilted(cube());
    const auto beside = [](double gap) { return tilted(moved(cube(), {2 + gap, 0.3, 0.2})); };
    return {
        {"cube",
         [] {
             return HardMesh{cube(), 0.2};
         }},
        {"tilted-cube",
         [=] {
             return HardMesh{first, 0.17};
         }},
        {"spiky-solid-1", [] { return noisy(1); }},
        {"spiky-solid-2", [] { return noisy(2); }},
        {"spiky-solid-3", [] { return noisy(3); }},
        {"saddle-of-valence-3",
         [] {
             return HardMesh{saddle_cone(3), 0.17};
         }},
        {"saddle-of-valence-8",
         [] {
             return HardMesh{saddle_cone(8), 0.17};
         }},
        {"saddle-of-valence-64",
         [] {
             return HardMesh{saddle_cone(64), 0.17};
         }},
        {"fan-of-1000", fan},
        {"slivers-1e-05", [] { return HardMesh{with_slivers(noisy_sphere(1, 2), 1e-5)}; }},
        {"slivers-1e-09", [] { return HardMesh{with_slivers(noisy_sphere(1, 2), 1e-9)}; }},
        {"slivers-1e-13", [] { return HardMesh{with_slivers(noisy_sphere(1, 2), 1e-13)}; }},
        {"triangles-without-area",
         [] { return HardMesh{with_seams(rounded(noisy_sphere(2, 2)), 0.5, true)}; }},
        {"areas-of-rounding",
         [] { return HardMesh{with_seams(tilted(noisy_sphere(3, 2)), 1.0 / 3, true)}; }},
        {"t-junctions",
         [] { return HardMesh{with_seams(rounded(noisy_sphere(4, 2)), 0.5, false)}; }},
        {"t-junctions-that-gape",
         [] { return HardMesh{with_seams(tilted(noisy_sphere(5, 2)), 1.0 / 3, false)}; }},
        {"repeated-triangles", repeated},
        {"unindexed-soup", [] { return HardMesh{unindexed(noisy_sphere(7, 2))}; }},
        {"one-flipped",
         [] {
             return HardMesh{with_flips(noisy_sphere(8, 2), 1000), 0.17, noisy_sphere(8, 2)};
         }},
        {"tenth-flipped",
         [] {
             return HardMesh{with_flips(noisy_sphere(9, 2), 10), 0.17, noisy_sphere(9, 2)};
         }},
        {"inside-out",
         [] {
             return HardMesh{turned_round(noisy_sphere(11, 2)), 0.17, noisy_sphere(11, 2)};
         }},
        {"hole-of-8-percent", with_hole},
        {"offset-1e6", [] { return noisy(30, 1, Vec3d(2.1, -1.7, 1.9) * 1e6); }},
        {"offset-1e8", [] { return noisy(30, 1, Vec3d(2.1, -1.7, 1.9) * 1e8); }},
        {"scale-1e-12", [] { return noisy(31, 1e-12); }},
        {"scale-1e-6", [] { return noisy(31, 1e-6); }},
        {"scale-1e6", [] { return noisy(31, 1e6); }},
        {"scale-1e12", [] { return noisy(31, 1e12); }},
        {"triangles-larger-than-the-band",
         [] {
             return HardMesh{tilted(box(Vec3d::Zero(), {1.03, 0.71, 0.35})), 0.03};
         }},
        {"single-triangle",
         [] {
             return HardMesh{tilted({{{0, 0, 0}, {1, 0.1, 0}, {0.3, 0.9, 0}}, {{0, 1, 2}}}),
                             0.03,
                             {},
                             Sides::None};
         }},
        {"smaller-than-a-voxel",
         [] {
             return HardMesh{moved(scaled(tetrahedron(), 0.3), {0.3, 0.2, 0.4}), 1};
         }},
        {"millionth-of-a-voxel",
         [] {
             return HardMesh{moved(scaled(tetrahedron(), 1e-6), {5, -3, 2}), 1};
         }},
        {"plate-1e-3-thin",
         [] {
             return HardMesh{tilted(box(Vec3d::Zero(), {20, 15, 1e-3})), 1};
         }},
        {"plate-1e-7-thin",
         [] {
             return HardMesh{tilted(box(Vec3d::Zero(), {20, 15, 1e-7})), 1};
         }},
        {"wedge-of-0.01-degrees", wedge},
        {"needle-of-0.01-degrees",
         [] {
             return HardMesh{tilted(needle_on_a_ball()), 0.17};
         }},
        {"shells-1e-6-apart",
         [=] {
             return HardMesh{joined(first, beside(0.17e-6)), 0.17};
         }},
        {"shell-in-shell",
         [=] {
             return HardMesh{joined(ball, scaled(tilted(ball), 0.85)), 0.2};
         }},
        {"cavity",
         [=] {
             return HardMesh{joined(ball, turned_round(scaled(ball, 0.85))), 0.2};
         }},
        {"three-shells",
         [=] {
             return HardMesh{
                 joined(joined(ball, turned_round(scaled(ball, 0.7))), scaled(ball, 0.4)), 0.2};
         }},
        {"overlapping-shells",
         [=] {
             return HardMesh{joined(ball, tilted(moved(ball, {0.9, 0.2, 0.4}))), 0.17};
         }},
        {"overlap-below-a-voxel",
         [=] {
             return HardMesh{joined(first, beside(-0.03)), 0.17};
         }},
        {"pierces-itself",
         [] {
             return HardMesh{crossing_tube(40, 6), 0.12};
         }},
        {"shared-edge",
         [] {
             return HardMesh{rounded(tilted(joined(cube(), moved(cube(), {2, 2, 0})))), 0.2};
         }},
        {"shared-face",
         [] {
             return HardMesh{joined(cube(), moved(cube(), {2, 0, 0})), 0.2};
         }},
        {"tip-to-tip",
         [] {
             return HardMesh{rounded(tilted(joined(
                                 moved(tetrahedron(), -Vec3d::Ones()),
                                 turned_round(moved(scaled(tetrahedron(), -1), Vec3d::Ones()))))),
                             0.2};
         }},
        {"moebius-strip",
         [] {
             return HardMesh{moebius_strip(40), 0.1, {}, Sides::None, SignMethod::Unsigned};
         }},
        {"vertices-on-samples", on_samples},
    };
}

} // namespace isocast::stability
