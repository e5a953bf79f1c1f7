// The reference's pictures against closed forms, and the GPU's against the reference's.
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/reference_renderer.h"

#include "../renderer_test_base.h"
#include "hard_fields.h"
#include "volume/analytic_fields.h"
#include "volume/errors.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace isocast {
namespace {

using namespace test;

const ImageSet all_images{FrameImage::Hit, FrameImage::Gradient, FrameImage::Curvature,
                          FrameImage::Direction, FrameImage::Beauty};

/// What a scene's images are of.
struct Drawn {
    Image hit, gradient, curvature, direction, beauty;

    std::size_t count() const { return hit.rgba.size() / 4; }
    static Vec3d vector(const Image& image, std::size_t i) {
        return {image.rgba[4 * i], image.rgba[4 * i + 1], image.rgba[4 * i + 2]};
    }
    int object(std::size_t i) const { return static_cast<int>(hit.rgba[4 * i + 3]); }
};

template<class SomeRenderer>
Drawn read_all(const SomeRenderer& renderer, const ImageSet& wanted) {
    const auto read = [&](FrameImage image) {
        return wanted.contains(image) ? renderer.read(image) : Image{};
    };
    return {read(FrameImage::Hit), read(FrameImage::Gradient), read(FrameImage::Curvature),
            read(FrameImage::Direction), read(FrameImage::Beauty)};
}

Drawn by_reference(const Scene& scene, const Camera& camera, int width, int height,
                   const ImageSet& wanted = all_images) {
    ReferenceRenderer reference;
    reference.load(scene);
    reference.draw(camera, width, height, wanted, {.width = width, .height = height});
    return read_all(reference, wanted);
}

/// Samples of `f` in 0 ... n - 1, with its iso and filter.
FieldObject object_of(int n, const std::function<double(const Vec3d&)>& f, Filter filter,
                      double iso = 0) {
    return {.field = control_of(n, f), .iso_world = iso, .filter = filter};
}

Camera looking_at(const Vec3d& target, const Vec3d& from, double fov_y_degrees) {
    return {.eye_world = from, .target_world = target, .fov_y_degrees = fov_y_degrees};
}

TEST(ReferencePictures, OfASphereAreItsClosedForm) {
    // |p - c|^2 - R^2 in quarters, which Catmull-Rom's cubic reproduces; the B-spline adds 1.
    const Vec3d centre(12.25, 11.5, 12.75);
    const double radius = 8;
    const auto f = [&](const Vec3d& p) { return (p - centre).squaredNorm() - radius * radius; };
    for (const Filter filter : {Filter::CatmullRom, Filter::BSpline})
        for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
            Camera camera = looking_at(centre, centre + Vec3d(20, 31, 40), 25);
            camera.projection = projection;
            camera.height_world = 18;
            const Drawn drawn = by_reference(
                {.objects = {object_of(25, f, filter, filter == Filter::BSpline ? 1 : 0)}}, camera,
                60, 40);
            int hits = 0;
            for (std::size_t i = 0; i < drawn.count(); ++i) {
                const Ray ray =
                    camera_ray(camera, 60, 40, double(i % 60) + 0.5, double(i / 60) + 0.5);
                const Vec3d o = ray.origin_world - centre;
                const double b = o.dot(ray.direction_world) / ray.direction_world.squaredNorm();
                const double h = radius * radius - (o - b * ray.direction_world).squaredNorm();
                ASSERT_EQ(drawn.object(i), h > 0 ? 1 : 0);
                if (h < 0) continue;
                ++hits;
                const double t = -b - std::sqrt(h) / ray.direction_world.norm();
                const Vec3d p = ray.origin_world + t * ray.direction_world;
                // Images are floats: 2^-24 of 60.
                EXPECT_LT((Drawn::vector(drawn.hit, i) - (p - camera.eye_world)).norm(), 7e-6);
                const Vec3d normal = (p - centre).normalized();
                EXPECT_LT((Drawn::vector(drawn.gradient, i).normalized() - normal).norm(), 1e-6);
                for (const std::size_t k : {0, 1})
                    EXPECT_NEAR(drawn.curvature.rgba[4 * i + k], 1 / radius, 1e-7);
                EXPECT_EQ(drawn.curvature.rgba[4 * i + 3], 3); // an umbilic
                EXPECT_NEAR(Drawn::vector(drawn.direction, i).dot(normal), 0, 1e-6);
                EXPECT_NEAR(Drawn::vector(drawn.direction, i).norm(), 1, 1e-6);
            }
            EXPECT_GT(hits, 500);
        }
}

