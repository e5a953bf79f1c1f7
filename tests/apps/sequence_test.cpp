// Sequences: cameras on their way, numbers that change, and files that are whole or not there.
// SPDX-License-Identifier: MPL-2.0
#include "apps/sequence.h"

#include "../volume/temporary_folder.h"
#include "apps/inputs.h"
#include "apps/output_words.h"
#include "program.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace isocast::test {
namespace {

TEST(Frames, AreANumberOrARange) {
    EXPECT_EQ(frames_from("5").first, 0);
    EXPECT_EQ(frames_from("5").last, 4);
    EXPECT_EQ(frames_from("3..7").first, 3);
    EXPECT_EQ(frames_from("3..7").last, 7);
    EXPECT_EQ(frames_from("3..3").count(), 1);
    for (const char* text : {"", "0", "-1", "x", "3..", "..3", "4..3", "-1..3", "3...7", "1000001"})
        EXPECT_THROW(frames_from(text), UsageError) << text;
}

TEST(Frames, HaveTheirNumbersInTheirNames) {
    EXPECT_EQ(frame_path("out/a_%04d.png", 7), "out/a_0007.png");
    EXPECT_EQ(frame_path("%d.exr", 12345), "12345.exr");
    EXPECT_EQ(frame_path("%2d.exr", 3), "03.exr");
    for (const char* name : {"a.png", "a%.png", "a%s.png", "%d%d.png", "%04x.png", "%d/a.png"})
        EXPECT_THROW(frame_path(name, 0), UsageError) << name;
}

struct CameraPath : testing::Test {
    SceneFile scene;
    Camera base{.eye_world = {1, 2, 6}, .target_world = {0.5, 0, 1}, .up = {0.1, 2, 0}};
};

TEST_F(CameraPath, TurntableOfAFullTurnComesBackToTheFirstFrame) {
    scene.turntable_degrees = 360;
    constexpr int count = 8;
    const Camera first = camera_at(scene, base, 0, count);
    EXPECT_EQ(first.eye_world, base.eye_world);
    // The frame after the last. 1e-14: roundings of coordinates below 10.
    EXPECT_LT((camera_at(scene, base, count, count).eye_world - base.eye_world).norm(), 1e-14);
    for (int i = 1; i < count; ++i) {
        const Camera camera = camera_at(scene, base, i, count);
        EXPECT_EQ(camera.target_world, base.target_world);
        const Vec3d up = base.up.normalized();
        const Vec3d before = base.eye_world - base.target_world;
        const Vec3d after = camera.eye_world - base.target_world;
        EXPECT_NEAR(after.norm(), before.norm(), 1e-14);
        EXPECT_NEAR(after.dot(up), before.dot(up), 1e-14);
        // The angle around the axis.
        const Vec3d a = before - before.dot(up) * up;
        const Vec3d b = after - after.dot(up) * up;
        const double angle = std::atan2(up.dot(a.cross(b)), a.dot(b));
        EXPECT_NEAR(std::remainder(angle - i * 3.14159265358979 / 4, 6.28318530717959), 0, 1e-13);
    }
}

TEST_F(CameraPath, PassesTheKeysAtTheirTimes) {
    scene.camera_keys = {{.time = 1, .eye_world = {0, 0, 5}, .fov_y_degrees = 20},
                         {.time = 2, .eye_world = {3, 1, 4}, .target_world = Vec3d(1, 0, 0)},
                         {.time = 5, .eye_world = {6, -1, 0}, .fov_y_degrees = 50}};
    for (const bool is_smooth : {true, false}) {
        scene.has_smooth_path = is_smooth;
        // Five frames at times 1 ... 5.
        for (const auto& [frame, key] : {std::pair(0, 0u), std::pair(1, 1u), std::pair(4, 2u)}) {
            const Camera camera = camera_at(scene, base, frame, 5);
            const CameraKey& expected = scene.camera_keys[key];
            EXPECT_LT((camera.eye_world - expected.eye_world).norm(), 1e-14);
            EXPECT_LT(
                (camera.target_world - expected.target_world.value_or(base.target_world)).norm(),
                1e-14);
            EXPECT_NEAR(camera.fov_y_degrees, expected.fov_y_degrees.value_or(base.fov_y_degrees),
                        1e-13);
        }
    }
    scene.has_smooth_path = false;
    EXPECT_LT((camera_at(scene, base, 2, 5).eye_world - Vec3d(4, 1.0 / 3, 8.0 / 3)).norm(), 1e-14)
        << "a third of the way from the second to the third";
}

TEST_F(CameraPath, IsSmoothAndStraightWhereKeysLieOnALine) {
    // Cubics reproduce even motion exactly, whatever the distances of times.
    for (const double time : {0.0, 1.0, 1.5, 4.0})
        scene.camera_keys.push_back({.time = time, .eye_world = Vec3d(2 * time, 1 - time, 5)});
    for (int i = 0; i <= 40; ++i) {
        const double time = i / 10.0;
        EXPECT_LT((camera_at(scene, base, i, 41).eye_world - Vec3d(2 * time, 1 - time, 5)).norm(),
                  1e-14);
    }
    // On a bent path the velocity is the same on both sides of a key.
    scene.camera_keys[2].eye_world = {7, 3, 2};
    const auto eye = [&](int i) { return camera_at(scene, base, i, 40001).eye_world; };
    const Vec3d before = eye(15000) - eye(14999);
    const Vec3d after = eye(15001) - eye(15000);
    // Steps of 1e-4, squared, times an acceleration of some 70; a kink would show times 1e-4.
    EXPECT_LT((after - before).norm(), 2e-6);
    EXPECT_GT(before.norm(), 1e-4);
}

TEST(Animations, GoFromTheFirstFrameToTheLastOrRoundAndRound) {
    SceneFile scene;
    scene.objects.resize(2);
    scene.animations = {{.key = "object.1.t", .from = 0.25, .to = 0.75},
                        {.key = "effects.flow.phase", .from = 0, .to = 1, .is_loop = true}};
    EXPECT_EQ(scene_at(scene, 0, 5).objects[1].t, 0.25);
    EXPECT_EQ(scene_at(scene, 2, 5).objects[1].t, 0.5);
    EXPECT_EQ(scene_at(scene, 4, 5).objects[1].t, 0.75);
    EXPECT_EQ(scene_at(scene, 4, 5).look.effects.flow.phase, 0.8);
    EXPECT_EQ(scene_at(scene, 0, 1).objects[1].t, 0.25);
    EXPECT_EQ(scene.objects[1].t, 0) << "the scene itself stays";
}

TEST(Animations, LoadOnlyWhatTheyChange) {
    const auto change = [](std::vector<std::string> keys) {
        SceneFile scene;
        for (std::string& key : keys) scene.animations.push_back({.key = std::move(key)});
        return change_of(scene);
    };
    EXPECT_EQ(change({}), Change::Nothing);
    EXPECT_EQ(change({"camera.fov"}), Change::Nothing);
    EXPECT_EQ(change({"camera.fov", "effects.flow.phase"}), Change::Look);
    EXPECT_EQ(change({"object.0.iso", "light.0.strength"}), Change::Iso);
    EXPECT_EQ(change({"object.0.iso", "object.0.t"}), Change::Load);
    EXPECT_EQ(change({"quality.guarantee"}), Change::Load);
}

struct SequenceFiles : testing::Test {
    TemporaryFolder folder;
    const std::vector<std::string> small{"--size", "32x24", "--backend", "osmesa"};

