// Primitives shaded where they are drawn, against those shaded once a pixel.
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/renderer.h"
#include "renderer_test_base.h"
#include "some_primitives.h"
#include "volume/analytic_fields.h"
#include "volume/errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace isocast::test {
namespace {

constexpr int width = 160;
constexpr int height = 120;

struct DirectSplats : RendererTest {
    Camera camera{.eye_world = {0.8, 1.1, 5}, .target_world = Vec3d::Zero()};

    /// Of every kind, triangles with normals at their corners among them.
    Scene scene(SplatShading splats, Shadow shadow = Shadow::None) const {
        Random random(5);
        Primitives some = some_of_each(random, 4);
        TriangleMesh smooth = some.meshes[0];
        for (Vec3d& vertex : smooth.vertices_world) vertex += Vec3d(0.3, -0.4, 0.2);
        for (std::size_t i = 0; i < 3 * smooth.triangles.size(); ++i)
            smooth.normals_world.push_back(
                (area_normal(triangle_of(smooth, i / 3)).normalized() + 0.2 * random.unit())
                    .normalized()
                    .cast<float>());
        some.meshes.push_back(smooth);
        for_each_kind(some, [&](auto& of_kind) {
            for (auto& one : of_kind) one.colour = random.in_cube(0.4) + Vec3d::Constant(0.5);
        });
        Look look;
        look.lights = {{.direction = {1, 2, 0.5}, .is_in_view_space = false, .shadow = shadow},
                       {.direction = {-1, 0, 1}, .colour = {0.2, 0.1, 0.3}}};
        return {.quality = {.splats = splats},
                .look = look,
                .primitives = std::make_shared<Primitives>(some)};
    }
    Image drawn(const Scene& scene, const std::optional<PicturePart>& part = {}) {
        renderer.load(scene);
        report = renderer.draw(camera, width, height, {FrameImage::Beauty}, part);
        return renderer.read(FrameImage::Beauty);
    }
    std::vector<std::string> passes() const {
        std::vector<std::string> names;
        for (const PassReport& pass : report.passes)
            if (pass.ran) names.push_back(pass.name);
        return names;
    }

    FrameReport report;
};

/// Numbers that differ by more than the roundings of a colour to halves and of what it becomes,
/// both times: 2^-11 each of at most 2.
int different(const Image& a, const Image& b) {
    int count = 0;
    for (std::size_t i = 0; i < a.rgba.size(); ++i)
        count += !(std::abs(a.rgba[i] - b.rgba[i]) < 3 * 0x1p-10);
    return count;
}

TEST_F(DirectSplats, ShowWhatDeferredOnesShow) {
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic})
        for (const Shadow shadow : {Shadow::None, Shadow::Hard, Shadow::Soft})
            for (const bool is_cut : {false, true}) {
                camera.projection = projection;
                Scene direct = scene(SplatShading::Direct, shadow);
                if (is_cut)
                    direct.cut = {.look = CutLook::Capped,
                                  .planes = {{.normal = {1, 0, 1}, .offset_world = 0.2}}};
                Scene deferred = direct;
                deferred.quality.splats = SplatShading::Deferred;
                const Image expected = drawn(deferred);
                EXPECT_EQ(different(drawn(direct), expected), 0)
                    << int(projection) << int(shadow) << is_cut;
                EXPECT_EQ(passes(),
                          shadow == Shadow::None
                              ? std::vector<std::string>{"direct shading"}
                              : (std::vector<std::string>{"shadow map", "direct shading"}));
            }
}

TEST_F(DirectSplats, SeeShadows) {
    const Image lit = drawn(scene(SplatShading::Direct));
    EXPECT_GT(different(drawn(scene(SplatShading::Direct, Shadow::Hard)), lit), 300);
}

TEST_F(DirectSplats, AreTheSameInAPartOfThePicture) {
    const Scene some = scene(SplatShading::Direct, Shadow::Soft);
    const Image whole = drawn(some);
    const PicturePart part{.x = 37, .y = 21, .width = 64, .height = 50};
    const Image piece = drawn(some, part);
    for (int y = 0; y < part.height; ++y)
        for (int x = 0; x < part.width; ++x)
            for (int c = 0; c < 4; ++c)
                ASSERT_EQ(piece.pixel(x, y)[c], whole.pixel(part.x + x, part.y + y)[c]);
}

TEST_F(DirectSplats, RefuseWhatTheyCannotShowAndSayWhat) {
    Scene wrong = scene(SplatShading::Direct);
    wrong.look.effects.outlines.strength = 1;
    wrong.look.effects.occlusion.strength = 0.5;
    wrong.look.model = ShadingModel::Gooch;
    wrong.look.shows_environment = true;
    wrong.objects = {{.field = sampled(sphere_field(Vec3d::Zero(), 0.6), 16)}};
    try {
        renderer.load(wrong);
        FAIL() << "it was loaded";
    } catch (const InputError& error) {
        for (const char* part : {"fields", "blinn-phong", "environment", "outlines", "occlusion"})
            EXPECT_THAT(error.what(), testing::HasSubstr(part));
    }
    renderer.load(scene(SplatShading::Direct));
    EXPECT_THROW(renderer.set_look(wrong.look), InputError);
}

} // namespace
} // namespace isocast::test
