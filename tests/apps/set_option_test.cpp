// --set KEY=VALUE.
// SPDX-License-Identifier: MPL-2.0
#include "apps/scene_file.h"

#include "../volume/temporary_folder.h"
#include "apps/inputs.h"
#include "program.h"
#include "volume/errors.h"

#include <gtest/gtest.h>

namespace isocast::test {
namespace {

struct SetKey : testing::Test {
    SceneFile scene;
    SetKey() { scene.objects.resize(1); }

    std::string refusal(const std::string& assignment) {
        return message_of<UsageError>([&] { set_key(scene, assignment); });
    }
};

TEST_F(SetKey, TakesTomlAndBareWords) {
    set_key(scene, "effects.contours.strength=0.5");
    set_key(scene, "effects.contours.thickness_pixels=3");
    set_key(scene, "shading.colour=[1, 0, 0.5]");
    set_key(scene, "shading.background=\"#ffffff\"");
    set_key(scene, "shading.model=gooch");
    set_key(scene, "shading.show_environment=true");
    set_key(scene, "output.size=320x200");
    set_key(scene, "output.aov=P,id");
    set_key(scene, "quality.brick_size=16");
    set_key(scene, "quality.max_memory=500");
    EXPECT_EQ(scene.look.effects.contours.strength, 0.5);
    EXPECT_EQ(scene.look.effects.contours.thickness_pixels, 3);
    EXPECT_EQ(scene.look.material.colour, Vec3d(1, 0, 0.5));
    EXPECT_EQ(scene.look.background, Vec3d::Ones());
    EXPECT_EQ(scene.look.model, ShadingModel::Gooch);
    EXPECT_TRUE(scene.look.shows_environment);
    EXPECT_EQ(scene.output.height, 200);
    EXPECT_TRUE(scene.output.layers->id);
    EXPECT_EQ(scene.storage.brick_size, 16);
    EXPECT_EQ(scene.memory_bytes, 500);
}

TEST_F(SetKey, ReachesElementsByTheirIndexAndTheFirstWithoutOne) {
    set_key(scene, "light.shadow=soft");
    EXPECT_EQ(scene.look.lights.at(0).shadow, Shadow::Soft);
    set_key(scene, "light.0.shadow=hard");
    EXPECT_EQ(scene.look.lights.at(0).shadow, Shadow::Hard);
    set_key(scene, "light.1.direction=[0, 0, 1]");
    EXPECT_EQ(scene.look.lights.size(), 2u) << "one past the last is a new one";
    set_key(scene, "camera.key.0.time=3");
    EXPECT_EQ(scene.camera_keys.at(0).time, 3);
    EXPECT_NE(refusal("light.3.shadow=hard").find("there are 2"), std::string::npos);
}

TEST_F(SetKey, NamesTheKeyAndTheKnownOnes) {
    EXPECT_NE(refusal("effects.contours.width=1").find("thickness_pixels"), std::string::npos);
    EXPECT_NE(refusal("effects.contour.strength=1").find("contours"), std::string::npos);
    EXPECT_NE(refusal("kamera.fov=1").find("camera"), std::string::npos);
    EXPECT_NE(refusal("fov=1").find("'fov'"), std::string::npos);
    EXPECT_NE(refusal("camera.0.fov=1").find("'camera.0.fov'"), std::string::npos);
    EXPECT_NE(refusal("camera.fov").find("KEY=VALUE"), std::string::npos);
    EXPECT_NE(refusal("camera.fov=wide").find("camera.fov: expected a number"), std::string::npos);
    EXPECT_NE(refusal("light.shadow=blurred").find("none, hard, soft"), std::string::npos);
    EXPECT_NE(refusal("camera.fov=1\nup=2").find("camera.fov"), std::string::npos);
    EXPECT_THROW(set_key(scene, "shading.environment=nowhere.exr"), InputError);
}

TEST_F(SetKey, WorksWithABareFieldAndOverItsDefaults) {
    const TemporaryFolder folder;
    const auto draw = [&](const std::vector<std::string>& more) {
        return isocast(joined({"render", "field:torus@16", "-o", folder / "a.png", "--backend",
                               "osmesa", "--size", "48x32"},
                              more));
    };
    checked_output(draw({}));
    const std::string plain = contents_of(folder / "a.png");
    checked_output(draw({"--set", "shading.model=gooch", "--set", "light.direction=[0, 1, 0]"}));
    EXPECT_NE(contents_of(folder / "a.png"), plain);
    checked_output(draw({"--set", "output.size=64x64"}));
    // Options come after --set.
    EXPECT_EQ(contents_of(folder / "a.png").substr(16, 8), plain.substr(16, 8));
    const Outcome unknown = draw({"--set", "shading.gloss=1"});
    EXPECT_EQ(unknown.code, 2);
    EXPECT_NE(unknown.err.find("--set unknown key 'shading.gloss'"), std::string::npos)
        << unknown.err;
    EXPECT_EQ(draw({"--set", "shading.environment=nowhere.png"}).code, 3);
}

TEST_F(SetKey, KeysAreListed) {
    const Outcome outcome = isocast({"render", "--keys"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    for (const char* word : {"[camera]", "[[light]]", "[effects.contours]", "thickness_pixels"})
        EXPECT_NE(outcome.out.find(word), std::string::npos) << word;
}

} // namespace
} // namespace isocast::test
