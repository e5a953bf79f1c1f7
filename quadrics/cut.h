// Planes that cut primitives open.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/quadric.h"
#include "quadrics/superquadric.h"

#include <algorithm>
#include <optional>
#include <span>
#include <vector>

namespace isocast {

/// What is in front of it is cut away: of p with normal . p > offset.
struct CutPlane {
    Vec3d normal = Vec3d::UnitZ(); // any length but 0
    double offset_world = 0;       // of the unit normal
    bool operator==(const CutPlane&) const = default;
};

/// What a cut through a body shows.
enum class CutLook {
    Inside, // its inner side, behind the cut
    Flat,   // the same with the cut's normal: flat as a cap, at no cost
    Capped, // a cap in the plane; triangles have none
};

inline constexpr std::size_t max_cut_planes = 8;

/// Primitives are what lies behind all planes, and no nearer to the viewer than `near_world`.
struct Cut {
    CutLook look = CutLook::Inside;
    std::vector<CutPlane> planes;
    std::optional<double> near_world; // along the viewer's axis
    bool operator==(const Cut&) const = default;
};

/// throws  InputError that names the plane by its index: a normal without length, what is not
///         finite; too many; `near_world` that is not positive
void check(const Cut& cut);

/// The least and the greatest n . p over a primitive; of clipped quadrics over their boxes.
struct Reach {
    double least, greatest;
};
template<class Primitive>
Reach reach_along(const Primitive& primitive, const Vec3d& n) {
    return {n.dot(farthest_point(primitive, Vec3d(-n))), n.dot(farthest_point(primitive, n))};
}

/// Whether the planes, of unit normals, leave nothing of it.
template<class Primitive>
bool is_cut_away(const Primitive& primitive, std::span<const CutPlane> planes) {
    return std::ranges::any_of(planes, [&](const CutPlane& plane) {
        return reach_along(primitive, plane.normal).least >= plane.offset_world;
    });
}

/// How deep p is inside a solid: from -1 on inside, 0 on the surface, more outside. Open cylinders
/// and cones are solids between their ends, clipped quadrics where f <= 0 in their boxes. Of
/// several solids that a ray is in where it passes a cut, the cap of the one with the least shows.
double depth_inside(const Quadric& quadric, const Vec3d& p_world);
double depth_inside(const Superquadric& superquadric, const Vec3d& p_world);
template<class Primitive>
double depth_inside(const Primitive& primitive, const Vec3d& p_world) {
    return depth_inside(quadric_of(primitive), p_world);
}

} // namespace isocast
