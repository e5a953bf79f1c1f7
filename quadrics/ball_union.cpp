// SPDX-License-Identifier: MPL-2.0
#include "quadrics/ball_union.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace isocast {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double whole_turn = 2 * std::numbers::pi;

/// Finds the balls that can meet one: a grid whose cells are as large as the largest ball.
class BallGrid {
public:
    explicit BallGrid(std::span<const Ball> balls) : balls_(balls) {
        Eigen::AlignedBox3d box;
        double largest = 0;
        for (const Ball& ball : balls) {
            box.extend(ball.centre);
            largest = std::max(largest, ball.radius);
        }
        origin_ = box.min();
        // 21 bits for each axis, neighbours included.
        cell_size_ = std::max(2 * largest, box.sizes().maxCoeff() * 0x1p-20);
        for (std::size_t i = 0; i < balls.size(); ++i)
            places_.push_back({number_of(cell_of(balls[i].centre)), static_cast<std::int32_t>(i)});
        std::sort(places_.begin(), places_.end());
    }

    /// Calls visit(number) for every other ball that meets or touches ball `i`, and for more.
    template<class Visit>
    void for_each_near(std::size_t i, Visit visit) const {
        const auto cell = cell_of(balls_[i].centre);
        for (const int dz : {-1, 0, 1})
            for (const int dy : {-1, 0, 1}) {
                // The three cells along x are one run of numbers.
                const std::int64_t first = number_of({cell[0] - 1, cell[1] + dy, cell[2] + dz});
                for (auto at = std::lower_bound(places_.begin(), places_.end(), Place{first, 0});
                     at != places_.end() && at->cell <= first + 2; ++at)
                    if (static_cast<std::size_t>(at->ball) != i)
                        visit(static_cast<std::size_t>(at->ball));
            }
    }

private:
    struct Place {
        std::int64_t cell;
        std::int32_t ball;
        bool operator<(const Place& other) const {
            return cell != other.cell ? cell < other.cell : ball < other.ball;
        }
    };
    using Cell = std::array<std::int64_t, 3>;

    Cell cell_of(const Vec3d& p) const {
        const Vec3d at = (p - origin_) / cell_size_;
        return {static_cast<std::int64_t>(at.x()) + 1, static_cast<std::int64_t>(at.y()) + 1,
                static_cast<std::int64_t>(at.z()) + 1};
    }
    static std::int64_t number_of(const Cell& cell) {
        return (cell[2] << 42) + (cell[1] << 21) + cell[0];
    }

    std::span<const Ball> balls_;
    Vec3d origin_;
    double cell_size_;
    std::vector<Place> places_;
};

/// The cap that another ball cuts from a ball's sphere.
struct CutCap {
    std::size_t other;
    Vec3d direction;
    double cosine;       // of the circle in which the spheres meet
    double cover_cosine; // of what counts as covered: a little less
    double cover_sine;
};

/// A part of a circle that a ball covers [radian]; begin in [0, 2 pi), end - begin in (0, 2 pi).
struct Interval {
    double begin, end;
};

double sine_of(double cosine) {
    return std::sqrt(std::max(0.0, (1 - cosine) * (1 + cosine)));
}

class Exposure {
public:
    Exposure(std::span<const Ball> balls, double tolerance)
        : balls_(balls), tolerance_(tolerance), grid_(balls) {}

    /// The caps on the sphere of ball `i` that are within no other, from the largest on.
    std::vector<CutCap> caps_of(std::size_t i) const {
        const Ball& ball = balls_[i];
        std::vector<CutCap> all;
        grid_.for_each_near(i, [&](std::size_t j) {
            const Ball& other = balls_[j];
            const Vec3d offset = other.centre - ball.centre;
            const double d = offset.norm();
            if (d >= ball.radius + other.radius || d == 0) return;
            const double common = d * d + ball.radius * ball.radius;
            const double scale = 1 / (2 * d * ball.radius);
            const double shrunk = std::max(other.radius - tolerance_, 0.0);
            const double cover = (common - shrunk * shrunk) * scale;
            if (cover >= 1) return;
            all.push_back({j, offset / d, (common - other.radius * other.radius) * scale, cover,
                           sine_of(cover)});
        });
        std::ranges::sort(all, {}, &CutCap::cover_cosine);
        std::vector<CutCap> caps;
        for (const CutCap& cap : all) {
            // Within another: the angle between their middles and its own fit in the other's.
            const bool is_within = std::ranges::any_of(caps, [&](const CutCap& larger) {
                return larger.direction.dot(cap.direction) >=
                       larger.cover_cosine * cap.cover_cosine + larger.cover_sine * cap.cover_sine;
            });
            if (!is_within) caps.push_back(cap);
        }
        return caps;
    }

