// The nearest point that none of some equal balls reaches.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/grid_space.h"

#include <vector>

namespace isocast {

/// Balls of one radius that are added one by one, and the point outside of all of them that is
/// nearest to the origin, which is in the first.
///
/// A nearest point is a local minimum of the distance on one sphere, on the circle of two or in a
/// point of three: these are the candidates, and those in a ball are struck out. Each ball adds
/// O(n^2) candidates; n is below ten where probes meet in molecules.
class ProbeCuts {
public:
    /// tolerance  points no deeper than this in a ball count as outside
    ProbeCuts(double radius, double tolerance) : radius_(radius), tolerance_(tolerance) {}

    void add(const Vec3d& centre);
    std::size_t count() const { return centres_.size(); }

    struct Candidate {
        Vec3d point;
        double distance;
    };
    /// Infinitely far if rounding has struck out all.
    Candidate nearest() const;

private:
    /// Keeps `p`, on the spheres of the last ball and of balls `k` and `l`, if it is in no other.
    void propose(const Vec3d& p, std::size_t k, std::size_t l);

    double radius_, tolerance_;
    std::vector<Vec3d> centres_;
    std::vector<Candidate> candidates_; // in no ball
};

} // namespace isocast
