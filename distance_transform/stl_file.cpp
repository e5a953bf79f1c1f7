// Parses STL, text or binary, told apart by size: many binary files begin with "solid" too.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/mesh_parsers.h"
#include "distance_transform/text_scanner.h"
#include "volume/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace isocast {

namespace {

constexpr std::size_t header_bytes = 84; // 80 of comment, then the count of triangles
constexpr std::size_t record_bytes = 50; // normal and three corners in float32, 2 of attributes

static_assert(std::endian::native == std::endian::little, "binary STL is little-endian");

std::uint32_t binary_triangle_count(std::string_view bytes) {
    std::uint32_t count = 0;
    std::memcpy(&count, bytes.data() + 80, sizeof count);
    return count;
}

Mesh parse_binary(std::string_view bytes, std::string_view name) {
    const std::uint32_t count = binary_triangle_count(bytes);
    if (count > static_cast<std::uint32_t>(std::numeric_limits<int>::max()) / 3)
        throw InputError(fmt::format("{}: {} triangles are too many", name, count));
    Mesh mesh;
    mesh.vertices_world.reserve(3 * std::size_t{count});
    mesh.triangles.reserve(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        std::array<float, 9> corners;
        std::memcpy(corners.data(), bytes.data() + header_bytes + record_bytes * i + 12,
                    sizeof corners);
        if (!std::all_of(corners.begin(), corners.end(), [](float x) { return std::isfinite(x); }))
            throw InputError(fmt::format("{}: triangle {}: a coordinate is not finite", name, i));
        for (int k = 0; k < 9; k += 3)
            mesh.vertices_world.emplace_back(corners[k], corners[k + 1], corners[k + 2]);
        const int first = static_cast<int>(3 * i);
        mesh.triangles.push_back({first, first + 1, first + 2});
    }
    return mesh;
}

std::string lower_case(std::string_view token) {
    std::string lower(token);
    for (char& c : lower)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return lower;
}

/// Leaves the grammar to the three words that carry the mesh: vertex, endloop and endsolid.
Mesh parse_text(std::string_view bytes, std::string_view name) {
    TextScanner scanner(bytes, name, {});
    Mesh mesh;
    std::vector<int> loop;
    bool is_in_solid = false;
    for (std::string_view found = scanner.token(); !found.empty(); found = scanner.token()) {
        const std::string word = lower_case(found);
        if (word == "vertex") {
            if (mesh.vertices_world.size() >= std::numeric_limits<int>::max())
                scanner.fail("too many vertices");
            const double x = scanner.number_on_line("x");
            const double y = scanner.number_on_line("y");
            const double z = scanner.number_on_line("z");
            loop.push_back(static_cast<int>(mesh.vertices_world.size()));
            mesh.vertices_world.emplace_back(x, y, z);
        } else if (word == "endloop") {
            if (loop.size() < 3) scanner.fail(fmt::format("a facet has {} vertices", loop.size()));
            append_fan(mesh, loop);
            loop.clear();
        } else if (word == "solid" || word == "endsolid") {
            is_in_solid = word == "solid";
            scanner.next_line(); // the rest is a free name
        } else if (word == "facet") {
            scanner.next_line(); // its normal follows from the corners
        } else if (word != "outer" && word != "loop" && word != "endfacet") {
            scanner.fail(fmt::format("unexpected {} in a text STL", quoted(found)));
        }
    }
    if (is_in_solid || !loop.empty())
        throw InputError(fmt::format("{}: truncated: it ends before 'endsolid', after {} triangles",
                                     name, mesh.triangles.size()));
    return mesh;
}

} // namespace

Mesh parse_stl(std::string_view bytes, std::string_view name) {
    const bool holds_header = bytes.size() >= header_bytes;
    const std::size_t count = holds_header ? binary_triangle_count(bytes) : 0;
    if (holds_header && bytes.size() == header_bytes + record_bytes * count)
        return parse_binary(bytes, name);
    TextScanner scanner(bytes, name, {});
    if (lower_case(scanner.token()) == "solid") return parse_text(bytes, name);
    if (!holds_header)
        throw InputError(fmt::format(
            "{}: not an STL file: no 'solid', and too short ({} bytes) for a binary header", name,
            bytes.size()));
    throw InputError(fmt::format(
        "{}: not a whole STL file: no 'solid', and as a binary one of {} triangles it would have "
        "{} bytes, not {} ({} whole triangles)",
        name, count, header_bytes + record_bytes * count, bytes.size(),
        (bytes.size() - header_bytes) / record_bytes));
}

} // namespace isocast
