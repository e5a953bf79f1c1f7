// Solids composed of fields: creases, objects with themselves, places where all gradients vanish.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/reconstruct.h"
#include "stability/fields.h"
#include "stability/picture_judge.h"
#include "volume/analytic_fields.h"

#include <numbers>

namespace isocast::stability {

namespace {

constexpr double radius = 0.8;
constexpr double half_apart = 0.45; // of the two balls' middles, along x
/// By which a hit on a ball may be off: fourth-order errors of the spline's value, f'''' h^4 / 192
/// a line with f'''' below 15 / r^3 and voxels of at most 2/39.
constexpr double ball_error = 3 * 15 / (radius * radius * radius) / 192 * 6.92e-6;

FieldObject ball(double x, int n, const Vec3d& shift = Vec3d::Zero()) {
    const Vec3d middle = Vec3d(x, 0, 0) + shift;
    const GridSpace space = GridSpace::uniform(2.0 / (n - 1), middle - Vec3d::Ones());
    return {.field = field_in(space, {Index3::Zero(), Index3::Constant(n)},
                              [&](const Vec3d& p) { return (p - middle).norm() - radius; })};
}

CsgTree pair(CsgOperation operation) {
    return {{CsgOperation::Object, 0}, {CsgOperation::Object, 1}, {operation}};
}

/// Two balls on lattices that do not match.
Scene balls(CsgOperation operation, const Vec3d& shift = Vec3d::Zero()) {
    return {.objects = {ball(-half_apart, 40, shift), ball(half_apart, 43, shift)},
            .tree = pair(operation)};
}

Camera from(const Vec3d& side) {
    return {.eye_world = 5 * side,
            .target_world = Vec3d::Zero(),
            .up = std::abs(side.y()) > 0.5 ? Vec3d::UnitZ() : Vec3d::UnitY(),
            .projection = Projection::Orthographic,
            .height_world = 2.8};
}

struct Shown {
    Image hits, gradients;
};

Shown draw(Device& device, const Scene& scene, const Camera& camera) {
    device.renderer.load(scene);
    device.renderer.draw(camera, 64, 64, {FrameImage::Hit, FrameImage::Gradient});
    return {device.renderer.read(FrameImage::Hit), device.renderer.read(FrameImage::Gradient)};
}

/// Calls visit(p_world, owner, gradient) at every hit.
template<class Visit>
void for_each_hit(const Shown& shown, const Camera& camera, Visit visit) {
    for (std::size_t i = 0; i < shown.hits.rgba.size(); i += 4) {
        const float* hit = &shown.hits.rgba[i];
        if (hit[3] == 0) continue;
        const float* g = &shown.gradients.rgba[i];
        visit(Vec3d(camera.eye_world + Vec3d(hit[0], hit[1], hit[2])), static_cast<int>(hit[3]),
              Vec3d(g[0], g[1], g[2]));
    }
}

const std::array sides{Vec3d(0, 0, 1), Vec3d(1, 0, 0), Vec3d(Vec3d(0.5, 0.4, 0.6).normalized())};

/// Hits off their owner's ball, over the ball's error; owners must change at the crease, x = 0.
Worst owners_change_at_the_crease(Device& device, CsgOperation operation) {
    Worst worst;
    for (const Vec3d& side : sides) {
        const Camera camera = from(side);
        for_each_hit(draw(device, balls(operation), camera), camera,
                     [&](const Vec3d& p, int owner, const Vec3d&) {
                         const double x = owner == 1 ? -half_apart : half_apart;
                         worst.see(std::abs((p - Vec3d(x, 0, 0)).norm() - radius) / ball_error);
                         if (operation == CsgOperation::Difference) {
                             worst.must(owner == 1 || owner == -2);
                             worst.must(p.x() < 1.1 * ball_error);
                         } else if (std::abs(p.x()) > 1.1 * ball_error) {
                             worst.must(
                                 owner ==
                                 ((operation == CsgOperation::Union) == (p.x() < 0) ? 1 : 2));
                         }
                     });
    }
    return worst;
}

/// Normals at and beside creases are those of the owner's own spline, in double, turned round where
/// it is taken away.
Worst normals_at_the_crease(Device& device, CsgOperation operation) {
    const Scene scene = balls(operation);
    std::vector<std::shared_ptr<const FieldSource>> controls;
    for (const FieldObject& object : scene.objects)
        controls.push_back(control_samples(object.field, object.filter));
    Worst worst;
    for (const Vec3d& side : sides) {
        const Camera camera = from(side);
        for_each_hit(draw(device, scene, camera), camera,
                     [&](const Vec3d& p, int owner, const Vec3d& gradient) {
                         const FieldSource& control =
                             *controls[static_cast<std::size_t>(std::abs(owner) - 1)];
                         const GridSpace& space = control.space();
                         const Vec3d exact =
                             space.gradient_to_world(
                                 tricubic_jet(control, space.to_index(p)).gradient) *
                             (owner < 0 ? -1 : 1);
                         worst.see((gradient.normalized() - exact.normalized()).norm());
                     });
    }
    return worst;
}

/// By sums of the thickness along z, less the analytic volume, by a ball's.
Worst volume(Device& device, CsgOperation operation) {
    const double ball_volume = 4.0 / 3 * std::numbers::pi * std::pow(radius, 3);
    const double lens = std::numbers::pi / 12 * (4 * radius + 2 * half_apart) *
                        std::pow(2 * radius - 2 * half_apart, 2);
    const Camera camera = from(Vec3d::UnitZ());
    device.renderer.load(balls(operation));
    device.renderer.draw(camera, 128, 128, {FrameImage::Hit});
    const Image hits = device.renderer.read(FrameImage::Hit);
    const double pixel = camera.height_world / 128;
    double sum = 0;
    for (std::size_t i = 0; i < hits.rgba.size(); i += 4)
        if (hits.rgba[i + 3] != 0)
            sum += 2 * (hits.rgba[i + 2] + camera.eye_world.z()) * pixel * pixel;
    Worst worst;
    worst.see(std::abs(sum - (operation == CsgOperation::Union ? 2 * ball_volume - lens : lens)) /
              ball_volume);
    return worst;
}

/// A with A is A, bit for bit, or nothing.
Worst with_itself(Device& device) {
    const Camera camera = from(sides[2]);
    const FieldObject a = ball(0.1, 40);
    const Image alone = draw(device, {.field = a.field}, camera).hits;
    Worst worst;
    for (const CsgOperation operation : {CsgOperation::Union, CsgOperation::Intersection}) {
        Image hits = draw(device, {.objects = {a, a}, .tree = pair(operation)}, camera).hits;
        for (std::size_t i = 3; i < hits.rgba.size(); i += 4)
            if (hits.rgba[i] != 0) hits.rgba[i] = 1; // either owns it
        worst.see(same_pictures(hits, alone));
    }
    for (const float value :
         draw(device, {.objects = {a, a}, .tree = pair(CsgOperation::Difference)}, camera)
             .hits.rgba)
        worst.must(value == 0);
    return worst;
}

/// A - (B or C) is (A - B) - C, pixel by pixel.
Worst de_morgan(Device& device) {
    const Camera camera = from(sides[2]);
    const std::vector<FieldObject> objects{ball(0, 40), ball(0.6, 37), ball(-0.5, 33)};
    const auto object = [](int i) { return CsgStep{CsgOperation::Object, i}; };
    const CsgStep unite{CsgOperation::Union}, subtract{CsgOperation::Difference};
    const Image a =
        draw(device,
             {.objects = objects, .tree = {object(0), object(1), object(2), unite, subtract}},
             camera)
            .hits;
    const Image b =
        draw(device,
             {.objects = objects, .tree = {object(0), object(1), subtract, object(2), subtract}},
             camera)
            .hits;
    return same_pictures(a, b);
}

/// x^2 + y^2 - z^2 with a ball that touches its apex: both gradients vanish or contradict there.
Worst numbers_at_an_apex(Device& device) {
    const GridSpace space = GridSpace::uniform(2.0 / 32, -Vec3d::Ones());
    const IndexBox extent{Index3::Zero(), Index3::Constant(33)};
    const FieldObject cone{.field = field_in(space, extent, [](const Vec3d& p) {
                               return p.x() * p.x() + p.y() * p.y() - p.z() * p.z();
                           })};
    const FieldObject touching{.field = field_in(space, extent, [](const Vec3d& p) {
                                   return (p - Vec3d(0, 0, 0.5)).norm() - 0.5;
                               })};
    Worst worst;
    for (const CsgOperation operation :
         {CsgOperation::Union, CsgOperation::Intersection, CsgOperation::Difference})
        for (const Vec3d& side : sides) {
            device.renderer.load({.objects = {cone, touching}, .tree = pair(operation)});
            // Odd: a ray meets the apex.
            device.renderer.draw(
                from(side), 65, 65,
                {FrameImage::Hit, FrameImage::Gradient, FrameImage::Curvature, FrameImage::Beauty});
            for (const FrameImage image :
                 {FrameImage::Hit, FrameImage::Gradient, FrameImage::Curvature, FrameImage::Beauty})
                for (const float value : device.renderer.read(image).rgba)
                    worst.must(std::isfinite(value));
        }
    return worst;
}

/// At 1e6 from the origin, seen from 100 radii: hits are eye-relative floats.
Worst far_away(Device& device) {
    const Vec3d far(1e6, -3e6, 2e6);
    const Camera camera{
        .eye_world = far + Vec3d(30, 20, 40), .target_world = far, .fov_y_degrees = 3};
    Worst worst;
    for_each_hit(draw(device, balls(CsgOperation::Union, far), camera), camera,
                 [&](const Vec3d& p, int owner, const Vec3d&) {
                     const Vec3d from_ball =
                         p - far - Vec3d(owner == 1 ? -half_apart : half_apart, 0, 0);
                     worst.see(std::abs(from_ball.norm() - radius));
                 });
    return worst;
}

} // namespace

void append_solid_cases(std::vector<Case>& cases) {
    using enum CsgOperation;
    for (const auto& [name, operation] :
         {std::pair{"union", Union}, std::pair{"intersection", Intersection},
          std::pair{"difference", Difference}}) {
        append(cases,
               {std::string("solid.crease-of-a-") + name,
                "hits of two balls and their owners' spheres, by the spline's error; owners "
                "on each side of the crease",
                1, "fourth-order error of the spline", [operation = operation](Device& device) {
                    return owners_change_at_the_crease(device, operation);
                }});
        append(cases, {std::string("solid.normals-of-a-") + name,
                       "normals at creases and those of the owner's spline in double", 2e-4,
                       "32 roundings of 2 over a voxel of 0.05, and places to 1e-5 voxel",
                       [operation = operation](Device& device) {
                           return normals_at_the_crease(device, operation);
                       }});
        if (operation == Difference) continue;
        append(cases,
               {std::string("solid.volume-of-a-") + name,
                "volume by pixels and of two balls and their lens [ball]", 0.003,
                "midpoint sums at the rim: 1e-3 at random, three times",
                [operation = operation](Device& device) { return volume(device, operation); }});
    }
    append(cases, {"solid.with-itself", "pictures of A with A and of A, or none", 0, "bit for bit",
                   with_itself});
    append(cases, {"solid.de-morgan", "pictures of A - (B or C) and of (A - B) - C", 0,
                   "bit for bit", de_morgan});
    append(cases, {"solid.apex", "images where gradients vanish and numbers", 0, "finite",
                   numbers_at_an_apex});
    append(cases,
           {"solid.origin-1e6-away", "hits of two balls and their spheres [world]", 1e-5 + 5e-6,
            "floats of 54 have steps of 4e-6, and the spline errs by 2e-6", far_away});
}

} // namespace isocast::stability
