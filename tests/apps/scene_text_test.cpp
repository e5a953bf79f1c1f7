// Scenes written as TOML: what is read again is the same, key by key and picture by picture.
// SPDX-License-Identifier: MPL-2.0
#include "apps/scene_keys.h"

#include "../volume/temporary_folder.h"
#include "program.h"
#include "raycaster/image_files.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <numbers>
#include <random>

namespace isocast::test {
namespace {

namespace fs = std::filesystem;

const fs::path gallery = fs::path(ISOCAST_SOURCE_DIR) / "docs/gallery";
// What TOML must escape, and UTF-8.
const std::string awkward = "a \"quoted\" 'name' \\n C:\\dir # = [x]\n\ttabs \x01\x7f \u00e9";

std::string full_name(const SceneTable& table, const SceneKey& key) {
    return table.name + "." + key.name;
}

/// One element in each array.
SceneFile one_of_each() {
    SceneFile scene;
    for (const SceneTable& table : scene_tables())
        if (table.is_array()) table.resize(scene, 1);
    return scene;
}

/// What all keys get, by their full names and the numbers of elements.
std::map<std::string, std::optional<SceneValue>> values_of(const SceneFile& scene,
                                                           const fs::path& folder) {
    std::map<std::string, std::optional<SceneValue>> values;
    for (const SceneTable& table : scene_tables()) {
        const std::size_t count = table.is_array() ? table.count(scene) : 1;
        for (std::size_t i = 0; i < count; ++i) {
            values[fmt::format("{}.{}", table.name, i)] = std::nullopt; // so that counts are equal
            for (const SceneKey& key : table.keys)
                values[fmt::format("{}.{}.{}", table.name, i, key.name)] =
                    key.get(scene, i, folder);
        }
    }
    return values;
}

void expect_equal(const SceneFile& a, const SceneFile& b, const fs::path& folder) {
    const auto values_a = values_of(a, folder), values_b = values_of(b, folder);
    for (const auto& [name, value] : values_a)
        EXPECT_TRUE(values_b.contains(name) && values_b.at(name) == value) << name;
    EXPECT_EQ(values_a.size(), values_b.size());
}

struct SceneText : testing::Test {
    TemporaryFolder folder;

    SceneText() {
        for (const char* name : {"a.vdb", "a.obj", "a.xyz", "a.csv", "a.vtk", "a.slim"})
            write_text(folder / name, "");
        write_png({2, 1, {1, 1, 1, 1, 0, 0, 0, 1}}, folder / "map.png");
    }
    std::string text(const SceneFile& scene) const { return scene_text(scene, folder.path()); }
    /// Written, and read again.
    SceneFile again(const SceneFile& scene, const std::string& name = "again.toml") const {
        write_scene_file(scene, folder / name);
        return read_scene_file(folder / name);
    }

    /// Values of the key's type, one of which is not its initial one.
    static std::vector<SceneValue> values_for(const SceneTable& table, const SceneKey& key) {
        static const std::map<std::string, SceneValue> special{
            {"object.field", "a.vdb"},
            {"object.mesh", "a.obj"},
            {"object.molecule", "a.xyz"},
            {"object.points", "a.csv"},
            {"object.tetrahedra", "a.vtk"},
            {"object.slim", "a.slim"},
            {"object.series", "field_##.vdb"},
            {"effects.solid_texture.volume", "field:torus@8"},
            {"effects.curvature_map.picture", "map.png"},
            {"shading.environment", "map.png"},
            {"quality.texture_memory", 0.25}, // whole bytes
            {"quality.max_memory", "2147483648"},
            {"output.size", "64x48"},
            {"output.aov", std::vector<std::string>{"N", "id"}},
            {"output.frames", "3..7"},
            {"output.samples", std::int64_t{4}}};
        const std::string& type = key.type;
        if (const auto found = special.find(full_name(table, key)); found != special.end())
            return {found->second};
        if (type == "text") return {awkward};
        if (type == "[\"name\", ...]") return {std::vector<std::string>{"a", awkward}};
        if (type == "[lo, hi]") return {std::vector<double>{-1e-300, 1.0 / 3}};
        if (type == "[x, y, z]") return {std::vector<double>{0.1, -1e-300, 1e300 / 3}};
        if (type == "colour") return {std::vector<double>{0.1, 1e-300, 1e300 / 3}};
        if (type == "true | false") return {true, false};
        if (type.starts_with("number")) return {0.1, std::numbers::pi / 3, 1e300 / 3};
        if (type.starts_with("integer"))
            return {std::int64_t{2}, std::int64_t{3}, std::int64_t{17}};
        std::vector<SceneValue> names; // "one" | "another"
        for (std::size_t end = 0, begin; (begin = type.find('"', end)) != std::string::npos;) {
            end = type.find('"', begin + 1) + 1;
            names.emplace_back(type.substr(begin + 1, end - begin - 2));
        }
        return names;
    }

