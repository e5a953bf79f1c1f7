// Scene files: every key is read, and every mistake is told with its line and column.
// SPDX-License-Identifier: MPL-2.0
#include "apps/scene_keys.h"

#include "../volume/temporary_folder.h"
#include "apps/inputs.h"
#include "program.h"
#include "raycaster/image_files.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace isocast::test {
namespace {

struct SceneFiles : testing::Test {
    TemporaryFolder folder;

    SceneFiles() {
        write_text(folder / "a.vdb", "");
        write_text(folder / "a.obj", "");
        write_text(folder / "a.xyz", "");
        write_text(folder / "a.csv", "");
        write_text(folder / "a.slim", "");
        write_png({2, 1, {1, 1, 1, 1, 0, 0, 0, 1}}, folder / "map.png");
    }
    SceneFile read(const std::string& text) const {
        write_text(folder / "scene.toml", text);
        return read_scene_file(folder / "scene.toml");
    }
    /// Reading, or the check afterwards, finds problems: each starts with the file's name and
    /// `where`, and holds all words.
    void expect_refused(const std::string& text, const std::string& where,
                        const std::vector<std::string>& words) const {
        const std::string message = message_of<InputError>([&] { check_scene(read(text)); });
        const std::string start = fmt::format("scene.toml:{}: ", where);
        EXPECT_NE(message.find(start), std::string::npos) << "no " << start << "in: " << message;
        for (const std::string& word : words)
            EXPECT_NE(message.find(word), std::string::npos)
                << "no '" << word << "' in: " << message;
    }
};

/// A value that the key takes.
std::string example_of(const SceneTable& table, const SceneKey& key) {
    if (key.name == "frames" || key.name == "resolution") return "3";
    if (key.name == "series") return "\"field_##.vdb\"";
    if (key.name == "size" && table.name == "output") return "\"64x48\"";
    if (key.name == "max_memory") return "\"2G\"";
    if (key.name == "aov") return "[\"P\", \"N\"]";
    if (key.name == "of" || key.name == "morph") return "[\"a\", \"b\"]";
    if (key.name == "key" || key.name == "name") return "\"object.0.t\"";
    if (key.name == "mesh") return "\"mesh:knot\"";
    if (key.name == "field" || key.name == "volume") return "\"field:torus@8\"";
    if (key.name == "points") return "\"a.csv\"";
    if (key.name == "molecule") return "\"a.xyz\"";
    if (key.name == "slim") return "\"a.slim\"";
    if (key.name == "shrink") return "0.25";
    if (key.type == "text") return "\"1\"";
    if (key.type.starts_with("file")) return "\"map.png\"";
    if (key.type == "[lo, hi]") return "[-1, 2]";
    if (key.type == "[x, y, z]" || key.type == "colour") return "[0.25, 0.5, 1]";
    if (key.type == "true | false") return "true";
    if (key.name == "shadow_map_pixels") return "16";
    if (key.type.starts_with("number")) return "1";
    if (key.type.starts_with("integer")) return "1";
    return key.type.substr(0, key.type.find(' ')); // the first of the names
}

TEST_F(SceneFiles, EveryKeyOfTheTableIsRead) {
    int count = 0;
    for (const SceneTable& table : scene_tables()) {
        std::string text = header_of(table) + "\n";
        for (const SceneKey& key : table.keys) {
            text += fmt::format("{} = {}\n", key.name, example_of(table, key));
            ++count;
        }
        SceneFile scene;
        EXPECT_NO_THROW(scene = read(text)) << message_of<InputError>([&] { read(text); });
        for (const SceneKey& key : table.keys)
            EXPECT_TRUE(scene.places.contains(table.is_array()
                                                  ? fmt::format("{}.0.{}", table.name, key.name)
                                                  : fmt::format("{}.{}", table.name, key.name)))
                << table.name << "." << key.name;
    }
    EXPECT_GT(count, 100);
}

TEST_F(SceneFiles, EveryKeyIsInTheUsersPage) {
    const std::string page =
        contents_of(std::filesystem::path(ISOCAST_SOURCE_DIR) / "docs/scenes.md");
    EXPECT_NE(page.find(scene_reference()), std::string::npos)
        << "isocast render --keys prints what belongs there";
}

TEST_F(SceneFiles, KeysGoToTheirMembers) {
    const SceneFile scene = read(R"(
[camera]
eye = [1, 2, 3]
fov = 40
[[camera.key]]
time = 2
eye = [4, 5, 6]
[[light]]
direction = [0, 1, 0]
space = "world"
shadow = "soft"
size = 5
shadow_map_pixels = 300
[[light]]
colour = "#ff0080"
[[object]]
name = "part"
field = "a.vdb"
iso = 0.5
filter = "linear"
colour = [1, 0.5, 0]
[shading]
model = "gooch"
specular = 0
environment = "map.png"
[effects.contours]
thickness_pixels = 3
[effects.curvature_map]
picture = "map.png"
strength = 0.5
[effects.curvature_colour]
range = [-2, 3.5]
measure = "shape_index"
[quality]
guarantee = 0.1
fetch = "samples"
brick_size = 16
texture_memory = 2
[output]
size = "320x200"
aov = "P,curvature"
frames = "3..7"
)");
    EXPECT_EQ(scene.camera.eye_world, Vec3d(1, 2, 3));
    EXPECT_EQ(scene.camera_keys.at(0).eye_world, Vec3d(4, 5, 6));
    ASSERT_EQ(scene.look.lights.size(), 2u);
    EXPECT_FALSE(scene.look.lights[0].is_in_view_space);
    EXPECT_EQ(scene.look.lights[0].shadow, Shadow::Soft);
    EXPECT_EQ(scene.look.lights[0].size_degrees, 5);
    EXPECT_EQ(scene.look.lights[0].shadow_map_pixels, 300);
    EXPECT_FALSE(scene.look.lights[1].shadow_map_pixels);
    EXPECT_TRUE(scene.look.lights[1].is_in_view_space);
    EXPECT_EQ(scene.look.lights[1].colour.x(), 1);
    EXPECT_NEAR(scene.look.lights[1].colour.z(), 0.2158605, 1e-7) << "sRGB 128/255, IEC 61966-2-1";
    ASSERT_EQ(scene.objects.size(), 1u);
    EXPECT_EQ(scene.objects[0].field, folder / "a.vdb") << "relative to the scene's folder";
    EXPECT_EQ(scene.objects[0].filter, Filter::Linear);
    EXPECT_EQ(scene.look.model, ShadingModel::Gooch);
    EXPECT_EQ(scene.look.material.specular, 0);
    EXPECT_EQ(scene.look.environment.kind, ::isocast::Environment::Kind::Picture);
    EXPECT_EQ(scene.look.environment.picture.width, 2);
    EXPECT_EQ(scene.look.effects.contours.strength, 1) << "its table stands there";
    EXPECT_EQ(scene.look.effects.contours.thickness_pixels, 3);
    EXPECT_EQ(scene.look.effects.curvature_map.strength, 0.5);
    EXPECT_EQ(scene.look.effects.ridges.strength, 0);
    EXPECT_EQ(scene.look.effects.curvature_colour.range->at(1), 3.5);
    EXPECT_EQ(scene.look.effects.curvature_colour.measure, CurvatureMeasure::ShapeIndex);
    EXPECT_EQ(scene.quality.guarantee_voxels, 0.1);
    EXPECT_EQ(scene.fetch, Fetch::Samples);
    EXPECT_EQ(scene.storage.brick_size, 16);
    EXPECT_EQ(scene.storage.budget_bytes, 2 << 20);
    EXPECT_EQ(scene.output.width, 320);
    EXPECT_TRUE(scene.output.layers->curvature);
    EXPECT_EQ(scene.output.frames->first, 3);
    EXPECT_EQ(scene.output.frames->count(), 5);
}

TEST_F(SceneFiles, UnknownKeysGetThePlaceAndTheKnownOnes) {
    expect_refused("[camera]\nfov = 20\n  zoom = 2\n", "3:3",
                   {"'camera.zoom'", "eye, target, direction, up, fov, height"});
    expect_refused("[effects.contour]\n", "1:10",
                   {"'effects.contour'", "contours", "outlines", "flow"});
    expect_refused("[effects.contours]\nwidth = 2\n", "2:1",
                   {"'effects.contours.width'", "thickness_pixels"});
    expect_refused("colour = 2\n", "1:1", {"'colour'", "camera", "light", "object", "effects"});
    expect_refused("[[light]]\n[[light]]\nshadows = true\n", "3:1",
                   {"'light.1.shadows'", "shadow, strength, size"});
}

TEST_F(SceneFiles, WrongTypesGetThePlaceAndTheRightOne) {
    expect_refused("[camera]\nfov = \"wide\"\n", "2:7", {"camera.fov", "a number", "'wide'"});
    expect_refused("[camera]\nfov = 180\n", "2:7", {"above 0 and below 180", "180"});
    expect_refused("[camera]\neye = [1, 2]\n", "2:7", {"[x, y, z]", "2 numbers"});
    expect_refused("[camera]\ndirection = [0, 0, 0]\n", "2:13", {"zero"});
    expect_refused("[shading]\ncolour = [0.1, -1, 0]\n", "2:10", {"#rrggbb"});
    expect_refused("[shading]\ncolour = \"#12345g\"\n", "2:10", {"'#12345g'"});
    expect_refused("[shading]\nshow_environment = 1\n", "2:20", {"true or false"});
    expect_refused("[shading]\nambient = nan\n", "2:11", {"a number"});
    expect_refused("[output]\ntile = 2.5\n", "2:8", {"an integer", "2.5"});
    expect_refused("[output]\nsamples = 3\n", "2:11", {"1, 2, 4, 8, 16, 32, 64"});
    expect_refused("[output]\nsize = [1, [2]]\n", "2:8", {"list"});
    expect_refused("light = 3\n", "1:9", {"[[light]]"});
    expect_refused("[light]\n", "1:1", {"[[light]]"});
    expect_refused("camera = 3\n", "1:10", {"[camera]"});
    expect_refused("[effects]\nflow = 1\n", "2:8", {"[effects.flow]"});
    expect_refused("[[object]]\nfield = \"mesh:knot\"\n", "2:9", {"mesh, not a field"});
}

TEST_F(SceneFiles, WrongNamesGetThePlaceAndTheKnownOnes) {
    expect_refused("[shading]\nmodel = \"phong\"\n", "2:9",
                   {"'phong'", "blinn-phong, gooch, flat"});
    expect_refused("[[light]]\nshadow = \"blurred\"\n", "2:10", {"none, hard, soft"});
    expect_refused("[output]\naov = \"P,Q\"\n", "2:7", {"'Q'", "P, N, curvature"});
    expect_refused("[quality]\nbrick_size = 9\n", "2:14", {"'9'", "8, 16, 32, none"});
}

TEST_F(SceneFiles, FilesThatCannotBeUsedGetThePlace) {
    expect_refused("[[object]]\nfield = \"nowhere.vdb\"\n", "2:9", {"nowhere.vdb", "no such file"});
    expect_refused("[shading]\nenvironment = \"nowhere.exr\"\n", "2:15",
                   {"nowhere.exr", "no such file"});
    expect_refused("[shading]\nenvironment = \"forest\"\n", "2:15", {"forest", "no such file"});
    write_text(folder / "text.exr", "not a picture");
    expect_refused("[shading]\nenvironment = \"text.exr\"\n", "2:15", {"text.exr"});
    write_text(folder / "text.png", "not a picture");
    expect_refused("[effects.curvature_map]\npicture = \"text.png\"\n", "2:11", {"text.png"});
    write_text(folder / "text.jpg", "not a picture");
    expect_refused("[shading]\nenvironment = \"text.jpg\"\n", "2:15", {".png, .exr"});
    expect_refused("[[object]]\nseries = \"field.vdb\"\n", "2:10", {"#"});
    expect_refused("[[object]]\nseries = \"mesh_##.obj\"\n", "2:10", {"field files", ".vdb"});
}

TEST_F(SceneFiles, SyntaxErrorsGetThePlace) {
    expect_refused("[camera]\nfov = = 2\n", "2:7", {});
    expect_refused("[camera]\nfov = 2\nfov = 3\n", "3:7", {"fov"});
}

TEST_F(SceneFiles, CyclesAndWrongReferencesGetThePlace) {
    const std::string two = "[[object]]\nname = \"a\"\nfield = \"a.vdb\"\n"
                            "[[object]]\nname = \"b\"\nmesh = \"a.obj\"\n";
    EXPECT_NO_THROW(check_scene(read(two + "[[object]]\ncsg = \"union\"\nof = [\"a\", \"b\"]\n")));
    expect_refused("[[object]]\nname = \"a\"\ncsg = \"union\"\nof = [\"b\", \"c\"]\n"
                   "[[object]]\nname = \"b\"\nfield = \"a.vdb\"\n"
                   "[[object]]\nname = \"c\"\nmorph = [\"b\", \"a\"]\n",
                   "10:9", {"a -> c -> a"});
    expect_refused("[[object]]\nname = \"a\"\ncsg = \"union\"\nof = [\"a\", \"a\"]\n", "4:6",
                   {"a -> a"});
    expect_refused(two + "[[object]]\ncsg = \"union\"\nof = [\"a\", \"d\"]\n", "9:6",
                   {"'d'", "a, b"});
    expect_refused(two + "[[object]]\ncsg = \"union\"\nof = [\"a\"]\n", "9:6", {"two"});
    expect_refused(two + "[[object]]\nname = \"a\"\nfield = \"a.vdb\"\n", "8:8", {"another 'a'"});
    expect_refused(two + "[[object]]\nmorph = [\"a\"]\n", "8:9", {"two"});
    expect_refused(two + "[[object]]\nname = \"c\"\n", "7:1", {"field, mesh, csg, morph", "none"});
    expect_refused("[[object]]\nfield = \"a.vdb\"\nmesh = \"a.obj\"\n", "1:1", {"2"});
    expect_refused("[[object]]\nfield = \"a.vdb\"\nresolution = 8\n", "3:14", {"meshes"});
    EXPECT_TRUE(message_of<InputError>([&] {
                    check_scene(read("[camera]\nfov = 20\n"));
                }).ends_with("scene.toml: object: there is none"));
}

TEST_F(SceneFiles, ObjectsThatCannotBeDrawnTogetherGetThePlace) {
    const std::string two = "[[object]]\nname = \"a\"\nfield = \"a.vdb\"\n"
                            "[[object]]\nname = \"b\"\nmesh = \"a.obj\"\n";
    const std::string csg =
        two + "[[object]]\nname = \"c\"\ncsg = \"union\"\nof = [\"a\", \"b\"]\n";
    expect_refused(csg + "[[object]]\nmorph = [\"a\", \"c\"]\n", "12:9", {"'c' is a csg"});
    expect_refused(csg + "iso = 2\n", "11:7", {"those that it combines"});
    expect_refused(csg + "filter = \"exact\"\n", "11:10", {"those that it combines"});
    expect_refused(csg + "[output]\nframes = 2\n[[animate]]\nkey = \"object.2.iso\"\n", "7:1",
                   {"object.2.iso", "those that it combines"});
    expect_refused(two + "[quality]\nrate = 2\n", "8:8", {"certified steps"});
    expect_refused(two + "[quality]\ntraversal = \"walk\"\n", "8:13", {"lists"});
    std::string many;
    for (int i = 0; i < max_object_count; ++i) many += "[[object]]\nfield = \"a.vdb\"\n";
    EXPECT_NO_THROW(check_scene(read(many)));
    expect_refused(many + "[[object]]\nfield = \"a.vdb\"\n", "17:1", {"9 fields", "8 at most"});
}

TEST_F(SceneFiles, TimesWithoutFilesGetThePlace) {
    for (const char* name : {"f_02.vdb", "f_04.vdb"}) write_text(folder / name, "");
    const std::string series = "[[object]]\nseries = \"f_##.vdb\"\n";
    for (const char* time : {"", "time = 2\n", "time = 3.5\n", "time = 4\n"})
        EXPECT_NO_THROW(check_scene(read(series + time))) << time;
    expect_refused(series + "time = 4.5\n", "3:8", {"object.0.time", "time 4.5", "2 ... 4"});
    expect_refused("[[object]]\nseries = \"g_##.vdb\"\n", "2:10", {"no such files"});
    expect_refused("[[object]]\nfield = \"a.vdb\"\ntime = 2\n", "3:8", {"only a series"});
    // Of a sequence the last time is told before the first is drawn.
    const std::string frames = "[output]\nframes = 3\n[[animate]]\nkey = \"object.time\"\n";
    EXPECT_NO_THROW(check_scene(read(series + frames + "from = 2\nto = 4\n")));
    expect_refused(series + frames + "from = 2\nto = 5\n", "1:1", {"object.0.time", "time 5"});
}

TEST_F(SceneFiles, KeysThatExcludeEachOtherGetThePlace) {
    const std::string object = "[[object]]\nfield = \"a.vdb\"\n";
    expect_refused(object + "[camera]\neye = [1,2,3]\ndirection = [1,2,3]\n", "5:13", {"exclude"});
    expect_refused(object + "[camera]\ntarget = [1,2,3]\n", "4:10", {"needs eye"});
    expect_refused(object + "[camera]\nfov = 20\nheight = 2\n", "5:10", {"exclude"});
    expect_refused(object + "[camera]\nturntable = 360\n", "4:13", {"output.frames"});
    expect_refused(object + "[[light]]\nshadow = \"hard\"\n[[light]]\nshadow = \"soft\"\n", "6:10",
                   {"one light"});
    expect_refused(object + "[output]\ntransparent = true\n[shading]\nshow_environment = true\n",
                   "4:15", {"environment"});
    expect_refused(object + "[output]\nframes = 3\n[[animate]]\nkey = \"object.0.tt\"\n", "6:7",
                   {"object.0.tt", "known"});
    expect_refused(object + "[output]\nframes = 3\n[[animate]]\nkey = \"object.0.name\"\n", "6:7",
                   {"no number"});
    expect_refused(object + "[output]\nframes = 3\n[[animate]]\nkey = \"object.1.t\"\n", "6:7",
                   {"there are 1"});
    expect_refused(
        object + "[output]\nframes = 3\n[[animate]]\nkey = \"effects.flow.strength\"\nto = 2\n",
        "6:7", {"between 0 and 1"});
    expect_refused(object + "[output]\nframes = 3\n[[animate]]\nkey = \"output.tile\"\n", "6:7",
                   {"same in all frames"});
    expect_refused(object +
                       "[output]\nframes = 3\n[[camera.key]]\ntime = 1\n[[camera.key]]\ntime = 1\n",
                   "8:8", {"order"});
}

TEST_F(SceneFiles, AllProblemsAreInOneMessage) {
    const std::string message = message_of<InputError>(
        [&] { read("[camera]\nfov = 0\nzoom = 2\n[[light]]\nshadow = 1\n[nothing]\n"); });
    EXPECT_EQ(std::ranges::count(message, '\n'), 3) << message;
    for (const char* place : {":2:7: ", ":3:1: ", ":5:10: ", ":6:2: "})
        EXPECT_NE(message.find(place), std::string::npos) << place << " in " << message;
}

TEST_F(SceneFiles, AreRefusedByTheProgramWithTheirPlace) {
    write_text(folder / "scene.toml", "[[object]]\nfield = \"field:torus@16\"\nname = 3\n");
    const Outcome outcome = isocast({"render", folder / "scene.toml", "-o", folder / "out.png"});
    EXPECT_EQ(outcome.code, 3);
    EXPECT_NE(outcome.err.find("scene.toml:3:8: object.0.name"), std::string::npos) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "out.png"));
}

