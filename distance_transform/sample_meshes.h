// Built-in meshes, so that everything works with no data at hand (thesis figure 4.7).
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/mesh.h"

#include <string_view>

namespace isocast {

/// sphere6, torus, knot, seashell.
std::vector<std::string> sample_mesh_names();

/// sphere6   octahedron subdivided six times onto the unit sphere: 16,386 vertices
/// torus     3,000 vertices; knot: a tube along the trefoil, 1,440; seashell: closed, about 915
/// throws    InputError that lists the known names
Mesh sample_mesh(std::string_view name);

/// The corners (±1, 0, 0), (0, ±1, 0), (0, 0, ±1).
Mesh octahedron();

/// Every triangle cut into four at the middles of its edges; new vertices follow the old ones.
Mesh subdivided(const Mesh& mesh);

/// Octahedron subdivided `levels` times, new vertices pushed onto the unit sphere each time:
/// 4^(levels + 1) + 2 vertices.
Mesh subdivided_sphere(int levels);

} // namespace isocast