TEST(ReferencePictures, OfAPlaneAreItsClosedForm) {
    const Vec3d slope(0.5, -0.25, 0.875); // eighths are exact in float
    const Vec3d middle(8, 8, 8);
    const auto f = [&](const Vec3d& p) { return slope.dot(p - middle); };
    const Camera camera = looking_at(middle, middle + Vec3d(4, 1, 9), 20);
    for (const Filter filter :
         {Filter::Linear, Filter::BSpline, Filter::Interpolating, Filter::CatmullRom}) {
        const Drawn drawn = by_reference({.objects = {object_of(17, f, filter)}}, camera, 32, 32);
        for (std::size_t i = 0; i < drawn.count(); ++i) {
            const Ray ray = camera_ray(camera, 32, 32, double(i % 32) + 0.5, double(i / 32) + 0.5);
            const double t = slope.dot(middle - ray.origin_world) / slope.dot(ray.direction_world);
            ASSERT_EQ(drawn.object(i), 1);
            EXPECT_LT((Drawn::vector(drawn.hit, i) - t * ray.direction_world).norm(), 1e-6);
            EXPECT_LT((Drawn::vector(drawn.gradient, i) - slope).norm(), 1e-7);
            if (filter == Filter::Linear) continue; // mixed derivatives of it are no curvature
            EXPECT_NEAR(drawn.curvature.rgba[4 * i], 0, 1e-14);
            EXPECT_NEAR(drawn.curvature.rgba[4 * i + 1], 0, 1e-14);
        }
    }
}

TEST(ReferencePictures, ConvergeToATorus) {
    // By the B-spline through the samples at fourth order: halving the voxels takes a sixteenth of
    // the error, 12 at least where it is not yet of that order; of normals an eighth, 6 at least.
    const Vec3d axis = Vec3d(0.2, -0.3, 1).normalized();
    const AnalyticField torus = torus_field(Vec3d::Zero(), axis, 1.0, 0.4);
    std::vector<double> errors;
    std::vector<double> angles;
    for (const int n : {24, 48}) {
        const double voxel = 3.2 / (n - 1);
        const GridSpace space = GridSpace::uniform(voxel, Vec3d::Constant(-1.6));
        const auto in_index =
            control_of(n, [&](const Vec3d& p) { return torus.jet(space.to_world(p)).value; });
        const auto field = std::make_shared<DenseField>(
            space, in_index->extent(),
            std::vector(in_index->values().begin(), in_index->values().end()));
        const Drawn drawn = by_reference({.objects = {{.field = field, .filter = Filter::Exact}}},
                                         looking_at(Vec3d::Zero(), {1, 2, 4}, 30), 64, 64);
        errors.push_back(0);
        angles.push_back(0);
        for (std::size_t i = 0; i < drawn.count(); ++i) {
            if (drawn.object(i) == 0) continue;
            const Vec3d p = Vec3d(1, 2, 4) + Drawn::vector(drawn.hit, i);
            const Jet jet = torus.jet(p);
            errors.back() = std::max(errors.back(), std::abs(jet.value));
            angles.back() =
                std::max(angles.back(),
                         (Drawn::vector(drawn.gradient, i).normalized() - jet.gradient).norm());
        }
    }
    EXPECT_GT(errors[0] / errors[1], 12) << errors[0] << ' ' << errors[1];
    EXPECT_GT(angles[0] / angles[1], 6) << angles[0] << ' ' << angles[1];
    EXPECT_GT(errors[1], 1e-7); // floats of 5: there is an error to be seen
}

/// By how much pictures of the GPU and of the reference differ.
struct Difference {
    int hits = 0;
    int other_objects = 0;    // pixels that show another object, or none
    double across_voxels = 0; // positions, across the surface
    double normal_degrees = 0;
    double colour = 0; // sRGB, by 255
};

double srgb(double linear) {
    const double c = std::clamp(linear, 0.0, 1.0);
    return 255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055);
}

