// Reads a mesh file into memory for its format's parser, and writes meshes.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/mesh_files.h"

#include "distance_transform/mesh_parsers.h"
#include "volume/atomic_file.h"
#include "volume/errors.h"
#include "volume/files.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <system_error>

namespace isocast {

namespace {

using Text = fmt::memory_buffer;

void append_obj(Text& out, const Mesh& mesh) {
    for (const Vec3d& p : mesh.vertices_world)
        fmt::format_to(std::back_inserter(out), "v {} {} {}\n", p.x(), p.y(), p.z());
    for (const auto& [a, b, c] : mesh.triangles)
        fmt::format_to(std::back_inserter(out), "f {} {} {}\n", a + 1, b + 1, c + 1);
}

void append_off(Text& out, const Mesh& mesh) {
    fmt::format_to(std::back_inserter(out), "OFF\n{} {} 0\n", mesh.vertices_world.size(),
                   mesh.triangles.size());
    for (const Vec3d& p : mesh.vertices_world)
        fmt::format_to(std::back_inserter(out), "{} {} {}\n", p.x(), p.y(), p.z());
    for (const auto& [a, b, c] : mesh.triangles)
        fmt::format_to(std::back_inserter(out), "3 {} {} {}\n", a, b, c);
}

void append_stl(Text& out, const Mesh& mesh) {
    fmt::format_to(std::back_inserter(out), "solid isocast\n");
    for (const auto& [a, b, c] : mesh.triangles) {
        const std::array corners = {mesh.vertices_world[a], mesh.vertices_world[b],
                                    mesh.vertices_world[c]};
        const Vec3d n = (corners[1] - corners[0]).cross(corners[2] - corners[0]).stableNormalized();
        fmt::format_to(std::back_inserter(out), "facet normal {} {} {}\nouter loop\n", n.x(), n.y(),
                       n.z());
        for (const Vec3d& p : corners)
            fmt::format_to(std::back_inserter(out), "vertex {} {} {}\n", p.x(), p.y(), p.z());
        fmt::format_to(std::back_inserter(out), "endloop\nendfacet\n");
    }
    fmt::format_to(std::back_inserter(out), "endsolid isocast\n");
}

template<class T>
void append_bytes(Text& out, const T& value) {
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), &value, sizeof(T));
    out.append(raw.data(), raw.data() + raw.size());
}

void append_ply(Text& out, const Mesh& mesh) {
    fmt::format_to(std::back_inserter(out),
                   "ply\nformat binary_{}_endian 1.0\nelement vertex {}\nproperty double x\n"
                   "property double y\nproperty double z\nelement face {}\n"
                   "property list uchar int vertex_indices\nend_header\n",
                   std::endian::native == std::endian::little ? "little" : "big",
                   mesh.vertices_world.size(), mesh.triangles.size());
    for (const Vec3d& p : mesh.vertices_world)
        for (const double x : p) append_bytes(out, x);
    for (const std::array<int, 3>& triangle : mesh.triangles) {
        append_bytes(out, std::uint8_t{3});
        for (const int index : triangle) append_bytes(out, index);
    }
}

struct MeshFormat {
    std::string_view extension;
    Mesh (*parse)(std::string_view bytes, std::string_view name);
    void (*append)(Text& out, const Mesh& mesh);
};

constexpr std::array formats = {
    MeshFormat{".obj", parse_obj, append_obj}, MeshFormat{".ply", parse_ply, append_ply},
    MeshFormat{".stl", parse_stl, append_stl}, MeshFormat{".off", parse_off, append_off}};

const MeshFormat* find_format(const std::filesystem::path& path) {
    const std::string extension = lower_case_extension(path);
    const auto found = std::find_if(formats.begin(), formats.end(), [&](const MeshFormat& format) {
        return format.extension == extension;
    });
    return found == formats.end() ? nullptr : &*found;
}

