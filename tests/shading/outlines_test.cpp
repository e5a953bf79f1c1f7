// Outlines: Sobel's stencil, silhouettes and creases where they are known.
// SPDX-License-Identifier: MPL-2.0
#include "effect_rules.h"

#include <numbers>

namespace isocast::test {
namespace {

struct EdgeLines : Shading {
    double coverage(int x, int y) const { return outlines.pixel(x, y)[3]; }
    void draw_outlines(const Scene& scene) {
        outlines = draw(scene, FrameImage::Outlines);
        hits = renderer.read(FrameImage::Hit);
        source = renderer.read(FrameImage::OutlineSource);
    }
    bool is_hit(int x, int y) const { return hits.pixel(x, y)[3] != 0; }
    /// Whether all that the stencil at a pixel reads are hits, or none.
    bool is_amidst(int x, int y, bool hit) const {
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx)
                if (is_hit(std::clamp(x + dx, 0, size - 1), std::clamp(y + dy, 0, size - 1)) != hit)
                    return false;
        return true;
    }
    /// Sobel's masks over 3x3 texels, in double, columns by x and by y upwards.
    Eigen::Matrix<double, 4, 2> sobel(int x, int y) const {
        Eigen::Matrix<double, 4, 2> sum = Eigen::Matrix<double, 4, 2>::Zero();
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx) {
                const float* texel =
                    source.pixel(std::clamp(x + dx, 0, size - 1), std::clamp(y + dy, 0, size - 1));
                const Eigen::Vector4d value(texel[0], texel[1], texel[2], texel[3]);
                sum.col(0) += dx * (2 - std::abs(dy)) * value;
                sum.col(1) -= dy * (2 - std::abs(dx)) * value;
            }
        return sum;
    }

    Image outlines;
    Image hits;
    Image source;
};

AnalyticField plane(const Vec3d& normal) {
    return {"plane",
            [n = Vec3d(normal.normalized())](const Vec3d& p) {
                return Jet{.value = n.dot(p), .gradient = n};
            },
            1};
}

TEST_F(EdgeLines, AreSobelsStencilByFourMeans) {
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera.projection = projection;
        camera.height_world = 3;
        const Scene scene{.field = sampled(builtin_field("gyroid"), 40)};
        draw_outlines(scene);
        const Outlines& look = scene.look.effects.outlines;
        const double threshold = look.silhouette_threshold * 2 * std::sqrt(3.0); // of the extent
        const bool is_perspective = projection == Projection::Perspective;
        const Mat3d rotation = camera.view_from_world_rotation();
        const double pixel = 2 * camera.half_height_at(1) / size;
        int lines = 0;
        double worst = 0;
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                const Eigen::Matrix<double, 4, 2> s = sobel(x, y);
                const float* centre = source.pixel(x, y);
                const Vec3d n(centre[0], centre[1], centre[2]);
                Vec3d ray = camera_ray(camera, size, size, x + 0.5, y + 0.5).direction_world;
                ray /= -(rotation * ray).z();
                const double along =
                    std::abs(n.dot(ray)) < 1e-6 ? std::copysign(1e-6, n.dot(ray)) : n.dot(ray);
                const Eigen::Vector2d plane =
                    pixel * (rotation * n).head<2>() / along * (is_perspective ? centre[3] : 1);
                double jump =
                    std::max(0.0, (s.row(3).transpose() / 4 - 2 * plane).norm() - plane.norm());
                if (is_perspective) {
                    // The means of the four corners, by the stencil's sums of texels.
                    double near = 0;
                    for (const int cy : {-1, 0})
                        for (const int cx : {-1, 0}) {
                            double mean = 0;
                            for (const int ty : {cy, cy + 1})
                                for (const int tx : {cx, cx + 1})
                                    mean += source.pixel(std::clamp(x + tx, 0, size - 1),
                                                         std::clamp(y + ty, 0, size - 1))[3] /
                                            4.0;
                            near = std::max(near, mean);
                        }
                    jump = near == 0 ? 0 : near > jump ? jump / (near * (near - jump)) : 1e30;
                }
                const double crease = s.topRows<3>().norm() / 4;
                const auto ramp = [](double step, double limit) {
                    return std::clamp(step / limit - 0.5, 0.0, 1.0);
                };
                const double expected =
                    std::max(ramp(jump, threshold), ramp(crease, look.crease_threshold));
                worst = std::max(worst, std::abs(coverage(x, y) - expected));
                if (expected > 0.5) ++lines;
            }
        EXPECT_GT(lines, 300);
        // Nearness rounds by 2^-24 of at most 10 in the sums, planes at a grazing ray by 1e-3 of
        // their slopes; the ramp is 1/threshold = 14 steep.
        EXPECT_LT(worst, 1e-3);
    }
}

TEST_F(EdgeLines, OfASphereAreAClosedRing) {
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera.projection = projection;
        camera.height_world = 2.6;
        draw_outlines({.field = sampled(builtin_field("sphere"), 48)});
        // From the middle, by sides of pixels, nothing gets out.
        std::vector<std::array<int, 2>> front{{size / 2, size / 2}};
        std::set<std::array<int, 2>> seen(front.begin(), front.end());
        double covered = 0;
        int area = 0;
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                covered += coverage(x, y);
                area += is_hit(x, y);
            }
        while (!front.empty()) {
            const auto [x, y] = front.back();
            front.pop_back();
            ASSERT_TRUE(x > 0 && y > 0 && x + 1 < size && y + 1 < size);
            for (const std::array<int, 2> next :
                 {std::array{x + 1, y}, {x - 1, y}, {x, y + 1}, {x, y - 1}})
                if (coverage(next[0], next[1]) < 0.5 && seen.insert(next).second)
                    front.push_back(next);
        }
        EXPECT_GT(seen.size(), 1000U);
        // The stencil reaches a pixel to either side, along the sides or the diagonals of pixels.
        const double length = 2 * std::sqrt(std::numbers::pi * area);
        EXPECT_GT(covered / length, 2);
        EXPECT_LT(covered / length, 2 * std::sqrt(2.0));
    }
}