struct GpuAndReference : RendererTest {
    /// Draws both. Only at pixels whose neighbours show different objects may they show different
    /// ones: a silhouette or crease passes within what rays err by.
    Difference compare(const Scene& scene, const Camera& camera, double voxel_world,
                       int size = 96) {
        const ImageSet wanted{FrameImage::Hit, FrameImage::Gradient, FrameImage::Beauty};
        renderer.load(scene);
        renderer.draw(camera, size, size, wanted);
        const Drawn gpu = read_all(renderer, wanted);
        const Drawn truth = by_reference(scene, camera, size, size, wanted);
        Difference difference;
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                const auto i = static_cast<std::size_t>(y * size + x);
                if (gpu.object(i) != truth.object(i)) {
                    ++difference.other_objects;
                    EXPECT_TRUE(is_at_edge(truth, x, y, size)) << x << ' ' << y;
                    continue;
                }
                for (std::size_t c = 0; c < 3; ++c)
                    difference.colour =
                        std::max(difference.colour, std::abs(srgb(gpu.beauty.rgba[4 * i + c]) -
                                                             srgb(truth.beauty.rgba[4 * i + c])));
                if (truth.object(i) == 0) continue;
                ++difference.hits;
                const Vec3d n = Drawn::vector(truth.gradient, i).normalized();
                const Vec3d m = Drawn::vector(gpu.gradient, i).normalized();
                const Vec3d moved = Drawn::vector(gpu.hit, i) - Drawn::vector(truth.hit, i);
                difference.across_voxels =
                    std::max(difference.across_voxels, std::abs(moved.dot(n)) / voxel_world);
                difference.normal_degrees =
                    std::max(difference.normal_degrees,
                             2 * std::asin(0.5 * (m - n).norm()) * 180 / std::numbers::pi);
            }
        worst_.across_voxels = std::max(worst_.across_voxels, difference.across_voxels);
        worst_.normal_degrees = std::max(worst_.normal_degrees, difference.normal_degrees);
        worst_.colour = std::max(worst_.colour, difference.colour);
        worst_.other_objects += difference.other_objects;
        RecordProperty("voxels", std::to_string(worst_.across_voxels));
        RecordProperty("degrees", std::to_string(worst_.normal_degrees));
        RecordProperty("colour", std::to_string(worst_.colour));
        RecordProperty("other", worst_.other_objects);
        return difference;
    }

    static bool is_at_edge(const Drawn& drawn, int x, int y, int size) {
        for (int v = std::max(0, y - 1); v <= std::min(size - 1, y + 1); ++v)
            for (int u = std::max(0, x - 1); u <= std::min(size - 1, x + 1); ++u)
                if (drawn.object(static_cast<std::size_t>(v * size + u)) !=
                    drawn.object(static_cast<std::size_t>(y * size + x)))
                    return true;
        return false;
    }

    Difference worst_; // of what a test compared, for its record

    /// The bounds that docs/raycasting.md states.
    static void expect_equal(const Difference& difference) {
        EXPECT_GT(difference.hits, 1000);
        EXPECT_LE(difference.other_objects, 0.002 * difference.hits);
        EXPECT_LT(difference.across_voxels, 3e-5);
        // Where rays graze, places err along them, and normals by the curvature times that.
        EXPECT_LT(difference.normal_degrees, 0.01);
        EXPECT_LT(difference.colour, 0.5);
    }
};

TEST_F(GpuAndReference, AgreeOnFields) {
    for (const Filter filter : {Filter::Interpolating, Filter::BSpline, Filter::CatmullRom}) {
        const HardField torus = tilted_torus(40, 3);
        const Scene scene{.objects = {{.field = torus.control, .filter = filter}}};
        expect_equal(compare(scene, looking_at({19.5, 19.5, 19.5}, {50, 60, 100}, 22), 1));
    }
}

TEST_F(GpuAndReference, AgreeOnSmoothNoiseByEachModelOfShading) {
    Scene scene{
        .objects = {{.field = smooth_noise(32, 5).control, .filter = Filter::Interpolating}}};
    scene.look.lights.push_back(
        {.direction = {0, 1, 0.2}, .is_in_view_space = false, .colour = {0.2, 0.3, 0.5}});
    for (const ShadingModel model :
         {ShadingModel::BlinnPhong, ShadingModel::Gooch, ShadingModel::Flat}) {
        scene.look.model = model;
        expect_equal(compare(scene, looking_at({16, 16, 16}, {70, 90, 60}, 15), 1));
    }
}

TEST_F(GpuAndReference, AgreeOnCurvatureColoursRidgesAndContours) {
    Scene scene{
        .objects = {{.field = tilted_torus(40, 3).control, .filter = Filter::Interpolating}}};
    Effects& effects = scene.look.effects;
    effects.curvature_colour = {.strength = 0.8, .range = {{-0.5, 0.5}}};
    effects.ridges = {.strength = 0.5, .threshold = 0.2};
    effects.accessibility = {.strength = 0.5, .radius_world = 3};
    effects.contours = {.strength = 1};
    expect_equal(compare(scene, looking_at({19.5, 19.5, 19.5}, {50, 60, 100}, 22), 1));
}