    /// Adds the exposed arcs of the circle in which the sphere of ball `i` has cap `cap`, and their
    /// ends. Returns whether there are any.
    bool add_arcs(std::size_t i, const CutCap& cap, std::span<const CutCap> caps,
                  std::vector<ExposedArc>& arcs, std::vector<Vec3d>& ends) const {
        const Ball& ball = balls_[i];
        const Vec3d x = cap.direction.unitOrthogonal();
        const Vec3d y = cap.direction.cross(x);
        const double sine = sine_of(cap.cosine);
        std::vector<Interval> covered;
        for (const CutCap& other : caps) {
            if (other.other == cap.other) continue;
            // On the circle u = cosine w + sine (cos t x + sin t y): where is u · w' > cosine'?
            const double in_x = sine * other.direction.dot(x);
            const double in_y = sine * other.direction.dot(y);
            const double rest =
                other.cover_cosine - cap.cosine * other.direction.dot(cap.direction);
            const double squared = in_x * in_x + in_y * in_y;
            if (rest * rest >= squared) {
                if (rest >= 0) continue;
                return false;
            }
            const double half = std::acos(rest / std::sqrt(squared));
            double begin = std::atan2(in_y, in_x) - half;
            if (begin < 0) begin += whole_turn; // it is above -2 pi
            covered.push_back({begin, begin + 2 * half});
        }
        const double radius = ball.radius * sine;
        const Vec3d centre = ball.centre + ball.radius * cap.cosine * cap.direction;
        const auto toward = [&](double t) -> Vec3d { return std::cos(t) * x + std::sin(t) * y; };
        if (covered.empty()) {
            arcs.push_back({centre, cap.direction, radius, x, -2, 2 * radius});
            return true;
        }
        std::ranges::sort(covered, {}, &Interval::begin);
        const double first = covered.front().begin;
        double reach = first;
        for (const Interval& interval : covered) reach = std::max(reach, interval.end - whole_turn);
        bool is_exposed = false;
        const auto add_gap = [&](double begin, double end) {
            if (begin >= end) return;
            is_exposed = true;
            const double half = (end - begin) / 2;
            arcs.push_back({centre, cap.direction, radius, toward(begin + half), std::cos(half),
                            2 * radius * std::sin(half / 2)});
            for (const double t : {begin, end}) ends.push_back(centre + radius * toward(t));
        };
        for (const Interval& interval : covered) {
            add_gap(reach, interval.begin);
            reach = std::max(reach, interval.end);
        }
        add_gap(reach, first + whole_turn);
        return is_exposed;
    }

private:
    std::span<const Ball> balls_;
    double tolerance_;
    BallGrid grid_;
};

/// One of each that are nearer to each other than `tolerance`: an arc's end is that of two others.
void unite(std::vector<Vec3d>& points, double tolerance) {
    std::ranges::sort(points, {}, [](const Vec3d& p) { return p.x(); });
    std::size_t kept = 0;
    for (const Vec3d& p : points) {
        bool is_new = true;
        for (std::size_t k = kept; k > 0 && is_new && p.x() - points[k - 1].x() <= tolerance; --k)
            is_new = (p - points[k - 1]).squaredNorm() > tolerance * tolerance;
        if (is_new) points[kept++] = p;
    }
    points.resize(kept);
}

} // namespace

std::vector<Ball> without_swallowed(std::vector<Ball> balls, double tolerance) {
    std::ranges::sort(balls, std::greater{}, &Ball::radius);
    const BallGrid grid(balls);
    std::vector<char> is_kept(balls.size(), 1);
    for (std::size_t i = 0; i < balls.size(); ++i)
        grid.for_each_near(i, [&](std::size_t j) {
            if (j < i && is_kept[j] &&
                (balls[i].centre - balls[j].centre).norm() + balls[i].radius <=
                    balls[j].radius + tolerance)
                is_kept[i] = 0;
        });
    std::size_t kept = 0;
    for (std::size_t i = 0; i < balls.size(); ++i)
        if (is_kept[i]) balls[kept++] = balls[i];
    balls.resize(kept);
    return balls;
}