TEST_F(EdgeLines, AreNotInsideASmoothSphere) {
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera.projection = projection;
        camera.height_world = 2.6;
        draw_outlines({.field = sampled(builtin_field("sphere"), 48)});
        int inside = 0;
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x)
                if (is_amidst(x, y, true)) {
                    ++inside;
                    // Normals turn fast in the last pixel within the ring.
                    EXPECT_LT(coverage(x, y), 0.25) << x << " " << y;
                } else if (is_amidst(x, y, false)) {
                    EXPECT_EQ(coverage(x, y), 0);
                }
        EXPECT_GT(inside, 2000);
    }
}

TEST_F(EdgeLines, AreTheEdgesOfACube) {
    // A voxel is as large as a pixel, or the spline would round the edges over several.
    size = 64;
    const Mat3d turn(Eigen::AngleAxisd(0.5, Vec3d(1, 2, 3).normalized()));
    const AnalyticField cube{"box",
                             [&](const Vec3d& p) {
                                 return Jet{.value =
                                                (turn.transpose() * p).cwiseAbs().maxCoeff() - 1};
                             },
                             1.8};
    camera = {.eye_world = turn * Vec3d(4, 5, 6)};
    draw_outlines({.field = sampled(cube, 100)});
    // Of the twelve edges nine are seen; three are creases.
    const auto covered_along = [&](const Vec3d& from, const Vec3d& to) {
        double least = 1;
        for (int i = 10; i <= 90; ++i) {
            const Eigen::Vector2d p =
                pixel_of(camera, size, turn * (from + i / 100.0 * (to - from)));
            double there = 0;
            for (const double dy : {-0.5, 0.5})
                for (const double dx : {-0.5, 0.5})
                    there = std::max(there, coverage(int(p.x() + dx), int(p.y() + dy)));
            least = std::min(least, there);
        }
        return least;
    };
    const Vec3d corner(1, 1, 1);
    for (int axis = 0; axis < 3; ++axis) {
        Vec3d end = corner;
        end[axis] = -1;
        EXPECT_GT(covered_along(corner, end), 0.5) << axis;
        // Faces are clear of them.
        Vec3d middle = Vec3d::Zero();
        middle[axis] = 1;
        const Eigen::Vector2d p = pixel_of(camera, size, turn * middle);
        for (int dy = -2; dy <= 2; ++dy)
            for (int dx = -2; dx <= 2; ++dx)
                EXPECT_EQ(coverage(int(p.x()) + dx, int(p.y()) + dy), 0) << axis;
    }
}

TEST_F(EdgeLines, AreNotOnAPlaneSeenAtAGrazingAngle) {
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera = {.eye_world = {0.3, 0.15, 4},
                  .target_world = {0, 0, 0},
                  .projection = projection,
                  .fov_y_degrees = 10,
                  .height_world = 0.6};
        const Scene scene{.field = sampled(plane({0.01, 1, 0.005}), 32)};
        draw_outlines(scene);
        int inside = 0;
        double steepest = 0;
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                if (!is_amidst(x, y, true)) continue;
                ++inside;
                EXPECT_EQ(coverage(x, y), 0);
                const double nearness =
                    projection == Projection::Perspective ? source.pixel(x, y)[3] : 1;
                steepest =
                    std::max(steepest, sobel(x, y).row(3).norm() / 4 / (nearness * nearness));
            }
        EXPECT_GT(inside, 100);
        // Plain Sobel filters would draw lines all over it.
        EXPECT_GT(steepest,
                  2 * scene.look.effects.outlines.silhouette_threshold * 2 * std::sqrt(3.0));
    }
}

TEST_F(EdgeLines, ReachBeyondTheSurfaceInTheBeauty) {
    Scene scene{.field = sampled(builtin_field("sphere"), 48)};
    scene.look.effects.outlines = {.strength = 1, .colour = {1, 0, 0}};
    const Image beauty = draw(scene);
    const Image hits_of = renderer.read(FrameImage::Hit);
    const Image lines = renderer.read(FrameImage::Outlines);
    int beyond = 0;
    for (std::size_t i = 0; i < beauty.rgba.size(); i += 4) {
        // Lengths of unit normals may be a rounding less than 1, which some drivers cut to halves.
        constexpr float half_rounding = 0x1p-11F;
        if (hits_of.rgba[i + 3] != 0 || lines.rgba[i + 3] < 1 - half_rounding) continue;
        ++beyond;
        EXPECT_GE(beauty.rgba[i], 1 - 2 * half_rounding);
        EXPECT_LE(beauty.rgba[i + 1], 2 * half_rounding);
        EXPECT_GE(beauty.rgba[i + 3], 1 - 2 * half_rounding);
    }
    EXPECT_GT(beyond, 100);
}

TEST_F(EdgeLines, AreNothingAtStrengthZero) {
    Look look;
    look.effects.outlines = {.strength = 0, .silhouette_threshold = 0.1, .colour = {1, 0, 0}};
    expect_nothing_at_strength_zero(*this, look);
}

TEST_F(EdgeLines, AloneNeedNoShadingAndNoHessian) {
    expect_no_more_passes(*this, FrameImage::Outlines,
                          {"raycast", "gradient", "outline source", "outlines"});
}

TEST_F(EdgeLines, AreFiniteAnywhere) {
    expect_finite_anywhere(*this, FrameImage::Outlines);
}

} // namespace
} // namespace isocast::test
