// Contours: their thickness on surfaces whose silhouettes are known.
// SPDX-License-Identifier: MPL-2.0
#include "effect_rules.h"

#include <numbers>

namespace isocast::test {
namespace {

constexpr double pi = std::numbers::pi;

struct ContourLines : Shading {
    Scene scene_of(std::shared_ptr<const FieldSource> field, double thickness_pixels) {
        Scene scene{.field = std::move(field)};
        scene.look.effects.contours.thickness_pixels = thickness_pixels;
        return scene;
    }
    /// The contours' coverage added up: pixels.
    double area(const Scene& scene) {
        image = draw(scene, FrameImage::Contours);
        hits = renderer.read(FrameImage::Hit);
        gradients = renderer.read(FrameImage::Gradient);
        double sum = 0;
        for (std::size_t i = 3; i < image.rgba.size(); i += 4) sum += image.rgba[i];
        return sum;
    }
    /// Width of the ring within a circle of `radius` pixels that has this area.
    static double ring_width(double radius, double area) {
        return radius - std::sqrt(radius * radius - area / pi);
    }
    /// n.v at a pixel of the last picture.
    double facing(int x, int y) const {
        const float* g = gradients.pixel(x, y);
        const Vec3d v = -camera_ray(camera, size, size, x + 0.5, y + 0.5).direction_world;
        return Vec3d(g[0], g[1], g[2]).normalized().dot(v.normalized());
    }
    /// How many pixels of the last picture face the viewer by less than a limit.
    double area_by_angle(double limit) const {
        double sum = 0;
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) sum += hits.pixel(x, y)[3] != 0 && facing(x, y) < limit;
        return sum;
    }

    Image image;
    Image hits;
    Image gradients;
};

std::shared_ptr<const FieldSource> ball(double radius) {
    AnalyticField field = sphere_field(Vec3d::Zero(), radius);
    field.half_extent_world = 1.3 * radius;
    return sampled(field, 40);
}

/// The outermost pixels are whole: an area of a ring errs by the square root of its length, at most
/// 18 pixels of 330, and a width by a 20th; curvatures err by 1 % (tests/raycaster).
constexpr double width_tolerance = 0.1;

TEST_F(ContourLines, OfSpheresAreAsWideAsAsked) {
    size = 128;
    const double eye = 5;
    for (const Projection projection : {Projection::Orthographic, Projection::Perspective}) {
        camera = {.eye_world = {0, 0, eye}, .projection = projection, .height_world = 2.7};
        double narrowest_by_angle = 1e9;
        double widest_by_angle = 0;
        for (const double radius : {0.3, 0.6, 1.2}) {
            const double radius_pixels = projection == Projection::Orthographic
                                             ? radius * size / camera.height_world
                                             : radius / std::sqrt(eye * eye - radius * radius) *
                                                   size / (2 * camera.half_height_at(1));
            for (const double thickness : {1.5, 3.0}) {
                const double width =
                    ring_width(radius_pixels, area(scene_of(ball(radius), thickness)));
                EXPECT_NEAR(width, thickness, width_tolerance) << radius;
            }
            // What Kindlmann et al. mend: an angle alone gives widths as different as the radii.
            const double by_angle = ring_width(radius_pixels, area_by_angle(0.4));
            narrowest_by_angle = std::min(narrowest_by_angle, by_angle);
            widest_by_angle = std::max(widest_by_angle, by_angle);
        }
        EXPECT_GT(widest_by_angle, 3 * narrowest_by_angle);
    }
}

TEST_F(ContourLines, OfATorusAreAsWideWithinAsWithout) {
    camera = {.eye_world = {0, 0, 5}, .projection = Projection::Orthographic, .height_world = 3};
    size = 128;
    const double pixels = size / camera.height_world;
    area(scene_of(sampled(builtin_field("torus"), 48), 2));
    double within = 0;
    double without = 0;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
            (std::hypot(x + 0.5 - size / 2, y + 0.5 - size / 2) < pixels ? within : without) +=
                image.pixel(x, y)[3];
    EXPECT_NEAR(ring_width(1.4 * pixels, without), 2, width_tolerance);
    const double hole = 0.6 * pixels;
    EXPECT_NEAR(std::sqrt(hole * hole + within / pi) - hole, 2, width_tolerance);
}

// An ellipsoid A u, |u| = 1, of a field that is no distance, on voxels that are no cubes. It is
// seen from an eye at e where u . A^-1 e = 1, and along v where u . A^-1 v = 0.
TEST_F(ContourLines, OfAnEllipsoidAreAsWideAllAround) {
    size = 160;
    Mat3d turn;
    turn = Eigen::AngleAxisd(0.7, Vec3d(1, 2, 0.5).normalized());
    const Mat3d a = turn * Vec3d(1.2, 0.4, 0.7).asDiagonal();
    GridSpace space = GridSpace::uniform(1);
    space.world_from_index.linear() << 0.075, 0.01, 0, 0, 0.06, 0.01, 0, 0, 0.07;
    const IndexBox box{Index3::Constant(-24), Index3::Constant(25)};
    std::vector<float> values;
    for_each_sample(box, [&](const Index3& i) {
        values.push_back(
            static_cast<float>((a.inverse() * space.to_world(i.cast<double>())).norm() - 1));
    });
    const auto field = std::make_shared<DenseField>(space, box, std::move(values));
    constexpr double thickness = 2.5;
    // The wide camera sees it far from the middle: there pixels are at an angle to the ray.
    const Camera parallel{
        .eye_world = {1, 2, 5}, .projection = Projection::Orthographic, .height_world = 2.7};
    const Camera wide{.eye_world = {1, 1, 2.5}, .target_world = {-1.1, 0, 0}, .fov_y_degrees = 80};
    for (const Camera& view : {parallel, wide}) {
        camera = view;
        const bool is_wide = view.projection == Projection::Perspective;
        const Vec3d b = a.inverse() * (is_wide ? camera.eye_world
                                               : Vec3d(camera.target_world - camera.eye_world));
        const Vec3d middle = is_wide ? Vec3d(b / b.squaredNorm()) : Vec3d::Zero();
        const double ring = std::sqrt(1 - middle.squaredNorm());
        const Vec3d e1 = b.unitOrthogonal();
        const Vec3d e2 = b.normalized().cross(e1);
        constexpr int samples = 2000;
        std::vector<Eigen::Vector2d> silhouette;
        for (int i = 0; i < samples; ++i) {
            const double t = 2 * pi * i / samples;
            silhouette.push_back(pixel_of(
                camera, size, a * (middle + ring * (std::cos(t) * e1 + std::sin(t) * e2))));
        }
        area(scene_of(field, thickness));
        // Around it in twelve parts: what is covered beside what lies within reach, and what an
        // angle alone would give.
        constexpr std::size_t parts = 12;
        std::array<double, parts> covered{};
        std::array<double, parts> by_angle{};
        std::array<double, parts> expected{};
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                if (hits.pixel(x, y)[3] == 0) continue;
                const Eigen::Vector2d p(x + 0.5, y + 0.5);
                std::size_t nearest = 0;
                for (std::size_t i = 0; i < samples; ++i)
                    if ((silhouette[i] - p).norm() < (silhouette[nearest] - p).norm()) nearest = i;
                const std::size_t part = nearest * parts / samples;
                covered[part] += image.pixel(x, y)[3];
                by_angle[part] += facing(x, y) < 0.35;
                expected[part] +=
                    std::clamp(thickness - (silhouette[nearest] - p).norm() + 0.5, 0.0, 1.0);
            }
        double least = 1e9;
        double greatest = 0;
        for (std::size_t i = 0; i < parts; ++i) {
            // The curvature changes along the view, as a circle's does not: least radii are 8
            // pixels here, of which the line is a third. Computed in double for 160 pixels, 0.19 of
            // the width (root mean square), for 640 pixels 0.06.
            EXPECT_NEAR(covered[i] / expected[i], 1, 0.25) << i;
            least = std::min(least, by_angle[i] / expected[i]);
            greatest = std::max(greatest, by_angle[i] / expected[i]);
        }
        EXPECT_GT(greatest, 3 * least);
    }
}

