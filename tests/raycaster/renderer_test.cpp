// Pictures of fields with a known surface.
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/renderer.h"

#include "filtering/reconstruct.h"
#include "raycaster/reference.h"
#include "test_context.h"
#include "volume/analytic_fields.h"
#include "volume/dense_field.h"
#include "volume/errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace isocast {
namespace {

const std::filesystem::path shader_folder = std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders";

/// Samples of a distance field over a box, stored; no band clamps them.
std::shared_ptr<DenseField> dense(const AnalyticField& field, const GridSpace& space,
                                  const IndexBox& extent) {
    std::vector<float> values;
    for (int z = extent.lo.z(); z < extent.hi.z(); ++z)
        for (int y = extent.lo.y(); y < extent.hi.y(); ++y)
            for (int x = extent.lo.x(); x < extent.hi.x(); ++x)
                values.push_back(float(field.jet(space.to_world(Vec3d(x, y, z))).value));
    return std::make_shared<DenseField>(space, extent, std::move(values));
}

/// A sphere of 40 voxels, its centre off the lattice.
std::shared_ptr<DenseField> sphere_40() {
    return dense(sphere_field({50.137, 49.759, 50.319}, 40), GridSpace::uniform(1),
                 {Index3::Zero(), Index3::Constant(101)});
}

/// The search ends within 1e-5 voxel, coordinates of 300 voxels round by 2e-5 a few times, and
/// values of spheres of distances err by 2^-20 of those that a surface point reads, 4 voxels: 1e-4
/// in all, ten times that where rays meet the surface at an angle of 0.1 rad. The pictures' few
/// rays that graze it more closely are within that too, since those bounds are generous (measured).
constexpr double hit_tolerance = 1e-3;

struct Differences {
    int hits = 0;
    int missed = 0;        // the reference hits, the picture does not
    int false_hits = 0;    // the other way round
    double rms_voxels = 0; // of the hit position along the ray
    double max_voxels = 0;
};

/// The Hit image against the double reference caster, pixel by pixel.
Differences compare(const Image& hits, std::shared_ptr<const FieldSource> samples, double iso,
                    const Camera& camera) {
    const FieldSource& field = *samples;
    const ReferenceCaster reference(*control_samples(samples, Filter::Interpolating), iso);
    Differences out;
    double sum = 0;
    for (int y = 0; y < hits.height; ++y)
        for (int x = 0; x < hits.width; ++x) {
            const Ray ray = camera_ray(camera, hits.width, hits.height, x + 0.5, y + 0.5);
            const auto t = reference.hit(ray);
            const float* hit = hits.pixel(x, y);
            if (!t != (hit[3] == 0)) {
                ++(t ? out.missed : out.false_hits);
                continue;
            }
            if (!t) continue;
            ++out.hits;
            const Vec3d p = camera.eye_world + Vec3d(hit[0], hit[1], hit[2]);
            const double error = (p - (ray.origin_world + *t * ray.direction_world)).norm() /
                                 field.space().voxel_size_world();
            sum += error * error;
            out.max_voxels = std::max(out.max_voxels, error);
        }
    out.rms_voxels = std::sqrt(sum / std::max(1, out.hits));
    return out;
}

struct Rendering : testing::Test {
    std::unique_ptr<gl::Context> context = test::make_context();
    Renderer renderer{*context, shader_folder};

