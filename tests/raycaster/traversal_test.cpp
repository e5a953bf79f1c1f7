// All ways to the blocks of a ray give one picture, and so do all ways to store samples; the order
// of tiles does not matter.
// SPDX-License-Identifier: MPL-2.0
#include "hard_fields.h"
#include "raycaster/fetch_choice.h"
#include "raycaster/passes.h"
#include "raycaster/renderer.h"
#include "test_context.h"
#include "volume/analytic_fields.h"
#include "volume/errors.h"
#include "volume/sparsify.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace isocast {
namespace {

using test::HardField;
using test::Random;

const std::filesystem::path shader_folder = std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders";
constexpr int field_size = 40;
constexpr std::array others{Traversal::DrawnBlocks, Traversal::BoundingFaces, Traversal::Walk};

const char* name_of(Traversal traversal) {
    constexpr std::array names{"lists", "drawn", "bounds", "walk"};
    return names[static_cast<std::size_t>(traversal)];
}

/// Anisotropic, sheared, and left-handed voxels, far from the world's origin.
std::vector<GridSpace> spaces() {
    std::vector<GridSpace> all(3, GridSpace::uniform(1));
    all[1].world_from_index.linear() << 0.9, 0.2, 0.0, -0.1, 0.4, 0.3, 0.1, 0.0, 2.0;
    all[2].world_from_index.linear() << 0.1, 0.9, 0.4, 1.3, 0.1, 0.3, 0.1, 0.0, 0.8;
    all[2].world_from_index.translation() = Vec3d(1000, -2000, 500);
    return all;
}

std::shared_ptr<const FieldSource> placed(const HardField& field, const GridSpace& space) {
    return std::make_shared<DenseField>(space, field.control->extent(),
                                        test::copied(*field.control, field.control->extent()));
}

/// Outside, inside (in an active block or not), and parallel rays, along an axis too.
std::vector<Camera> cameras(const GridSpace& space, Random& random) {
    const auto world = [&](double x, double y, double z) { return space.to_world({x, y, z}); };
    const Vec3d inside = test::random_point(random, 0.3 * field_size, 0.7 * field_size);
    const double span = (world(field_size, 0, 0) - world(0, 0, field_size)).norm();
    return {
        {.eye_world = world(95, 70, 88), .target_world = world(21, 19, 20)},
        {.eye_world = world(-30, 19, 20), .target_world = world(21, 20, 20)},
        {.eye_world = space.to_world(inside), .target_world = world(3, 30, 9)},
        {.eye_world = world(-40, 60, 70),
         .target_world = world(20, 20, 20),
         .projection = Projection::Orthographic,
         .height_world = 0.8 * span},
        {.eye_world = world(20, 20, 90),
         .target_world = world(20, 20, 20),
         .up = space.world_from_index.linear().col(1),
         .projection = Projection::Orthographic,
         .height_world = 0.8 * span},
    };
}

int hit_count(const std::vector<Image>& images) {
    int count = 0;
    for (const Image& image : images)
        for (std::size_t i = 3; i < image.rgba.size(); i += 4) count += image.rgba[i] != 0;
    return count;
}

struct Traversals : testing::Test {
    std::unique_ptr<gl::Context> context = test::make_context();
    Renderer renderer{*context, shader_folder};

    std::vector<Image> draw(const Scene& scene, const std::vector<Camera>& views, int width = 61,
                            int height = 47, const ImageSet& images = {FrameImage::Hit}) {
        renderer.load(scene);
        std::vector<Image> pictures;
        for (const Camera& camera : views) {
            renderer.draw(camera, width, height, images);
            for (const FrameImage image : {FrameImage::Hit, FrameImage::Gradient})
                if (images.contains(image)) pictures.push_back(renderer.read(image));
        }
        return pictures;
    }

