// Sites as the GPU reads them, and the slices that meet them.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/gl/seen_tile.h"

namespace isocast {

/// A site in the coordinates of one tile: all numbers are small, so that float32 serves.
///
/// twin  shaders/distance/section.vert: Site
struct GpuSite {
    std::int32_t cell[3]; // the tile's sample next to the site's middle, from the first one
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
    std::int32_t number;      // in SeenTile::sites
    std::int32_t first_slice; // of the tile
    float error; // bound on what float does to any of the functions and the distance [voxels]
    float unused;
};
static_assert(sizeof(GpuSite) == 160, "ten attributes of 16 bytes");

/// An instance of the draw: a site, with a rectangle for each of some slices of a tile.
struct SiteSections {
    GpuSite site;
    int kind;
    int slice_count; // >= 1
};

/// All instances that the tile's samples need, with no slice that holds none.
///
/// slot  the tile's place in the target
std::vector<SiteSections> sections_of_tile(const SeenTile& tile, int slot);

} // namespace isocast
