// What no requested output needs does not exist: no pass, no program, no byte (DESIGN section 4).
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/passes.h"
#include "shading_scene.h"

#include <algorithm>
#include <set>

namespace isocast::test {
namespace {

const std::shared_ptr<const FieldSource> torus = sampled(builtin_field("torus"), 40);

struct EffectOfALook {
    std::string name; // of its pass and folder
    FrameImage image;
    double& (*strength)(Look&);
    std::set<std::string> passes; // that run beside those of a plain picture
};

Light& shadowed(Look& look) {
    look.lights[0].shadow = Shadow::Soft;
    return look.lights[0];
}

const std::vector<EffectOfALook> all_effects{
    {"solid texture",
     FrameImage::SolidTexture,
     [](Look& l) -> double& { return l.effects.solid_texture.strength; },
     {}},
    {"curvature colour",
     FrameImage::CurvatureColour,
     [](Look& l) -> double& { return l.effects.curvature_colour.strength; },
     {"curvature"}},
    {"curvature map",
     FrameImage::CurvatureMap,
     [](Look& l) -> double& { return l.effects.curvature_map.strength; },
     {"curvature"}},
    {"uncertainty",
     FrameImage::Uncertainty,
     [](Look& l) -> double& { return l.effects.uncertainty.strength; },
     {"flow line curvature"}},
    {"flow",
     FrameImage::Flow,
     [](Look& l) -> double& { return l.effects.flow.strength; },
     {"direction", "flow noise"}},
    {"accessibility",
     FrameImage::Accessibility,
     [](Look& l) -> double& { return l.effects.accessibility.strength; },
     {"curvature"}},
    {"occlusion",
     FrameImage::Occlusion,
     [](Look& l) -> double& { return l.effects.occlusion.strength; },
     {}},
    {"shadow",
     FrameImage::Shadow,
     [](Look& l) -> double& { return shadowed(l).shadow_strength; },
     {"shadow map"}},
    {"refraction",
     FrameImage::Refraction,
     [](Look& l) -> double& { return l.effects.refraction.strength; },
     {}},
    {"reflection",
     FrameImage::Reflection,
     [](Look& l) -> double& { return l.effects.reflection.strength; },
     {}},
    {"ridges",
     FrameImage::Ridges,
     [](Look& l) -> double& { return l.effects.ridges.strength; },
     {"curvature"}},
    {"contours",
     FrameImage::Contours,
     [](Look& l) -> double& { return l.effects.contours.strength; },
     {"view curvature"}},
    {"outlines",
     FrameImage::Outlines,
     [](Look& l) -> double& { return l.effects.outlines.strength; },
     {"outline source"}},
};

/// Lit from the side, so that the torus throws a shadow on itself.
Look plain_look() {
    Look look;
    look.lights[0].direction = {1, 0.4, 0.3};
    return look;
}

std::set<std::string> running(const FrameReport& report) {
    std::set<std::string> names;
    for (const PassReport& pass : report.passes)
        if (pass.ran) names.insert(pass.name);
    return names;
}

struct OnlyWhatIsAsked : Shading, testing::WithParamInterface<EffectOfALook> {
    /// From a renderer that has drawn nothing before.
    FrameReport first_report(const Look& look, const ImageSet& wanted, Image* beauty = nullptr) {
        Renderer fresh(*context, shader_folder);
        fresh.load({.field = torus, .look = look});
        const FrameReport out = fresh.draw(camera, size, size, wanted);
        if (beauty) *beauty = fresh.read(FrameImage::Beauty);
        return out;
    }
};

TEST_F(OnlyWhatIsAsked, APlainPictureRunsThreePassesAndCompilesTwoPrograms) {
    const FrameReport plain = first_report(plain_look(), {FrameImage::Beauty});
    EXPECT_EQ(running(plain), (std::set<std::string>{"raycast", "gradient", "shading"}));
    EXPECT_EQ(plain.programs_compiled, 2);
    EXPECT_EQ(plain.image_bytes, size * size * (16 + 16 + 8));
    EXPECT_EQ(plain.look_bytes, 0);
}

TEST_P(OnlyWhatIsAsked, AtStrengthZeroIsAbsent) {
    Image plain;
    const FrameReport of_plain = first_report(plain_look(), {FrameImage::Beauty}, &plain);
    Look look = plain_look();
    GetParam().strength(look) = 0;
    Image at_zero;
    const FrameReport of_zero = first_report(look, {FrameImage::Beauty}, &at_zero);
    EXPECT_EQ(at_zero.rgba, plain.rgba);
    EXPECT_EQ(running(of_zero), running(of_plain));
    EXPECT_EQ(of_zero.programs_compiled, of_plain.programs_compiled);
    EXPECT_EQ(of_zero.image_bytes, of_plain.image_bytes);
    EXPECT_EQ(of_zero.field_bytes, of_plain.field_bytes);
    EXPECT_EQ(of_zero.look_bytes, 0);
}

TEST_P(OnlyWhatIsAsked, RunsItsOwnPassesAndNoOthers) {
    Image plain;
    std::set<std::string> expected =
        running(first_report(plain_look(), {FrameImage::Beauty}, &plain));
    expected.insert(GetParam().name);
    expected.insert(GetParam().passes.begin(), GetParam().passes.end());
    Look look = plain_look();
    GetParam().strength(look) = 1;
    Image with_effect;
    EXPECT_EQ(running(first_report(look, {FrameImage::Beauty}, &with_effect)), expected);
    EXPECT_NE(with_effect.rgba, plain.rgba) << "it shows";
}

TEST_P(OnlyWhatIsAsked, AloneRunsNoShading) {
    Look look = plain_look();
    GetParam().strength(look) = 1;
    const std::set<std::string> names = running(first_report(look, {GetParam().image}));
    EXPECT_TRUE(names.contains(GetParam().name));
    EXPECT_FALSE(names.contains("shading"));
    for (const EffectOfALook& other : all_effects)
        EXPECT_EQ(names.contains(other.name), other.name == GetParam().name) << other.name;
}

INSTANTIATE_TEST_SUITE_P(Effects, OnlyWhatIsAsked, testing::ValuesIn(all_effects),
                         [](const auto& test) {
                             std::string name = test.param.name;
                             std::erase(name, ' ');
                             return name;
                         });

} // namespace
} // namespace isocast::test
