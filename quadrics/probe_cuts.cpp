// SPDX-License-Identifier: MPL-2.0
#include "quadrics/probe_cuts.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace isocast {

bool ProbeCuts::is_in_a_ball(const Vec3d& p) const {
    const double least = (radius_ - tolerance_) * (radius_ - tolerance_);
    return std::ranges::any_of(
        centres_, [&](const Vec3d& centre) { return (p - centre).squaredNorm() < least; });
}

void ProbeCuts::propose(const Vec3d& p) {
    if (!is_in_a_ball(p)) candidates_.push_back({p, p.norm()});
}

void ProbeCuts::add(const Vec3d& centre) {
    const double squared_radius = radius_ * radius_;
    centres_.push_back(centre);
    std::erase_if(candidates_, [&](const Candidate& candidate) {
        return (candidate.point - centre).norm() < radius_ - tolerance_;
    });
    // On its sphere; from the middle all of it is as far.
    const double length = centre.norm();
    if (length < radius_)
        propose(length > 0 ? Vec3d(centre * (1 - radius_ / length)) : Vec3d(radius_, 0, 0));
    for (std::size_t k = 0; k + 1 < centres_.size(); ++k) {
        // On the circle with another one.
        const Vec3d half = (centres_[k] - centre) / 2;
        const double squared_circle = squared_radius - half.squaredNorm();
        if (squared_circle <= 0 || half.isZero(0)) continue;
        const Vec3d axis = half.normalized();
        const Vec3d middle = centre + half;
        const Vec3d across = middle.dot(axis) * axis - middle;
        const double width = across.norm();
        const Vec3d direction = width > 0 ? Vec3d(across / width) : axis.unitOrthogonal();
        propose(middle + std::sqrt(squared_circle) * direction);
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
            propose(centre + to_circumcentre + up);
            propose(centre + to_circumcentre - up);
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
