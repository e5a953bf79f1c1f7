// The verbs of the program. Each declares its options and gives the function that runs it.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

namespace CLI {
class App;
}

namespace isocast {

class Console;

struct Verb {
    CLI::App* app;
    /// throws  UsageError, InputError, ResourceError, Interrupted, gl::GlError
    std::function<void(Console&)> run;
};

/// meshes -> fields. Shaders and data, here and below, are in the first of the folders that exists.
Verb convert_verb(CLI::App& program, std::vector<std::filesystem::path> shader_folders,
                  std::vector<std::filesystem::path> data_folders);
/// field or mesh -> picture
Verb render_verb(CLI::App& program, std::vector<std::filesystem::path> shader_folders,
                 std::vector<std::filesystem::path> data_folders);
/// the same in a window
Verb view_verb(CLI::App& program, std::vector<std::filesystem::path> shader_folders,
               std::vector<std::filesystem::path> data_folders);
/// what a mesh or field file holds
Verb info_verb(CLI::App& program);
/// what accuracy costs: errors and times at many settings
Verb accuracy_verb(CLI::App& program, std::vector<std::filesystem::path> shader_folders,
                   std::vector<std::filesystem::path> data_folders);
/// built-in mesh or field -> file
Verb sample_verb(CLI::App& program);
/// checks that a user can run
Verb selftest_verb(CLI::App& program, std::vector<std::filesystem::path> shader_folders);

} // namespace isocast
