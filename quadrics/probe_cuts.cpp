// SPDX-License-Identifier: MPL-2.0
#include "quadrics/probe_cuts.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace isocast {

void ProbeCuts::propose(const Vec3d& p, std::size_t k, std::size_t l) {
    const double least = (radius_ - tolerance_) * (radius_ - tolerance_);
    // Of the last ball and of balls k and l it is on the spheres, whatever rounding says.
    for (std::size_t i = 0; i + 1 < centres_.size(); ++i)
        if (i != k && i != l && (p - centres_[i]).squaredNorm() < least) return;
    candidates_.push_back({p, p.norm()});
}

void ProbeCuts::add(const Vec3d& centre) {
    constexpr auto none = static_cast<std::size_t>(-1);
    const double squared_radius = radius_ * radius_;
    centres_.push_back(centre);
    std::erase_if(candidates_, [&](const Candidate& candidate) {
        return (candidate.point - centre).norm() < radius_ - tolerance_;
    });
    // On its sphere; from the middle all of it is as far.
    const double length = centre.norm();
    if (length < radius_)
        propose(length > 0 ? Vec3d(centre * (1 - radius_ / length)) : Vec3d(radius_, 0, 0), none,
                none);
    for (std::size_t k = 0; k + 1 < centres_.size(); ++k) {
        // On the circle with another one.
        const Vec3d half = (centres_[k] - centre) / 2;
        const double squared_circle = squared_radius - half.squaredNorm();
        if (squared_circle <= 0 || half.isZero(0)) continue;
        const Vec3d axis = half.normalized();
        const Vec3d middle = centre + half;
        const Vec3d across = middle.dot(axis) * axis - middle;
        // On the axis all of the circle is as far; so near it, rounding is all there is of
        // `across`.
        const Vec3d direction = across.norm() > 1e-9 * radius_
                                    ? Vec3d((across - across.dot(axis) * axis).normalized())
                                    : axis.unitOrthogonal();
        propose(middle + std::sqrt(squared_circle) * direction, k, none);
        // The two points with a third: at one distance from all three, above the circumcentre.
        for (std::size_t l = 0; l < k; ++l) {
            const Vec3d b = centres_[k] - centre, c = centres_[l] - centre;
            const Vec3d normal = b.cross(c);
            const double squared_normal = normal.squaredNorm();
            if (squared_normal == 0) continue;
            const Vec3d to_circumcentre =
                (b.squaredNorm() * c - c.squaredNorm() * b).cross(normal) / (2 * squared_normal);
            const double squared_height = squared_radius - to_circumcentre.squaredNorm();
            if (!(squared_height > 0)) continue;
            const Vec3d up = normal * std::sqrt(squared_height / squared_normal);
            propose(centre + to_circumcentre + up, k, l);
            propose(centre + to_circumcentre - up, k, l);
        }
    }
}

ProbeCuts::Candidate ProbeCuts::nearest() const {
    const auto found = std::ranges::min_element(candidates_, {}, &Candidate::distance);
    if (found != candidates_.end()) return *found;
    constexpr double infinity = std::numeric_limits<double>::infinity();
    return {Vec3d::Constant(infinity), infinity};
}

} // namespace isocast