const MeshFormat& format_of(const std::filesystem::path& path) {
    if (const MeshFormat* format = find_format(path)) return *format;
    throw InputError(fmt::format("{}: unknown mesh format '{}' (known: {})", path.string(),
                                 path.extension().string(), mesh_file_extensions()));
}

struct FileCloser {
    void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, FileCloser>;

std::string message_of(int error) {
    return std::generic_category().message(error);
}

void write_whole(std::span<const char> bytes, const std::filesystem::path& to,
                 const std::filesystem::path& named) {
    const auto fail = [&] {
        throw ResourceError(fmt::format("{}: cannot write: {}", named.string(), message_of(errno)));
    };
    File file(std::fopen(to.c_str(), "wb"));
    if (!file) fail();
    if (std::fwrite(bytes.data(), 1, bytes.size(), file.get()) != bytes.size()) fail();
    // A full disk may show only when the buffer is flushed.
    if (std::fclose(file.release()) != 0) fail();
}

} // namespace

std::string read_whole(const std::filesystem::path& path) {
    if (std::filesystem::is_directory(path))
        throw InputError(fmt::format("{}: is a directory", path.string()));
    const File file(std::fopen(path.c_str(), "rb"));
    if (!file)
        throw InputError(fmt::format("{}: cannot open: {}", path.string(), message_of(errno)));
    std::string bytes;
    constexpr std::size_t chunk = std::size_t{1} << 20; // large enough that calls cost nothing
    for (std::size_t got = chunk; got == chunk;) {
        const std::size_t before = bytes.size();
        bytes.resize(before + chunk);
        got = std::fread(bytes.data() + before, 1, chunk, file.get());
        bytes.resize(before + got);
    }
    if (std::ferror(file.get()))
        throw InputError(fmt::format("{}: cannot read: {}", path.string(), message_of(errno)));
    if (bytes.empty()) throw InputError(fmt::format("{}: the file is empty", path.string()));
    return bytes;
}

void append_fan(Mesh& mesh, std::span<const int> polygon) {
    for (std::size_t k = 2; k < polygon.size(); ++k)
        mesh.triangles.push_back({polygon[0], polygon[k - 1], polygon[k]});
}

bool is_mesh_file(const std::filesystem::path& path) {
    return find_format(path) != nullptr;
}

std::string mesh_file_extensions() {
    std::string list;
    for (const MeshFormat& format : formats) {
        if (!list.empty()) list += ", ";
        list += format.extension;
    }
    return list;
}

Mesh read_mesh(const std::filesystem::path& path) {
    const MeshFormat& format = format_of(path);
    const std::string bytes = read_whole(path);
    Mesh mesh = format.parse(bytes, path.string());
    if (mesh.triangles.empty())
        throw InputError(fmt::format("{}: no triangles ({} vertices); convert --method points "
                                     "takes points",
                                     path.string(), mesh.vertices_world.size()));
    return mesh;
}

PolygonMesh read_polygons(const std::filesystem::path& path) {
    const std::string extension = lower_case_extension(path);
    if (extension != ".obj" && extension != ".ply")
        throw InputError(fmt::format("{}: polygons are read from .obj and .ply", path.string()));
    const std::string bytes = read_whole(path);
    PolygonMesh out;
    out.mesh = extension == ".obj" ? parse_obj(bytes, path.string(), nullptr, &out.corner_counts)
                                   : parse_ply(bytes, path.string(), nullptr, &out.corner_counts);
    if (out.corner_counts.empty())
        throw InputError(fmt::format("{}: no faces ({} vertices)", path.string(),
                                     out.mesh.vertices_world.size()));
    return out;
}

void write_mesh(const Mesh& mesh, const std::filesystem::path& path) {
    Text text;
    format_of(path).append(text, mesh);
    AtomicFile file(path);
    write_whole({text.data(), text.size()}, file.temporary_path(), path);
    file.commit();
}

} // namespace isocast
