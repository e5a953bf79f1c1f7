// Distances to molecular surfaces by brute force: without caps, arcs, grids or lists.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/primitives.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <queue>
#include <vector>

namespace isocast {

/// A union of open balls: every point of the boundary that could be the nearest, tested against
/// every ball.
class NaiveUnion {
public:
    /// Points that are no deeper in balls than this count as outside.
    static constexpr double slack = 1e-9;

    NaiveUnion(std::vector<Sphere> spheres, double growth) : spheres_(std::move(spheres)) {
        for (Sphere& sphere : spheres_) sphere.radius_world += growth;
    }

    double height(const Vec3d& p) const {
        double least = std::numeric_limits<double>::infinity();
        for (const Sphere& s : spheres_)
            least = std::min(least, (p - s.centre_world).norm() - s.radius_world);
        return least;
    }

    /// The nearest point of the complement to a point of the union, if one is within `most`: among
    /// the feet on all spheres, the nearest points of all circles of two, all points of three.
    std::optional<Vec3d> nearest_outside(const Vec3d& p, double most) const {
        std::optional<Vec3d> best;
        double best_distance = most;
        const auto propose = [&](const Vec3d& q) {
            const double distance = (q - p).norm();
            if (distance > best_distance || height(q) < -slack) return;
            best = q;
            best_distance = distance;
        };
        std::vector<const Sphere*> near;
        for (const Sphere& s : spheres_)
            if ((p - s.centre_world).norm() <= s.radius_world + most) near.push_back(&s);
        for (std::size_t i = 0; i < near.size(); ++i) {
            const Vec3d& a = near[i]->centre_world;
            const double ra = near[i]->radius_world;
            const Vec3d offset = p - a;
            propose(a + ra * (offset.norm() > 0 ? Vec3d(offset.normalized()) : Vec3d::UnitX()));
            for (std::size_t j = 0; j < i; ++j) {
                const Vec3d ab = near[j]->centre_world - a;
                const double rb = near[j]->radius_world, d = ab.norm();
                if (d == 0) continue;
                const Vec3d axis = ab / d;
                const double along = (d * d + ra * ra - rb * rb) / (2 * d);
                if (std::abs(along) > ra) continue;
                const double circle = std::sqrt(ra * ra - along * along);
                const Vec3d middle = a + along * axis;
                const Vec3d q = p - middle - (p - middle).dot(axis) * axis;
                propose(middle +
                        circle * (q.norm() > 1e-9 ? Vec3d(q.normalized()) : axis.unitOrthogonal()));
                for (std::size_t k = 0; k < j; ++k) {
                    // On the circle, y = middle + circle (cos t u + sin t v): |y - c|^2 = rc^2.
                    const Vec3d& c = near[k]->centre_world;
                    const Vec3d u = axis.unitOrthogonal(), v = axis.cross(u), m = middle - c;
                    const double rc = near[k]->radius_world;
                    const double rest =
                        (rc * rc - m.squaredNorm() - circle * circle) / (2 * circle);
                    const double x = m.dot(u), y = m.dot(v), length = std::hypot(x, y);
                    if (length == 0 || !(std::abs(rest) <= length)) continue;
                    const double t = std::atan2(y, x), half = std::acos(rest / length);
                    for (const double angle : {t - half, t + half})
                        propose(middle + circle * (std::cos(angle) * u + std::sin(angle) * v));
                }
            }
        }
        return best;
    }

    /// Signed distance to the boundary, exact up to `most` inside.
    double distance(const Vec3d& p, double most) const {
        const double h = height(p);
        if (h >= 0) return h;
        const auto q = nearest_outside(p, most);
        return q ? -(*q - p).norm() : -most;
    }

private:
    std::vector<Sphere> spheres_;
};

struct Bounds {
    double lower, upper;
};

/// Of the distance from `p` to the excluded surface, up to `most`: to the nearest point at least
/// `probe` deep in `grown`, or from such a point to the nearest that is less deep; by branch and
/// bound over cubes. They are closer than `tolerance` unless what is searched is thinner than a
/// tenth of that, or 5,000 cubes do not find it.
inline Bounds distance_to_excluded_surface(const NaiveUnion& grown, double probe, const Vec3d& p,
                                           double most, double tolerance) {
    struct Cube {
        Vec3d middle;
        double half;
        double least; // distance of its points
        bool operator<(const Cube& other) const { return least > other.least; }
    };
    std::priority_queue<Cube> cubes;
    cubes.push({p, most, 0});
    double upper = most;
    const auto deeper = [&](const Vec3d& q) {
        return -grown.distance(q, 2 * probe + most) - probe;
    };
    const double sought = deeper(p) < 0 ? 1 : -1;
    for (int count = 0; !cubes.empty(); ++count) {
        const Cube cube = cubes.top();
        cubes.pop();
        if (cube.least >= upper - tolerance) return {std::min(cube.least, upper), upper};
        const double by = sought * deeper(cube.middle);
        const double radius = std::sqrt(3.0) * cube.half;
        if (by >= 0) upper = std::min(upper, (cube.middle - p).norm());
        if (by + radius < 0) continue; // depth changes by no more than the way
        if (radius < tolerance / 10 || count == 5'000) return {cube.least, upper};
        for (int corner = 0; corner < 8; ++corner) {
            const double half = cube.half / 2;
            const Vec3d middle = cube.middle + half * Vec3d(2 * (corner & 1) - 1, (corner & 2) - 1,
                                                            (corner >> 1 & 2) - 1);
            const double least = ((middle - p).cwiseAbs().array() - half).max(0).matrix().norm();
            cubes.push({middle, half, least});
        }
    }
    return {upper, upper};
}

} // namespace isocast
