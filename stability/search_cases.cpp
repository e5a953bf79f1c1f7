// The search of rays: thin, grazed, flat and one-voxel surfaces, and fields with hardly any.
// SPDX-License-Identifier: MPL-2.0
#include "stability/hard_fields.h"
#include "stability/picture_judge.h"
#include "volume/analytic_fields.h"
#include "volume/blended_field.h"

#include <tbb/global_control.h>

namespace isocast::stability {

namespace {

constexpr int n = 28;
const Vec3d middle = Vec3d::Constant(0.5 * (n - 1));

/// From a random side, perspective and parallel.
std::vector<Camera> oblique(unsigned seed, int count = 2) {
    Random random(seed);
    std::vector<Camera> cameras;
    for (int i = 0; i < count; ++i)
        cameras.push_back({.eye_world = middle + 3.0 * n * random.unit(),
                           .target_world = middle,
                           .up = random.unit(),
                           .projection = i % 2 ? Projection::Orthographic : Projection::Perspective,
                           .height_world = 1.3 * n});
    return cameras;
}

/// Along an axis, parallel: two components of every ray are exactly zero.
Camera along_axis(int axis, double sign = 1) {
    return {.eye_world = middle + sign * 2 * n * Vec3d::Unit(axis),
            .target_world = middle,
            .up = Vec3d::Unit((axis + 1) % 3),
            .projection = Projection::Orthographic,
            .height_world = 1.0 * n};
}

/// guarantee_voxels  the oracle's steps are half as long
Subject subject_of(std::shared_ptr<const FieldSource> control, Filter filter = Filter::BSpline,
                   double guarantee_voxels = 0.05) {
    return {.samples = std::move(control),
            .filter = filter,
            .quality = {.guarantee_voxels = guarantee_voxels}};
}
/// Of surfaces that are thinner.
Subject thin_subject_of(std::shared_ptr<const FieldSource> control) {
    return subject_of(std::move(control), Filter::BSpline, 0.01);
}

Worst sheet_edge_on(Device& device) {
    const ThinSheet sheet = thin_sheet(n, 4);
    Random random(40);
    std::vector<Camera> cameras;
    for (const double height : {0.0, 0.001, 0.1}) {
        const Vec3d along = sheet.normal.cross(random.unit()).normalized();
        cameras.push_back({.eye_world = sheet.p_on_sheet + 60 * along + height * sheet.normal,
                           .target_world = sheet.p_on_sheet,
                           .up = sheet.normal,
                           .fov_y_degrees = height == 0 ? 1.0 : 10.0});
    }
    return judge_search(device, thin_subject_of(sheet.field.control), cameras, {32, 32});
}

/// At the heights of the tube's top, where rays graze it for long, of its middle and between.
Worst torus_edge_on(Device& device) {
    const Vec3d axis = Vec3d(0.2, -0.3, 1).normalized();
    const AnalyticField torus = torus_field(middle, axis, 9, 2.5);
    const auto control = unit_field(n, [&](const Vec3d& p) { return torus.jet(p).value; });
    const Vec3d along = axis.cross(Vec3d(1, 2, 3)).normalized();
    std::vector<Camera> cameras;
    for (const double height : {0.0, 2.4, 2.49, 2.5, 2.51})
        cameras.push_back({.eye_world = middle + 100 * along + height * axis,
                           .target_world = middle + height * axis,
                           .up = axis,
                           .projection = Projection::Orthographic,
                           .height_world = 0.5});
    return judge_search(device, subject_of(control), cameras, {32, 32});
}

Worst from_inside(Device& device) {
    std::vector<Camera> cameras;
    Random random(5);
    for (int i = 0; i < 4; ++i) {
        const Vec3d eye = middle + random.in_cube(8);
        cameras.push_back({.eye_world = eye,
                           .target_world = eye + random.unit(),
                           .up = random.unit(),
                           .fov_y_degrees = 120});
    }
    return judge_search(device, subject_of(smooth_noise(n, 6).control), cameras, {32, 32});
}

/// Flat at the iso value, with what is below it on one side.
Worst plateau(Device& device, double iso, Filter filter) {
    Subject subject = subject_of(
        unit_field(n, [&](const Vec3d& p) { return iso + std::min(0.0, (p.z() - 12) / 4); }),
        filter);
    subject.iso = iso;
    std::vector<Camera> cameras = oblique(7);
    cameras.push_back(along_axis(2));
    return judge_search(device, subject, cameras, {32, 32});
}

/// Nothing may be seen of a field from any side, nor may the drawing fail.
Worst nothing_is_seen(Device& device, const Subject& subject) {
    Worst worst;
    std::vector<Camera> cameras = oblique(8);
    cameras.push_back(along_axis(0));
    cameras.push_back({.eye_world = middle, .target_world = middle + Vec3d(1, 2, 3)});
    for (const Camera& camera : cameras)
        for (const float value : hits_of(device, subject, camera, {24, 24}).rgba)
            worst.must(value == 0);
    return worst;
}

/// Inside is a single layer of samples, whose spline is a sheet.
Worst one_voxel_wide(Device& device, int axis) {
    const auto control = unit_field(n, [&](const Vec3d& p) { return p[axis] == 13 ? -1.0 : 0.5; });
    std::vector<Camera> cameras = oblique(9);
    cameras.push_back(along_axis(axis));
    cameras.push_back(along_axis((axis + 1) % 3));
    return judge_search(device, subject_of(control), cameras, {32, 32});
}

/// The field itself is one voxel wide.
Worst extent_of_one_voxel(Device& device) {
    const auto field = field_in(GridSpace::uniform(1), {Index3::Zero(), Index3(n, n, 2)},
                                [](const Vec3d& p) { return (p - middle).head<2>().norm() - 8; });
    std::vector<Camera> cameras = oblique(10);
    cameras.push_back(
        {.eye_world = {-30, 4, 0.5}, .target_world = {14, 13, 0.5}, .fov_y_degrees = 4});
    return judge_search(device, subject_of(field), cameras, {32, 32});
}

/// One sample below the others, in each of a block's corners: bricks with a spot of surface.
Worst one_sample(Device& device) {
    Worst worst;
    for (const Index3& at : {Index3(8, 8, 8), Index3(15, 15, 15), Index3(7, 16, 8)}) {
        const auto control =
            unit_field(n, [&](const Vec3d& p) { return p == at.cast<double>() ? -4.0 : 1.0; });
        std::vector<Camera> cameras = oblique(11);
        for (Camera& camera : cameras) {
            camera.target_world = at.cast<double>();
            camera.eye_world = camera.target_world + 30 * Vec3d(0.4, 0.5, 0.8);
            camera.fov_y_degrees = 5;
            camera.height_world = 3;
        }
        worst.see(judge_search(device, subject_of(control), cameras, {32, 32}));
    }
    return worst;
}

/// A slab over the faces between blocks, along rays that run in these.
Worst in_faces_between_blocks(Device& device) {
    Worst worst;
    for (int axis = 0; axis < 3; ++axis) {
        const auto control =
            unit_field(n, [&](const Vec3d& p) { return std::abs(p[axis] - 13.6) - 5; });
        for (const double sign : {-1.0, 1.0})
            for (const double offset : {0.0, 3.0}) {
                Vec3d target = Vec3d::Constant(16);
                target[(axis + 1) % 3] -= offset;
                // One pixel: zero components are exact.
                worst.see(judge_search(device, subject_of(control),
                                       {{.eye_world = target + 64 * sign * Vec3d::Unit(axis),
                                         .target_world = target,
                                         .up = Vec3d::Unit((axis + 1) % 3),
                                         .projection = Projection::Orthographic,
                                         .height_world = 1}},
                                       {1, 1}));
            }
    }
    return worst;
}

Image picture_of(Device& device, const Subject& subject) {
    return hits_of(device, subject, oblique(12)[0], {40, 40});
}

Worst traversals_agree(Device& device) {
    Subject subject = subject_of(smooth_noise(n, 13).control);
    const Image lists = picture_of(device, subject);
    Worst worst;
    for (const Traversal traversal :
         {Traversal::DrawnBlocks, Traversal::BoundingFaces, Traversal::Walk}) {
        subject.quality.traversal = traversal;
        worst.see(same_pictures(picture_of(device, subject), lists));
    }
    return worst;
}

Worst bricks_agree(Device& device) {
    Subject subject = subject_of(smooth_noise(n, 14).control);
    const Image expected = picture_of(device, subject);
    Worst worst;
    for (const int brick : {16, 32, no_bricks}) {
        subject.storage = {.brick_size = brick};
        worst.see(same_pictures(picture_of(device, subject), expected));
    }
    // As few as one at a time.
    subject.storage = {.budget_bytes = 5 * BrickLayout(StorageOptions{}).brick_bytes};
    worst.see(same_pictures(picture_of(device, subject), expected));
    return worst;
}

Worst threads_agree(Device& device) {
    const Subject subject = subject_of(smooth_noise(n, 15).control, Filter::Interpolating);
    const auto with = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        return picture_of(device, subject);
    };
    return same_pictures(with(1), with(2));
}

/// From one ball to two by the iso value, set and loaded anew.
Worst iso_moves_through_a_saddle(Device& device) {
    const auto two = unit_field(n, [](const Vec3d& p) {
        return std::min((p - middle - Vec3d(5, 0, 0)).norm(),
                        (p - middle + Vec3d(5, 0, 0)).norm()) -
               4;
    });
    const Camera camera = oblique(16)[0];
    Worst worst;
    device.renderer.load({.field = two});
    for (const double iso : {-1.0, 0.999, 1.0, 1.001, 3.0}) {
        device.renderer.set_iso(iso);
        device.renderer.draw(camera, 48, 48, {FrameImage::Hit});
        const Image moved = device.renderer.read(FrameImage::Hit);
        Subject subject = subject_of(two, Filter::Interpolating);
        subject.iso = iso;
        worst.see(same_pictures(moved, hits_of(device, subject, camera)));
    }
    return worst;
}

/// Between two times, while a bridge between two balls breaks.
Worst time_with_a_breaking_bridge(Device& device) {
    const auto balls_apart = [](double distance) {
        return std::shared_ptr<const FieldSource>(unit_field(n, [=](const Vec3d& p) {
            const Vec3d half(distance / 2, 0, 0);
            return std::min((p - middle - half).norm(), (p - middle + half).norm()) - 5;
        }));
    };
    Worst worst;
    for (const double t : {0.0, 0.45, 0.5, 0.55, 1.0}) {
        const auto now = std::make_shared<BlendedField>(balls_apart(9), balls_apart(11.5), t);
        worst.see(judge_search(device, subject_of(now), oblique(17), {32, 32}));
    }
    return worst;
}

} // namespace

