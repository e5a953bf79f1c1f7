// Sites as the GPU reads them, and the slices that meet them.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/gl/slab_tiles.h"

namespace isocast {

/// A site in the coordinates of one tile: all numbers are small, so that float32 serves.
///
/// twin  shaders/distance/section.vert: Site
struct GpuSite {
    std::int32_t cell[3]; // a sample next to the site's origin, from the tile's first sample
    std::int32_t slot;    // the tile's place in the target
    float base_min[3];    // SiteRegion, from the cell
    float low;
    float base_max[3];
    float high;
    float direction[3];
    float lateral;
    float lateral_factor[3];
    float lateral_slope;
    /// Linear functions of a sample: gradient, and value at the cell. shaders/distance/section.glsl
    /// says which they are.
    float functions[4][4];
    std::int32_t number;
    float error; // bound on what float does to any of the functions and the distance [voxels]
    float unused[2];
};
static_assert(sizeof(GpuSite) == 160, "std430 layout of section.vert");

/// One slice of one site: an instance of the draw.
struct Section {
    std::uint32_t site;  // which GpuSite
    std::uint32_t slice; // of the tile
};
static_assert(sizeof(Section) == 8);

inline constexpr int site_kinds = 3; // faces, edges, vertices: SITE_KIND 0, 1, 2

/// The sections of one tile, by kind of site.
struct TileSections {
    std::vector<GpuSite> sites;
    std::array<std::vector<Section>, site_kinds> sections;
};

/// list  sites that may reach the tile, in ascending order
/// slot  the tile's place in the target
TileSections sections_of_tile(const SiteArrays& sites, std::span<const std::int32_t> list,
                              const Index3& first_sample, int slab_height, int slot);

} // namespace isocast
