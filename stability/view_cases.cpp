// Cameras that are hard: far, near, inside, of any angle and picture size.
// SPDX-License-Identifier: MPL-2.0
#include "stability/fields.h"
#include "stability/picture_judge.h"
#include "volume/placed_field.h"

namespace isocast::stability {

namespace {

/// A ball of 10 voxels, 1e-3 world units an edge, about `centre`.
std::shared_ptr<const FieldSource> ball_at(const Vec3d& centre, double voxel, int n = 28) {
    const GridSpace space = GridSpace::uniform(
        voxel, centre - voxel * (Vec3d::Constant(0.5 * (n - 1)) + Vec3d(0.21, -0.13, 0.37)));
    // Distances from the rounded places of samples: subtract before rounding.
    const Vec3d from = space.world_from_index.translation();
    return field_in(
        GridSpace{Eigen::Affine3d(space.world_from_index)}, {Index3::Zero(), Index3::Constant(n)},
        [&](const Vec3d& p) { return (p - from - (centre - from)).norm() - 10 * voxel; });
}

Subject ball_subject(const Vec3d& centre, double voxel) {
    return {.samples = ball_at(centre, voxel), .filter = Filter::Interpolating};
}

const Vec3d direction = Vec3d(0.4, 0.3, 0.87).normalized();

Camera at_ball(const Vec3d& centre, double distance, double radius) {
    return {.eye_world = centre + distance * direction,
            .target_world = centre,
            .fov_y_degrees = 2 * std::atan(1.2 * radius / distance) * 180 / std::acos(-1.0)};
}

/// The eye so many radii off.
Worst from_afar(Device& device, double radii) {
    const double voxel = 1e-3;
    Worst worst = judge_positions(device, ball_subject(Vec3d::Zero(), voxel),
                                  at_ball(Vec3d::Zero(), radii * 10 * voxel, 10 * voxel));
    worst.error /= std::max(1e-3, 0x1p-22 * radii * 10);
    return worst;
}

Worst far_from_the_origin(Device& device, double offset) {
    const Vec3d centre = offset * Vec3d(1, -2, 1.5);
    return judge_positions(device, ball_subject(centre, 1e-3), at_ball(centre, 0.04, 0.01));
}

Worst of_angle(Device& device, double fov, double distance) {
    Camera camera = at_ball(Vec3d::Zero(), distance, 0.01);
    camera.fov_y_degrees = fov;
    return judge_positions(device, ball_subject(Vec3d::Zero(), 1e-3), camera);
}

/// A fov so small that the picture is a spot of the ball of a hundredth of a voxel.
Worst through_a_pinhole(Device& device) {
    return of_angle(device, 0.001, 0.04);
}

Worst of_size(Device& device, int width, int height) {
    return judge_positions(device, ball_subject(Vec3d::Zero(), 1e-3),
                           at_ball(Vec3d::Zero(), 0.04, 0.01), {width, height});
}

/// A picture of 16384 x 1 in parts of 4096, against the rays of the whole one.
Worst one_line_in_tiles(Device& device) {
    constexpr int width = 16384;
    const Subject subject = ball_subject(Vec3d::Zero(), 1e-3);
    // As wide as it is: the ball, 0.02 wide, fills most of the line.
    Camera camera = at_ball(Vec3d::Zero(), 0.04, 0.01);
    camera.projection = Projection::Orthographic;
    camera.height_world = 0.024 / width;
    device.renderer.load({.field = subject.samples, .filter = subject.filter});
    const auto control = control_samples(subject.samples, subject.filter);
    const ReferenceCaster reference(*control, 0);
    Worst worst;
    for (int first = 0; first < width; first += 4096) {
        device.renderer.draw(camera, width, 1, {FrameImage::Hit},
                             PicturePart{.x = first, .width = 4096, .height = 1});
        const Image image = device.renderer.read(FrameImage::Hit);
        for (int x = 0; x < 4096; x += 16) {
            const Ray ray = camera_ray(camera, width, 1, first + x + 0.5, 0.5);
            const auto t = reference.hit(ray);
            const float* hit = image.pixel(x, 0);
            if (t.has_value() != (hit[3] != 0))
                worst.must(false);
            else if (t)
                worst.see((Vec3d(hit[0], hit[1], hit[2]) + camera.eye_world - ray.origin_world -
                           *t * ray.direction_world)
                              .norm() /
                          1e-3);
        }
    }
    return worst;
}

/// Parts of a picture are the whole one's pixels, bit by bit.
Worst parts_are_the_whole(Device& device) {
    const Subject subject = ball_subject(Vec3d::Zero(), 1e-3);
    const Camera camera = at_ball(Vec3d::Zero(), 0.04, 0.01);
    const Image whole = hits_of(device, subject, camera, {61, 47});
    Worst worst;
    for (const PicturePart& part : {PicturePart{.x = 0, .y = 0, .width = 1, .height = 1},
                                    PicturePart{.x = 17, .y = 9, .width = 31, .height = 5},
                                    PicturePart{.x = 60, .y = 0, .width = 1, .height = 47}}) {
        device.renderer.draw(camera, 61, 47, {FrameImage::Hit}, part);
        const Image image = device.renderer.read(FrameImage::Hit);
        for (int y = 0; y < part.height; ++y)
            for (int x = 0; x < part.width; ++x)
                for (int c = 0; c < 4; ++c)
                    worst.must(image.pixel(x, y)[c] == whole.pixel(part.x + x, part.y + y)[c]);
    }
    return worst;
}

/// The eye a hundredth of a voxel outside, and inside.
Worst eye_at_the_surface(Device& device, double height_voxels) {
    const double voxel = 1e-3;
    const Vec3d eye = (10 + height_voxels) * voxel * direction;
    const Camera camera{.eye_world = eye,
                        .target_world = eye + direction.cross(Vec3d::UnitX()) - 0.5 * direction,
                        .fov_y_degrees = 100};
    return judge_positions(device, ball_subject(Vec3d::Zero(), voxel), camera);
}

Worst sheared_and_mirrored(Device& device) {
    GridSpace space;
    space.world_from_index.linear() << 0.9, 0.2, 0.0, -0.1, 1.1, 0.3, 0.1, 0.0, -0.8;
    space.world_from_index.translation() = Vec3d(1000, -2000, 500);
    const Vec3d centre = space.to_world({15.2, 16.1, 14.7});
    const auto field = field_in(space, {Index3::Zero(), Index3::Constant(31)},
                                [&](const Vec3d& p) { return (p - centre).norm() - 8; });
    return judge_positions(device, {.samples = field, .filter = Filter::Interpolating},
                           {.eye_world = centre + Vec3d(24, 20, 28), .target_world = centre});
}

/// A ball that the box of its field cuts open: beyond it samples only repeat.
Worst surface_ends_with_the_field(Device& device) {
    const auto field =
        field_in(GridSpace::uniform(1), {Index3::Zero(), Index3(14, 28, 28)},
                 [](const Vec3d& p) { return (p - Vec3d(13.6, 13.3, 14.2)).norm() - 10; });
    Worst worst;
    for (const Vec3d& eye : {Vec3d(70, 30, 40), Vec3d(-50, 20, 30), Vec3d(13.5, 13, 70)})
        worst.see(judge_positions(device, {.samples = field, .filter = Filter::Interpolating},
                                  {.eye_world = eye, .target_world = {10, 14, 14}}));
    return worst;
}

/// Scaled by a power of two with its camera, a picture is scaled.
Worst scales_exactly(Device& device, int exponent) {
    const double scale = std::exp2(exponent);
    const auto small = ball_at(Vec3d::Zero(), 0x1p-10);
    Camera camera = at_ball(Vec3d::Zero(), 40 * 0x1p-10, 10 * 0x1p-10);
    const Image a = hits_of(device, {.samples = small}, camera);
    camera.eye_world *= scale;
    camera.target_world *= scale;
    Image b = hits_of(device,
                      {.samples = std::make_shared<PlacedField>(small, Placement{.scale = scale})},
                      camera);
    for (std::size_t i = 0; i < b.rgba.size(); ++i)
        if (i % 4 != 3) b.rgba[i] = static_cast<float>(b.rgba[i] / scale);
    return same_pictures(a, b);
}

} // namespace

void append_view_cases(std::vector<Case>& cases) {
    const char* compares = "hits and the double caster's, along each ray [voxels]";
    const char* from = "1e-5 of the search, 2e-5 a few times of coordinates, ten times that where "
                       "rays graze";
    const auto add = [&](const std::string& name, auto run) {
        append(cases, {"view." + name, compares, 1e-3, from, run});
    };
    for (const auto& [name, offset] :
         {std::pair{"origin-1e3-away", 1e3}, std::pair{"origin-1e6-away", 1e6}})
        add(name,
            [offset = offset](Device& device) { return far_from_the_origin(device, offset); });
    for (const auto& [name, radii] :
         {std::pair{"eye-1e2-radii-away", 1e2}, std::pair{"eye-1e4-radii-away", 1e4},
          std::pair{"eye-1e6-radii-away", 1e6}, std::pair{"eye-1e8-radii-away", 1e8}})
        append(cases,
               {std::string("view.") + name,
                "hits and the double caster's, by 1e-3 voxel or four steps of a float at that "
                "distance, if more",
                1, "positions are floats, relative to the eye",
                [radii = radii](Device& device) { return from_afar(device, radii); }});
    add("fov-0.001", through_a_pinhole);
    add("fov-90", [](Device& device) { return of_angle(device, 90, 0.015); });
    add("fov-179", [](Device& device) { return of_angle(device, 179, 0.0101); });
    add("fov-179-inside", [](Device& device) { return of_angle(device, 179, 0.004); });
    add("picture-1x1", [](Device& device) { return of_size(device, 1, 1); });
    add("picture-1x97", [](Device& device) { return of_size(device, 1, 97); });
    add("picture-16384x1-in-tiles", one_line_in_tiles);
    add("eye-0.01-voxel-outside", [](Device& device) { return eye_at_the_surface(device, 0.01); });
    add("eye-0.01-voxel-inside", [](Device& device) { return eye_at_the_surface(device, -0.01); });
    add("eye-in-the-middle", [](Device& device) { return eye_at_the_surface(device, -10); });
    add("sheared-and-mirrored", sheared_and_mirrored);
    add("surface-ends-with-the-field", surface_ends_with_the_field);
    append(cases, {"view.parts-are-the-whole", "pixels of parts and of the whole picture", 0,
                   "bit for bit", parts_are_the_whole});
    for (const int exponent : {-30, 30})
        append(cases, {exponent < 0 ? "view.world-of-2^-30" : "view.world-of-2^30",
                       "pictures of a scene and of the same times a power of two", 0, "bit for bit",
                       [exponent](Device& device) { return scales_exactly(device, exponent); }});
}

} // namespace isocast::stability
