// Every effect of colour and environment: absent at strength 0, alone without shading, and finite
// on hard fields.
// SPDX-License-Identifier: MPL-2.0
#include "shading_scene.h"

#include "filtering/filter.h"
#include "raycaster/shading.h"
#include "volume/errors.h"

#include "../volume/random_fields.h"

namespace isocast::test {
namespace {

struct Effect {
    std::string pass; // its name
    FrameImage image;
    std::function<double&(Effects&)> strength;
    int programs; // that its image alone needs
};

const std::vector<Effect> effects{
    {"solid texture", FrameImage::SolidTexture,
     [](Effects& e) -> double& { return e.solid_texture.strength; }, 2},
    {"curvature colour", FrameImage::CurvatureColour,
     [](Effects& e) -> double& { return e.curvature_colour.strength; }, 3},
    {"curvature map", FrameImage::CurvatureMap,
     [](Effects& e) -> double& { return e.curvature_map.strength; }, 3},
    {"accessibility", FrameImage::Accessibility,
     [](Effects& e) -> double& { return e.accessibility.strength; }, 3},
    {"refraction", FrameImage::Refraction,
     [](Effects& e) -> double& { return e.refraction.strength; }, 2},
    {"reflection", FrameImage::Reflection,
     [](Effects& e) -> double& { return e.reflection.strength; }, 2},
};

struct ColourEffects : Shading, testing::WithParamInterface<std::size_t> {
    const Effect& effect = effects[GetParam()];
    Scene scene{.field = sampled(builtin_field("torus"), 48)};
};

TEST_P(ColourEffects, AtStrengthZeroAreAbsentBitForBit) {
    const Image plain = draw(scene);
    const FrameReport plain_report = report;
    Scene with = scene;
    // Everything but the strength.
    with.look.effects.solid_texture.kind = SolidTexture::Kind::Checker;
    with.look.effects.curvature_colour.range = {{-1, 1}};
    with.look.effects.refraction.index = 2;
    effect.strength(with.look.effects) = 0;
    EXPECT_EQ(draw(with).rgba, plain.rgba);
    EXPECT_FALSE(pass(effect.pass).ran);
    EXPECT_EQ(pass(effect.pass).texture_bytes, 0);
    EXPECT_EQ(report.programs_compiled, plain_report.programs_compiled);
    EXPECT_EQ(report.image_bytes, plain_report.image_bytes);
    EXPECT_EQ(report.look_bytes, 0);
    effect.strength(with.look.effects) = 1;
    EXPECT_NE(draw(with).rgba, plain.rgba);
    EXPECT_TRUE(pass(effect.pass).ran);
}

TEST_P(ColourEffects, AreBlendedByTheirStrength) {
    // Layers over and under light are mixed linearly, so half the strength is half the way.
    const auto picture = [&](double strength) {
        effect.strength(scene.look.effects) = strength;
        return draw(scene);
    };
    const Image none = picture(0);
    const Image half = picture(0.5);
    const Image full = picture(1);
    for (std::size_t i = 0; i < half.rgba.size(); ++i)
        ASSERT_NEAR(half.rgba[i], 0.5 * (none.rgba[i] + full.rgba[i]),
                    4.0 / 2048); // halves, of values up to 1.1
}

TEST_P(ColourEffects, AloneRunNoShading) {
    effect.strength(scene.look.effects) = 1;
    draw(scene, effect.image);
    EXPECT_FALSE(pass("shading").ran);
    EXPECT_EQ(report.programs_compiled, effect.programs);
    EXPECT_EQ(pass(effect.pass).asked_by, "output");
    for (const Effect& other : effects) EXPECT_EQ(pass(other.pass).ran, other.pass == effect.pass);
    const bool needs_curvature = effect.programs == 3;
    EXPECT_EQ(pass("curvature").ran, needs_curvature);
    EXPECT_EQ(pass("gradient").ran, !needs_curvature);
    // Hit, the derivatives, and a layer of halves.
    EXPECT_EQ(report.image_bytes, std::int64_t{size} * size * (16 + 16 + 8));
}

TEST_P(ColourEffects, AreFiniteOnNoiseAndFromInside) {
    Random random(5);
    const auto noise =
        std::make_shared<DenseField>(random_dense(random, {Index3::Zero(), Index3::Constant(24)}));
    size = 64;
    effect.strength(scene.look.effects) = 1;
    const Camera outside{.eye_world = {40, 50, 60}, .target_world = Vec3d::Constant(12)};
    const Camera inside{.eye_world = {11.7, 12.2, 12.4}, .target_world = Vec3d::Zero()};
    Camera parallel = outside;
    parallel.projection = Projection::Orthographic;
    parallel.height_world = 40;
    for (const Filter filter : {Filter::Interpolating, Filter::CatmullRom, Filter::Linear})
        for (const Camera& c : {outside, inside, parallel}) {
            camera = c;
            scene.field = noise;
            scene.filter = filter;
            const Image image = draw(scene, effect.image);
            int covered = 0;
            for (std::size_t i = 0; i < image.rgba.size(); ++i) {
                ASSERT_TRUE(std::isfinite(image.rgba[i]));
                if (i % 4 == 3) {
                    ASSERT_TRUE(image.rgba[i] >= 0 && image.rgba[i] <= 1);
                    covered += image.rgba[i] > 0;
                }
            }
            // Linear's mixed second derivatives alone bend; others bend everywhere.
            EXPECT_GT(covered, 200);
        }
}

TEST_P(ColourEffects, DoNotDependOnTheShapeOfVoxels) {
    // The same sphere in cubic voxels, and in a grid that is turned and stretched.
    GridSpace turned;
    turned.world_from_index.linear() =
        Eigen::AngleAxisd(0.4, Vec3d(1, 2, 3).normalized()).toRotationMatrix() *
        Vec3d(0.06, 0.045, 0.05).asDiagonal();
    turned.world_from_index.translation() =
        -(turned.world_from_index.linear() * Vec3d::Constant(30.2));
    const auto sphere_in = [](const GridSpace& space) {
        const IndexBox extent{Index3::Zero(), Index3::Constant(61)};
        std::vector<float> values;
        for_each_sample(extent, [&](const Index3& i) {
            values.push_back(static_cast<float>(space.to_world(i.cast<double>()).norm() - 1));
        });
        return std::make_shared<DenseField>(space, extent, std::move(values));
    };
    effect.strength(scene.look.effects) = 1;
    // What the fields' extents or pictures would choose.
    scene.look.effects.solid_texture.scale_world = 0.7;
    scene.look.effects.curvature_colour.range = {{-2, 2}};
    scene.look.effects.curvature_map.range = 2;
    scene.look.effects.accessibility.radius_world = 1;
    scene.field = sphere_in(GridSpace::uniform(0.05, Vec3d::Constant(-1.5)));
    const Image even = draw(scene, effect.image);
    scene.field = sphere_in(turned);
    const Image other = draw(scene, effect.image);
    int differing = 0;
    for (std::size_t i = 0; i < even.rgba.size(); ++i)
        // 0.03: curvatures of 16 voxels a radius err by 15/12/16^2, which a map's slope of 4 on a
        // quarter shows as 0.005; reflections of a normal that errs by 1e-4 less.
        differing += std::abs(even.rgba[i] - other.rgba[i]) > 0.03F;
    // At the silhouette a pixel is a hit of one and not of the other.
    EXPECT_LT(differing, 4 * 10);
}

TEST_P(ColourEffects, BeyondFullStrengthAreRefused) {
    for (const double strength : {-0.1, 1.5, std::nan("")}) {
        effect.strength(scene.look.effects) = strength;
        EXPECT_THROW(renderer.load(scene), InputError);
    }
}

INSTANTIATE_TEST_SUITE_P(, ColourEffects, testing::Range(std::size_t{0}, effects.size()),
                         [](const auto& test) {
                             std::string name = effects[test.param].pass;
                             std::erase(name, ' ');
                             return name;
                         });

} // namespace
} // namespace isocast::test
