// Where the boundary of a union of balls is: the parts of spheres, of the circles in which two
// meet, and of the points in which three meet that lie in no other ball.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/grid_space.h"

#include <cstdint>
#include <span>
#include <vector>

namespace isocast {

struct Ball {
    Vec3d centre = Vec3d::Zero();
    double radius = 1;
};

/// The points u of the unit sphere with u · direction > cosine: those of a ball's sphere that lie
/// in another ball.
struct Cap {
    Vec3d direction;
    double cosine;
};

/// A piece of the circle in which two spheres meet, or all of it.
struct ExposedArc {
    Vec3d centre;
    Vec3d axis; // unit
    double radius;
    Vec3d middle;    // unit, from the centre to the arc's middle
    double cos_half; // of half its angle; -2 for a whole circle
    double reach;    // no point of it is farther than this from its middle
};

/// The boundary of the union of open balls: the points that lie in none and are near some.
struct UnionBoundary {
    std::vector<Ball> balls; // the first `caps.size()` have a part of the boundary
    std::vector<std::vector<Cap>> caps;
    std::vector<ExposedArc> arcs; // of those balls
    std::vector<Vec3d> points;    // the arcs' ends
};

/// The balls that are within none of the others by more than `tolerance`, one of each that are the
/// same, from the largest to the smallest.
std::vector<Ball> without_swallowed(std::vector<Ball> balls, double tolerance);

/// The boundary of the union of `balls`, on all cores; O(n) at the densities of chemistry.
///
/// tolerance  points no deeper than this in other balls count as exposed, so that four spheres
///            through one point, tangent ones and the like have their point in any rounding. The
///            result is that of radii that differ by this much. It is above the rounding errors
///            of the coordinates: 2^-42 of their extent
UnionBoundary boundary_of(std::vector<Ball> balls, double tolerance);

/// Parts of a boundary, by number.
struct BoundaryPart {
    std::vector<std::int32_t> faces; // of balls with a part of the boundary
    std::vector<std::int32_t> balls; // others, that only tell inside from outside
    std::vector<std::int32_t> arcs;
    std::vector<std::int32_t> points;

    bool has_boundary() const { return !faces.empty() || !arcs.empty() || !points.empty(); }
};

BoundaryPart whole(const UnionBoundary& boundary);

/// Of `part`, what points within `radius` of `centre` need: balls nearer than `outer` to one of
/// them, and all boundary within `inner` of one that is in a ball.
BoundaryPart near(const UnionBoundary& boundary, const BoundaryPart& part, const Vec3d& centre,
                  double radius, double outer, double inner);

/// The boundary near some points, laid out for speed. It keeps its memory from one load to the
/// next; each thread has its own.
class NearBoundary {
public:
    struct Nearest {
        double distance;
        Vec3d point;
        bool is_on_face; // or on an arc, or at an arc's end
    };

    NearBoundary();
    void load(const UnionBoundary& boundary, const BoundaryPart& part);

    /// The distance to the nearest ball. Where it is negative, a ball of that radius about `p` is
    /// in the union: the distance to the boundary is no less.
    /// returns  infinity if there are no balls
    double height(const Vec3d& p);

    /// The point of the boundary that is nearest to `p`, in the union. height(p) was the last call.
    ///
    /// returns   infinity if there is none
    /// accuracy  exact: the nearest point is a local minimum of the distance on its sphere, circle
    ///           or among the ends, and all of these are looked at. On a sphere it is the foot of
    ///           the ray from the centre through `p`, which is in the ball: the distance to a
    ///           sphere's far side has no minimum
    Nearest nearest(const Vec3d& p);

private:
    bool is_exposed(Eigen::Index face, const Vec3d& direction) const;

    const UnionBoundary* boundary_ = nullptr;
    std::vector<std::int32_t> faces_;
    Eigen::Index ball_count_ = 0, arc_count_ = 0, point_count_ = 0;
    Eigen::Index nearest_ball_ = 0;
    // A row for each, and more; columns so that they are computed side by side.
    Eigen::ArrayXXd balls_; // centre, radius; faces first
    Eigen::ArrayXd to_balls_;
    Eigen::ArrayXXd arcs_; // centre, axis, radius, middle, cos_half
    Eigen::ArrayXXd points_;
    Eigen::ArrayXXd work_;
};

} // namespace isocast