    /// Sets the key of the first element to a value that it did not have, and returns that.
    std::optional<SceneValue> change(SceneFile& scene, const SceneTable& table,
                                     const SceneKey& key) const {
        const auto before = key.get(scene, 0, folder.path());
        for (const SceneValue& value : values_for(table, key)) try {
                if (value == before) continue;
                key.set(scene, 0, value, folder.path());
                return value;
            } catch (const std::runtime_error&) { // out of its range
            }
        return std::nullopt;
    }
};

TEST_F(SceneText, EveryKeyAloneComesBack) {
    int count = 0;
    const SceneFile fresh = one_of_each();
    const auto fresh_values = values_of(fresh, folder.path());
    for (const SceneTable& table : scene_tables())
        for (const SceneKey& key : table.keys) {
            SCOPED_TRACE(full_name(table, key));
            ++count;
            SceneFile scene = fresh;
            const auto value = change(scene, table, key);
            ASSERT_TRUE(value) << "no value for " << key.type;
            EXPECT_EQ(key.get(scene, 0, folder.path()), value);
            if (key.reset) {
                SceneFile as_new = scene;
                key.reset(as_new, 0);
                expect_equal(as_new, fresh, folder.path());
            }
            // No other key tells of it.
            auto expected = fresh_values;
            expected[fmt::format("{}.0.{}", table.name, key.name)] = value;
            EXPECT_EQ(values_of(scene, folder.path()), expected);
            expect_equal(again(scene), scene, folder.path());
        }
    EXPECT_GT(count, 150); // or the loops found nothing
}

TEST_F(SceneText, AllKeysAtOnceComeBack) {
    SceneFile scene = one_of_each();
    for (const SceneTable& table : scene_tables())
        for (const SceneKey& key : table.keys)
            EXPECT_TRUE(change(scene, table, key)) << full_name(table, key);
    // A second element of each array stays new.
    for (const SceneTable& table : scene_tables())
        if (table.is_array()) table.resize(scene, 2);
    const SceneFile read = again(scene);
    expect_equal(read, scene, folder.path());
    EXPECT_EQ(text(read), text(scene));
    EXPECT_EQ(read.look.environment.picture.rgba, scene.look.environment.picture.rgba);
    EXPECT_EQ(read.look.effects.curvature_map.picture.width, 2);
    EXPECT_TRUE(read.look.effects.solid_texture.volume);
}

TEST_F(SceneText, OnlyWhatDiffersFromANewSceneIsWritten) {
    EXPECT_EQ(text({}), "");
    SceneFile scene;
    scene.objects.resize(2);
    scene.objects[0].field = "field:torus@64";
    scene.objects[1].mesh = folder / "a.obj";
    scene.objects[1].colour = Vec3d(1, 0.5, 0.1);
    scene.camera.fov_y_degrees = 40;
    scene.output.samples = 4;
    EXPECT_EQ(text(scene), R"([[object]]
field = "field:torus@64"

[[object]]
mesh = "a.obj"
colour = [1, 0.5, 0.1]

[camera]
fov = 40

[output]
samples = 4

)");
}

TEST_F(SceneText, NoLightAndManyLightsComeBack) {
    SceneFile scene;
    scene.look.lights.clear();
    set_key(scene, "camera.fov=20"); // a table after the empty array
    EXPECT_TRUE(again(scene).look.lights.empty());
    scene.look.lights.resize(3);
    scene.look.lights[1].shadow = Shadow::Soft;
    expect_equal(again(scene), scene, folder.path());
    EXPECT_EQ(again(scene).look.lights.size(), 3u);
}

TEST_F(SceneText, EffectsThatAreOffStayOff) {
    // An effect's table that does not say its strength has 1.
    SceneFile scene;
    set_key(scene, "effects.contours.thickness_pixels=3");
    set_key(scene, "effects.ridges.strength=1");
    const SceneFile read = again(scene);
    EXPECT_EQ(read.look.effects.contours.strength, 0);
    EXPECT_EQ(read.look.effects.contours.thickness_pixels, 3);
    EXPECT_EQ(read.look.effects.ridges.strength, 1);
    EXPECT_EQ(read.look.effects.flow.strength, 0);
}

TEST_F(SceneText, NumbersComeBackToTheLastBit) {
    std::mt19937_64 random(9);
    std::vector<double> numbers{0.1, 1e-300, -1e300 / 3, 5e-324, 1e22, 1e16, 123456789012345678.0};
    while (numbers.size() < 1000) {
        const double number = std::bit_cast<double>(random());
        if (std::isfinite(number)) numbers.push_back(number);
    }
    SceneFile scene;
    scene.animations.resize(numbers.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) scene.animations[i].from = numbers[i];
    const SceneFile read = again(scene);
    ASSERT_EQ(read.animations.size(), numbers.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) EXPECT_EQ(read.animations[i].from, numbers[i]);
    scene.camera.eye_world = Vec3d(-0.0, 0, -1);
    const Vec3d eye = again(scene).camera.eye_world.value();
    EXPECT_TRUE(std::signbit(eye.x()) && !std::signbit(eye.y()));
}

TEST_F(SceneText, AViewersCameraComesBackToTheLastBit) {
    std::mt19937 random(9);
    std::uniform_real_distribution<double> any(-10, 10);
    const auto vector = [&] { return Vec3d(any(random), any(random), any(random)); };
    for (int i = 0; i < 50; ++i) {
        SceneFile scene;
        scene.camera = {.eye_world = vector(), .target_world = vector(), .up = vector()};
        (i % 2 ? scene.camera.fov_y_degrees : scene.camera.height_world) = 20 + any(random);
        const CameraSpec read = again(scene).camera;
        const std::vector<Vec3d> no_points;
        const Camera a = camera_from(scene.camera, no_points, 1.5);
        const Camera b = camera_from(read, no_points, 1.5);
        EXPECT_EQ(a.eye_world, b.eye_world);
        EXPECT_EQ(a.view_from_world_rotation(), b.view_from_world_rotation());
        EXPECT_EQ(a.projection, b.projection);
        EXPECT_EQ(a.height_world, b.height_world);
        EXPECT_EQ(a.half_height_at(1), b.half_height_at(1));
    }
}

TEST_F(SceneText, PathsAreRelativeBelowTheFolderAloneAndFoundAgain) {
    const std::string odd = "odd \"name\" \\ with spaces";
    fs::create_directories(folder / "scenes/below" / odd);
    fs::create_directories(folder / "elsewhere/deep");
    fs::create_directory_symlink(folder / "elsewhere/deep", folder / "scenes/link");
    fs::create_symlink(folder / "elsewhere/linked.vdb", folder / "scenes/linked.vdb");
    const std::vector<std::pair<fs::path, std::string>> cases{
        {"scenes/a.vdb", "a.vdb"},
        {"scenes/below/" + odd + "/b.vdb", "below/" + odd + "/b.vdb"},
        {"scenes/below/../c.vdb", "c.vdb"},
        {"scenes/..d.vdb", "..d.vdb"},
        {"scenes/linked.vdb", "linked.vdb"}, // itself a link out of the folder
        {"elsewhere/e.vdb", (fs::canonical(folder.path()) / "elsewhere/e.vdb").string()},
        // .. behind a link is where the link leads to.
        {"scenes/link/../e.vdb", (fs::canonical(folder.path()) / "elsewhere/e.vdb").string()},
        {"scenes/below/../../f.vdb", (fs::canonical(folder.path()) / "f.vdb").string()}};
    for (const auto& [file, written] : cases) {
        SCOPED_TRACE(file);
        write_text(folder.path() / file, file.string());
        SceneFile scene;
        scene.objects.resize(1);
        scene.objects[0].field = folder.path() / file;
        EXPECT_EQ(scene_tables().front().key("field")->get(scene, 0, folder / "scenes"),
                  SceneValue(written));
        const SceneFile read = again(scene, "scenes/scene.toml");
        EXPECT_EQ(contents_of(read.objects.at(0).field), file.string()) << "the same file";
    }
    // Paths of a command line are relative to the working folder.
    SceneFile scene;
    scene.objects.resize(1);
    scene.objects[0].field = "a.vdb:grid";
    EXPECT_EQ(scene_tables().front().key("field")->get(scene, 0, folder / "scenes"),
              SceneValue((fs::canonical(fs::current_path()) / "a.vdb:grid").string()));
    EXPECT_EQ(scene_tables().front().key("field")->get(scene, 0, {}), SceneValue("a.vdb:grid"));
}

TEST_F(SceneText, WhatNoFileCanSayIsRefusedAndTheOldFileStays) {
    write_text(folder / "old.toml", "old");
    const auto refusal = [&](const SceneFile& scene) {
        return message_of<InputError>([&] { write_scene_file(scene, folder / "old.toml"); });
    };
    SceneFile scene;
    scene.look.effects.curvature_map.picture = {1, 1, {1, 1, 1, 1}};
    EXPECT_NE(refusal(scene).find("effects.curvature_map.picture: "), std::string::npos);
    scene = {};
    scene.look.environment.kind = ::isocast::Environment::Kind::Picture;
    EXPECT_NE(refusal(scene).find("shading.environment: "), std::string::npos);
    scene = {};
    scene.objects.resize(1);
    scene.objects[0].name = "\xff";
    EXPECT_NE(refusal(scene).find("TOML"), std::string::npos);
    EXPECT_EQ(contents_of(folder / "old.toml"), "old");
    EXPECT_NE(message_of<InputError>([&] { write_scene_file({}, folder / "no/a.toml"); }), "");
}

TEST_F(SceneText, TheGallerysScenesComeBack) {
    write_text(folder / "1l2y.pdb", "");
    int count = 0;
    for (const auto& entry : fs::directory_iterator(gallery)) {
        if (entry.path().extension() != ".toml") continue;
        SCOPED_TRACE(entry.path().filename());
        ++count;
        std::string text = contents_of(entry.path());
        const bool has_place = text.find("DATA/") != std::string::npos; // which nobody has
        for (std::size_t at; (at = text.find("DATA/")) != std::string::npos;) text.erase(at, 5);
        if (has_place) write_text(folder / "placed.toml", text);
        const SceneFile scene = read_scene_file(has_place ? folder / "placed.toml" : entry.path());
        const SceneFile read = again(scene);
        expect_equal(read, scene, folder.path());
        EXPECT_NO_THROW(check_scene(read));
    }
    EXPECT_GE(count, 9);
}

TEST_F(SceneText, DrawsTheSamePicture) {
    const auto draw = [&](const fs::path& scene) {
        checked_output(isocast(
            {"render", scene, "-o", folder / "out.png", "--backend", "osmesa", "--size", "96x64"}));
        return contents_of(folder / "out.png");
    };
    for (const char* name : {"three_grids.toml", "textured_quadrics.toml"}) {
        write_scene_file(read_scene_file(gallery / name), folder / "again.toml");
        EXPECT_EQ(draw(folder / "again.toml"), draw(gallery / name)) << name;
    }
}

} // namespace
} // namespace isocast::test
