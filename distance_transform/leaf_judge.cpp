// Which leaves of an adaptive distance field must be divided.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/leaf_judge.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

namespace isocast {

namespace {

/// How fast the allowed error grows with the distance beyond AdaptiveOptions::accurate_within. The
/// bunny takes 2.3 times as many sampled nodes with a quarter of it, and 0.9 times as many with
/// four times it.
constexpr double far_share = 0.25;

} // namespace

Cube cube_of(const OctreeCell& cell) {
    const double half = cell.size() / 2.0;
    return {(cell.position.cast<double>().array() + half).matrix(), half};
}

bool is_empty(const Cube& cube, double distance_at_centre) {
    return std::abs(distance_at_centre) > std::numbers::sqrt3 * cube.half_edge;
}

DistanceBounds distance_bounds(const Cube& cube, const std::array<NodeData, 8>& corners,
                               double distance_at_centre, const Vec3d& from_centre) {
    constexpr double rounding = 0x1p-22; // of the corners' floats, squared
    double squared = 0;
    DistanceBounds bounds{0, std::abs(distance_at_centre) + cube.half_edge * from_centre.norm()};
    for (int i = 0; i < 8; ++i) {
        const Vec3d corner = corner_direction(i);
        const double distance = std::abs(corners[static_cast<std::size_t>(i)][0]);
        const double weight = (1 + corner.array() * from_centre.array()).prod() / 8;
        squared += weight * distance * distance * (1 - rounding);
        bounds.greatest =
            std::min(bounds.greatest,
                     distance * (1 + rounding) + cube.half_edge * (corner - from_centre).norm());
    }
    const double spread =
        cube.half_edge * cube.half_edge * (1 - from_centre.array().square()).sum();
    bounds.least = std::sqrt(std::max(squared - spread, 0.0));
    return bounds;
}

Margin LeafJudge::margin_of(const Cube& cube, const std::array<NodeData, 8>& corners,
                            ExactDistance::Hint& hint) const {
    const CellFunction g(options_.filter, cube.lo(), 2 * cube.half_edge, corners);
    if (!options_.max_error_cells)
        return {.is_known = true,
                .slack = distance_.surface_in(cube, g, 0).is_there ? -1.0F : 0.0F};
    const double distance = distance_.at(cube.centre, hint).distance;
    Margin margin{.is_known = true,
                  .slack = static_cast<float>(slack_at(g, cube.centre, distance)),
                  .error_at_centre = static_cast<float>(g.at(cube.centre) - distance)};
    if (margin.slack < 0) return margin;
    const SurfaceInCube surface = is_empty(cube, distance)
                                      ? SurfaceInCube{}
                                      : distance_.surface_in(cube, g, *options_.max_error_cells);
    const double slack = surface.is_there ? slack_at_surface(cube, surface, corners)
                                          : slack_at_points(cube, g, corners, distance, hint);
    margin.slack = std::min(margin.slack, static_cast<float>(slack));
    return margin;
}

std::optional<int> LeafJudge::spoiling_corner(const OctreeCell& cell, Margin& margin,
                                              const std::array<NodeData, 8>& sampled,
                                              const std::array<NodeData, 8>& now,
                                              ExactDistance::Hint& hint) const {
    if (now == sampled) return std::nullopt;
    const Cube cube = cube_of(cell);
    if (!margin.is_known) margin = margin_of(cube, sampled, hint);
    if (margin.slack < 0) return std::nullopt;
    std::optional<int> corner;
    double farthest = -1;
    bool has_changed_side = false;
    for (std::size_t i = 0; i < 8; ++i) {
        double moved = 0;
        // Both ends' slopes weigh a quarter of the edge at most, between them.
        for (unsigned d = 0; d < static_cast<unsigned>(components_of(options_.filter)); ++d)
            moved += std::abs(double{now[i][d]} - sampled[i][d]) *
                     std::pow(cell.size() / 4.0, std::popcount(d));
        const bool is_on_other_side = (now[i][0] < 0) != (sampled[i][0] < 0);
        has_changed_side = has_changed_side || is_on_other_side;
        if (moved <= farthest || (moved <= margin.slack && !is_on_other_side)) continue;
        farthest = moved;
        corner = static_cast<int>(i);
    }
    if (!corner) return std::nullopt;
    const CellFunction before(options_.filter, cube.lo(), 2 * cube.half_edge, sampled);
    const CellFunction g(options_.filter, cube.lo(), 2 * cube.half_edge, now);
    const double distance = before.at(cube.centre) - margin.error_at_centre;
    if (slack_at(g, cube.centre, distance) < 0) return corner;
    const SurfaceInCube surface = is_empty(cube, distance)
                                      ? SurfaceInCube{}
                                      : distance_.surface_in(cube, g, *options_.max_error_cells);
    const bool is_spoiled =
        surface.is_there
            ? slack_at_surface(cube, surface, now) < 0
            : has_changed_side || slack_at_points(cube, g, sampled, distance, hint) < 0;
    return is_spoiled ? corner : std::nullopt;
}

double LeafJudge::slack_at_surface(const Cube& cube, const SurfaceInCube& surface,
                                   const std::array<NodeData, 8>& corners) const {
    const double max_error = *options_.max_error_cells;
    const bool is_inside = corners[0][0] < 0;
    const bool is_one_sided = std::ranges::all_of(
        corners, [&](const NodeData& corner) { return (corner[0] < 0) == is_inside; });
    const double from_low = (surface.box.max() - cube.lo()).minCoeff();
    const double from_high = (cube.hi() - surface.box.min()).minCoeff();
    if (is_one_sided && std::min(from_low, from_high) > hidden_share * max_error) return -1;
    return max_error - surface.bound;
}

/// At the middles of three faces, the others' being the neighbours', and where a cubic without
/// mixed derivatives errs most.
/// The distance there is asked for only where bounds do not do.
double LeafJudge::slack_at_points(const Cube& cube, const CellFunction& g,
                                  const std::array<NodeData, 8>& sampled, double distance_at_centre,
                                  ExactDistance::Hint& hint) const {
    double slack = std::numeric_limits<double>::infinity();
    const auto ask = [&](const Vec3d& from_centre) {
        const Vec3d p = cube.centre + cube.half_edge * from_centre;
        if (distance_.is_to_nearest() && is_empty(cube, distance_at_centre)) {
            const DistanceBounds bounds =
                distance_bounds(cube, sampled, distance_at_centre, from_centre);
            const double value = distance_at_centre < 0 ? -g.at(p) : g.at(p);
            const double least =
                allowed_at(bounds.least) - std::max(value - bounds.least, bounds.greatest - value);
            if (least >= 0) {
                slack = std::min(slack, least);
                return;
            }
        }
        slack = std::min(slack, slack_at(g, p, distance_.at(p, hint).distance));
    };
    for (int axis = 0; axis < 3 && slack >= 0; ++axis) ask(Vec3d::Unit(axis));
    if (options_.filter == OctreeFilter::Linear) return slack;
    for (int i = 0; i < 8 && slack >= 0; ++i) ask(corner_direction(i) / 2);
    return slack;
}

double LeafJudge::slack_at(const CellFunction& g, const Vec3d& p, double distance) const {
    return allowed_at(distance) - std::abs(distance - g.at(p));
}

double LeafJudge::allowed_at(double distance) const {
    const double beyond = std::abs(distance) - options_.accurate_within_cells;
    return std::max(*options_.max_error_cells, far_share * beyond);
}

} // namespace isocast
