// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/gl/seen_tile.h"

#include <algorithm>

namespace isocast {

SeenTile see_tile(const Sites& sites, const BandTiles& band, const BandTile& tile) {
    const SiteArrays& arrays = sites.arrays();
    const std::span<const std::int32_t> list = band.sites_of(tile);
    const auto place = [&](std::int32_t first) {
        return static_cast<std::size_t>(std::ranges::lower_bound(list, first) - list.begin());
    };
    SeenTile seen{.of_band = tile,
                  .sites = std::vector<TileSite>(list.size()),
                  .first_edge = place(arrays.face_count),
                  .first_vertex = place(arrays.face_count + arrays.edge_count)};
    const Vec3d first_sample = tile_size * tile.coordinate.cast<double>();
    sites.kernels().see_sites(
        {.sites = &arrays,
         .list = list.data(),
         .count = std::ssize(list),
         .first_sample = {first_sample.x(), first_sample.y(), first_sample.z()}},
        seen.sites.data());
    return seen;
}

} // namespace isocast
