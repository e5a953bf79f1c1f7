// What the cases draw with: a renderer for each backend, made when the first case asks for it.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/renderer.h"

#include <filesystem>
#include <map>
#include <stdexcept>

namespace isocast::stability {

/// A case that cannot run here, and why.
struct Skip : std::runtime_error {
    using std::runtime_error::runtime_error;
};

struct Device {
    Device(gl::Backend backend, const std::filesystem::path& shader_folder)
        : context(gl::make_context({.backend = backend})), shaders({shader_folder}),
          renderer(*context, shader_folder) {}
    std::unique_ptr<gl::Context> context;
    gl::ShaderLibrary shaders;
    Renderer renderer;
};

class Devices {
public:
    explicit Devices(std::filesystem::path shader_folder)
        : shader_folder_(std::move(shader_folder)) {}
    ~Devices();
    Devices(const Devices&) = delete;
    Devices& operator=(const Devices&) = delete;

    /// Its context is current until the next call.
    /// throws  Skip where there is no such backend
    Device& at(gl::Backend backend);
    /// Those that were made so far.
    std::vector<gl::DriverInfo> drivers() const;

private:
    std::filesystem::path shader_folder_;
    std::map<gl::Backend, std::unique_ptr<Device>> devices_;
    std::map<gl::Backend, std::string> missing_; // and why
};

} // namespace isocast::stability