TEST_F(GpuAndReference, AgreeOnSolidsOnGridsThatDiffer) {
    GridSpace turned;
    turned.world_from_index.linear() << 0.9, 0.2, 0.0, -0.1, 1.1, 0.3, 0.1, 0.0, 0.8;
    turned.world_from_index.translation() = Vec3d(-3, -12, 0);
    const auto ball = control_of(
        32, [&](const Vec3d& p) { return (turned.to_world(p) - Vec3d(12, 10, 14)).norm() - 8; });
    const auto placed = std::make_shared<DenseField>(
        turned, ball->extent(), std::vector(ball->values().begin(), ball->values().end()));
    Scene scene{.objects = {{.field = tilted_torus(32, 8).control, .colour = Vec3d(0.8, 0.2, 0.1)},
                            {.field = placed,
                             .filter = Filter::CatmullRom,
                             .colour = Vec3d(0.1, 0.4, 0.8),
                             .cut_colour = Vec3d(0.9, 0.9, 0.2)}}};
    for (const CsgOperation operation :
         {CsgOperation::Union, CsgOperation::Intersection, CsgOperation::Difference}) {
        scene.tree = {{CsgOperation::Object, 0}, {CsgOperation::Object, 1}, {operation}};
        Difference difference = compare(scene, looking_at({15, 14, 15}, {40, 60, 80}, 22), 0.8);
        // Of two objects depths are compared in float; the bound on those that differ is of edges,
        // of which an intersection has more.
        EXPECT_LE(difference.other_objects, 5);
        difference.other_objects = 0;
        EXPECT_GT(difference.hits, 300);
        difference.hits = 1001;
        expect_equal(difference);
    }
}

TEST_F(GpuAndReference, AgreeOnPrimitivesBesideAField) {
    Primitives some;
    some.spheres = {{.centre_world = {10, 26, 20}, .radius_world = 6, .colour = {0.9, 0.1, 0.1}}};
    some.cylinders = {{.a_world = {4, 4, 30},
                       .b_world = {30, 26, 24},
                       .radius_world = 2,
                       .colour = {0.1, 0.8, 0.2},
                       .colour_b = Vec3d(0.2, 0.2, 0.9)}};
    some.meshes = {{.vertices_world = {{20, 0, 30}, {38, 4, 28}, {30, 20, 34}, {36, 0, 10}},
                    .triangles = {{0, 1, 2}, {0, 3, 1}},
                    .normals_world = {{0, -0.6F, 0.8F},
                                      {0.6F, 0, 0.8F},
                                      {0, 0.6F, 0.8F},
                                      {0, -1, 0},
                                      {0, -1, 0},
                                      {0, -1, 0}}}};
    const Scene scene{.objects = {{.field = tilted_torus(40, 3).control}},
                      .primitives = std::make_shared<Primitives>(some)};
    // Floats of coordinates: 2^-22 of distances of 90, for a voxel that is 1.
    expect_equal(compare(scene, looking_at({19.5, 19.5, 19.5}, {30, 40, 100}, 25), 1, 128));
}

TEST(ReferenceRenderer, DrawsPartsThatAreThoseOfTheWholeOnAnyNumberOfThreads) {
    const Scene scene{.objects = {{.field = smooth_noise(24, 5).control}}};
    ReferenceRenderer reference;
    reference.load(scene);
    const Camera camera = looking_at({12, 12, 12}, {50, 70, 40}, 20);
    const auto picture = [&](const PicturePart& part) {
        reference.draw(camera, 40, 30, all_images, part);
        return reference.read(FrameImage::Beauty);
    };
    const Image whole = picture({.width = 40, .height = 30});
    const Image part = picture({.x = 7, .y = 11, .width = 20, .height = 9});
    for (int y = 0; y < 9; ++y)
        for (int x = 0; x < 20; ++x)
            for (int c = 0; c < 4; ++c)
                ASSERT_EQ(part.pixel(x, y)[c], whole.pixel(x + 7, y + 11)[c]);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    reference.load(scene);
    EXPECT_EQ(picture({.width = 40, .height = 30}).rgba, whole.rgba);
}

TEST(ReferenceRenderer, RefusesWhatItCannotDrawByName) {
    ReferenceRenderer reference;
    Scene scene{.objects = {{.field = tilted_torus(24, 1).control}}};
    scene.look.lights[0].shadow = Shadow::Hard;
    scene.look.effects.occlusion.strength = 1;
    scene.look.effects.ridges.strength = 1;
    try {
        reference.load(scene);
        FAIL();
    } catch (const InputError& error) {
        EXPECT_STREQ(error.what(),
                     "the reference does not draw: ridges without a threshold, occlusion, "
                     "shadow");
    }
    scene.look = {};
    reference.load(scene);
    const PicturePart part{.width = 4, .height = 4};
    EXPECT_THROW(reference.draw({}, 4, 4, {FrameImage::Occlusion}, part), InputError);
    EXPECT_THROW(reference.draw({}, 4, 4, {FrameImage::Steps}, part), InputError);
    scene.primitives = std::make_shared<Primitives>(Primitives{.spheres = {{}}});
    reference.load(scene);
    EXPECT_THROW(reference.draw({}, 4, 4, {FrameImage::Curvature}, part), InputError);
}

} // namespace
} // namespace isocast
