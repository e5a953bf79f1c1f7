// Primitives one by one: far, thin, cut by the eye's plane, along rays, near and far at once.
// SPDX-License-Identifier: MPL-2.0
#include "stability/picture_judge.h"
#include "stability/random.h"
#include "stability/splat_scenes.h"

namespace isocast::stability {

namespace {

const Camera camera{.eye_world = {0, 0, 5}, .target_world = Vec3d::Zero()};
constexpr PictureSize size{96, 72};

Worst from_afar(Device& device, const Primitives& one, double ratio) {
    Camera there = camera;
    there.eye_world = Vec3d(0.3, 0.5, 1).normalized() / ratio;
    there.fov_y_degrees = 2 * std::atan(1.2 * ratio) * 180 / std::acos(-1.0);
    return judge_primitives(device, one, there, {72, 72});
}

/// Around the eye, and from in front of its plane to behind.
Worst across_the_eyes_plane(Device& device, Projection projection) {
    Camera there = camera;
    there.projection = projection;
    return judge_primitives(device, around_the_eye(camera.eye_world), there, size);
}

Worst crowd(Device& device, const Vec3d& shift) {
    Random random(1);
    Primitives some;
    for (int i = 0; i < 60; ++i) {
        some.spheres.push_back(
            {.centre_world = random.in_cube() + shift, .radius_world = random.uniform(0.05, 0.3)});
        some.cylinders.push_back({.a_world = random.in_cube() + shift,
                                  .b_world = random.in_cube() + shift,
                                  .radius_world = 0.05});
    }
    Camera there = camera;
    there.eye_world += shift;
    there.target_world += shift;
    return judge_primitives(device, some, there, size);
}

Worst discs(Device& device, double thin) {
    Random random(2);
    Primitives some;
    for (int i = 0; i < 12; ++i)
        some.ellipsoids.push_back(
            {.centre_world = random.in_cube(),
             .axes_world = random.rotation() * Vec3d(0.5, 0.5, 0.5 * thin).asDiagonal()});
    return judge_primitives(device, some, camera, size);
}

Worst cylinder_along_the_view(Device& device, bool is_capped) {
    Worst worst;
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        Camera there = camera;
        there.projection = projection;
        worst.see(judge_primitives(device,
                                   {.cylinders = {{.a_world = {0, 0, -1},
                                                   .b_world = {0, 0, 1},
                                                   .radius_world = 0.5,
                                                   .is_capped = is_capped}}},
                                   there, size));
    }
    return worst;
}

/// Its side is parallel to the view's axis, a little below it.
Worst cone_side_along_rays(Device& device) {
    const double tilt = 0.3;
    const Vec3d a(0, -0.05, 3);
    return judge_primitives(
        device,
        {.cones = {{.a_world = a,
                    .b_world = a + 4 * Vec3d(0, -std::sin(tilt), -std::cos(tilt)),
                    .radius_a_world = 0,
                    .radius_b_world = 4 * std::tan(tilt)},
                   {.a_world = {0, 0, -1},
                    .b_world = {0, 0, 1},
                    .radius_a_world = 0.6,
                    .radius_b_world = 0.4}}},
        camera, {97, 73});
}

/// alpha is 0 for every ray.
Worst paraboloids_along_parallel_rays(Device& device) {
    Camera there = camera;
    there.projection = Projection::Orthographic;
    Worst worst;
    for (const double bend : {1.0, -1.0})
        worst.see(judge_primitives(device,
                                   {.quadrics = {{.axes_world = Mat3d::Identity() * 0.7,
                                                  .a = Vec3d(1, 1, 0).asDiagonal(),
                                                  .b = {0, 0, 0.5 * bend},
                                                  .c = -0.2},
                                                 {.centre_world = {0.2, 0.1, -1},
                                                  .a = Vec3d(1, -1, 0).asDiagonal(),
                                                  .b = {0, 0, 0.3071 * bend},
                                                  .c = 0}}},
                                   there, size));
    return worst;
}

/// The eye so high over the unit sphere, looking along it: grazing rays go as far as roundings.
Worst just_outside(Device& device, double height) {
    Worst worst = judge_primitives(device, {.spheres = {{}}},
                                   {.eye_world = {0, 0, 1 + height},
                                    .target_world = {0.5, 0, 1 + 0.9 * height},
                                    .up = Vec3d::UnitZ(),
                                    .fov_y_degrees = 60},
                                   size);
    worst.error /= 1e-5 + 1e-6 / height;
    return worst;
}

/// A sphere right before the eye and one a billion times as far, both of the same picture size and
/// side by side; and one behind each, which may not show.
Worst near_and_far(Device& device, double ratio) {
    Primitives some;
    for (const auto& [side, distance] : {std::pair{-1.0, 1.0}, std::pair{1.0, ratio}}) {
        const Vec3d place = distance * Vec3d(0.15 * side, 0, -1);
        some.spheres.push_back({.centre_world = place, .radius_world = 0.08 * distance});
        // Behind by its own size, and smaller.
        some.spheres.push_back({.centre_world = 1.1 * place, .radius_world = 0.05 * distance});
    }
    return judge_primitives(device, some, {.eye_world = Vec3d::Zero(), .target_world = {0, 0, -1}},
                            size);
}

/// Four hundred spheres and sticks about one point.
Worst at_one_point(Device& device) {
    Primitives some;
    for (int i = 0; i < 200; ++i) {
        some.spheres.push_back({.radius_world = 0.2 + 1e-4 * i});
        some.cylinders.push_back(
            {.a_world = {0, -0.5, 0}, .b_world = {0, 0.5, 0}, .radius_world = 0.3 + 1e-5 * i});
    }
    return judge_primitives(device, some, camera, size);
}

/// With sides along and across the picture's, through pixels' middles.
Worst triangles_of_a_mesh(Device& device, double distance) {
    Random random(3);
    Primitives some;
    for (int i = 0; i < 30; ++i) {
        const Vec3d p = random.in_cube(), q = p + random.in_cube(0.4);
        some.meshes.push_back(
            {.vertices_world = {p, q, p + random.in_cube(0.4)}, .triangles = {{0, 1, 2}}});
    }
    Camera there = camera;
    there.eye_world = {0, 0, 5 * distance};
    there.fov_y_degrees = 30 / distance;
    return judge_primitives(device, some, there, size);
}

/// Edge on: nothing of it may be seen but its roundings, and nothing else either.
Worst triangle_edge_on(Device& device) {
    Worst worst;
    device.renderer.load({.primitives = std::make_shared<Primitives>(Primitives{
                              .meshes = {{.vertices_world = {{-1, 0, 0}, {1, 0, 0}, {0, 0, -2}},
                                          .triangles = {{0, 1, 2}}}}})});
    device.renderer.draw({.eye_world = {0, 0, 5}, .target_world = Vec3d::Zero()}, 48, 48,
                         {FrameImage::Hit});
    for (const float value : device.renderer.read(FrameImage::Hit).rgba) worst.must(value == 0);
    return worst;
}

Worst cut_open(Device& device, CutLook look) {
    Primitives some;
    for (auto& [name, one] : each_kind()) {
        for (const Sphere& s : one.spheres) some.spheres.push_back(s);
        for (Ellipsoid e : one.ellipsoids) {
            e.centre_world = {0.3, 0.9, 0.2};
            some.ellipsoids.push_back(e);
        }
        for (const Cylinder& c : one.cylinders) some.cylinders.push_back(c);
        // On an axis of its own: of two that share theirs, a cap could be of either.
        for (Cone c : one.cones) {
            c.b_world = {0.5, -0.9, 0.1};
            some.cones.push_back(c);
        }
    }
    return judge_primitives(
        device, some, camera, size,
        {.look = look, .planes = {{.normal = {0.2, 0.1, 1}, .offset_world = 0.1}}});
}

} // namespace

