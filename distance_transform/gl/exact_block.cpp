// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/gl/exact_block.h"

#include "distance_transform/block_signs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace isocast {

namespace {

// These functions reproduce the bits of scan_kernel.inl: the same sums in the same order, which
// depends on the axis of the site's region.

struct Offer {
    double square; // of the distance; infinite where the site offers none
    double side;
};

constexpr Offer no_offer = {std::numeric_limits<double>::infinity(), 1};

/// sample  from the tile's first
Offer offer_of(int kind, const TileSite& site, const Index3& sample) {
    const int axis = site.region.axis;
    const int k = sample[axis];
    const int u = sample[(axis + 1) % 3];
    const int v = sample[(axis + 2) % 3];
    std::array<double, 4> c;
    for (std::size_t i = 0; i < c.size(); ++i) {
        const SampleFunction& f = site.functions[i];
        c[i] = k * f.along_k + ((f.first + v * f.along_v) + u * f.along_u);
    }
    if (kind == 0) {
        const bool is_over_face = c[1] <= tower_slack && c[2] <= tower_slack && c[3] <= tower_slack;
        return is_over_face ? Offer{c[0] * c[0], c[0]} : no_offer;
    }
    if (kind == 1) {
        const bool is_beside = -tower_slack <= c[2] && c[2] <= site.length + tower_slack;
        return is_beside
                   ? Offer{c[0] * c[0] + c[1] * c[1], c[0] * site.normal_x + c[1] * site.normal_y}
                   : no_offer;
    }
    return {c[1] * c[1] + (c[2] * c[2] + c[3] * c[3]), c[0]};
}

/// The nearest so far. Of equal ones the kernel keeps the first: by axis, then by number.
struct Nearest {
    double square;
    int axis = 3;
    std::uint32_t site = 0;
    bool is_negative = false;
};

} // namespace

bool finish_block(const SeenTile& tile, const Index3& at, std::span<const Candidate> candidates,
                  double half_width, double scale, ScannedBlock& block) {
    const double reach = half_width + border_slack;
    std::array<Nearest, samples_per_block> nearest;
    nearest.fill({.square = reach * reach});
    for (const auto& [sample, number] : candidates) {
        const int i = static_cast<int>(sample % samples_per_block);
        const TileSite& site = tile.sites[number];
        const int axis = site.region.axis;
        const Offer offer = offer_of(tile.kind(number), site, block_size * at + sample_of(i));
        Nearest& held = nearest[i];
        const bool is_nearer = offer.square < held.square ||
                               (offer.square == held.square && held.axis < 3 &&
                                (axis < held.axis || (axis == held.axis && number < held.site)));
        if (is_nearer) held = {offer.square, axis, number, offer.side < 0 && offer.square > 0};
    }
    bool any = false;
    for (int row = 0; row < 64; ++row) {
        block.active[row] = block.negative[row] = 0;
        for (int x = 0; x < block_size; ++x) {
            const int i = block_size * row + x;
            const bool is_active = nearest[i].axis < 3;
            block.distance[i] =
                static_cast<float>(std::min(std::sqrt(nearest[i].square), half_width) * scale);
            block.active[row] |= static_cast<std::uint8_t>(is_active << x);
            block.negative[row] |= static_cast<std::uint8_t>(nearest[i].is_negative << x);
            any |= is_active;
        }
    }
    return any;
}

} // namespace isocast