    void render(const std::string& input, const std::string& output,
                std::vector<std::string> more) const {
        more.insert(more.begin(), {"render", input, "-o", folder / output});
        more.insert(more.end(), small.begin(), small.end());
        checked_output(isocast(more));
    }
    std::string scene(const std::string& text) const {
        write_text(folder / "scene.toml", text);
        return folder / "scene.toml";
    }
    std::string bytes(const std::string& name) const { return contents_of(folder / name); }
};

TEST_F(SequenceFiles, AreOneForEachFrame) {
    render("field:torus@16", "a_%03d.png", {"--frames", "4..6", "--set", "camera.turntable=90"});
    EXPECT_EQ(folder.entry_count(), 3);
    for (const char* name : {"a_004.png", "a_005.png", "a_006.png"})
        EXPECT_TRUE(bytes(name).ends_with(std::string("IEND\xae\x42\x60\x82", 8))) << name;
    EXPECT_NE(bytes("a_004.png"), bytes("a_005.png"));
    // The first frame is that of no turntable.
    render("field:torus@16", "b.png", {});
    EXPECT_EQ(bytes("a_004.png"), bytes("b.png"));
}

TEST_F(SequenceFiles, EqualThePicturesOfEachFrameAlone) {
    const std::string path = scene("[[object]]\nfield = \"field:sphere@24\"\n"
                                   "[camera]\neye = [0, 1, 5]\n"
                                   "[output]\nframes = 3\n"
                                   "[[animate]]\nkey = \"object.iso\"\nto = 0.25\n"
                                   "[[animate]]\nkey = \"shading.specular\"\nfrom = 1\nto = 0\n");
    render(path, "a%d.png", {});
    for (const int i : {0, 1, 2}) {
        render("field:sphere@24", "b.png",
               {"--camera", "eye=0,1,5", "--iso", fmt::format("{}", i / 8.0), "--set",
                fmt::format("shading.specular={}", 1 - i / 2.0)});
        EXPECT_EQ(bytes(fmt::format("a{}.png", i)), bytes("b.png")) << i;
    }
}

TEST_F(SequenceFiles, OfASeriesReadTheFileOfEachTime) {
    for (const auto& [number, name] : {std::pair("07", "sphere"), std::pair("08", "torus")})
        checked_output(isocast({"sample", fmt::format("field:{}@16", name), "-o",
                                folder / fmt::format("field_{}.vdb", number)}));
    const std::string path = scene("[[object]]\nseries = \"field_##.vdb\"\n"
                                   "[camera]\neye = [0, 1, 5]\ntarget = [0, 0, 0]\n"
                                   "[output]\nframes = 2\n"
                                   "[[animate]]\nkey = \"object.time\"\nfrom = 7\nto = 8\n");
    render(path, "a%d.png", {});
    for (const int i : {0, 1}) {
        render(folder / fmt::format("field_0{}.vdb", 7 + i), "b.png",
               {"--camera", "eye=0,1,5;target=0,0,0"});
        EXPECT_EQ(bytes(fmt::format("a{}.png", i)), bytes("b.png")) << i;
    }
}

TEST_F(SequenceFiles, KeepTheNumbersOfTheFirstFrame) {
    /// Which range of curvatures the last frame has.
    const auto note = [&](const std::string& direction, const std::string& more) {
        const std::string path = scene("[[object]]\nfield = \"field:gyroid@16\"\n"
                                       "[effects.curvature_colour]\n"
                                       "[camera]\ndirection = " +
                                       direction + "\n" + more);
        const nlohmann::json json = nlohmann::json::parse(
            checked_output(isocast({"render", path, "-o", folder / "a%d.png", "--size", "300x200",
                                    "--backend", "osmesa", "--json"})));
        for (const std::string one : json["notes"])
            if (one.starts_with("curvature colour")) return one;
        return std::string("none");
    };
    const std::string first = note("[0, 0.3, 1]", "[output]\nframes = 1\n");
    EXPECT_NE(first, "none");
    EXPECT_NE(note("[1, 0.3, 0.2]", "[output]\nframes = 1\n"), first) << "from elsewhere";
    const std::string turning = "turntable = 100\n[output]\nframes = 2\n";
    EXPECT_EQ(note("[0, 0.3, 1]", turning), first);
    // The look; the iso value; what is loaded.
    for (const char* key : {"shading.specular", "object.iso", "quality.guarantee"})
        EXPECT_EQ(note("[0, 0.3, 1]",
                       turning + fmt::format("[[animate]]\nkey = \"{}\"\nfrom = {}\nto = 0.2\n",
                                             key, key == std::string("object.iso") ? 0 : 0.01)),
                  first)
            << key;
}

TEST_F(SequenceFiles, NeedAPlaceForTheNumber) {
    const Outcome outcome =
        isocast({"render", "field:torus@16", "-o", folder / "a.png", "--frames", "3"});
    EXPECT_EQ(outcome.code, 2);
    EXPECT_NE(outcome.err.find("%04d"), std::string::npos) << outcome.err;
    EXPECT_EQ(folder.entry_count(), 0);
}

TEST_F(SequenceFiles, AreWholeOrNotThereAfterCtrlC) {
    const Outcome outcome =
        isocast_on_terminal({"render", "field:torus@16", "-o", folder / "a%05d.png", "--frames",
                             "100000", "--size", "64x64", "--backend", "osmesa"},
                            "drawing");
    EXPECT_EQ(outcome.code, 130) << outcome.err;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
        EXPECT_TRUE(entry.path().filename().string().starts_with("a0")) << entry.path();
        EXPECT_TRUE(contents_of(entry.path()).ends_with(std::string("IEND\xae\x42\x60\x82", 8)));
    }
}

} // namespace
} // namespace isocast::test
