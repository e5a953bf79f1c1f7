// SPDX-License-Identifier: MPL-2.0
#include "apps/verdict_json.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace isocast {

nlohmann::ordered_json to_json(const MeshVerdict& verdict) {
    return {{"summary", verdict.summary()},
            {"closed", verdict.is_closed()},
            {"oriented", verdict.is_oriented()},
            {"manifold", verdict.is_manifold()},
            {"reversed", verdict.reversed},
            {"unreferenced_vertices", verdict.unreferenced_vertices},
            {"duplicate_vertices", verdict.duplicate_vertices},
            {"degenerate_triangles", verdict.degenerate_triangles},
            {"duplicate_triangles", verdict.duplicate_triangles},
            {"boundary_edges", verdict.boundary_edges},
            {"boundary_loops", verdict.boundary_loops},
            {"non_manifold_edges", verdict.non_manifold_edges},
            {"flipped_edges", verdict.flipped_edges},
            {"turned_triangles", verdict.turned_triangles},
            {"orientable", verdict.is_orientable},
            {"non_manifold_vertices", verdict.non_manifold_vertices},
            {"shells", verdict.shells},
            {"volume", verdict.volume_world}};
}

void print_json(const nlohmann::ordered_json& json) {
    using Json = nlohmann::ordered_json;
    fmt::print("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace));
}

} // namespace isocast
