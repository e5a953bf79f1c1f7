// What no requested output needs does not exist: no pass, no program, no byte (DESIGN section 4).
// SPDX-License-Identifier: MPL-2.0
#include "../volume/temporary_folder.h"
#include "gl/readback.h"
#include "raycaster/passes.h"
#include "shading_scene.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <set>
#include <sstream>

namespace isocast::test {
namespace {

const std::shared_ptr<const FieldSource> torus = sampled(builtin_field("torus"), 40);

struct EffectOfALook {
    std::string name; // of its pass and folder
    FrameImage image;
    double& (*strength)(Look&);
    std::set<std::string> passes; // that run beside those of a plain picture
    /// Evaluations of the field at each hit beside those of a plain picture, which has one for the
    /// ray's normal; -1: rays of its own.
    int evaluations = 0;
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
     {"curvature"},
     1},
    {"curvature map",
     FrameImage::CurvatureMap,
     [](Look& l) -> double& { return l.effects.curvature_map.strength; },
     {"curvature"},
     1},
    {"uncertainty",
     FrameImage::Uncertainty,
     [](Look& l) -> double& { return l.effects.uncertainty.strength; },
     {"flow line curvature"},
     1},
    {"flow",
     FrameImage::Flow,
     [](Look& l) -> double& { return l.effects.flow.strength; },
     {"direction", "flow noise"},
     1},
    {"accessibility",
     FrameImage::Accessibility,
     [](Look& l) -> double& { return l.effects.accessibility.strength; },
     {"curvature"},
     1},
    {"occlusion",
     FrameImage::Occlusion,
     [](Look& l) -> double& { return l.effects.occlusion.strength; },
     {},
     -1},
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
     {"curvature"},
     1},
    {"contours",
     FrameImage::Contours,
     [](Look& l) -> double& { return l.effects.contours.strength; },
     {"view curvature"},
     1},
    {"outlines",
     FrameImage::Outlines,
     [](Look& l) -> double& { return l.effects.outlines.strength; },
     {"outline source"}},
    {"slice", FrameImage::Slice, [](Look& l) -> double& { return l.effects.slice.strength; }, {}},
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

/// Shaders that count what they fetch of the field's samples, as they are written: a compiler may
/// fetch less.
class CountingShaders {
public:
    CountingShaders() {
        std::filesystem::copy(shader_folder, folder(), std::filesystem::copy_options::recursive);
        const std::string version = "#version 450 core\n";
        for (const auto& entry : std::filesystem::recursive_directory_iterator(folder())) {
            if (entry.path().extension() != ".frag") continue;
            std::stringstream text;
            text << std::ifstream(entry.path()).rdbuf();
            std::string source = text.str();
            source.insert(source.find(version) + version.size(), prelude);
            std::ofstream(entry.path()) << source;
        }
    }
    std::filesystem::path folder() const { return folder_ / "shaders"; }

private:
    static constexpr std::string_view prelude = R"(
layout(std430, binding = 5) buffer Fetches { uint fetches; };
vec4 counted(samplerBuffer s, int at) { atomicAdd(fetches, 1u); return texelFetch(s, at); }
vec4 counted(sampler2D s, ivec2 at, int level) { return texelFetch(s, at, level); }
vec4 counted(sampler3D s, ivec3 at, int level) { return texelFetch(s, at, level); }
uvec4 counted(usamplerBuffer s, int at) { return texelFetch(s, at); }
ivec4 counted(isamplerBuffer s, int at) { return texelFetch(s, at); }
#define texelFetch counted
)";
    TemporaryFolder folder_;
};

struct FieldFetches : OnlyWhatIsAsked {
    CountingShaders shaders;
    Renderer counting{*context, shaders.folder()};
    gl::ReadbackBuffer count{4, "fetches"};
    std::int64_t hits = 0;

    FieldFetches() { size = 64; }
    /// In the second frame: what is kept costs nothing.
    std::int64_t fetches(const Look& look, ImageSet wanted) {
        wanted.insert(FrameImage::Hit);
        counting.load({.field = torus, .look = look});
        counting.draw(camera, size, size, wanted);
        count.clear();
        count.bind_to_storage(5);
        counting.draw(camera, size, size, wanted);
        gl::Fence::after_all_commands().wait();
        std::uint32_t out = 0;
        std::memcpy(&out, count.data(), sizeof(out));
        const Image image = counting.read(FrameImage::Hit);
        hits = 0;
        for (std::size_t i = 3; i < image.rgba.size(); i += 4) hits += image.rgba[i] != 0;
        return out;
    }
};
constexpr int of_evaluation = 16; // rows of four, of the default storage

TEST_F(FieldFetches, OfNormalsAreOneEvaluationAndOfAllThatFollowsFromTheHessianOneMore) {
    const std::int64_t of_rays = fetches({}, {});
    EXPECT_GT(hits, 500);
    // A few steps of a ray at least: what is counted is the field.
    EXPECT_GT(of_rays, 2 * of_evaluation * hits);
    const std::int64_t one = of_evaluation * hits;
    EXPECT_EQ(fetches({}, {FrameImage::Gradient}), of_rays + one);
    for (const FrameImage image : {FrameImage::Curvature, FrameImage::Direction,
                                   FrameImage::ViewCurvature, FrameImage::FlowLineCurvature})
        EXPECT_EQ(fetches({}, {image}), of_rays + one) << name_of(image);
    EXPECT_EQ(fetches({}, {FrameImage::Curvature, FrameImage::Direction, FrameImage::ViewCurvature,
                           FrameImage::FlowLineCurvature}),
              of_rays + one);
    EXPECT_EQ(fetches({}, {FrameImage::Gradient, FrameImage::Curvature}), of_rays + 2 * one);
    // Asked for without directions, curvatures have no image of them.
    report = first_report(plain_look(), {FrameImage::Curvature});
    EXPECT_FALSE(pass("direction").ran);
    EXPECT_EQ(pass("direction").texture_bytes, 0);
}

TEST_P(FieldFetches, OfAnEffectAreThoseOfTheDerivativesThatItNeeds) {
    const std::int64_t plain = fetches(plain_look(), {FrameImage::Beauty});
    Look look = plain_look();
    GetParam().strength(look) = 0;
    EXPECT_EQ(fetches(look, {FrameImage::Beauty}), plain);
    GetParam().strength(look) = 1;
    const std::int64_t more = fetches(look, {FrameImage::Beauty}) - plain;
    if (GetParam().evaluations < 0) {
        // Sixteen rays, most of which meet nothing, since they start outwards.
        EXPECT_GT(more, 0);
    } else {
        EXPECT_EQ(more, GetParam().evaluations * of_evaluation * hits);
    }
}

constexpr auto name_of_effect = [](const testing::TestParamInfo<EffectOfALook>& test) {
    std::string name = test.param.name;
    std::erase(name, ' ');
    return name;
};
INSTANTIATE_TEST_SUITE_P(Effects, OnlyWhatIsAsked, testing::ValuesIn(all_effects), name_of_effect);
INSTANTIATE_TEST_SUITE_P(Effects, FieldFetches, testing::ValuesIn(all_effects), name_of_effect);

} // namespace
} // namespace isocast::test