TEST_F(ContourLines, OfASmallSphereLeaveThreeQuartersOfItsRadius) {
    camera = {.eye_world = {0, 0, 5}, .projection = Projection::Orthographic, .height_world = 3};
    const double radius_pixels = 0.125 * size / camera.height_world; // 4
    const double width = ring_width(radius_pixels, area(scene_of(ball(0.125), 8)));
    // The pixels of a circle of 4 are 52 instead of 50.3.
    EXPECT_NEAR(width, radius_pixels / 4, 0.2);
    EXPECT_EQ(image.pixel(size / 2, size / 2)[3], 0);
}

TEST_F(ContourLines, AreNotSeenWithinASphere) {
    camera = {.eye_world = {0.2, 0.3, 0.1}, .target_world = {1, 0, 0}, .fov_y_degrees = 120};
    EXPECT_EQ(area(scene_of(ball(1), 3)), 0);
}

TEST_F(ContourLines, AreNothingAtStrengthZero) {
    Look look;
    look.effects.contours = {.strength = 0, .thickness_pixels = 5, .colour = {1, 0, 0}};
    expect_nothing_at_strength_zero(*this, look);
}

TEST_F(ContourLines, AloneNeedNoShadingAndNoPrincipalCurvatures) {
    expect_no_more_passes(*this, FrameImage::Contours,
                          {"raycast", "gradient", "view curvature", "contours"});
    // 16 bytes a pixel of hits, gradients and contours, and 4 of one curvature.
    EXPECT_EQ(report.image_bytes, size * size * (3 * 16 + 4));
}

TEST_F(ContourLines, AreFiniteAnywhere) {
    expect_finite_anywhere(*this, FrameImage::Contours);
}

TEST_F(ContourLines, AreBlendedOverTheLight) {
    Scene scene = scene_of(ball(1), 3);
    const Image plain = draw(scene);
    scene.look.effects.contours.strength = 0.5;
    scene.look.effects.contours.colour = {1, 0, 0};
    const Image with = draw(scene);
    const Image contours = renderer.read(FrameImage::Contours);
    for (std::size_t i = 0; i < plain.rgba.size(); i += 4) {
        const float share = 0.5F * contours.rgba[i + 3];
        // Both pictures are rounded to halves.
        EXPECT_NEAR(with.rgba[i], (1 - share) * plain.rgba[i] + share, 0x1p-10);
        EXPECT_NEAR(with.rgba[i + 1], (1 - share) * plain.rgba[i + 1], 0x1p-10);
    }
}

} // namespace
} // namespace isocast::test
