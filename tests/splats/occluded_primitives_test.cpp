// Ambient occlusion among primitives, against double rays in the same directions.
// SPDX-License-Identifier: MPL-2.0
#include "quadrics/primitive_tree.h"
#include "raycaster/renderer.h"
#include "raycaster/splats_on_gpu.h"
#include "renderer_test_base.h"
#include "shading/disc.h"
#include "some_primitives.h"
#include "volume/analytic_fields.h"

#include <gtest/gtest.h>

#include <bit>

namespace isocast::test {
namespace {

constexpr double nowhere = std::numeric_limits<double>::infinity();
constexpr CutLook capped = CutLook::Capped;

/// Both sides, by the corners' shares.
double distance_to(const Triangle& triangle, const Ray& ray) {
    const auto& [a, b, c] = triangle.corners_world;
    Mat3d columns;
    columns << b - a, c - a, -ray.direction_world;
    if (columns.determinant() == 0) return nowhere;
    const Vec3d shares = columns.inverse() * (ray.origin_world - a);
    const bool is_inside = shares.x() >= 0 && shares.y() >= 0 && shares.x() + shares.y() <= 1;
    return is_inside && shares.z() >= 0 ? shares.z() : nowhere;
}

/// What is left of a ray, and whether it comes in through a cut.
struct Left {
    double from = 0;
    double to = nowhere;
};
Left left_of(const Ray& ray, const std::vector<CutPlane>& planes) {
    Left left;
    for (const CutPlane& plane : planes) {
        const double room = plane.offset_world - plane.normal.dot(ray.origin_world);
        const double speed = plane.normal.dot(ray.direction_world);
        if (speed > 0)
            left.to = std::min(left.to, room / speed);
        else
            left.from = std::max(left.from, room / speed);
    }
    return left;
}

/// Whether a ray of unit direction meets any of the primitives within the distance.
bool is_blocked(const Primitives& primitives, const Ray& ray, double distance,
                const std::vector<CutPlane>& planes, CutLook look) {
    const Left left = left_of(ray, planes);
    const double end = std::min(left.to, distance);
    if (left.from > end) return false;
    bool blocked = false;
    for_each_kind(primitives, [&](const auto& some) {
        for (const auto& one : some) {
            const auto hit = intersect(one, ray.origin_world, ray.direction_world, left.from);
            blocked = blocked || (hit && hit->t <= end);
            if (look == capped && left.from > 0)
                blocked = blocked ||
                          depth_inside(one, ray.origin_world + left.from * ray.direction_world) < 0;
        }
    });
    for (const TriangleMesh& mesh : primitives.meshes)
        for (std::size_t i = 0; i < mesh.triangles.size() && !blocked; ++i) {
            const double t = distance_to(triangle_of(mesh, i), ray);
            blocked = t >= left.from && t <= end;
        }
    return blocked;
}

struct OccludedPrimitives : RendererTest {
    Camera camera{.eye_world = {0.8, 1.1, 5}, .target_world = Vec3d::Zero()};
    int size = 64;
    int rays = 16;
    Random random{3};
    Image hits, gradients, seen;
    FrameReport report;

    void look_at(Scene scene, double distance_world) {
        scene.look.effects.occlusion = {.distance_world = distance_world, .rays = rays};
        renderer.load(scene);
        report = renderer.draw(camera, size, size,
                               {FrameImage::Occlusion, FrameImage::Hit, FrameImage::Gradient});
        hits = renderer.read(FrameImage::Hit);
        gradients = renderer.read(FrameImage::Gradient);
        seen = renderer.read(FrameImage::Occlusion);
    }
    void look_at(const Primitives& primitives, double distance_world, const Cut& cut = {}) {
        look_at({.primitives = std::make_shared<Primitives>(primitives), .cut = cut},
                distance_world);
    }
    Vec3d vector(const Image& image, int x, int y) const {
        return Eigen::Map<const Eigen::Vector3f>(image.pixel(x, y)).cast<double>();
    }

