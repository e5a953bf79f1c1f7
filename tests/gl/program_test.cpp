// Shader files: #include, #line, defines, and errors that name file and line.
// SPDX-License-Identifier: MPL-2.0
#include "gl/program.h"

#include "gl/errors.h"
#include "test_context.h"

#include <gtest/gtest.h>

#include <fstream>

namespace isocast::gl {
namespace {

/// A folder of shaders that is removed with its owner.
struct ShaderFolder {
    std::filesystem::path path = std::filesystem::path(testing::TempDir()) /
                                 (std::string("isocast_shaders_") +
                                  testing::UnitTest::GetInstance()->current_test_info()->name());

    ShaderFolder() { std::filesystem::create_directories(path / "lib"); }
    ~ShaderFolder() { std::filesystem::remove_all(path); }
    void write(const std::string& name, const std::string& text) const {
        std::ofstream(path / name) << text;
    }
};

TEST(ShaderLibrary, IncludesEachFileOnceAndKeepsLineNumbers) {
    const ShaderFolder folder;
    folder.write("lib/a.glsl", "#include \"lib/b.glsl\"\nfloat a() { return b(); }\n");
    folder.write("lib/b.glsl", "float b() { return 1.0; }\n");
    folder.write("main.frag", "#version 450 core\n"
                              "#include \"lib/a.glsl\"\n"
                              "#include \"lib/b.glsl\"\n"
                              "void main() {}\n");
    const ExpandedSource source = ShaderLibrary({folder.path}).expand("main.frag", {{"N", "3"}});
    EXPECT_EQ(source.files, (std::vector<std::string>{"main.frag", "lib/a.glsl", "lib/b.glsl"}));
    EXPECT_EQ(source.text, "#version 450 core\n"
                           "#define N 3\n"
                           "#line 2 0\n"
                           "#line 1 1\n"
                           "#line 1 2\n"
                           "float b() { return 1.0; }\n"
                           "#line 2 1\n"
                           "float a() { return b(); }\n"
                           "#line 3 0\n"
                           "#line 4 0\n"
                           "void main() {}\n");
}

TEST(ShaderLibrary, NamesFilesInLogsOfSeveralDrivers) {
    const std::vector<std::string> files = {"main.frag", "lib/a.glsl"};
    EXPECT_EQ(name_files_in_log("1:42(3): error: no\n", files),
              "shaders/lib/a.glsl:42: error: no\n");
    EXPECT_EQ(name_files_in_log("0(7) : error C1: no\n", files),
              "shaders/main.frag:7: error C1: no\n");
    EXPECT_EQ(name_files_in_log("plain text\n", files), "plain text\n");
}

TEST(ShaderLibrary, MissingFileIsNamed) {
    const ShaderFolder folder;
    folder.write("main.frag", "#version 450 core\n#include \"lib/absent.glsl\"\n");
    try {
        ShaderLibrary({folder.path}).expand("main.frag", {});
        FAIL() << "no error";
    } catch (const GlError& error) {
        EXPECT_NE(std::string(error.what()).find("lib/absent.glsl"), std::string::npos);
    }
}

struct Programs : testing::Test {
    std::unique_ptr<Context> context = test::make_context();
    ShaderFolder folder;
    void SetUp() override {
        folder.write("full.vert", "#version 450 core\nvoid main() { gl_Position = vec4(0.0); }\n");
    }
};

TEST_F(Programs, CompileErrorNamesTheIncludedFileAndItsLine) {
    folder.write("lib/bad.glsl", "// one\n// two\nfloat f() { return undefined_name; }\n");
    folder.write("bad.frag", "#version 450 core\n#include \"lib/bad.glsl\"\n"
                             "out vec4 o; void main() { o = vec4(f()); }\n");
    ShaderLibrary library({folder.path});
    try {
        library.program({{"full.vert", "bad.frag"}, {}});
        FAIL() << "no error";
    } catch (const GlError& error) {
        EXPECT_NE(std::string(error.what()).find("shaders/lib/bad.glsl:3:"), std::string::npos)
            << error.what();
    }
}

TEST_F(Programs, AreCompiledOnceForEachSetOfDefines) {
    folder.write("ok.frag", "#version 450 core\nuniform float u_a;\nout vec4 o;\n"
                            "void main() { o = vec4(u_a + float(N)); }\n");
    ShaderLibrary library({folder.path});
    const ProgramKey one{{"full.vert", "ok.frag"}, {{"N", "1"}}};
    const ProgramKey two{{"full.vert", "ok.frag"}, {{"N", "2"}}};
    EXPECT_EQ(library.compiled_program_count(), 0);
    const Program& first = library.program(one);
    EXPECT_EQ(&library.program(one), &first);
    EXPECT_NE(&library.program(two), &first);
    EXPECT_EQ(library.compiled_program_count(), 2);
    EXPECT_NO_THROW(first.set("u_a", 1.0f));
    EXPECT_THROW(first.set("u_b", 1.0f), GlError) << "a mistyped uniform must not go unnoticed";
}

} // namespace
} // namespace isocast::gl
