// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/gl/site_sections.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace isocast {

namespace {

/// What float32 does, at most, to a linear function with a gradient of length one where its terms
/// add up to `terms` (their magnitudes): u = 2^-24 for each of 2 conversions, 5 products and 5
/// sums.
double float_error(double terms) {
    return 12 * 0x1p-24 * terms;
}

/// A linear function of the samples.
struct Linear {
    Vec3d gradient = Vec3d::Zero();
    double value = 0; // at the cell

    static Linear of(const SampleFunction& f, int axis, const Index3& cell) {
        Vec3d gradient;
        gradient[axis] = f.along_k;
        gradient[(axis + 1) % 3] = f.along_u;
        gradient[(axis + 2) % 3] = f.along_v;
        return {gradient, f.first + gradient.dot(cell.cast<double>())};
    }
};

/// returns  the greatest magnitude of their values at the cell
double write_functions(GpuSite& to, int kind, const TileSite& seen, const Index3& cell) {
    std::array<Linear, 4> f;
    for (std::size_t i = 0; i < f.size(); ++i)
        f[i] = Linear::of(seen.functions[i], seen.region.axis, cell);
    if (kind == 1) {
        f[3] = {f[2].gradient, f[2].value - seen.length};
        f[2] = {-f[2].gradient, -f[2].value};
    }
    // The three offsets, in any order: the GL needs no side.
    if (kind == 2) f[0] = std::exchange(f[3], Linear{});
    double greatest = 0;
    for (std::size_t i = 0; i < f.size(); ++i) {
        for (int k = 0; k < 3; ++k) to.functions[i][k] = static_cast<float>(f[i].gradient[k]);
        to.functions[i][3] = static_cast<float>(f[i].value);
        greatest = std::max(greatest, std::abs(f[i].value));
    }
    return greatest;
}

/// Where the region's slices along z begin and end, from the cell.
struct Slices {
    double low;
    double high;
};

/// value  of the greatest function at the cell
Slices write_region(GpuSite& to, int kind, const SiteRegion& region, const Index3& cell,
                    double value) {
    const double height = std::max(-region.low, region.high);
    const double reach = region.lateral + region.lateral_slope * height;
    // A base that goes on beyond is the same to all samples of the tile.
    const double far = tile_size + height;
    double extent = 0;
    for (int k = 0; k < 3; ++k) {
        to.base_min[k] = static_cast<float>(std::clamp(region.base_min[k] - cell[k], -far, far));
        to.base_max[k] = static_cast<float>(std::clamp(region.base_max[k] - cell[k], -far, far));
        to.direction[k] = static_cast<float>(region.direction[k]);
        to.lateral_factor[k] = static_cast<float>(region.lateral_factor[k]);
        extent = std::max(extent, region.base_max[k] - region.base_min[k]);
    }
    to.low = static_cast<float>(region.low);
    to.high = static_cast<float>(region.high);
    to.lateral = static_cast<float>(region.lateral);
    to.lateral_slope = static_cast<float>(region.lateral_slope);
    // How far the tile's samples in the region are from the cell, along each axis; 2 for rounding
    // the cell to a whole sample, and for the region to be drawn in full.
    const double offset = std::min(extent / 2 + height + reach + 2, double{tile_size});
    // Where the value at a sample is within the band, the offset bounds that at the cell. Where it
    // is larger, rounding in proportion leaves it large.
    constexpr double root_3 = std::numbers::sqrt3;
    const double terms = root_3 * offset + std::min(value, root_3 * offset + height + reach);
    // The distance to a line or a point is made of several functions.
    to.error = static_cast<float>(float_error(terms) * (kind == 0 ? 1 : 2));
    const double a = region.low * region.direction[2];
    const double b = region.high * region.direction[2];
    const double aside = reach * region.lateral_factor[2] + to.error;
    return {to.base_min[2] + std::min(a, b) - aside, to.base_max[2] + std::max(a, b) + aside};
}

/// Whether the slice's rectangle holds a sample of the tile: needles mostly pass between them.
///
/// twin  shaders/distance/section.vert, which draws that rectangle
bool holds_a_sample(const GpuSite& site, int slice) {
    const float z = static_cast<float>(slice - site.cell[2]);
    const float* w = site.direction;
    float low = site.low;
    float high = site.high;
    const float aside =
        (site.lateral + site.lateral_slope * std::max(-low, high)) * site.lateral_factor[2] +
        site.error;
    if (std::abs(w[2]) > 0.01f) {
        const float a = (z - site.base_max[2] - aside) / w[2];
        const float b = (z - site.base_min[2] + aside) / w[2];
        low = std::max(low, std::min(a, b));
        high = std::min(high, std::max(a, b));
    }
    if (low > high) return false;
    const float lateral = site.lateral + site.lateral_slope * std::max(-low, high);
    for (int k = 0; k < 2; ++k) {
        const float around = lateral * site.lateral_factor[k] + site.error;
        const float cell = static_cast<float>(site.cell[k]);
        const float first =
            std::ceil(site.base_min[k] + std::min(low * w[k], high * w[k]) - around) + cell;
        const float last =
            std::floor(site.base_max[k] + std::max(low * w[k], high * w[k]) + around) + cell;
        if (std::max(first, 0.0f) > std::min(last, tile_size - 1.0f)) return false;
    }
    return true;
}

} // namespace

std::vector<SiteSections> sections_of_tile(const SeenTile& tile, int slot) {
    std::vector<SiteSections> result;
    result.reserve(tile.sites.size());
    for (std::size_t i = 0; i < tile.sites.size(); ++i) {
        const TileSite& seen = tile.sites[i];
        const int kind = tile.kind(i);
        Index3 cell;
        for (int k = 0; k < 3; ++k)
            cell[k] = static_cast<int>(std::clamp(
                (seen.region.base_min[k] + seen.region.base_max[k]) / 2, 0.0, tile_size - 1.0));
        GpuSite site{};
        const double value = write_functions(site, kind, seen, cell);
        const Slices slices = write_region(site, kind, seen.region, cell, value);
        const int first = std::max(0, static_cast<int>(std::ceil(slices.low)) + cell.z());
        const int last =
            std::min(tile_size - 1, static_cast<int>(std::floor(slices.high)) + cell.z());
        std::ranges::copy(cell, site.cell);
        site.slot = slot;
        site.number = static_cast<std::int32_t>(i);
        for (int z = first; z <= last; ++z) {
            if (!holds_a_sample(site, z)) continue;
            site.first_slice = z;
            while (z < last && holds_a_sample(site, z + 1)) ++z;
            result.push_back({site, kind, z - site.first_slice + 1});
        }
    }
    return result;
}

} // namespace isocast
