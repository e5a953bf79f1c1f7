// Exact signed distances: what an adaptive field is built from.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/cell_function.h"

#include <cstdint>
#include <functional>

namespace isocast {

struct Cube {
    Vec3d centre;
    double half_edge;

    Vec3d lo() const { return (centre.array() - half_edge).matrix(); }
    Vec3d hi() const { return (centre.array() + half_edge).matrix(); }
};

/// Where in a cube the surface lies, as far as its cell must know.
struct SurfaceInCube {
    bool is_there = false; // false is proved
    /// |g| <= bound on all of the surface in the cube; proved too. Infinite if it is not.
    double bound = 0;
    /// The surface lies here.
    Eigen::AlignedBox3d box;
};

/// A signed distance; all in index space [finest cells]. Const and safe on several threads.
class ExactDistance {
public:
    struct Sample {
        double distance;
        Vec3d gradient;
    };
    /// What was nearest to the point asked for before; 0 at first. It saves time where the next
    /// point is near that one.
    using Hint = std::int32_t;

    virtual ~ExactDistance() = default;
    virtual Sample at(const Vec3d& p, Hint& hint) const = 0;
    /// Whether |distance| is that to the nearest of some points, not just below it: its square less
    /// |p|^2 is concave then.
    virtual bool is_to_nearest() const { return false; }
    /// g          of the cell that is the cube
    /// tolerance  bounds above it are of no use
    virtual SurfaceInCube surface_in(const Cube& cube, const CellFunction& g,
                                     double tolerance) const = 0;
};

/// Any function that changes no faster than its argument moves, which is what proves cubes empty:
/// distances, their unions and intersections, and what lies below a distance.
class LipschitzDistance final : public ExactDistance {
public:
    /// finest  edge of the smallest cubes that are looked at for a proof [finest cells]
    explicit LipschitzDistance(std::function<Sample(const Vec3d&)> at, double finest = 0.25)
        : at_(std::move(at)), finest_(finest) {}

    Sample at(const Vec3d& p, Hint&) const override { return at_(p); }
    SurfaceInCube surface_in(const Cube& cube, const CellFunction& g,
                             double tolerance) const override;

private:
    std::function<Sample(const Vec3d&)> at_;
    double finest_;
};

} // namespace isocast