    struct Comparison {
        int pixels = 0;
        int rays = 0;
        int blocked = 0;
        int different = 0; // pixels
    };
    /// Of drawn hits and normals; blocks(ray of unit direction).
    template<class Blocks>
    Comparison compare(Blocks blocks) const {
        Comparison sum;
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                if (hits.pixel(x, y)[3] == 0) continue;
                const Vec3d p = vector(hits, x, y);
                Vec3d n = vector(gradients, x, y).normalized();
                if (n.dot(camera_ray(camera, size, size, x + 0.5, y + 0.5).direction_world) > 0)
                    n = -n;
                int blocked = 0;
                for (int i = 0; i < rays; ++i) {
                    const Vec3d d =
                        sky_direction(i, rays, turns_of_pixel(x + 0.5, size - y - 0.5), n);
                    const Vec3d start = camera.eye_world + p + 0x1p-18 * p.norm() * n;
                    blocked += blocks(Ray{start, d.normalized()});
                }
                ++sum.pixels;
                sum.rays += rays;
                sum.blocked += blocked;
                sum.different += std::lround((1 - seen.pixel(x, y)[0]) * rays) != blocked;
            }
        return sum;
    }
};

/// Rays that graze something within the floats' 1e-6 may go either way: of a pixel's 16, among some
/// 50 outlines in sight, each as long as the sky is wide, 16 * 50 * 1e-6; and the same 1e-6 decides
/// near starts in creases. Four pixels of a thousand would be five times as many.
constexpr double few = 0.004;

TEST_F(OccludedPrimitives, CountTheRaysThatMeetAnyKind) {
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera.projection = projection;
        camera.height_world = 3;
        for (const double distance : {0.3, 10.0}) {
            const Primitives primitives = some_of_each(random, 3);
            look_at(primitives, distance);
            const Comparison c = compare([&](const Ray& ray) {
                return is_blocked(primitives, ray, distance, {}, CutLook::Inside);
            });
            EXPECT_GT(c.pixels, 1000);
            EXPECT_GT(c.blocked, distance < 1 ? 0.02 * c.rays : 0.1 * c.rays);
            EXPECT_LT(c.blocked, 0.9 * c.rays);
            EXPECT_LE(c.different, few * c.pixels) << distance;
        }
    }
}

TEST_F(OccludedPrimitives, AreCutAsTheyAreDrawn) {
    for (const CutLook look : {CutLook::Inside, CutLook::Flat, CutLook::Capped}) {
        const Primitives primitives = some_of_each(random, 3);
        const Cut cut{.look = look, .planes = {{Vec3d(0.2, 0.3, 1), 0.3}, {random.unit(), 0.6}}};
        look_at(primitives, 10, cut);
        const std::vector<CutPlane> planes = planes_of(cut, camera);
        const auto blocks = [&](const Ray& ray) {
            return is_blocked(primitives, ray, 10, planes, look);
        };
        const Comparison c = compare(blocks);
        EXPECT_GT(c.pixels, 800);
        EXPECT_LE(c.different, few * c.pixels) << static_cast<int>(look);
        // The planes make a difference.
        const Comparison uncut = compare(
            [&](const Ray& ray) { return is_blocked(primitives, ray, 10, {}, CutLook::Inside); });
        EXPECT_GT(uncut.different, 0.1 * c.pixels);
    }
}

TEST_F(OccludedPrimitives, BesideFieldsAreBlockedByEither) {
    const auto ball = [](const Vec3d& centre, double radius) {
        return AnalyticField{
            "ball", [=](const Vec3d& p) { return Jet{.value = (p - centre).norm() - radius}; }};
    };
    const Sphere first{.centre_world = {-0.3, -0.1, 0}, .radius_world = 0.4};
    const Sphere second{.centre_world = {0.5, 0.3, 0.1}, .radius_world = 0.3};
    Primitives primitives;
    primitives.spheres = {{.centre_world = {0.1, -0.5, 0.3}, .radius_world = 0.25},
                          {.centre_world = {-0.2, 0.6, 0.2}, .radius_world = 0.2}};
    primitives.meshes.push_back({.vertices_world = {{-1, -0.8, -1}, {1, -0.8, -1}, {0, -0.8, 1.5}},
                                 .triangles = {{0, 2, 1}}});
    for (const bool is_composed : {false, true}) {
        const std::shared_ptr<const FieldSource> field =
            sampled(ball(first.centre_world, first.radius_world), 64);
        Scene scene{.primitives = std::make_shared<Primitives>(primitives)};
        Primitives all = primitives;
        all.spheres.push_back(first);
        if (is_composed) {
            scene.objects = {
                {.field = field},
                {.field = sampled(ball(second.centre_world, second.radius_world), 64)}};
            all.spheres.push_back(second);
        } else {
            scene.field = field;
        }
        look_at(scene, 3);
        const Comparison c =
            compare([&](const Ray& ray) { return is_blocked(all, ray, 3, {}, CutLook::Inside); });
        EXPECT_GT(c.pixels, 700);
        EXPECT_GT(c.blocked, 0.05 * c.rays);
        // Balls' fields on voxels of 0.03 err by 1e-4, and start 5e-4 off: of 16 rays, each with an
        // outline or two.
        EXPECT_LE(c.different, 0.01 * c.pixels) << is_composed;
    }
}