TEST_F(SceneFiles, DrawWhatTheSameOptionsDraw) {
    write_text(folder / "scene.toml", R"([[object]]
field = "field:torus@24"
iso = 0.05
colour = [0.5, 0.25, 0.75]
[camera]
direction = [1, 2, 3]
fov = 25
[shading]
specular = 0.5
[quality]
filter = "bspline"
[output]
size = "48x32"
)");
    const auto draw = [&](std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), "render");
        arguments.insert(arguments.end(), {"--backend", "osmesa", "-o", folder / "out.png"});
        checked_output(isocast(arguments));
        return contents_of(folder / "out.png");
    };
    const std::string of_scene = draw({folder / "scene.toml"});
    EXPECT_EQ(of_scene,
              draw({"field:torus@24", "--iso", "0.05", "--camera", "direction=1,2,3;fov=25",
                    "--filter", "bspline", "--size", "48x32", "--set", "shading.specular=0.5",
                    "--set", "object.colour=[0.5, 0.25, 0.75]"}));
    // Options override the scene.
    const std::string other = draw({folder / "scene.toml", "--iso", "0.1", "--filter", "exact"});
    EXPECT_NE(other, of_scene);
    EXPECT_EQ(other, draw({"field:torus@24", "--iso", "0.1", "--camera", "direction=1,2,3;fov=25",
                           "--filter", "exact", "--size", "48x32", "--set", "shading.specular=0.5",
                           "--set", "shading.colour=[0.5, 0.25, 0.75]"}));
}

} // namespace
} // namespace isocast::test
