// Meshes that are hard to convert.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/mesh.h"
#include "volume/grid_space.h"

#include <utility>
#include <vector>

namespace isocast::stability {

using Triangle = std::array<int, 3>;

template<class Map>
Mesh mapped(Mesh mesh, const Map& map) {
    for (Vec3d& p : mesh.vertices_world) p = map(p);
    return mesh;
}
inline Mesh moved(const Mesh& mesh, const Vec3d& by) {
    return mapped(mesh, [&](const Vec3d& p) { return Vec3d(p + by); });
}
inline Mesh scaled(const Mesh& mesh, double factor) {
    return mapped(mesh, [&](const Vec3d& p) { return Vec3d(factor * p); });
}
Mesh turned_round(Mesh mesh);
Mesh joined(Mesh mesh, const Mesh& other);
/// To multiples of 2^-20, so that halves of edges are exact.
Mesh rounded(const Mesh& mesh);
/// By a rotation that aligns nothing with the lattice.
Mesh tilted(const Mesh& mesh);
/// The surface between `lo` and `hi`.
Mesh box(const Vec3d& lo, const Vec3d& hi);
/// [-1, 1]^3.
inline Mesh cube() {
    return box(-Vec3d::Ones(), Vec3d::Ones());
}
Mesh tetrahedron();
/// Every triangle cut into four at the middles of its edges, `times` over.
Mesh subdivided(Mesh mesh, int times);
/// The octahedron, `times` subdivided, drawn out along each vertex by waves and noise: closed, full
/// of saddles, without intersections.
Mesh noisy_sphere(unsigned seed, int times);
Mesh sphere(int times);
/// Two cones over a line of corners, which turns counter-clockwise seen from the top.
Mesh double_cone(const std::vector<Vec3d>& line, const Vec3d& top, const Vec3d& bottom);
/// A closed cone over a rim that goes up and down at every corner.
Mesh saddle_cone(int valence);
/// Every third triangle cut into three about a vertex beside the middle of its first edge, which is
/// raised a little: one of them is a sliver of such a height by its length.
Mesh with_slivers(Mesh mesh, double height);
/// Every third triangle cut in two at a share of an edge, which its neighbour keeps; a triangle
/// without area closes the seam, or none does.
Mesh with_seams(Mesh mesh, double share, bool is_closed);
/// Each triangle with vertices of its own.
Mesh unindexed(const Mesh& mesh);
/// One in so many triangles.
Mesh with_flips(Mesh mesh, int one_in);
Mesh moebius_strip(int around);
/// A tube of round cross section about a figure of eight, through itself.
Mesh crossing_tube(int rings, int sides);
/// A spike of a hundredth of a degree on a ball.
Mesh needle_on_a_ball();

/// In voxels from a sample: in long double, since samples far from the world's origin need more
/// than 53 bits.
Mesh in_voxels(const Mesh& mesh, const GridSpace& space, const Index3& origin);
/// The samples within a band of so many voxels about a mesh, and three more.
IndexBox box_about(const Mesh& mesh, const GridSpace& space, double half_width_voxels);

} // namespace isocast::stability