/// The form factor of a sphere above the horizon: (r / d)^2 cos.
TEST_F(OccludedPrimitives, OfAPlateUnderABallAreItsFormFactor) {
    const Sphere ball{.centre_world = {0, 0, 0.5}, .radius_world = 0.3};
    Primitives primitives;
    primitives.spheres = {ball};
    primitives.cylinders = {
        {.a_world = {0, 0, -0.1}, .b_world = Vec3d::Zero(), .radius_world = 2, .is_capped = true}};
    camera = {.eye_world = {1.5, -3, 2.5}, .up = Vec3d::UnitZ(), .fov_y_degrees = 20};
    rays = 256;
    look_at(primitives, 4);
    double sum = 0;
    int count = 0;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            const Vec3d p = camera.eye_world + vector(hits, x, y);
            if (hits.pixel(x, y)[3] == 0 || std::abs(p.z()) > 1e-5) continue;
            const Vec3d to_ball = ball.centre_world - p;
            const double d = to_ball.norm();
            const double hidden = std::pow(ball.radius_world / d, 2) * to_ball.z() / d;
            const double error = seen.pixel(x, y)[0] - (1 - hidden);
            // As Occlusions.OfAFloorUnderABallAreItsFormFactor.
            EXPECT_LT(std::abs(error), 6.0 / rays);
            sum += error;
            ++count;
        }
    EXPECT_GT(count, 1000);
    EXPECT_NEAR(sum / count, 0, 0.1 / rays);
}

/// No acne: what is convex does not shade itself, near or far, small or large.
TEST_F(OccludedPrimitives, ThatAreConvexSeeAllOfTheSky) {
    const Mat3d axes = random.rotation() * Vec3d(1, 0.7, 0.2).asDiagonal();
    const auto alone = [](auto Primitives::*kind, auto one) {
        Primitives primitives;
        (primitives.*kind).push_back(one);
        return primitives;
    };
    const std::array<Primitives, 5> bodies{
        alone(&Primitives::spheres, Sphere{}),
        alone(&Primitives::ellipsoids, Ellipsoid{.axes_world = axes}),
        alone(&Primitives::cylinders, Cylinder{.is_capped = true}),
        alone(&Primitives::cones, Cone{}),
        alone(&Primitives::superquadrics,
              Superquadric{.axes_world = axes, .alpha = 0.5, .beta = 0.3})};
    for (const double distance : {1.5, 5.0, 1000.0})
        for (std::size_t i = 0; i < bodies.size(); ++i) {
            camera.eye_world = distance * Vec3d(0.3, 0.4, 0.9).normalized();
            camera.fov_y_degrees = distance > 100 ? 0.15 : 40;
            look_at(bodies[i], 10 * distance);
            int count = 0;
            int dark = 0;
            for (std::size_t at = 0; at < seen.rgba.size(); at += 4) {
                count += hits.rgba[at + 3] != 0;
                dark += hits.rgba[at + 3] != 0 && seen.rgba[at] != 1;
            }
            EXPECT_GT(count, 300);
            EXPECT_EQ(dark, 0) << "body " << i << " from " << distance;
        }
    // Right above a sphere that is 1e4 times as large as what is seen of it.
    camera = {.eye_world = {0, 0, 1.0001}, .target_world = {3e-5, 0, 1}};
    look_at(bodies[0], 1);
    for (std::size_t at = 0; at < seen.rgba.size(); at += 4) EXPECT_EQ(seen.rgba[at], 1);
}

TEST_F(OccludedPrimitives, KnowNoOccludersBeyondTheDistance) {
    Primitives primitives;
    primitives.spheres = {{.radius_world = 0.5},
                          {.centre_world = {1.2, 0, 0}, .radius_world = 0.5}};
    look_at(primitives, 0.199); // 0.2 between them
    for (std::size_t at = 0; at < seen.rgba.size(); at += 4) EXPECT_EQ(seen.rgba[at], 1);
    look_at(primitives, 0.4);
    bool is_any_dark = false;
    for (std::size_t at = 0; at < seen.rgba.size(); at += 4) is_any_dark |= seen.rgba[at] < 1;
    EXPECT_TRUE(is_any_dark);
}

TEST_F(OccludedPrimitives, InPartsAreTheWholePicture) {
    const std::shared_ptr<const FieldSource> field = sampled(builtin_field("sphere"), 24);
    for (const bool has_field : {false, true}) {
        Scene scene{.primitives = std::make_shared<Primitives>(some_of_each(random, 2))};
        if (has_field) scene.field = field;
        scene.look.effects.occlusion = {.strength = 1, .rays = 5};
        renderer.load(scene);
        renderer.draw(camera, size, size, {FrameImage::Beauty});
        const Image whole = renderer.read(FrameImage::Beauty);
        const PicturePart part{.x = 13, .y = 17, .width = 31, .height = 24};
        renderer.draw(camera, size, size, {FrameImage::Beauty}, part);
        const Image drawn = renderer.read(FrameImage::Beauty);
        for (int y = 0; y < part.height; ++y)
            for (int x = 0; x < part.width; ++x)
                for (int channel = 0; channel < 4; ++channel)
                    ASSERT_EQ(drawn.pixel(x, y)[channel],
                              whole.pixel(x + part.x, y + part.y)[channel]);
    }
}

