// Surfaces of overlapping pieces of quadrics, each in a sphere of its own: sparse low-degree
// implicits.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/grid_space.h"

#include <array>
#include <optional>
#include <vector>

namespace isocast {

/// Keeps what lies at distances >= -offset_world along a unit normal, from a patch's centre.
struct SlimPlane {
    Vec3d normal = Vec3d::UnitX();
    double offset_world = 0;

    double side_of(const Vec3d& from_centre_world) const {
        return normal.dot(from_centre_world) + offset_world;
    }
};

/// The graph w = h(u, v) over the plane through `centre` across `normal`, within the sphere, and
/// what its planes keep of it. f = w - h is negative inside, as in fields.
struct SlimPatch {
    Vec3d centre_world = Vec3d::Zero();
    double radius_world = 1;
    Vec3d normal = Vec3d::UnitZ(); // outwards, unit
    /// h = c0 + c1 u + c2 v + c3 u^2 + c4 u v + c5 v^2, u and v [world] along slim_axes(normal).
    std::array<double, 6> height{};
    int plane_count = 0; // 0 ... 2
    bool is_any = false; // of two planes one suffices: around a corner that juts into the surface
    std::array<SlimPlane, 2> planes{};
    double errors = 1; // how many of the level's errors it may be off by, 1 at least
};

/// Columns u, v and `normal`: a right-handed frame that depends on the normal alone.
///
/// source  Duff et al., Building an Orthonormal Basis, Revisited, JCGT 2017
Mat3d slim_axes(const Vec3d& normal);

/// f = p^T A p + 2 b^T p + c of points p from the patch's centre, world axes: Stoll et al. 2006
/// eqs 2, 3.
struct SlimQuadric {
    Mat3d a;
    Vec3d b;
    double c;
};
SlimQuadric slim_quadric(const SlimPatch& patch);

/// Whether its planes keep a point, given from the centre; closed by `spare_world`.
bool is_kept(const SlimPatch& patch, const Vec3d& from_centre_world, double spare_world = 0);

/// 1 at the centre, 0 on the sphere, smooth in between: a Gaussian up to half the
/// radius, then the parabola that is 0 with its derivative on the sphere and takes over value and
/// slope there.
///
/// share   distance from the centre, by the radius
/// source  Ohtake, Belyaev, Alexa 2005, as Stoll et al. 2006 section 5.1.1 describes it: neither
///         gives numbers that we have. With sigma^2 = 1/8 value and slope at 1/2 are e^-1 and
///         -4 e^-1, which 4 e^-1 (1 - s)^2 continues
double slim_weight(double share);

/// A cover of the whole surface by patches.
struct SlimLevel {
    std::vector<SlimPatch> patches;
    double max_error_world = 0; // that they were fitted with
};
struct SlimSurface {
    std::vector<SlimLevel>
        levels;             // the finest first, each with a greater error than the one before
    bool is_closed = false; // then what faces away is never seen
    Vec3d colour = Vec3d(0.72, 0.6, 0.42); // linear; of the scene, not of the file

    std::size_t patch_count() const; // of all levels
};

/// throws  InputError that names the level, the patch and what is wrong: no level, errors that do
///         not grow, a number that is not finite, a radius or an error that is not positive, a
///         normal that is not of unit length, too many planes
void check(const SlimSurface& surface);

/// Where a ray meets a patch.
struct SlimHit {
    double t = 0;
    Vec3d normal; // unit, outwards
    double weight = 0;
};
/// In double, by eq. 7, about the ray's closest approach to the centre.
///
/// faces_front  takes only what faces the ray's start
/// returns      the hits with t >= t_near, 2 at most, nearest first
std::vector<SlimHit> intersect(const SlimPatch& patch, const Vec3d& origin_world,
                               const Vec3d& direction_world, bool faces_front, double t_near = 0);

/// Whether no ray from the eye meets the outer side of the quadric within the sphere.
///
/// source  Stoll et al. 2006 eq. 18; of parallel rays n . v > 0 over the sphere
bool is_turned_away(const SlimPatch& patch, const Vec3d& eye_world, bool is_perspective,
                    const Vec3d& view_direction);

} // namespace isocast
