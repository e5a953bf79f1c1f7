// What checks of meshes share: vertices that are numbers, and elements of vertices that there are.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/errors.h"
#include "volume/grid_space.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace isocast {

/// mesh     "mesh 0", as messages name it
/// element  "triangle ", as they name one before its index
/// throws   InputError
template<std::size_t N>
void check_elements(const std::string& mesh, std::string_view element,
                    const std::vector<Vec3d>& vertices_world,
                    const std::vector<std::array<int, N>>& elements) {
    const auto vertex =
        std::ranges::find_if_not(vertices_world, [](const Vec3d& v) { return v.allFinite(); });
    if (vertex != vertices_world.end())
        throw InputError(
            fmt::format("{}: vertex {} is not finite", mesh, vertex - vertices_world.begin()));
    const auto vertex_count = static_cast<int>(vertices_world.size());
    for (std::size_t i = 0; i < elements.size(); ++i)
        for (const int corner : elements[i])
            if (corner < 0 || corner >= vertex_count)
                throw InputError(
                    fmt::format("{}: {}{}: there is no vertex {}", mesh, element, i, corner));
}

} // namespace isocast
