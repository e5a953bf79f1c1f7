// Every shader compiles, and every shader file is used.
// SPDX-License-Identifier: MPL-2.0
#include "apps/view/canvas.h"
#include "distance_transform/gl/scan_on_gpu.h"
#include "gl/context.h"
#include "raycaster/passes.h"
#include "stability/shader_probe.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <set>

namespace isocast {
namespace {

const std::filesystem::path shader_folder = std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders";

/// Of the raycaster, the distance transform, the stability suite and the viewer.
std::vector<gl::ProgramKey> every_program() {
    std::vector<gl::ProgramKey> keys = all_programs();
    const std::vector<gl::ProgramKey> of_scan = scan_programs();
    keys.insert(keys.end(), of_scan.begin(), of_scan.end());
    const std::vector<gl::ProgramKey> of_probes = stability::probe_programs();
    keys.insert(keys.end(), of_probes.begin(), of_probes.end());
    const std::vector<gl::ProgramKey> of_canvas = view::canvas_programs();
    keys.insert(keys.end(), of_canvas.begin(), of_canvas.end());
    return keys;
}

class Shaders : public testing::TestWithParam<gl::Backend> {};

TEST_P(Shaders, AllCompile) {
    const auto context = gl::make_context({.backend = GetParam()});
    gl::ShaderLibrary shaders({shader_folder});
    for (const gl::ProgramKey& key : every_program()) EXPECT_NO_THROW(shaders.program(key));
    EXPECT_EQ(shaders.compiled_program_count(), int(every_program().size()));
    EXPECT_GT(shaders.compiled_program_count(), 0);
}

INSTANTIATE_TEST_SUITE_P(Backends, Shaders, testing::Values(gl::Backend::Egl, gl::Backend::Osmesa),
                         [](const auto& test) {
                             return test.param == gl::Backend::Egl ? "Egl" : "Osmesa";
                         });

TEST(ShaderFiles, EveryOneIsPartOfAProgram) {
    const gl::ShaderLibrary shaders({shader_folder});
    std::set<std::string> used;
    for (const gl::ProgramKey& key : every_program())
        for (const std::string& entry_point : key.entry_points) {
            const auto files = shaders.expand(entry_point, key.defines).files;
            used.insert(files.begin(), files.end());
        }
    std::set<std::string> present;
    for (const auto& file : std::filesystem::recursive_directory_iterator(shader_folder))
        if (file.is_regular_file() && file.path().extension() != ".md")
            present.insert(std::filesystem::relative(file.path(), shader_folder).string());
    EXPECT_EQ(present, used);
}

TEST(ShaderFiles, AskOnePlaceWhereInThePictureAPixelIs) {
    // gl_FragCoord counts from the corner of the part that is drawn, and knows no shift: alone it
    // is for texels. Else pictures in tiles, or of many samples a pixel, are wrong.
    for (const char* folder : {"raycast", "shading", "common"})
        for (const auto& file :
             std::filesystem::recursive_directory_iterator(shader_folder / folder)) {
            if (!file.is_regular_file() || file.path().filename() == "pixel.glsl") continue;
            std::ifstream stream(file.path());
            for (std::string line; std::getline(stream, line);) {
                line = line.substr(0, line.find("//"));
                for (auto at = line.find("gl_FragCoord"); at != std::string::npos;
                     at = line.find("gl_FragCoord", at + 1))
                    EXPECT_EQ(line.substr(at - std::min<std::size_t>(at, 6), 6), "ivec2(")
                        << file.path() << ": " << line
                        << "\nuse picture_pixel() of common/pixel.glsl";
            }
        }
}

} // namespace
} // namespace isocast