void append_search_cases(std::vector<Case>& cases) {
    const char* compares = "values at hits over what float32 makes of them; stretches of more than "
                           "the guarantee that rays pass";
    const char* from = "2^-20 of the samples, and 3e-5 voxel of place";
    const auto add = [&](const std::string& name, auto run) {
        append(cases, {"search." + name, compares, 1, from, run});
    };
    const auto exact = [&](const std::string& name, const char* what, auto run) {
        append(cases, {"search." + name, what, 0, "bit for bit", run});
    };
    add("sheet-of-0.02-voxel", [](Device& device) {
        return judge_search(device, thin_subject_of(thin_sheet(n, 1).field.control), oblique(1));
    });
    add("sheet-edge-on", sheet_edge_on);
    add("shell-of-0.1-voxel", [](Device& device) {
        return judge_search(device, thin_subject_of(thin_shell(n, 1).field.control), oblique(2));
    });
    add("torus-edge-on", torus_edge_on);
    add("needles", [](Device& device) {
        return judge_search(device, thin_subject_of(needles(n, 3).control), oblique(3));
    });
    for (const Filter filter :
         {Filter::Linear, Filter::BSpline, Filter::Interpolating, Filter::CatmullRom})
        add("white-noise-" + std::string(filter_name(filter)), [filter](Device& device) {
            return judge_search(device, subject_of(white_noise(n, 4), filter), oblique(4),
                                {32, 32});
        });
    for (int axis = 0; axis < 3; ++axis)
        add(std::string("along-") + "xyz"[axis], [axis](Device& device) {
            Worst worst = judge_search(device, subject_of(tilted_torus(n, 5).control),
                                       {along_axis(axis), along_axis(axis, -1)}, {32, 32});
            worst.see(judge_search(device, subject_of(smooth_noise(n, 5).control),
                                   {along_axis(axis), along_axis(axis, -1)}, {32, 32}));
            return worst;
        });
    add("from-inside", from_inside);
    add("in-faces-between-blocks", in_faces_between_blocks);
    add("plateau-at-iso-0", [](Device& device) { return plateau(device, 0, Filter::BSpline); });
    add("plateau-at-iso-0.375",
        [](Device& device) { return plateau(device, 0.375, Filter::BSpline); });
    add("plateau-linear", [](Device& device) { return plateau(device, 0.375, Filter::Linear); });
    for (int axis = 0; axis < 3; ++axis)
        add(std::string("one-voxel-wide-across-") + "xyz"[axis],
            [axis](Device& device) { return one_voxel_wide(device, axis); });
    add("extent-of-one-voxel", extent_of_one_voxel);
    add("one-sample-inside", one_sample);
    add("bridge-that-breaks-in-time", time_with_a_breaking_bridge);
    for (const SampleFormat format : {SampleFormat::Float16, SampleFormat::Norm16})
        add(format == SampleFormat::Float16 ? "stored-as-float16" : "stored-as-norm16",
            [format](Device& device) {
                Subject subject = subject_of(smooth_noise(n, 18).control);
                subject.storage.format = format;
                return judge_search(device, subject, oblique(18));
            });
    add("fetches-of-8-bit-fractions", [](Device& device) {
        Subject subject = subject_of(smooth_noise(n, 19).control);
        subject.storage = {.fetch = Fetch::Linear, .fraction_bits = 8};
        return judge_search(device, subject, oblique(19));
    });
    const auto blank = [&](const char* name, double value, double iso) {
        exact(name, "pixels of a field without a surface and background",
              [value, iso](Device& device) {
                  Subject subject = subject_of(unit_field(n, [=](const Vec3d&) { return value; }));
                  subject.iso = iso;
                  return nothing_is_seen(device, subject);
              });
    };
    blank("empty-field", 1, 0);
    blank("all-inside-field", -1, 0);
    blank("all-at-iso", 0.375, 0.375);
    exact("traversals", "pictures by lists and by three other traversals", traversals_agree);
    exact("bricks-of-any-size", "pictures by bricks of 8, 16, 32, by none and by five at a time",
          bricks_agree);
    exact("threads-1-and-2", "pictures of bricks cut by 1 and 2 threads", threads_agree);
    exact("iso-through-a-saddle", "pictures of a moved and of a loaded iso value",
          iso_moves_through_a_saddle);
}

} // namespace isocast::stability
