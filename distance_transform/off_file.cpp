// Parses Object File Format (OFF, and COFF, NOFF, … whose extra numbers are skipped), text only.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/mesh_parsers.h"
#include "distance_transform/text_scanner.h"
#include "volume/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace isocast {

namespace {

/// Moves to the next line that holds a token.
/// throws  InputError that says how many of how many records there are, if the file ends
void start_record(TextScanner& scanner, std::string_view bytes, std::string_view name,
                  std::string_view what, std::int64_t index, std::int64_t count) {
    for (;;) {
        TextScanner ahead = scanner;
        if (!ahead.token_on_line().empty()) return;
        if (ahead.position() >= bytes.size())
            throw InputError(
                fmt::format("{}: truncated: it holds {} of {} {}", name, index, count, what));
        scanner.next_line();
    }
}

/// The counts of vertices and faces, after the optional keyword.
std::array<std::int64_t, 2> read_counts(TextScanner& scanner) {
    static constexpr std::array keywords = {"OFF",   "COFF",   "NOFF",   "CNOFF",
                                            "STOFF", "STCOFF", "STNOFF", "STCNOFF"};
    std::string_view first = scanner.token();
    if (std::find(keywords.begin(), keywords.end(), first) != keywords.end()) {
        first = scanner.token();
        if (first == "BINARY") scanner.fail("binary OFF is not supported");
    }
    const std::int64_t vertices = scanner.integer(first, "the number of vertices");
    const std::int64_t faces = scanner.integer(scanner.token(), "the number of faces");
    if (vertices < 0 || faces < 0) scanner.fail("a count is negative");
    scanner.next_line();
    return {vertices, faces};
}

} // namespace

Mesh parse_off(std::string_view bytes, std::string_view name) {
    TextScanner scanner(bytes, name, {.hash_comments = true});
    const auto [vertices, faces] = read_counts(scanner);
    Mesh mesh;
    for (std::int64_t i = 0; i < vertices; ++i) {
        start_record(scanner, bytes, name, "vertices", i, vertices);
        const double x = scanner.number_on_line("x");
        const double y = scanner.number_on_line("y");
        const double z = scanner.number_on_line("z");
        mesh.vertices_world.emplace_back(x, y, z);
        scanner.next_line();
    }
    std::vector<int> polygon;
    for (std::int64_t i = 0; i < faces; ++i) {
        start_record(scanner, bytes, name, "faces", i, faces);
        const std::int64_t corners = scanner.integer_on_line("the number of corners");
        if (corners < 3) scanner.fail(fmt::format("face {} has {} corners", i, corners));
        polygon.clear();
        for (std::int64_t k = 0; k < corners; ++k) {
            const std::int64_t index = scanner.integer_on_line("a vertex index");
            if (index < 0 || index >= vertices)
                scanner.fail(
                    fmt::format("vertex index {} of face {} is out of range: there are {} vertices",
                                index, i, vertices));
            polygon.push_back(static_cast<int>(index));
        }
        append_fan(mesh, polygon);
        scanner.next_line();
    }
    return mesh;
}

} // namespace isocast