UnionBoundary boundary_of(std::vector<Ball> balls, double tolerance) {
    struct OfBall {
        std::vector<CutCap> caps;
        std::vector<ExposedArc> arcs;
        std::vector<Vec3d> ends;
        std::vector<std::size_t> others; // the balls whose spheres the arcs lie on, too
    };
    balls = without_swallowed(std::move(balls), tolerance);
    const Exposure exposure(balls, tolerance);
    std::vector<OfBall> of_balls(balls.size());
    tbb::parallel_for(std::size_t{0}, balls.size(), [&](std::size_t i) {
        OfBall& own = of_balls[i];
        own.caps = exposure.caps_of(i);
        for (const CutCap& cap : own.caps)
            if (i < cap.other && exposure.add_arcs(i, cap, own.caps, own.arcs, own.ends))
                own.others.push_back(cap.other);
    });
    std::vector<char> is_exposed(balls.size());
    for (std::size_t i = 0; i < balls.size(); ++i) {
        if (of_balls[i].caps.empty() || !of_balls[i].arcs.empty()) is_exposed[i] = 1;
        for (const std::size_t other : of_balls[i].others) is_exposed[other] = 1;
    }
    UnionBoundary result;
    for (std::size_t i = 0; i < balls.size(); ++i) {
        const OfBall& own = of_balls[i];
        result.arcs.insert(result.arcs.end(), own.arcs.begin(), own.arcs.end());
        result.points.insert(result.points.end(), own.ends.begin(), own.ends.end());
        if (!is_exposed[i]) continue;
        result.balls.push_back(balls[i]);
        std::vector<Cap>& caps = result.caps.emplace_back();
        for (const CutCap& cap : own.caps) caps.push_back({cap.direction, cap.cover_cosine});
    }
    for (std::size_t i = 0; i < balls.size(); ++i)
        if (!is_exposed[i]) result.balls.push_back(balls[i]);
    unite(result.points, tolerance);
    return result;
}

BoundaryPart whole(const UnionBoundary& boundary) {
    BoundaryPart part;
    const auto count = [](std::vector<std::int32_t>& numbers, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) numbers.push_back(static_cast<std::int32_t>(i));
    };
    count(part.faces, 0, boundary.caps.size());
    count(part.balls, boundary.caps.size(), boundary.balls.size());
    count(part.arcs, 0, boundary.arcs.size());
    count(part.points, 0, boundary.points.size());
    return part;
}

BoundaryPart near(const UnionBoundary& boundary, const BoundaryPart& part, const Vec3d& centre,
                  double radius, double outer, double inner) {
    BoundaryPart result;
    // Where one ball covers all, no others are needed to tell that it is inside: the deepest one
    // is kept.
    bool is_covered = false;
    double deepest = 0;
    std::int32_t cover = -1;
    const auto note_cover = [&](std::int32_t ball, double depth) {
        if (depth < radius) return false;
        if (depth >= deepest) {
            deepest = depth;
            cover = ball;
        }
        return is_covered = true;
    };
    for (const std::int32_t i : part.faces) {
        const Ball& ball = boundary.balls[static_cast<std::size_t>(i)];
        const double depth = ball.radius - (centre - ball.centre).norm();
        if (-depth > outer + radius) continue;
        note_cover(i, depth);
        if (depth <= inner + radius) result.faces.push_back(i);
    }
    for (const std::int32_t i : part.balls) {
        const Ball& ball = boundary.balls[static_cast<std::size_t>(i)];
        const double depth = ball.radius - (centre - ball.centre).norm();
        if (-depth <= radius && !note_cover(i, depth)) result.balls.push_back(i);
    }
    if (is_covered) result.balls = {cover};
    const double reach = inner + radius;
    for (const std::int32_t i : part.arcs) {
        const ExposedArc& arc = boundary.arcs[static_cast<std::size_t>(i)];
        const Vec3d offset = centre - arc.centre;
        const double limit = reach + arc.reach;
        if ((offset - arc.radius * arc.middle).squaredNorm() > limit * limit) continue;
        const double along = offset.dot(arc.axis);
        const double across = (offset - along * arc.axis).norm() - arc.radius;
        if (along * along + across * across <= reach * reach) result.arcs.push_back(i);
    }
    for (const std::int32_t i : part.points)
        if ((centre - boundary.points[static_cast<std::size_t>(i)]).squaredNorm() <= reach * reach)
            result.points.push_back(i);
    return result;
}

namespace {

/// Room for `count` rows, with what was there lost.
template<class Columns>
void make_room(Columns& columns, std::size_t count) {
    const auto rows = static_cast<Eigen::Index>(count);
    if (columns.rows() < rows) columns.resize(rows + rows / 2, columns.cols());
}

} // namespace

NearBoundary::NearBoundary() : balls_(0, 4), arcs_(0, 11), points_(0, 3), work_(0, 5) {}