    Image hits(std::shared_ptr<const FieldSource> field, const Camera& camera, int size,
               double iso = 0) {
        renderer.load({.field = std::move(field), .iso_world = iso});
        renderer.draw(camera, size, size, {FrameImage::Hit});
        return renderer.read(FrameImage::Hit);
    }
};

TEST_F(Rendering, SphereIsHitWhereTheSplineHasItsRoot) {
    const auto field = sphere_40();
    const Camera camera{.eye_world = {130, 100, 270}, .target_world = {50, 50, 50}};
    const Differences d = compare(hits(field, camera, 256), field, 0, camera);
    RecordProperty("rms_voxels", std::to_string(d.rms_voxels));
    EXPECT_GT(d.hits, 20000);
    EXPECT_EQ(d.missed, 0);
    EXPECT_EQ(d.false_hits, 0);
    // hit_tolerance, and its typical value: 1e-5 is where the search ends, 2e-5 a coordinate's
    // rounding, at slopes that are near 1 along most rays.
    EXPECT_LT(d.rms_voxels, 1e-4);
    EXPECT_LT(d.max_voxels, hit_tolerance);
}

TEST_F(Rendering, OrthographicRaysHitToo) {
    const auto field = sphere_40();
    const Camera camera{.eye_world = {130, 100, 270},
                        .target_world = {50, 50, 50},
                        .projection = Projection::Orthographic,
                        .height_world = 90};
    const Differences d = compare(hits(field, camera, 128), field, 0, camera);
    EXPECT_GT(d.hits, 8000);
    EXPECT_EQ(d.missed + d.false_hits, 0);
    EXPECT_LT(d.max_voxels, hit_tolerance);
}

TEST_F(Rendering, AxisParallelRaysHitToo) {
    const auto field = sphere_40();
    for (const Vec3d& axis : {Vec3d(1, 0, 0), Vec3d(0, -1, 0), Vec3d(0, 0, 1)}) {
        Camera camera{.eye_world = Vec3d(50, 50, 50) + 100 * axis,
                      .target_world = {50, 50, 50},
                      .up = Vec3d(0.3, 0.4, 0.5),
                      .projection = Projection::Orthographic,
                      .height_world = 90};
        const Differences d = compare(hits(field, camera, 64), field, 0, camera);
        EXPECT_GT(d.hits, 2000);
        EXPECT_EQ(d.missed + d.false_hits, 0) << axis.transpose();
        EXPECT_LT(d.max_voxels, hit_tolerance) << axis.transpose();
    }
}

TEST_F(Rendering, SurfaceEndsWhereTheFieldDoes) {
    // The box cuts the sphere open at x = 29: beyond it samples only repeat, which is no field.
    const auto field = dense(sphere_field({30.137, 29.759, 30.319}, 25), GridSpace::uniform(1),
                             {Index3::Zero(), Index3(30, 61, 61)});
    for (const Vec3d& eye : {Vec3d(150, 60, 80), Vec3d(-90, 40, 60), Vec3d(29, 29, 140)}) {
        const Camera camera{.eye_world = eye, .target_world = {20, 30, 30}};
        const Image image = hits(field, camera, 128);
        const Differences d = compare(image, field, 0, camera);
        EXPECT_GT(d.hits, 1000);
        EXPECT_EQ(d.missed + d.false_hits, 0) << eye.transpose();
        EXPECT_LT(d.max_voxels, hit_tolerance) << eye.transpose();
        for (int i = 0; i < 128 * 128; ++i) {
            const float* hit = image.pixel(i % 128, i / 128);
            if (hit[3] == 0) continue;
            // 1e-4: float coordinates of 100 voxels, a few roundings.
            ASSERT_LT(camera.eye_world.x() + hit[0], 29 + 1e-4);
        }
    }
}

TEST_F(Rendering, SurfaceThatLeavesTheFieldThroughItsCornersHasNoStrayPixels) {
    // Rays that leave the box where bricks end once took a rounded exit point for one in the brick
    // beyond, whose constant had the other sign.
    const std::shared_ptr<const FieldSource> field = sampled(builtin_field("gyroid"), 96);
    const auto control = control_samples(field, Filter::Interpolating);
    renderer.load({.field = field});
    const Camera camera = frame_box(renderer.surface_box_world(), {0.45, 0.35, 1}, 1, 30);
    renderer.draw(camera, 512, 512, {FrameImage::Hit});
    const Image image = renderer.read(FrameImage::Hit);
    int hit_count = 0;
    double greatest_value_voxels = 0;
    for (int i = 0; i < 512 * 512; ++i) {
        const float* hit = image.pixel(i % 512, i / 512);
        if (hit[3] == 0) continue;
        ++hit_count;
        const Vec3d p_index =
            field->space().to_index(camera.eye_world + Vec3d(hit[0], hit[1], hit[2]));
        greatest_value_voxels =
            std::max(greatest_value_voxels, std::abs(tricubic_value(*control, p_index)) /
                                                field->space().voxel_size_world());
    }
    EXPECT_GT(hit_count, 100000);
    // Hits are within 1e-4 voxel of the surface, and the slope is at most sqrt(6) (as for a gyroid
    // of distances below 1/h, one voxel's worth).
    EXPECT_LT(greatest_value_voxels, 1e-3);
}

TEST_F(Rendering, EyeInsideTheObjectSeesItsInnerSide) {
    const auto field = sphere_40();
    const Camera camera{
        .eye_world = {45, 52, 49}, .target_world = {100, 80, 60}, .fov_y_degrees = 100};
    const Differences d = compare(hits(field, camera, 64), field, 0, camera);
    EXPECT_EQ(d.hits, 64 * 64);
    EXPECT_LT(d.max_voxels, hit_tolerance);
}

TEST_F(Rendering, EyeInsideAnActiveBlockSeesTheSurfaceBeforeIt) {
    const auto field = sphere_40();
    // Two voxels outside the surface, looking along it.
    const Camera camera{
        .eye_world = {92.1, 50, 50.3}, .target_world = {80, 70, 60}, .fov_y_degrees = 90};
    const Differences d = compare(hits(field, camera, 128), field, 0, camera);
    EXPECT_GT(d.hits, 1000);
    EXPECT_EQ(d.missed + d.false_hits, 0);
    EXPECT_LT(d.max_voxels, hit_tolerance);
}

TEST_F(Rendering, ShearedAndMirroredGridsShowTheSameSphere) {
    // Voxels that are no cubes, axes that are not orthogonal, and a left-handed one.
    for (const double mirror : {1.0, -1.0}) {
        GridSpace space;
        space.world_from_index.linear() << 0.9, 0.2, 0.0, -0.1, 1.1, 0.3, 0.1, 0.0, mirror * 0.8;
        space.world_from_index.translation() = Vec3d(1000, -2000, 500);
        const Vec3d centre = space.to_world({40.2, 41.1, 39.7});
        const auto field =
            dense(sphere_field(centre, 20), space, {Index3::Zero(), Index3::Constant(81)});
        const Camera camera{.eye_world = centre + Vec3d(60, 50, 70), .target_world = centre};
        renderer.load({.field = field});
        renderer.draw(camera, 128, 128, {FrameImage::Hit, FrameImage::Gradient});
        const Differences d = compare(renderer.read(FrameImage::Hit), field, 0, camera);
        EXPECT_GT(d.hits, 4000);
        EXPECT_EQ(d.missed + d.false_hits, 0);
        EXPECT_LT(d.max_voxels, hit_tolerance);

        const Image gradient = renderer.read(FrameImage::Gradient);
        const Image hit = renderer.read(FrameImage::Hit);
        double worst = 0;
        for (std::size_t i = 0; i < hit.rgba.size(); i += 4) {
            if (hit.rgba[i + 3] == 0) continue;
            const Vec3d p = camera.eye_world + Vec3d(hit.rgba[i], hit.rgba[i + 1], hit.rgba[i + 2]);
            const Vec3d g(gradient.rgba[i], gradient.rgba[i + 1], gradient.rgba[i + 2]);
            worst = std::max(worst, (g - (p - centre).normalized()).norm());
        }
        // The interpolating filter errs by terms of fourth order: h^3/24 * the fourth derivative of
        // |x|, 3/r^3 = 3/8000, summed over three axes.
        EXPECT_LT(worst, 1e-4);
    }
}

TEST_F(Rendering, IsoValueMovesTheSurface) {
    const auto field = sphere_40();
    const Camera camera{.eye_world = {50.137, 49.759, 270}, .target_world = {50.137, 49.759, 50}};
    const auto nearest_z = [&](double iso) {
        const Image image = hits(field, camera, 3, iso);
        return 270 + image.pixel(1, 1)[2];
    };
    // The interpolating spline errs by fourth derivatives, 3/r^3 = 7e-5 times a small factor; the
    // rest is the hit's own error.
    EXPECT_NEAR(nearest_z(0) - nearest_z(-5), 5, 2e-4);
}

TEST_F(Rendering, FieldWithoutASurfaceGivesBackground) {
    const auto field = sphere_40();
    const Camera camera{.eye_world = {50, 50, 300}, .target_world = {50, 50, 50}};
    const Image image = hits(field, camera, 16, 1e6);
    EXPECT_FALSE(renderer.has_surface());
    for (const float value : image.rgba) EXPECT_EQ(value, 0);
}

TEST_F(Rendering, NarrowBandShowsTheSameSurfaceAsTheWholeField) {
    const Camera camera{.eye_world = {1.5, 1, 4}, .target_world = Vec3d::Zero()};
    const AnalyticField torus = builtin_field("torus");
    const std::shared_ptr<const FieldSource> whole = sampled(torus, 96);
    const std::shared_ptr<const FieldSource> band = sampled(torus, 96, 3.0);
    const Image a = hits(whole, camera, 128);
    const Image b = hits(band, camera, 128);
    double worst = 0;
    int hit_count = 0;
    for (std::size_t i = 0; i < a.rgba.size(); i += 4) {
        ASSERT_EQ(a.rgba[i + 3], b.rgba[i + 3]);
        hit_count += a.rgba[i + 3] != 0;
        for (std::size_t c = 0; c < 3; ++c)
            worst = std::max(worst, double(std::abs(a.rgba[i + c] - b.rgba[i + c])));
    }
    EXPECT_GT(hit_count, 1000);
    // The filter's support reaches 2 sqrt(3) = 3.46 voxels and that of the interpolating control
    // samples one more, a little beyond the band; what is clamped there, by 1.5 voxels at most, has
    // weights below (1/6)^2.
    EXPECT_LT(worst / band->space().voxel_size_world(), 0.05);
}

TEST_F(Rendering, ReportsWhatRanAndWhatDidNot) {
    renderer.load({.field = sphere_40()});
    const Camera camera{.eye_world = {130, 100, 270}, .target_world = {50, 50, 50}};
    const FrameReport hit_only = renderer.draw(camera, 64, 32, {FrameImage::Hit});
    EXPECT_EQ(hit_only.programs_compiled, 1);
    EXPECT_EQ(hit_only.image_bytes, 64 * 32 * 16) << "four floats a pixel";
    EXPECT_EQ(hit_only.passes.back().name, "shading");
    EXPECT_FALSE(hit_only.passes.back().ran);
    EXPECT_EQ(hit_only.passes.back().texture_bytes, 0);
    EXPECT_THROW(renderer.read(FrameImage::Beauty), std::logic_error);

    const FrameReport beauty = renderer.draw(camera, 64, 32, {FrameImage::Beauty});
    EXPECT_EQ(beauty.programs_compiled, 3);
    EXPECT_EQ(beauty.image_bytes, 64 * 32 * (2 * 16 + 8));
    const auto pass = [](const FrameReport& report, std::string_view name) {
        return *std::ranges::find(report.passes, name, &PassReport::name);
    };
    EXPECT_FALSE(pass(beauty, "bounds").ran) << "lists need none";
    EXPECT_FALSE(pass(beauty, "splats").ran) << "there are no primitives";
    EXPECT_EQ(pass(beauty, "raycast").asked_by, "gradient, shading");
    EXPECT_EQ(pass(beauty, "gradient").drawn_by, "raycast") << "hits alone were drawn without";
    EXPECT_EQ(pass(hit_only, "raycast").texture_bytes, 64 * 32 * 16);
    EXPECT_EQ(pass(hit_only, "gradient").texture_bytes, 0);

    const FrameReport again = renderer.draw(camera, 64, 32, {FrameImage::Hit});
    EXPECT_EQ(again.programs_compiled, 3) << "programs are kept";
    EXPECT_EQ(again.image_bytes, hit_only.image_bytes) << "images that nobody needs are not";
}

TEST_F(Rendering, RefusesImpossibleSizes) {
    renderer.load({.field = sphere_40()});
    EXPECT_THROW(renderer.draw({}, 0, 5, {FrameImage::Hit}), InputError);
    EXPECT_THROW(renderer.draw({}, 5, 1 << 20, {FrameImage::Hit}), InputError);
}

TEST(RenderingBackends, EglAndOsmesaGiveTheSamePicture) {
    const Camera camera{.eye_world = {130, 100, 270}, .target_world = {50, 50, 50}};
    const auto picture = [&](gl::Backend backend) {
        const auto context = gl::make_context({.backend = backend});
        Renderer renderer(*context, shader_folder);
        renderer.load({.field = sphere_40()});
        renderer.draw(camera, 200, 150, {FrameImage::Beauty});
        return renderer.read(FrameImage::Beauty);
    };
    const Image egl = picture(gl::Backend::Egl);
    const Image osmesa = picture(gl::Backend::Osmesa);
    double greatest = 0;
    for (std::size_t i = 0; i < egl.rgba.size(); ++i)
        greatest = std::max(greatest, double(std::abs(egl.rgba[i] - osmesa.rgba[i])));
    RecordProperty("greatest_difference", std::to_string(greatest));
    // One step of an 8-bit picture. On a machine where both are llvmpipe it is 0.
    EXPECT_LT(greatest, 1.0 / 255);
}

} // namespace
} // namespace isocast
