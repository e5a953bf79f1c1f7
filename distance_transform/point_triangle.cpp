// Distance from a point to a triangle: its three edges first, then its face.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/point_triangle.h"

namespace isocast {

namespace {

// Ratio of height to length below which rounding leaves nothing of a triangle's normal that its
// edges do not say better: leaving out the face then costs at most half of 1e-10 edge lengths.
constexpr double sliver_ratio = 1e-10;

} // namespace

ClosestPoint closest_point(const Vec3d& p, const std::array<Vec3d, 3>& corners) {
    const std::array<Vec3d, 3> edges = {corners[1] - corners[0], corners[2] - corners[1],
                                        corners[0] - corners[2]};
    std::array<double, 3> squared_lengths;
    ClosestPoint best{};
    Vec3d from_edge; // to p from the best one; exact far from the origin too, where best.p is not
    int best_edge = 0;
    for (int k = 0; k < 3; ++k) {
        const Vec3d to_p = p - corners[k];
        squared_lengths[k] = edges[k].squaredNorm();
        const double along = to_p.dot(edges[k]);
        ClosestPoint on_edge;
        Vec3d offset = to_p;
        if (along <= 0) {
            on_edge = {corners[k], 0, vertex_features[k]};
        } else if (along >= squared_lengths[k]) {
            const int end = k == 2 ? 0 : k + 1;
            on_edge = {corners[end], 0, vertex_features[end]};
            offset = p - corners[end];
        } else {
            const Vec3d to_foot = edges[k] * (along / squared_lengths[k]);
            on_edge = {corners[k] + to_foot, 0, edge_features[k]};
            offset -= to_foot;
        }
        on_edge.squared_distance = offset.squaredNorm();
        if (k > 0 && on_edge.squared_distance >= best.squared_distance) continue;
        best = on_edge;
        from_edge = offset;
        best_edge = k;
    }
    // The point of the boundary closest to a point above the face's inside lies within an edge:
    // the disc that touches the boundary first from inside cannot touch a convex corner.
    if (best.feature != edge_features[best_edge]) return best;

    // Of the three equal cross products the one of the two shorter edges rounds least.
    const int longest =
        squared_lengths[0] >= squared_lengths[1] && squared_lengths[0] >= squared_lengths[2] ? 0
        : squared_lengths[1] >= squared_lengths[2]                                           ? 1
                                                                                             : 2;
    const Vec3d normal = edges[(longest + 1) % 3].cross(edges[(longest + 2) % 3]);
    const double squared_area = normal.squaredNorm();
    const double least = sliver_ratio * squared_lengths[longest];
    if (squared_area <= least * least) return best;
    if (normal.cross(edges[best_edge]).dot(from_edge) <= 0) return best;

    // Height measured from the nearest edge point, not from a far corner, so that the rounding of
    // a sliver's normal is multiplied by the sliver's width only.
    const double height = from_edge.dot(normal) / squared_area; // in units of the normal
    const double squared_distance = height * height * squared_area;
    if (squared_distance >= best.squared_distance) return best;
    return {p - height * normal, squared_distance, Feature::Face};
}

} // namespace isocast
