// Shader programs from files, with #include, defines and errors that name the file and line.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "gl/objects.h"

#include <Eigen/Core>

#include <compare>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace isocast::gl {

/// Which program: its entry points, relative to the shader folder, and its defines. The stage of
/// each entry point follows from its extension: .vert .frag .geom .comp.
struct ProgramKey {
    std::vector<std::string> entry_points;
    std::map<std::string, std::string> defines;
    auto operator<=>(const ProgramKey&) const = default;
};

/// A linked program.
class Program {
public:
    Program() = default;
    Program(Handle<delete_program> handle, std::string name)
        : handle_(std::move(handle)), name_(std::move(name)) {}

    void use() const;
    bool has(const char* uniform) const;
    /// Sets a uniform. throws GlError if the program has none of that name, so that a mistyped name
    /// cannot silently draw nothing.
    void set(const char* uniform, int value) const;
    void set(const char* uniform, float value) const;
    void set(const char* uniform, const Eigen::Vector2f& value) const;
    void set(const char* uniform, const Eigen::Vector2i& value) const;
    void set(const char* uniform, const Eigen::Vector3f& value) const;
    void set(const char* uniform, const Eigen::Vector4f& value) const;
    void set(const char* uniform, const Eigen::Vector3i& value) const;
    void set(const char* uniform, const Eigen::Vector4i& value) const;
    void set(const char* uniform, const Eigen::Matrix3f& value) const;
    void set(const char* uniform, const Eigen::Matrix4f& value) const;

private:
    int location(const char* uniform) const;

    Handle<delete_program> handle_;
    std::string name_;
};

/// One stage's source after #include and defines, and the file behind each #line source number.
struct ExpandedSource {
    std::string text;
    std::vector<std::string> files;
};

/// The folder of shaders, and the programs made from it so far.
class ShaderLibrary {
public:
    /// roots   folders in which files are sought, in this order
    /// throws  GlError if one of them is no folder
    explicit ShaderLibrary(std::vector<std::filesystem::path> roots);

    /// The program for `key`, compiled on the first call.
    /// throws  GlError that names file and line
    const Program& program(const ProgramKey& key);
    int compiled_program_count() const { return static_cast<int>(programs_.size()); }

    /// Text of an entry point: #include "a/b.glsl" replaced by that file, once each, with #line.
    ExpandedSource expand(const std::string& entry_point,
                          const std::map<std::string, std::string>& defines) const;

private:
    std::vector<std::filesystem::path> roots_;
    std::map<ProgramKey, Program> programs_;
};

/// Replaces the source numbers at the start of each line of a driver's log, as Mesa ("1:42(3):")
/// and NVIDIA ("1(42) :") write them, by "shaders/file:42".
std::string name_files_in_log(const std::string& log, const std::vector<std::string>& files);

} // namespace isocast::gl
