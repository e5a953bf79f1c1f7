// Which leaves of an adaptive distance field must be divided.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/adaptive.h"

namespace isocast {

Cube cube_of(const OctreeCell& cell);

/// No surface where the distance at the centre exceeds the way to the farthest point of the cell.
bool is_empty(const Cube& cube, double distance_at_centre);

/// Of an unsigned distance d at a point p of a cell.
struct DistanceBounds {
    double least, greatest;
};
/// From the distances at its corners c_i and its centre, where ExactDistance::is_to_nearest(): with
/// p = sum w_i c_i, d^2 - |p|^2 being concave,
///   d(p)^2 >= sum w_i d(c_i)^2 - sum w_i |c_i - p|^2,
/// and d(p) is at most that at another point and the way there.
///
/// from_centre  p [half edges]
DistanceBounds distance_bounds(const Cube& cube, const std::array<NodeData, 8>& corners,
                               double distance_at_centre, const Vec3d& from_centre);

/// By how much a leaf keeps what it must.
struct Margin {
    bool is_known = false;     // others, of finest leaves, are found once a corner has moved
    float slack = 0;           // what its corners may move by
    float error_at_centre = 0; // of the interpolant less the distance
};

class LeafJudge {
public:
    /// Both must outlive this.
    LeafJudge(const ExactDistance& distance, const AdaptiveOptions& options)
        : distance_(distance), options_(options) {}

    /// Slack below 0 if the cell must be divided.
    Margin margin_of(const Cube& cube, const std::array<NodeData, 8>& corners,
                     ExactDistance::Hint& hint) const;
    /// Of a leaf that was good as its corners were sampled and no longer is, the corner to mend: of
    /// those that moved by more than the slack or changed sides the one that moved farthest.
    std::optional<int> spoiling_corner(const OctreeCell& cell, Margin& margin,
                                       const std::array<NodeData, 8>& sampled,
                                       const std::array<NodeData, 8>& now,
                                       ExactDistance::Hint& hint) const;

private:
    double slack_at_surface(const Cube& cube, const SurfaceInCube& surface,
                            const std::array<NodeData, 8>& corners) const;
    double slack_at_points(const Cube& cube, const CellFunction& g,
                           const std::array<NodeData, 8>& sampled, double distance_at_centre,
                           ExactDistance::Hint& hint) const;
    double slack_at(const CellFunction& g, const Vec3d& p, double distance) const;
    double allowed_at(double distance) const;

    const ExactDistance& distance_;
    const AdaptiveOptions& options_;
};

} // namespace isocast