void append_splat_cases(std::vector<Case>& cases) {
    const char* compares = "what each pixel shows and the double caster; hits off the surface "
                           "[distance from the eye]";
    const char* from = "some roundings, five for each of GLSL's divisions";
    const auto add = [&](const std::string& name, auto run) {
        append(cases, {"splat." + name, compares, 1.5e-6, from, run});
    };
    auto kinds = each_kind();
    kinds.emplace_back(
        "triangle",
        Primitives{
            .meshes = {{.vertices_world = {{-1, -0.4, 0.2}, {0.9, -0.2, 0}, {0.1, 0.8, -0.3}},
                        .triangles = {{0, 1, 2}}}}});
    for (const auto& [kind, one] : kinds)
        for (const auto& [word, ratio] :
             {std::pair{"1e-01", 1e-1}, std::pair{"1e-03", 1e-3}, std::pair{"1e-06", 1e-6}})
            add(std::string(kind) + "-" + word, [one = one, ratio = ratio](Device& device) {
                return from_afar(device, one, ratio);
            });
    add("across-the-eye",
        [](Device& device) { return across_the_eyes_plane(device, Projection::Perspective); });
    add("across-the-eye-parallel",
        [](Device& device) { return across_the_eyes_plane(device, Projection::Orthographic); });
    add("crowd", [](Device& device) { return crowd(device, Vec3d::Zero()); });
    add("origin-1e6-away", [](Device& device) { return crowd(device, {1e6, -2e6, 3e6}); });
    for (const char* thin : {"1e-02", "1e-04", "1e-06"})
        append(cases, {std::string("splat.discs-") + thin, compares, 1e-4,
                       "rays that graze a disc meet it anywhere within a rounding's angle",
                       [t = std::stod(thin)](Device& device) { return discs(device, t); }});
    add("cylinder-along-the-view",
        [](Device& device) { return cylinder_along_the_view(device, false); });
    add("capped-cylinder-along-the-view",
        [](Device& device) { return cylinder_along_the_view(device, true); });
    add("cone-side-along-rays", cone_side_along_rays);
    add("paraboloids-along-rays", paraboloids_along_parallel_rays);
    for (const auto& [word, height] :
         {std::pair{"1e-01", 1e-1}, std::pair{"1e-03", 1e-3}, std::pair{"1e-05", 1e-5}})
        append(cases, {std::string("splat.eye-above-a-sphere-") + word,
                       "what each pixel shows and the double caster; hits off the surface "
                       "[1e-5 + 1e-6 / height of the distance]",
                       1, "as far as roundings let grazing rays go",
                       [height = height](Device& device) { return just_outside(device, height); }});
    for (const auto& [word, ratio] :
         {std::pair{"1e3", 1e3}, std::pair{"1e6", 1e6}, std::pair{"1e9", 1e9}})
        add(std::string("near-and-far-") + word,
            [ratio = ratio](Device& device) { return near_and_far(device, ratio); });
    add("at-one-point", at_one_point);
    add("triangles", [](Device& device) { return triangles_of_a_mesh(device, 1); });
    add("triangles-1e4-away", [](Device& device) { return triangles_of_a_mesh(device, 1e4); });
    append(cases, {"splat.triangle-edge-on", "pixels of a triangle seen edge on and background", 0,
                   "it has no area", triangle_edge_on});
    for (const auto& [word, look] :
         {std::pair{"inside", CutLook::Inside}, std::pair{"flat", CutLook::Flat},
          std::pair{"capped", CutLook::Capped}})
        add(std::string("cut-") + word,
            [look = look](Device& device) { return cut_open(device, look); });
}

} // namespace isocast::stability
