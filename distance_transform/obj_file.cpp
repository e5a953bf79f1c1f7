// Parses Wavefront OBJ: positions (v), faces (f) and, of points, normals (vn); the rest is skipped.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/mesh_parsers.h"
#include "distance_transform/text_scanner.h"
#include "volume/errors.h"

#include <fmt/format.h>

#include <limits>

namespace isocast {

namespace {

/// The greatest index that faces named, and where: a face may come before its vertices.
struct HighestIndex {
    std::int64_t index = 0;
    std::int64_t line = 0;
    std::int64_t face = 0;
};

/// Zero-based vertex index of a corner "v", "v/t", "v//n" or "v/t/n"; negative ones count back
/// from the last vertex so far.
std::int64_t corner_index(const TextScanner& scanner, std::string_view corner,
                          std::int64_t vertices_so_far) {
    const std::string_view position = corner.substr(0, corner.find('/'));
    const std::int64_t index = scanner.integer(position, "a face's vertex index");
    const std::int64_t zero_based = index > 0 ? index - 1 : vertices_so_far + index;
    if (index == 0 || zero_based < 0)
        scanner.fail(fmt::format("vertex index {} is out of range: there are {} vertices so far",
                                 index, vertices_so_far));
    if (zero_based >= std::numeric_limits<int>::max())
        scanner.fail(fmt::format("vertex index {} is out of range: too large", index));
    return zero_based;
}

} // namespace

Mesh parse_obj(std::string_view bytes, std::string_view name, std::vector<Vec3d>* normals,
               std::vector<int>* corner_counts) {
    TextScanner scanner(bytes, name, {.hash_comments = true, .backslash_continuation = true});
    Mesh mesh;
    HighestIndex highest;
    std::vector<int> polygon;
    std::int64_t faces = 0;
    for (; !scanner.is_at_end(); scanner.next_line()) {
        const std::string_view keyword = scanner.token_on_line();
        if (keyword == "v" || (keyword == "vn" && normals)) {
            const double x = scanner.number_on_line("x");
            const double y = scanner.number_on_line("y");
            const double z = scanner.number_on_line("z");
            (keyword == "v" ? mesh.vertices_world : *normals).emplace_back(x, y, z);
        } else if (keyword == "f") {
            ++faces;
            polygon.clear();
            const auto vertices_so_far = static_cast<std::int64_t>(mesh.vertices_world.size());
            for (std::string_view corner = scanner.token_on_line(); !corner.empty();
                 corner = scanner.token_on_line()) {
                const std::int64_t index = corner_index(scanner, corner, vertices_so_far);
                if (index >= highest.index) highest = {index, scanner.line(), faces};
                polygon.push_back(static_cast<int>(index));
            }
            if (polygon.size() < 3)
                scanner.fail(fmt::format("face {} has {} corners", faces, polygon.size()));
            append_fan(mesh, polygon);
            if (corner_counts) corner_counts->push_back(static_cast<int>(polygon.size()));
        }
    }
    if (highest.face > 0 && highest.index >= std::ssize(mesh.vertices_world))
        throw InputError(fmt::format(
            "{}: line {}: vertex index {} of face {} is out of range: there are {} vertices", name,
            highest.line, highest.index + 1, highest.face, mesh.vertices_world.size()));
    return mesh;
}

Mesh parse_obj(std::string_view bytes, std::string_view name) {
    return parse_obj(bytes, name, nullptr);
}

} // namespace isocast