TEST_F(OccludedPrimitives, OfStrengthZeroDoNotExist) {
    Scene scene{.primitives = std::make_shared<Primitives>(some_of_each(random, 2))};
    renderer.load(scene);
    const FrameReport plain = renderer.draw(camera, size, size, {FrameImage::Beauty});
    scene.look.effects.occlusion = {.strength = 0, .rays = 99};
    renderer.load(scene);
    const FrameReport without = renderer.draw(camera, size, size, {FrameImage::Beauty});
    EXPECT_EQ(without.programs_compiled, plain.programs_compiled);
    EXPECT_EQ(without.image_bytes, plain.image_bytes);
    EXPECT_EQ(without.scratch_bytes, plain.scratch_bytes);
    scene.look.effects.occlusion.strength = 1;
    renderer.load(scene);
    const FrameReport with = renderer.draw(camera, size, size, {FrameImage::Beauty});
    EXPECT_GT(with.scratch_bytes, plain.scratch_bytes) << "the tree";
}

TEST_F(OccludedPrimitives, ThatAreAllCutAwayLeaveTheFieldItsSky) {
    Scene scene{.field = sampled(builtin_field("sphere"), 24),
                .primitives = std::make_shared<Primitives>(some_of_each(random, 2)),
                .cut = {.planes = {{Vec3d::UnitX(), -100}}}};
    look_at(scene, 1);
    for (std::size_t at = 0; at < seen.rgba.size(); at += 4) EXPECT_EQ(seen.rgba[at], 1);
    scene.field = nullptr;
    look_at(scene, 1);
    for (std::size_t at = 0; at < seen.rgba.size(); at += 4) EXPECT_EQ(seen.rgba[at], 1);
}

Eigen::AlignedBox3f box_at(const PrimitiveTree& tree, int node) {
    Eigen::AlignedBox3f box;
    for (int axis = 0; axis < 3; ++axis) {
        box.min()[axis] = std::bit_cast<float>(tree.nodes[2 * std::size_t(node)][axis]);
        box.max()[axis] = std::bit_cast<float>(tree.nodes[2 * std::size_t(node) + 1][axis]);
    }
    return box;
}

/// Checks the subtree, and returns how many bodies it has.
int bodies_in(const PrimitiveTree& tree, int node, int& next_body) {
    const int look = tree.nodes[2 * std::size_t(node)].w();
    if (look < 0) {
        const int count = ((-1 - look) >> 4) + 1;
        const auto kind = static_cast<SplatKind>((-1 - look) & 15);
        EXPECT_LE(count, most_in_leaf);
        EXPECT_EQ(tree.nodes[2 * std::size_t(node) + 1].w(), next_body) << "one after the other";
        next_body += count * body_floats(kind) / 4;
        return count;
    }
    int count = 0;
    int child = node + 1;
    for (int i = 0; i < 2; ++i) {
        EXPECT_TRUE(box_at(tree, node).contains(box_at(tree, child)));
        count += bodies_in(tree, child, next_body);
        const int of_child = tree.nodes[2 * std::size_t(child)].w();
        child += of_child < 0 ? 1 : of_child;
    }
    EXPECT_EQ(child, node + look);
    return count;
}

TEST(PrimitiveTrees, HoldEachPrimitiveOnce) {
    Random random(7);
    Primitives primitives;
    for (int i = 0; i < 6000; ++i) { // more than one thread builds
        primitives.spheres.push_back(random.sphere());
        primitives.cones.push_back(random.cone());
    }
    primitives.spheres.resize(6100); // a hundred at one place
    int next_body = 0;
    const PrimitiveTree tree = tree_of(primitives, {1, 2, 3}, {});
    EXPECT_EQ(bodies_in(tree, 0, next_body), 12100);
    EXPECT_EQ(std::size_t(4 * next_body), tree.bodies.size());
    EXPECT_EQ(tree.kinds, 0b101U);
    next_body = 0;
    const PrimitiveTree half = tree_of(primitives, {1, 2, 3}, {{Vec3d::UnitX(), 0}});
    const int left = bodies_in(half, 0, next_body);
    EXPECT_GT(left, 5000);
    EXPECT_LT(left, 11000);
}

} // namespace
} // namespace isocast::test
