// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/gl/exact_block.h"

#include "distance_transform/block_signs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace isocast {

namespace {

// The slacks of scan_kernel.inl, whose bits these functions reproduce: the same sums in the same
// order, which depends on the axis of the site's region.
constexpr double tower_slack = 1e-9;
constexpr double border_slack = 1e-9;

/// A block's sample as the kernel sees it: place k in a column along the region's axis, column u,
/// v.
struct Sample {
    Vec3d block_origin;
    int axis;
    int k;
    int u;
    int v;
};

/// A linear function of the samples of a block.
struct Linear {
    double first;
    double along_k;
    double along_u;
    double along_v;

    static Linear of(const double* axis, const double* origin, const Sample& p) {
        return {axis[0] * (p.block_origin[0] - origin[0]) +
                    axis[1] * (p.block_origin[1] - origin[1]) +
                    axis[2] * (p.block_origin[2] - origin[2]),
                axis[p.axis], axis[(p.axis + 1) % 3], axis[(p.axis + 2) % 3]};
    }
    double at(const Sample& p) const {
        return p.k * along_k + (first + p.u * along_u + p.v * along_v);
    }
};

Linear combined(double a, const Linear& f, double b, const Linear& g, double c) {
    return {a * f.first + b * g.first + c, a * f.along_k + b * g.along_k,
            a * f.along_u + b * g.along_u, a * f.along_v + b * g.along_v};
}

struct Offer {
    double square; // of the distance; infinite where the site offers none
    double side;
};

constexpr Offer no_offer = {std::numeric_limits<double>::infinity(), 1};

Offer offer_of_face(const FaceSite& face, const Sample& p) {
    const Linear r = Linear::of(face.r, face.origin, p);
    const Linear s = Linear::of(face.s, face.origin, p);
    const Linear right =
        combined(face.right.sine, r, face.right.cosine, s, -face.right.sine * face.right.base);
    const Linear left =
        combined(-face.left.sine, r, face.left.cosine, s, -face.left.sine * face.left.base);
    if (!(-tower_slack <= s.at(p) && right.at(p) <= tower_slack && left.at(p) <= tower_slack))
        return no_offer;
    const double height = Linear::of(face.t, face.origin, p).at(p);
    return {height * height, height};
}

Offer offer_of_edge(const EdgeSite& edge, const Sample& p) {
    const double along = Linear::of(edge.e, edge.origin, p).at(p);
    if (!(-tower_slack <= along && along <= edge.length + tower_slack)) return no_offer;
    const double dx = Linear::of(edge.x, edge.origin, p).at(p);
    const double dy = Linear::of(edge.y, edge.origin, p).at(p);
    return {dx * dx + dy * dy, dx * edge.normal_x + dy * edge.normal_y};
}

Offer offer_of_vertex(const VertexSite& vertex, const Sample& p) {
    const int ku = (p.axis + 1) % 3;
    const int kv = (p.axis + 2) % 3;
    const double dk = p.k + (p.block_origin[p.axis] - vertex.origin[p.axis]);
    const double du = p.block_origin[ku] + p.u - vertex.origin[ku];
    const double dv = p.block_origin[kv] + p.v - vertex.origin[kv];
    return {dk * dk + (du * du + dv * dv), Linear::of(vertex.normal, vertex.origin, p).at(p)};
}

/// The nearest so far. Of equal ones the kernel keeps the first: by axis, then by number.
struct Nearest {
    double square;
    int axis = 3;
    std::int32_t site = 0;
    bool is_negative = false;
};

} // namespace

void fill_block(FieldBlock& block, std::span<const Candidate> candidates,
                const ExactTransform& transform) {
    const SiteArrays& sites = transform.sites;
    const Vec3d origin = block_size * block.coordinate.cast<double>();
    const double reach = transform.half_width_voxels + border_slack;
    std::array<Nearest, samples_per_block> nearest;
    nearest.fill({.square = reach * reach});
    for (const Candidate& candidate : candidates) {
        const std::int32_t site = candidate.site;
        const int axis = sites.regions[site].axis;
        const int i = static_cast<int>(candidate.sample % samples_per_block);
        const Index3 place = sample_of(i);
        const Sample p{origin, axis, place[axis], place[(axis + 1) % 3], place[(axis + 2) % 3]};
        const std::int32_t edge = site - sites.face_count;
        const std::int32_t vertex = edge - sites.edge_count;
        const Offer offer = edge < 0     ? offer_of_face(sites.faces[site], p)
                            : vertex < 0 ? offer_of_edge(sites.edges[edge], p)
                                         : offer_of_vertex(sites.vertices[vertex], p);
        Nearest& held = nearest[i];
        const bool is_nearer = offer.square < held.square ||
                               (offer.square == held.square && held.axis < 3 &&
                                (axis < held.axis || (axis == held.axis && site < held.site)));
        if (is_nearer) held = {offer.square, axis, site, offer.side < 0 && offer.square > 0};
    }
    SampleBits active;
    SampleBits negative;
    for (int i = 0; i < samples_per_block; ++i) {
        if (nearest[i].axis == 3) continue;
        active.set(i);
        if (nearest[i].is_negative) negative.set(i);
        block.values[i] =
            static_cast<float>(std::min(std::sqrt(nearest[i].square), transform.half_width_voxels) *
                               transform.voxel_size_world);
    }
    if (transform.winding)
        negative = winding_signs(block.values, active, transform.voxel_size_world,
                                 *transform.winding, origin);
    spread(active, negative);
    apply_signs(block, active, negative,
                static_cast<float>(transform.voxel_size_world * transform.half_width_voxels));
}

} // namespace isocast
