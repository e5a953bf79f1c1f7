// `isocast render --reference`, and that the same input gives the same bytes.
// SPDX-License-Identifier: MPL-2.0
#include "../volume/temporary_folder.h"
#include "exr_file.h"
#include "program.h"

#include <ImfMatrixAttribute.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>

namespace isocast::test {
namespace {

using Json = nlohmann::json;
using Words = std::vector<std::string>;

Words operator+(Words a, const Words& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

const Words small{"--size", "48x32"};
/// Mesa's software drivers end the program when they are asked for one that there is not.
const Environment no_opengl{{"GALLIUM_DRIVER", "nothing"}};

TEST(Reference, DrawsWhereThereIsNoOpenGl) {
    const TemporaryFolder folder;
    const Json json = Json::parse(checked_output(isocast(
        Words{"render", "field:torus@24", "-o", folder / "a.png", "--reference", "--json"} + small,
        no_opengl)));
    EXPECT_NE(
        isocast(Words{"render", "field:torus@24", "-o", folder / "b.png", "--backend", "osmesa"} +
                    small,
                no_opengl)
            .code,
        0);
    EXPECT_TRUE(json["gl"].is_null());
    ASSERT_EQ(json["passes"].size(), 1U);
    EXPECT_EQ(json["passes"][0]["name"], "reference");
    EXPECT_EQ(folder.entry_count(), 1);
}

TEST(Reference, ShowsWhatOpenGlShowsFromTheSameCamera) {
    const TemporaryFolder folder;
    const std::vector<Words> inputs{
        {"field:gyroid@24"},
        {"mesh:knot", "--resolution", "32"},
        {"field:torus@24", "field:sphere@20", "--filter", "bspline"},
        {"field:torus@24", "--set", "cut.plane.0.normal=[1,2,2]", "--set", "cut.plane.0.offset=0.6",
         "--set", "cut.plane.1.normal=[-1,0,0.2]", "--set", "cut.plane.1.offset=0.7"}};
    for (const Words& input : inputs) {
        const Words render = Words{"render"} + input + small + Words{"--aov", "P,N,curvature,id"};
        checked_output(isocast(render + Words{"-o", folder / "gl.exr", "--backend", "osmesa"}));
        checked_output(isocast(render + Words{"-o", folder / "reference.exr", "--reference"}));
        const ExrFile gl(folder / "gl.exr");
        const ExrFile reference(folder / "reference.exr");
        ASSERT_EQ(gl.channels.size(), reference.channels.size());
        const auto matrix = [](const ExrFile& file) {
            return file.file.header().typedAttribute<Imf::M44fAttribute>("worldToCamera").value();
        };
        EXPECT_EQ(matrix(gl), matrix(reference));
        int hits = 0;
        int others = 0;
        const auto count = static_cast<std::size_t>(gl.width * gl.height);
        for (std::size_t i = 0; i < count; ++i) {
            const float id = reference.channels.at("id")[i];
            if (gl.channels.at("id")[i] != id) {
                ++others;
                continue;
            }
            if (id == 0) continue;
            ++hits;
            // As docs/raycasting.md states; voxels are 1/13 at most, so that 3e-5 of one and the
            // roundings of places of 3 are below 5e-6.
            const Vec3d normal = reference.vector("N", i);
            EXPECT_LT(std::abs((gl.vector("P", i) - reference.vector("P", i)).dot(normal)), 5e-6);
            EXPECT_LT((gl.vector("N", i) - normal).norm(), 2e-4);
            for (const char* channel : {"R", "G", "B"}) // linear halves
                EXPECT_NEAR(gl.channels.at(channel)[i], reference.channels.at(channel)[i], 0.004);
        }
        EXPECT_GT(hits, 200);
        EXPECT_LE(others, 3) << input[0]; // on silhouettes
    }
}

TEST(Reference, AveragesTheSamplesOfAPixelAndDrawsTilesAndStereoPairs) {
    const TemporaryFolder folder;
    const auto picture = [&](const char* name, const Words& more) {
        checked_output(isocast(
            Words{"render", "field:torus@20", "-o", folder / name, "--reference"} + small + more));
        return contents_of(folder / name);
    };
    const std::string whole = picture("a.png", {"--samples", "4"});
    EXPECT_EQ(whole, picture("b.png", {"--samples", "4", "--tile", "17"}));
    EXPECT_NE(whole, picture("c.png", {}));
    EXPECT_NE(whole, picture("d.png", {"--samples", "4", "--set", "camera.stereo=auto"}));
}

TEST(Reference, RefusesWhatItCannotDraw) {
    const TemporaryFolder folder;
    const auto outcome = [&](const Words& more) {
        return isocast(Words{"render", "field:torus@16", "-o", folder / "a.exr", "--reference"} +
                       small + more);
    };
    for (const auto& [options, code, word] : std::vector<std::tuple<Words, int, const char*>>{
             {{"--set", "light.shadow=soft"}, 3, "shadow"},
             {{"--set", "effects.reflection.strength=1"}, 3, "reflection"},
             {{"--aov", "AO"}, 3, "occlusion"},
             {{"--aov", "steps"}, 3, "steps"},
             {{"--backend", "osmesa"}, 2, "--backend"},
             {{"--explain"}, 2, "--explain"}}) {
        const Outcome refused = outcome(options);
        EXPECT_EQ(refused.code, code) << refused.err;
        EXPECT_NE(refused.err.find(word), std::string::npos) << refused.err;
    }
    EXPECT_EQ(folder.entry_count(), 0);
}

/// What the command writes on one thread and on two, twice each.
std::vector<std::string> written(const Words& command, const std::string& name) {
    std::vector<std::string> files;
    for (const char* threads : {"1", "2", "1", "2"}) {
        const TemporaryFolder folder;
        checked_output(isocast(command + Words{"-o", folder / name, "--threads", threads}));
        std::map<std::string, std::string> all; // a .mhd has its samples beside it
        for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
            all[entry.path().filename()] = contents_of(entry.path());
        std::string& file = files.emplace_back();
        for (const auto& [_, bytes] : all) file += bytes;
    }
    return files;
}

/// A .vdb begins with a random UUID, after its 8 bytes of magic, three numbers of 4 and a flag.
std::string without_uuid(std::string vdb) {
    return vdb.erase(21, 36);
}

TEST(Determinism, FieldFilesHaveTheSameBytes) {
    for (const auto& [command, name] : std::vector<std::pair<Words, std::string>>{
             {{"convert", "mesh:knot", "--resolution", "48"}, "a.vdb"},
             {{"convert", "mesh:knot", "--resolution", "48"}, "a.nrrd"},
             {{"convert", "mesh:torus", "--resolution", "32"}, "a.mhd"},
             {{"convert", "mesh:torus", "--resolution", "32"}, "a.vti"},
             {{"convert", "mesh:seashell", "--method", "octree", "--max-error", "0.01"}, "a.hoct"},
             {{"convert", "mesh:torus", "--method", "points", "--resolution", "32"}, "a.vdb"},
         }) {
        const bool is_vdb = name.ends_with(".vdb");
        std::vector<std::string> files = written(command, name);
        if (is_vdb) {
            EXPECT_NE(files[0], files[2]); // or there is nothing to leave out
            for (std::string& file : files) file = without_uuid(file);
        }
        for (std::size_t i = 1; i < files.size(); ++i)
            EXPECT_EQ(files[i] == files[0], true) << command[0] << ' ' << command[1] << ' ' << name;
    }
}

TEST(Determinism, PicturesHaveTheSameBytes) {
    const Words plain{"render", "mesh:knot", "--resolution", "32"};
    const Words rich{"render", "field:gyroid@24",
                     "--set",  "light.shadow=soft",
                     "--set",  "effects.occlusion.strength=1",
                     "--set",  "effects.curvature_colour.strength=1",
                     "--set",  "effects.outlines.strength=1"};
    const Words backend{"--backend", "osmesa"};
    for (const auto& [command, name] : std::vector<std::pair<Words, std::string>>{
             {plain + backend, "a.png"},
             {plain + backend + Words{"--aov", "P,N,curvature,T,id,steps"}, "a.exr"},
             {plain + Words{"--reference"}, "a.png"},
             {rich + backend, "a.png"}}) {
        const std::vector<std::string> files = written(command + small, name);
        for (std::size_t i = 1; i < files.size(); ++i)
            EXPECT_EQ(files[i] == files[0], true) << command[1] << ' ' << name;
    }
}

} // namespace
} // namespace isocast::test
