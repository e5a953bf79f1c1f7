// Pictures of octrees: bricks as fine as their leaves, and several lattices where they span many
// levels.
// SPDX-License-Identifier: MPL-2.0
#include "renderer_test_base.h"
#include "volume/octree_field.h"

#include <cmath>
#include <functional>
#include <numbers>

namespace isocast {
namespace {

using Distance = std::function<double(const Vec3d& p)>;

/// Cells within twice their size of the surface are divided down to the level that `level_at` gives
/// for their middle: what the spline reads around the surface then has that level too.
std::shared_ptr<const HashedOctree> octree_of(const Distance& distance, int depth,
                                              const std::function<double(const Vec3d&)>& level_at) {
    const auto sampler = [&](const Index3& position, std::span<float> out) {
        out[0] = static_cast<float>(distance(position.cast<double>()));
    };
    auto tree = std::make_shared<HashedOctree>(depth, OctreeFilter::Linear, sampler);
    const auto grow = [&](const auto& self, const OctreeCell& cell) -> void {
        const Vec3d middle = (cell.position.cast<double>().array() + cell.size() / 2.0).matrix();
        if (cell.level == 0 || cell.level <= level_at(middle) ||
            std::abs(distance(middle)) > 2 * cell.size() + 4)
            return;
        tree->divide(cell, sampler);
        for (int i = 0; i < 8; ++i) self(self, child_of(cell, i));
    };
    grow(grow, tree->root());
    tree->constrain_hanging_nodes(sampler);
    return tree;
}

struct AdaptivePictures : test::RendererTest {
    static constexpr int size = 96;

    /// Of the hits of a picture the greatest |f| [world]; and how many pixels are hit.
    std::pair<double, int> greatest_error(const Camera& camera, const Distance& f,
                                          const std::function<bool(const Vec3d&)>& counts) {
        renderer.draw(camera, size, size, {FrameImage::Hit});
        const Image image = renderer.read(FrameImage::Hit);
        double greatest = 0;
        int hits = 0;
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                const float* hit = image.pixel(x, y);
                if (hit[3] == 0) continue;
                const Vec3d p = camera.eye_world + Vec3d(hit[0], hit[1], hit[2]);
                if (!counts(p)) continue;
                ++hits;
                greatest = std::max(greatest, std::abs(f(p)));
            }
        return {greatest, hits};
    }
};

TEST_F(AdaptivePictures, HaveBricksOfTheLevelOfTheirLeaves) {
    const Vec3d centre(128.2, 127.6, 128.9);
    constexpr double radius = 90.3;
    const Distance ball = [&](const Vec3d& p) { return (p - centre).norm() - radius; };
    const auto tree = octree_of(ball, 8, [](const Vec3d& p) { return p.x() > 150 ? 0 : 3; });
    const auto fields = fields_of_octree(tree, GridSpace::uniform(1), 0);
    ASSERT_EQ(fields.size(), 1U);
    renderer.load({.field = fields[0]});
    ASSERT_TRUE(renderer.coarse_bricks());
    EXPECT_TRUE(renderer.is_adapted());
    EXPECT_GT(renderer.coarse_bricks()->counts[0], 0);
    EXPECT_GT(renderer.coarse_bricks()->counts[3], 0);
    const Camera camera{.eye_world = centre + Vec3d(30, 80, 400),
                        .target_world = centre,
                        .projection = Projection::Orthographic,
                        .height_world = 2.2 * radius};
    const auto everywhere = [](const Vec3d&) { return true; };
    // h^2/8 for each of the two curvatures, h = 8: what a leaf's corners are off where they hang on
    // a coarse face. They are 1/r at the surface, and larger where such a face lies, within the
    // diagonal of its cell.
    const auto [greatest, hits] = greatest_error(camera, ball, everywhere);
    EXPECT_LT(greatest, 64 / (4 * (radius - 8 * std::numbers::sqrt3)));
    // The disc's area, to within a pixel of its rim.
    const double pixel = 2.2 * radius / size;
    const double disc = std::numbers::pi * radius * radius / (pixel * pixel);
    EXPECT_NEAR(hits, disc, 2 * std::numbers::pi * radius / pixel);
    // Away from larger leaves the spline of exact samples a voxel apart, which errs by less than
    // 1e-4 at that radius; hits 400 voxels from the eye are floats 3e-5 apart.
    const auto is_fine = [](const Vec3d& p) { return p.x() > 176; };
    EXPECT_LT(greatest_error(camera, ball, is_fine).first, 1e-3);
}

TEST_F(AdaptivePictures, ShowTwentyCellsOfSixteenThousand) {
    const Vec3d centre = Vec3d::Constant(8192.3);
    constexpr double radius = 6000;
    constexpr double small = 20;
    const Vec3d bump = centre + radius * Vec3d(1, 2, 2) / 3;
    const Distance f = [&](const Vec3d& p) {
        return std::min((p - centre).norm() - radius, (p - bump).norm() - small);
    };
    // Cells grow with the distance from the bump.
    const auto tree = octree_of(f, 14, [&](const Vec3d& p) {
        return std::min(8.0, std::log2(std::max((p - bump).norm() / (2 * small), 1.0)));
    });
    EXPECT_LT(tree->cell_count(), 2'000'000U);
    const auto fields = fields_of_octree(tree, GridSpace::uniform(1), 0, 5000);
    ASSERT_GT(fields.size(), 1U);
    Scene scene;
    for (const auto& field : fields) scene.objects.push_back({field});
    scene.tree = union_of_all(static_cast<int>(fields.size()));
    renderer.load(scene);
    const auto everywhere = [](const Vec3d&) { return true; };
    const Vec3d way = (bump - centre).normalized();
    const Vec3d aside = way.cross(Vec3d(0, 0, 1)).normalized();
    const auto [error_of_all, all] = greatest_error(
        {.eye_world = centre + 20000 * way, .target_world = centre, .fov_y_degrees = 45}, f,
        everywhere);
    // h^2/4r of the largest leaves, 256 cells.
    EXPECT_LT(error_of_all, 256.0 * 256 / (4 * radius));
    EXPECT_GT(all, size * size / 3);
    const Camera near{
        .eye_world = bump + 150 * (way + aside), .target_world = bump, .fov_y_degrees = 20};
    const auto is_bump = [&](const Vec3d& p) {
        return (p - bump).norm() < 2 * small && (p - centre).norm() > radius + 4;
    };
    const auto [error_of_bump, of_bump] = greatest_error(near, f, is_bump);
    // Of exact samples a cell apart, rounded to 2^-24 of 16384.
    EXPECT_LT(error_of_bump, 0.01);
    EXPECT_GT(of_bump, 500);
    EXPECT_EQ(greatest_error(near, f, everywhere).second, size * size); // no holes
}

} // namespace
} // namespace isocast
