// The options of `isocast render`.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/scene_file.h"
#include "gl/context.h"

#include <functional>

namespace CLI {
class App;
}

namespace isocast {

struct RenderCommand {
    std::vector<std::string> inputs;
    std::filesystem::path output;
    std::vector<std::string> settings;                      // --set
    std::vector<std::function<void(SceneFile&)>> overrides; // other options that stand for keys
    std::optional<int> resolution;                          // of meshes
    std::optional<double> max_error_world;                  // chooses filter and resolution
    gl::Backend backend = gl::Backend::Auto;
    bool reference = false; // in double, without OpenGL
    int repeat = 1;
    bool explain = false;
    std::size_t threads = 0;
    bool json = false;

    /// All that is drawn, for people.
    std::string input() const;
};

/// Adds the verb; its options go to `command`, which must outlive it.
CLI::App* add_render_options(CLI::App& program, RenderCommand& command);

/// The scene that a command asks for: that of its file, or of fields and meshes, then --set, then
/// the other options.
/// throws  UsageError, InputError
SceneFile scene_of(const RenderCommand& command);

} // namespace isocast