    /// Expects the pictures of lists of every traversal; returns how many pixels they hit.
    int compared_hits(Scene scene, const std::vector<Camera>& views, const std::string& name) {
        scene.quality.traversal = Traversal::TileLists;
        const std::vector<Image> expected = draw(scene, views);
        for (const Traversal traversal : others) {
            scene.quality.traversal = traversal;
            const std::vector<Image> images = draw(scene, views);
            for (std::size_t i = 0; i < images.size(); ++i)
                EXPECT_EQ(images[i].rgba, expected[i].rgba)
                    << name << ", camera " << i << ", " << name_of(traversal);
        }
        return hit_count(expected);
    }
};

TEST_F(Traversals, GiveThePictureOfListsToTheLastBit) {
    Random random(11);
    int compared = 0;
    for (const HardField& field : test::hard_fields(field_size, 5)) {
        for (const GridSpace& space : spaces()) {
            const std::vector<Camera> views = cameras(space, random);
            // 0.1: fewer looks where rays graze sheets and needles.
            const Scene scene{.field = placed(field, space),
                              .filter = Filter::BSpline,
                              .quality = {.guarantee_voxels = 0.1}};
            compared += compared_hits(scene, views, field.name);
        }
    }
    EXPECT_GT(compared, 10000);
}

/// Drawn blocks have a pass for gradients, the others find them with the hits.
TEST_F(Traversals, GiveTheSameGradients) {
    Random random(14);
    for (const HardField& field : test::hard_fields(field_size, 9)) {
        const GridSpace space = spaces()[1];
        const std::vector<Camera> views = cameras(space, random);
        const auto gradients = [&](Traversal traversal) {
            return draw({.field = placed(field, space),
                         .filter = Filter::BSpline,
                         .quality = {.traversal = traversal, .guarantee_voxels = 0.1}},
                        views, 61, 47, {FrameImage::Hit, FrameImage::Gradient});
        };
        const std::vector<Image> apart = gradients(Traversal::DrawnBlocks);
        const std::vector<Image> fused = gradients(Traversal::TileLists);
        ASSERT_EQ(apart.size(), 2 * views.size());
        for (std::size_t i = 0; i < apart.size(); ++i)
            EXPECT_EQ(apart[i].rgba, fused[i].rgba) << field.name << ", image " << i;
    }
}

TEST_F(Traversals, GiveThePictureOfListsForSampledRays) {
    Random random(12);
    for (const HardField& field : test::hard_fields(field_size, 6)) {
        const GridSpace space = spaces()[1];
        const std::vector<Camera> views = cameras(space, random);
        Scene scene{.field = placed(field, space),
                    .filter = Filter::BSpline,
                    .quality = {.rate = 1.0, .rate_factor = 4}};
        EXPECT_GT(compared_hits(scene, views, field.name), 0);
    }
}

TEST_F(Traversals, SeeNarrowBandsAndEmptyFields) {
    const auto band =
        std::make_shared<SparseField>(to_sparse(*sampled(builtin_field("torus"), 64, 3)));
    const double voxel = band->space().voxel_size_world();
    const std::vector<Camera> views{
        {.eye_world = {2.5, 1.3, 1.1}, .target_world = {0, 0, 0}},
        {.eye_world = {0.02, 0.01, -0.03}, .target_world = {1, 0, 0.2}}}; // in the torus' hole
    for (const double iso : {0.0, 2 * voxel, 1e6}) { // of the last there is no surface
        Scene scene{.field = band, .iso_world = iso};
        EXPECT_EQ(compared_hits(scene, views, "a band") > 0, iso < 1e6);
    }
}

TEST_F(Traversals, OtherThanListsNeedAllBricks) {
    const std::shared_ptr<const FieldSource> torus = sampled(builtin_field("torus"), 48);
    Scene scene{.field = torus, .storage = {.budget_bytes = 100'000}};
    EXPECT_NO_THROW(renderer.load(scene));
    for (const Traversal traversal : others) {
        scene.quality.traversal = traversal;
        EXPECT_THROW(renderer.load(scene), ResourceError) << name_of(traversal);
    }
}

TEST_F(Traversals, AreNamed) {
    for (const Traversal traversal :
         {Traversal::TileLists, Traversal::DrawnBlocks, Traversal::BoundingFaces, Traversal::Walk})
        EXPECT_EQ(traversal_from_name(name_of(traversal)), traversal);
    EXPECT_THROW(traversal_from_name("jumps"), InputError);
}

TEST_F(Traversals, BricksOfAnySizeAndNoneGiveOnePicture) {
    Random random(13);
    const GridSpace space = spaces()[2];
    for (const HardField& field :
         {test::needles(field_size, 7), test::smooth_noise(field_size, 7)}) {
        const std::vector<Camera> views = cameras(space, random);
        for (const Fetch fetch : {Fetch::Rows, Fetch::Samples}) {
            for (const SampleFormat format :
                 {SampleFormat::Float32, SampleFormat::Float16, SampleFormat::Norm16}) {
                Scene scene{.field = placed(field, space),
                            .filter = Filter::BSpline,
                            .storage = {.fetch = fetch, .format = format, .brick_size = no_bricks},
                            .quality = {.guarantee_voxels = 0.1}};
                const std::vector<Image> expected = draw(scene, views);
                for (const int brick_size : {8, 16, 32}) {
                    scene.storage.brick_size = brick_size;
                    const std::vector<Image> images = draw(scene, views);
                    for (std::size_t i = 0; i < images.size(); ++i)
                        EXPECT_EQ(images[i].rgba, expected[i].rgba)
                            << field.name << ", bricks of " << brick_size;
                }
            }
        }
    }
}

/// The Hit image, its tiles drawn in the order that `rearrange` makes of the runs.
template<class Rearrange>
Image drawn_in_order(const std::shared_ptr<const FieldSource>& field, const Camera& camera,
                     Rearrange rearrange) {
    constexpr int width = 83;
    constexpr int height = 71;
    const BlockRanges ranges = find_block_ranges(*field, Kernel::BSpline);
    const std::vector<ActivePage> active = active_pages(ranges, 0);
    const Scene scene{.field = field};
    const FieldObject object{.field = field};
    FieldOnGpu on_gpu(*field, *field, Kernel::BSpline, ranges, active, 0, {});
    PlacesOnGpu places(Traversal::TileLists, ranges, active, field->space(), camera, width, height);
    std::vector<Eigen::Vector4i> runs; // of one tile each
    for (const Eigen::Vector4i& run :
         list_blocks(ranges, active, field->space(), camera, width, height).runs())
        for (int x = run[0]; x < run[1]; ++x) runs.emplace_back(x, x + 1, run[2], 0);
    rearrange(runs);
    places.set_runs(std::move(runs));
    gl::ShaderLibrary shaders({shader_folder});
    const auto no_vertices = gl::VertexArray::without_attributes("no vertices");
    FrameTargets targets;
    gl::Texture& hit = targets.texture(FrameImage::Hit);
    hit = gl::Texture::image(format_of(FrameImage::Hit), width, height, "hit");
    targets.framebuffer(FrameImage::Hit) = gl::Framebuffer({&hit}, "hit");
    LookTextures look_textures;
    LookNumbers look_numbers;
    SeenScene seen;
    seen.objects.push_back({object, on_gpu, on_gpu, on_gpu, std::move(places), {}});
    FrameContext frame{shaders, no_vertices, scene,  seen,    &seen.objects.front(), seen.places(),
                       camera,  width,       height, targets, look_textures,         look_numbers};
    for (const Pass& pass : live_passes(declare_passes(frame), {FrameImage::Hit})) pass.run();
    Image image{width, height, std::vector<float>(std::size_t{4} * width * height)};
    hit.read_rgba(image.rgba);
    return image;
}

TEST(TileOrder, DoesNotMatter) {
    const auto context = test::make_context();
    const std::shared_ptr<const FieldSource> field = sampled(builtin_field("gyroid"), 48);
    const Camera camera{.eye_world = {1.9, 1.3, 3.1}, .target_world = {0.1, -0.05, 0}};
    const Image in_rows = drawn_in_order(field, camera, [](auto&) {});
    const Image backwards =
        drawn_in_order(field, camera, [](auto& runs) { std::ranges::reverse(runs); });
    const Image shuffled =
        drawn_in_order(field, camera, [](auto& runs) { std::ranges::shuffle(runs, Random(3)); });
    EXPECT_GT(hit_count({in_rows}), 1000);
    EXPECT_EQ(in_rows.rgba, backwards.rgba);
    EXPECT_EQ(in_rows.rgba, shuffled.rgba);
}

/// The eye in the plane x = 20 exactly: f = x - 20, which the spline reproduces, is 0 there.
TEST_F(Traversals, RaysThatStartOnTheSurfaceHitItOnTheWayInAndNeverOnTheWayOut) {
    if (!is_software_rasteriser(context->driver().renderer))
        GTEST_SKIP() << "GPUs fuse products and sums: what is 0 exactly here need not be there";
    const auto plane = test::control_of(field_size, [](const Vec3d& p) { return p.x() - 20; });
    const auto view = [](double x, double height) {
        Camera camera{.eye_world = {20, 17.3, 22.1},
                      .target_world = {20 + x, 17.3, 22.1},
                      .up = {0, 0, 1},
                      .fov_y_degrees = 90};
        if (height > 0) camera.projection = Projection::Orthographic;
        camera.height_world = height;
        return camera;
    };
    constexpr int size = 32;
    for (const Traversal traversal : {Traversal::TileLists, Traversal::DrawnBlocks,
                                      Traversal::BoundingFaces, Traversal::Walk}) {
        for (const double height : {0.0, 12.0}) {
            const Scene scene{
                .field = plane, .filter = Filter::BSpline, .quality = {.traversal = traversal}};
            const std::vector<Image> images =
                draw(scene, {view(-5, height), view(5, height)}, size, size);
            EXPECT_EQ(hit_count({images[0]}), size * size) << name_of(traversal);
            EXPECT_EQ(hit_count({images[1]}), 0) << name_of(traversal);
            // Roots are found to 1e-5 voxel along the ray, and values are exact to 32 roundings of
            // 20 (docs/raycasting.md), 4e-5 with slope one.
            for (std::size_t i = 0; i < images[0].rgba.size(); i += 4)
                EXPECT_LE(std::abs(images[0].rgba[i]), 5e-5F);
        }
    }
}

/// The active blocks by their numbers in BlockTable.
std::vector<Index3> numbered_blocks(const BlockRanges& ranges,
                                    const std::vector<ActivePage>& active) {
    std::vector<Index3> blocks;
    for (const ActivePage& page : active)
        for (int place = 0; place < blocks_per_page; ++place)
            if ((page.blocks >> place & 1U) != 0)
                blocks.push_back(page_blocks * ranges.pages[page.page].coordinate +
                                 block_in_page(place));
    return blocks;
}

TEST(BoundingFaces, AreThoseBetweenActiveBlocksAndOthers) {
    for (const HardField& field : test::hard_fields(field_size, 8)) {
        const BlockRanges ranges = find_block_ranges(*field.control, Kernel::BSpline);
        const std::vector<ActivePage> active = active_pages(ranges, 0);
        const BlockTable table = make_block_table(*field.control, ranges, active, 0);
        const auto key = [](const Index3& b) { return std::array{b.x(), b.y(), b.z()}; };
        const std::vector<Index3> blocks =
            find_active_blocks(*field.control, Kernel::BSpline, 0).coordinates;
        std::set<std::array<int, 3>> all;
        for (const Index3& block : blocks) all.insert(key(block));
        const std::vector<Index3> by_number = numbered_blocks(ranges, active);
        std::set<std::array<int, 4>> expected;
        for (const Index3& block : by_number)
            for (int face = 0; face < 6; ++face) {
                Index3 next = block;
                next[face / 2] += face % 2 == 1 ? 1 : -1;
                if (!all.contains(key(next)))
                    expected.insert({block.x(), block.y(), block.z(), face});
            }
        std::set<std::array<int, 4>> found;
        for (const Eigen::Vector2i& face : bounding_faces(table)) {
            const Index3& block = by_number[static_cast<std::size_t>(face[0])];
            EXPECT_TRUE(found.insert({block.x(), block.y(), block.z(), face[1]}).second);
        }
        EXPECT_EQ(found, expected) << field.name;
        EXPECT_GT(expected.size(), 10U);
    }
}

TEST(BlockOrder, ListsEachBlockOnceAndLayersThatNoRaySeesTwice) {
    Random random(9);
    const HardField field = test::hard_fields(field_size, 9).back();
    const BlockRanges ranges = find_block_ranges(*field.control, Kernel::BSpline);
    const std::vector<ActivePage> active = active_pages(ranges, 0);
    const std::vector<Index3> blocks = numbered_blocks(ranges, active);
    for (const GridSpace& space : spaces()) {
        for (const Camera& camera : cameras(space, random)) {
            const BlockOrder order = order_blocks(ranges, active, space, camera);
            std::vector<int> layer_of(blocks.size(), -1);
            ASSERT_EQ(order.blocks.size(), blocks.size());
            ASSERT_EQ(order.layers.back(), int(blocks.size()));
            for (std::size_t layer = 0; layer + 1 < order.layers.size(); ++layer) {
                EXPECT_LT(order.layers[layer], order.layers[layer + 1]);
                for (int i = order.layers[layer]; i < order.layers[layer + 1]; ++i) {
                    int& of = layer_of[static_cast<std::size_t>(
                        order.blocks[static_cast<std::size_t>(i)])];
                    EXPECT_EQ(of, -1) << "twice";
                    of = int(layer);
                }
            }
            for (int repeat = 0; repeat < 50; ++repeat) {
                const Ray ray = camera_ray(camera, 64, 64, test::random_real(random, 0, 64),
                                           test::random_real(random, 0, 64));
                const Vec3d o = space.to_index(ray.origin_world) / block_size;
                const Vec3d d =
                    space.world_from_index.linear().inverse() * ray.direction_world / block_size;
                std::vector<std::pair<double, int>> met; // where the ray enters, layer
                for (std::size_t i = 0; i < blocks.size(); ++i) {
                    const Vec3d lo = blocks[i].cast<double>();
                    const Eigen::Array3d t0 = (lo - o).array() / d.array();
                    const Eigen::Array3d t1 = (lo - o).array() / d.array() + 1 / d.array();
                    const double t_in = std::max(t0.min(t1).maxCoeff(), 0.0);
                    // 1e-9: below it a ray touches an edge as far as doubles can tell.
                    if (t0.max(t1).minCoeff() - t_in > 1e-9) met.emplace_back(t_in, layer_of[i]);
                }
                std::ranges::sort(met);
                for (std::size_t i = 1; i < met.size(); ++i)
                    EXPECT_LT(met[i - 1].second, met[i].second);
            }
        }
    }
}

} // namespace
} // namespace isocast