void NearBoundary::load(const UnionBoundary& boundary, const BoundaryPart& part) {
    boundary_ = &boundary;
    faces_ = part.faces;
    const auto whole_number = [](std::int32_t i) { return static_cast<std::size_t>(i); };
    ball_count_ = static_cast<Eigen::Index>(part.faces.size() + part.balls.size());
    arc_count_ = static_cast<Eigen::Index>(part.arcs.size());
    point_count_ = static_cast<Eigen::Index>(part.points.size());
    make_room(balls_, part.faces.size() + part.balls.size());
    make_room(to_balls_, part.faces.size() + part.balls.size());
    make_room(arcs_, part.arcs.size());
    make_room(points_, part.points.size());
    make_room(work_, std::max(part.arcs.size(), part.points.size()));
    Eigen::Index row = 0;
    for (const auto* list : {&part.faces, &part.balls})
        for (const std::int32_t i : *list) {
            const Ball& ball = boundary.balls[whole_number(i)];
            balls_.row(row++) << ball.centre.x(), ball.centre.y(), ball.centre.z(), ball.radius;
        }
    row = 0;
    for (const std::int32_t i : part.arcs) {
        const ExposedArc& arc = boundary.arcs[whole_number(i)];
        arcs_.row(row++) << arc.centre.x(), arc.centre.y(), arc.centre.z(), arc.axis.x(),
            arc.axis.y(), arc.axis.z(), arc.radius, arc.middle.x(), arc.middle.y(), arc.middle.z(),
            arc.cos_half;
    }
    row = 0;
    for (const std::int32_t i : part.points)
        points_.row(row++) = boundary.points[whole_number(i)].transpose();
}

double NearBoundary::height(const Vec3d& p) {
    if (ball_count_ == 0) return infinity;
    const auto column = [&](int k) { return balls_.col(k).head(ball_count_); };
    auto to_balls = to_balls_.head(ball_count_);
    to_balls =
        ((column(0) - p.x()).square() + (column(1) - p.y()).square() + (column(2) - p.z()).square())
            .sqrt() -
        column(3);
    return to_balls.minCoeff(&nearest_ball_);
}

bool NearBoundary::is_exposed(Eigen::Index face, const Vec3d& direction) const {
    const auto number = static_cast<std::size_t>(faces_[static_cast<std::size_t>(face)]);
    return std::ranges::none_of(boundary_->caps[number], [&](const Cap& cap) {
        return direction.dot(cap.direction) > cap.cosine;
    });
}

NearBoundary::Nearest NearBoundary::nearest(const Vec3d& p) {
    Nearest best{infinity, Vec3d::Constant(infinity), false};
    const auto try_face = [&](Eigen::Index face) {
        const double depth = -to_balls_[face];
        if (!(depth > 0 && depth < best.distance)) return;
        const Vec3d centre = balls_.row(face).head<3>().transpose();
        const double radius = balls_(face, 3);
        const Vec3d offset = p - centre;
        const double length = offset.norm();
        // All of the sphere is as far from its centre, its arcs too.
        const Vec3d direction = length > 0 ? Vec3d(offset / length) : Vec3d(Vec3d::UnitX());
        if (is_exposed(face, direction)) best = {depth, centre + radius * direction, true};
    };
    const auto face_count = static_cast<Eigen::Index>(faces_.size());
    if (nearest_ball_ < face_count) {
        try_face(nearest_ball_);
        if (best.is_on_face) return best; // no depth is less than that of any ball
    }
    for (Eigen::Index face = 0; face < face_count; ++face) try_face(face);

    if (arc_count_ > 0) {
        const auto arc = [&](int k) { return arcs_.col(k).head(arc_count_); };
        const auto work = [&](int k) { return work_.col(k).head(arc_count_); };
        for (int k = 0; k < 3; ++k) work(k) = p[k] - arc(k);
        work(3) = work(0) * arc(3) + work(1) * arc(4) + work(2) * arc(5); // along the axis
        for (int k = 0; k < 3; ++k) work(k) -= work(3) * arc(3 + k);
        work(4) = (work(0).square() + work(1).square() + work(2).square()).sqrt();
        work(3) = (work(3).square() + (work(4) - arc(6)).square()).sqrt();
        for (Eigen::Index i = 0; i < arc_count_; ++i) {
            if (!(work_(i, 3) < best.distance)) continue;
            const Vec3d across = work_.row(i).head<3>().transpose();
            const double length = work_(i, 4);
            const Vec3d middle = arcs_.row(i).segment<3>(7).transpose();
            if (!(across.dot(middle) >= length * arcs_(i, 10))) continue;
            // On the axis all of the circle is as far; so near it, `across` is rounding.
            const Vec3d direction = length > 1e-9 * arcs_(i, 6) ? Vec3d(across / length) : middle;
            best = {work_(i, 3),
                    arcs_.row(i).head<3>().transpose().matrix() + arcs_(i, 6) * direction, false};
        }
    }
    if (point_count_ > 0) {
        auto squared = work_.col(0).head(point_count_);
        squared = (points_.col(0).head(point_count_) - p.x()).square() +
                  (points_.col(1).head(point_count_) - p.y()).square() +
                  (points_.col(2).head(point_count_) - p.z()).square();
        Eigen::Index nearest = 0;
        const double distance = std::sqrt(squared.minCoeff(&nearest));
        if (distance < best.distance) best = {distance, points_.row(nearest).transpose(), false};
    }
    return best;
}

} // namespace isocast
