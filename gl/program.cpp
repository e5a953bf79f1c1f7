// SPDX-License-Identifier: MPL-2.0
#include "gl/program.h"

#include "gl/errors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glad/gl.h>

#include <algorithm>
#include <fstream>
#include <optional>
#include <sstream>

namespace isocast::gl {

namespace {

std::string read_shader(const std::vector<std::filesystem::path>& roots, const std::string& name) {
    for (const auto& root : roots)
        if (std::ifstream file(root / name); file) {
            std::ostringstream text;
            text << file.rdbuf();
            return text.str();
        }
    std::string sought;
    for (const auto& root : roots) sought += (sought.empty() ? "" : ", ") + root.string();
    throw GlError(fmt::format("no shader file '{}' in {}", name, sought));
}

std::optional<std::string> included_file(std::string_view line) {
    constexpr std::string_view directive = "#include \"";
    if (!line.starts_with(directive)) return std::nullopt;
    line.remove_prefix(directive.size());
    const auto end = line.find('"');
    if (end == std::string_view::npos) return std::nullopt; // the compiler will complain
    return std::string(line.substr(0, end));
}

struct Expander {
    const std::vector<std::filesystem::path>& roots;
    ExpandedSource out;

    void append(const std::string& name, const std::map<std::string, std::string>* defines) {
        const auto source = out.files.size();
        out.files.push_back(name);
        std::istringstream lines(read_shader(roots, name));
        if (source > 0) out.text += fmt::format("#line 1 {}\n", source);
        std::string line;
        for (int number = 1; std::getline(lines, line); ++number) {
            if (const auto file = included_file(line)) {
                if (std::ranges::find(out.files, *file) == out.files.end()) append(*file, nullptr);
                out.text += fmt::format("#line {} {}\n", number + 1, source);
                continue;
            }
            out.text += line + '\n';
            // Defines come right after #version, which must be a file's first directive.
            if (defines && line.starts_with("#version")) {
                for (const auto& [key, value] : *defines)
                    out.text += fmt::format("#define {} {}\n", key, value);
                out.text += fmt::format("#line {} {}\n", number + 1, source);
            }
        }
    }
};

GLenum stage_of(const std::string& entry_point) {
    const auto extension = std::filesystem::path(entry_point).extension();
    if (extension == ".vert") return GL_VERTEX_SHADER;
    if (extension == ".frag") return GL_FRAGMENT_SHADER;
    if (extension == ".geom") return GL_GEOMETRY_SHADER;
    if (extension == ".comp") return GL_COMPUTE_SHADER;
    throw GlError(
        fmt::format("'{}' is no entry point (known: .vert .frag .geom .comp)", entry_point));
}

std::string describe(const ProgramKey& key) {
    std::string text = fmt::format("{}", fmt::join(key.entry_points, " + "));
    for (const auto& [name, value] : key.defines) text += fmt::format(" {}={}", name, value);
    return text;
}

/// A shader that is deleted when the program has been linked.
struct Shader {
    unsigned id;
    explicit Shader(GLenum stage) : id(glCreateShader(stage)) {}
    ~Shader() { glDeleteShader(id); }
    Shader(const Shader&) = delete;
    Shader& operator=(const Shader&) = delete;
};

} // namespace

void Program::use() const {
    glUseProgram(handle_.id());
}

bool Program::has(const char* uniform) const {
    return glGetUniformLocation(handle_.id(), uniform) >= 0;
}

int Program::location(const char* uniform) const {
    const int location = glGetUniformLocation(handle_.id(), uniform);
    if (location < 0) throw GlError(fmt::format("program {} has no uniform {}", name_, uniform));
    return location;
}

void Program::set(const char* uniform, int value) const {
    glProgramUniform1i(handle_.id(), location(uniform), value);
}
void Program::set(const char* uniform, float value) const {
    glProgramUniform1f(handle_.id(), location(uniform), value);
}
void Program::set(const char* uniform, const Eigen::Vector2f& value) const {
    glProgramUniform2fv(handle_.id(), location(uniform), 1, value.data());
}
void Program::set(const char* uniform, const Eigen::Vector2i& value) const {
    glProgramUniform2iv(handle_.id(), location(uniform), 1, value.data());
}
void Program::set(const char* uniform, const Eigen::Vector3f& value) const {
    glProgramUniform3fv(handle_.id(), location(uniform), 1, value.data());
}
void Program::set(const char* uniform, const Eigen::Vector4f& value) const {
    glProgramUniform4fv(handle_.id(), location(uniform), 1, value.data());
}
void Program::set(const char* uniform, const Eigen::Vector3i& value) const {
    glProgramUniform3iv(handle_.id(), location(uniform), 1, value.data());
}
void Program::set(const char* uniform, const Eigen::Vector4i& value) const {
    glProgramUniform4iv(handle_.id(), location(uniform), 1, value.data());
}
void Program::set(const char* uniform, const Eigen::Matrix3f& value) const {
    glProgramUniformMatrix3fv(handle_.id(), location(uniform), 1, GL_FALSE, value.data());
}
void Program::set(const char* uniform, const Eigen::Matrix4f& value) const {
    glProgramUniformMatrix4fv(handle_.id(), location(uniform), 1, GL_FALSE, value.data());
}

ShaderLibrary::ShaderLibrary(std::vector<std::filesystem::path> roots) : roots_(std::move(roots)) {
    for (const auto& root : roots_)
        if (!std::filesystem::is_directory(root))
            throw GlError(fmt::format("no folder of shaders at {}", root.string()));
}

ExpandedSource ShaderLibrary::expand(const std::string& entry_point,
                                     const std::map<std::string, std::string>& defines) const {
    Expander expander{roots_, {}};
    expander.append(entry_point, &defines);
    return std::move(expander.out);
}

std::string name_files_in_log(const std::string& log, const std::vector<std::string>& files) {
    std::istringstream lines(log);
    std::string out;
    for (std::string line; std::getline(lines, line);) {
        // "SOURCE:LINE(COLUMN):" or "SOURCE(LINE) :"
        std::size_t source = 0;
        int number = 0;
        char separator = 0;
        std::istringstream position(line);
        if (position >> source >> separator >> number && source < files.size() &&
            (separator == ':' || separator == '(')) {
            const auto colon = line.find(':', static_cast<std::size_t>(position.tellg()));
            if (colon != std::string::npos)
                line = fmt::format("shaders/{}:{}{}", files[source], number, line.substr(colon));
        }
        out += line + '\n';
    }
    return out;
}

const Program& ShaderLibrary::program(const ProgramKey& key) {
    if (const auto found = programs_.find(key); found != programs_.end()) return found->second;

    Handle<delete_program> handle(glCreateProgram());
    for (const std::string& entry_point : key.entry_points) {
        const ExpandedSource source = expand(entry_point, key.defines);
        const Shader shader(stage_of(entry_point));
        const char* text = source.text.c_str();
        glShaderSource(shader.id, 1, &text, nullptr);
        glCompileShader(shader.id);
        GLint compiled = GL_FALSE;
        glGetShaderiv(shader.id, GL_COMPILE_STATUS, &compiled);
        if (!compiled) {
            GLint length = 0;
            glGetShaderiv(shader.id, GL_INFO_LOG_LENGTH, &length);
            std::string log(static_cast<std::size_t>(std::max(length, 1)), '\0');
            glGetShaderInfoLog(shader.id, length, nullptr, log.data());
            log.resize(log.find('\0'));
            throw GlError(fmt::format("shader {} does not compile:\n{}", describe(key),
                                      name_files_in_log(log, source.files)));
        }
        glAttachShader(handle.id(), shader.id);
    }
    glLinkProgram(handle.id());
    GLint linked = GL_FALSE;
    glGetProgramiv(handle.id(), GL_LINK_STATUS, &linked);
    if (!linked) {
        GLint length = 0;
        glGetProgramiv(handle.id(), GL_INFO_LOG_LENGTH, &length);
        std::string log(static_cast<std::size_t>(std::max(length, 1)), '\0');
        glGetProgramInfoLog(handle.id(), length, nullptr, log.data());
        log.resize(log.find('\0'));
        throw GlError(fmt::format("program {} does not link:\n{}", describe(key), log));
    }
    const std::string name = describe(key);
    constexpr std::size_t longest = 255; // that every GL takes
    glObjectLabel(GL_PROGRAM, handle.id(), static_cast<GLsizei>(std::min(name.size(), longest)),
                  name.c_str());
    return programs_.emplace(key, Program(std::move(handle), name)).first->second;
}

} // namespace isocast::gl
