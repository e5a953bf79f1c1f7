// Which active blocks each tile of a picture can see, the nearest first: the block-level ray
// segments of thesis section 6.3.2, found by tiles instead of by drawing every block's back faces.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "filtering/blocks.h"
#include "raycaster/camera.h"

#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace isocast {

/// Edge of a tile of the picture.
inline constexpr int tile_pixels = 4;

/// Tiles go from the bottom row up, like gl_FragCoord.
struct TileLists {
    int width = 0; // in tiles
    int height = 0;
    /// For each tile where its blocks start in `blocks`, and how many there are.
    std::vector<Eigen::Vector2i> lists;
    /// Numbers of active blocks. Along any ray of the tile, each comes before those behind it.
    std::vector<std::int32_t> blocks;

    /// The tiles with blocks, in runs along x: first, past the last, y, 0.
    std::vector<Eigen::Vector4i> runs() const;
};

/// A block is seen in the rectangle around its eight corners; one that reaches behind the eye,
/// everywhere. Blocks are numbered in the order of `active`, within a page by place_in_page.
///
/// part  whose tiles these are, of a picture of width x height; all of it if empty
TileLists list_blocks(const BlockRanges& ranges, const std::vector<ActivePage>& active,
                      const GridSpace& space, const Camera& camera, int width, int height,
                      const std::optional<PicturePart>& part = {});

inline int tiles_along(int pixels) {
    return (pixels + tile_pixels - 1) / tile_pixels;
}

/// The tiles of a picture, numbered along x first, of which `is_seen(number)` holds, in runs as
/// TileLists::runs().
std::vector<Eigen::Vector4i> runs_of_tiles(int width, int height,
                                           const std::function<bool(std::size_t)>& is_seen);

/// The runs of the tiles that any of several lists of runs hold.
std::vector<Eigen::Vector4i> union_of_runs(std::span<const std::vector<Eigen::Vector4i>> runs,
                                           int width, int height);

/// The same with all tiles next to them.
std::vector<Eigen::Vector4i> grown_runs(const std::vector<Eigen::Vector4i>& runs, int width,
                                        int height);

/// The runs of all tiles of a picture, as TileLists::runs().
std::vector<Eigen::Vector4i> whole_picture(int width, int height);

/// Active blocks, the nearest first.
struct BlockOrder {
    std::vector<std::int32_t> blocks;
    /// Where each layer starts in `blocks`, and their end: no ray sees two blocks of a layer.
    std::vector<std::int32_t> layers;
};

/// Blocks are numbered as in TileLists. All are listed, those behind the eye too.
BlockOrder order_blocks(const BlockRanges& ranges, const std::vector<ActivePage>& active,
                        const GridSpace& space, const Camera& camera);

} // namespace isocast
