// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/gl/site_sections.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace isocast {

namespace {

using Axis = Eigen::Map<const Vec3d>;

/// What float32 does, at most, to a linear function with a gradient of length one where its terms
/// add up to `terms` (their magnitudes): u = 2^-24 for each of 2 conversions, 5 products and 5
/// sums.
double float_error(double terms) {
    return 12 * 0x1p-24 * terms;
}

void write(float (&to)[4], const Vec3d& gradient, double value) {
    for (int k = 0; k < 3; ++k) to[k] = static_cast<float>(gradient[k]);
    to[3] = static_cast<float>(value);
}

void write_face(GpuSite& to, const FaceSite& face, const Vec3d& cell) {
    const Vec3d d = cell - Axis(face.origin);
    const Axis r(face.r);
    const Axis s(face.s);
    const Axis t(face.t);
    write(to.functions[0], t, t.dot(d));
    write(to.functions[1], -s, -s.dot(d));
    const auto write_side = [&](float(&function)[4], const FaceSite::Side& side, double sign) {
        const Vec3d outwards = sign * side.sine * r + side.cosine * s;
        write(function, outwards, outwards.dot(d) - side.sine * side.base);
    };
    write_side(to.functions[2], face.right, 1);
    write_side(to.functions[3], face.left, -1);
}

void write_edge(GpuSite& to, const EdgeSite& edge, const Vec3d& cell) {
    const Vec3d d = cell - Axis(edge.origin);
    const Axis e(edge.e);
    write(to.functions[0], Axis(edge.x), Axis(edge.x).dot(d));
    write(to.functions[1], Axis(edge.y), Axis(edge.y).dot(d));
    write(to.functions[2], -e, -e.dot(d));
    write(to.functions[3], e, e.dot(d) - edge.length);
}

void write_vertex(GpuSite& to, const VertexSite& vertex, const Vec3d& cell) {
    for (int k = 0; k < 3; ++k) write(to.functions[k], Vec3d::Unit(k), cell[k] - vertex.origin[k]);
}

/// A site by its number among all.
struct SiteAt {
    int kind;
    std::int32_t index; // among those of its kind

    SiteAt(const SiteArrays& sites, std::int32_t number) : kind(0), index(number) {
        if (index < sites.face_count) return;
        kind = 1;
        index -= sites.face_count;
        if (index < sites.edge_count) return;
        kind = 2;
        index -= sites.edge_count;
    }
    const double* origin(const SiteArrays& sites) const {
        if (kind == 0) return sites.faces[index].origin;
        if (kind == 1) return sites.edges[index].origin;
        return sites.vertices[index].origin;
    }
    void write_functions(GpuSite& to, const SiteArrays& sites, const Vec3d& cell) const {
        if (kind == 0)
            write_face(to, sites.faces[index], cell);
        else if (kind == 1)
            write_edge(to, sites.edges[index], cell);
        else
            write_vertex(to, sites.vertices[index], cell);
    }
};

/// Where the region's slices along z begin and end, from the cell.
struct Slices {
    double low;
    double high;
};

/// moved  from the site's origin to the cell
Slices write_region(GpuSite& to, const SiteRegion& region, const Vec3d& cell, double moved) {
    double extent = 0;
    for (int k = 0; k < 3; ++k) {
        to.base_min[k] = static_cast<float>(region.base_min[k] - cell[k]);
        to.base_max[k] = static_cast<float>(region.base_max[k] - cell[k]);
        to.direction[k] = region.direction[k];
        to.lateral_factor[k] = region.lateral_factor[k];
        extent = std::max(extent, double{region.base_max[k]} - region.base_min[k]);
    }
    to.low = region.low;
    to.high = region.high;
    to.lateral = region.lateral;
    to.lateral_slope = region.lateral_slope;
    const double height = std::max(-region.low, region.high);
    const double reach = region.lateral + region.lateral_slope * height;
    // How far the tile's samples in the region are from the cell, along each axis; 2 for roundings
    // of the region and of the cell to whole samples.
    const double offset = std::min(extent + height + reach + 2, double{tile_size});
    // The value at the cell: at most what the cell's distance from the site's origin makes it, and
    // for the bases of sides the extent; or, where the value at a sample is within the band, what
    // the offset makes it. Where that is larger, rounding in proportion leaves it large.
    constexpr double root_3 = std::numbers::sqrt3;
    const double value = std::min(moved + root_3 * (extent + 1), root_3 * offset + height + reach);
    to.error = static_cast<float>(float_error(root_3 * offset + value));
    const double a = double{region.low} * region.direction[2];
    const double b = double{region.high} * region.direction[2];
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
        (site.lateral + site.lateral_slope * std::max(-low, high)) * site.lateral_factor[2];
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
        const int first =
            floor_to_int(-(site.base_min[k] + std::min(low * w[k], high * w[k]) - around));
        const int last =
            floor_to_int(site.base_max[k] + std::max(low * w[k], high * w[k]) + around);
        // -first … last, within the tile.
        if (std::max(-first + site.cell[k], 0) > std::min(last + site.cell[k], tile_size - 1))
            return false;
    }
    return true;
}

} // namespace

std::vector<TileSite> sections_of_tile(const SiteArrays& sites, std::span<const std::int32_t> list,
                                       const Index3& first_sample, int slab_height, int slot) {
    std::vector<TileSite> result;
    result.reserve(list.size());
    const Vec3d tile_min = first_sample.cast<double>();
    const Vec3d tile_max = tile_min + Vec3d(tile_size - 1, tile_size - 1, slab_height - 1);
    for (const std::int32_t number : list) {
        const SiteAt at(sites, number);
        // Next to the site, but no farther from the tile's samples than they are from each other.
        const Vec3d cell =
            Axis(at.origin(sites)).array().floor().matrix().cwiseMax(tile_min).cwiseMin(tile_max);
        GpuSite site{};
        const Slices slices =
            write_region(site, sites.regions[number], cell, (cell - Axis(at.origin(sites))).norm());
        // The distance to a line or a point is made of several functions.
        if (at.kind != 0) site.error *= 2;
        const Index3 cell_in_tile = cell.cast<int>() - first_sample;
        const int first = std::max(0, static_cast<int>(std::ceil(slices.low)) + cell_in_tile.z());
        const int last =
            std::min(slab_height - 1, static_cast<int>(std::floor(slices.high)) + cell_in_tile.z());
        std::ranges::copy(cell_in_tile, site.cell);
        site.slot = slot;
        site.number = number;
        at.write_functions(site, sites, cell);
        for (int z = first; z <= last; ++z) {
            if (!holds_a_sample(site, z)) continue;
            site.first_slice = z;
            while (z < last && holds_a_sample(site, z + 1)) ++z;
            result.push_back({site, at.kind, z - site.first_slice + 1});
        }
    }
    return result;
}

} // namespace isocast
