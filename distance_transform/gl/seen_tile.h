// A tile of the band with its sites: what both the GL and the exact distances start from.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/band_tiles.h"

namespace isocast {

inline constexpr int site_kinds = 3; // faces, edges, vertices: SITE_KIND 0, 1, 2

struct SeenTile {
    BandTile of_band;
    std::vector<TileSite> sites; // by kind
    std::size_t first_edge;      // in `sites`
    std::size_t first_vertex;

    int kind(std::size_t site) const { return (site >= first_edge) + (site >= first_vertex); }
};

SeenTile see_tile(const Sites& sites, const BandTiles& band, const BandTile& tile);

} // namespace isocast
