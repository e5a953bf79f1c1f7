// Which active blocks each tile of a picture can see, the nearest first.
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/tile_lists.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>

namespace isocast {

namespace {

/// Tiles x_lo <= x < x_hi, y_lo <= y < y_hi.
struct TileBox {
    int x_lo, x_hi, y_lo, y_hi;
};

/// Blocks seen by a camera.
class Viewer {
public:
    Viewer(const GridSpace& space, const Camera& camera, int width, int height,
           const PicturePart& part)
        : is_perspective_(camera.projection == Projection::Perspective),
          columns_((part.width + tile_pixels - 1) / tile_pixels),
          rows_((part.height + tile_pixels - 1) / tile_pixels),
          centre_x_((width / 2.0 - part.first_pixel(height).x()) / tile_pixels),
          centre_y_((height / 2.0 - part.first_pixel(height).y()) / tile_pixels) {
        const Mat3d rotation = camera.view_from_world_rotation();
        view_from_index_ = rotation * space.world_from_index.linear();
        offset_view_ = rotation * (space.world_from_index.translation() - camera.eye_world);
        tiles_per_unit_ = height / 2.0 / camera.half_height_at(1) / tile_pixels;
        eye_block_ = (space.to_index(camera.eye_world) / block_size).array().floor().matrix();
        const Vec3d forward_index = view_from_index_.inverse() * Vec3d(0, 0, -1);
        forward_sign_ = forward_index.array().sign().matrix();
    }

    /// Grows along every ray from one block to the next: a ray's steps from block to block all lead
    /// away from the eye's block, one along one axis each.
    double order_of(const Index3& block) const {
        const Vec3d b = block.cast<double>();
        return is_perspective_ ? (b - eye_block_).cwiseAbs().sum() : b.dot(forward_sign_);
    }

    /// Empty where the block is behind the eye.
    TileBox tiles_of(const Index3& block) const {
        const Vec3d corner = view_from_index_ * (block_size * block.cast<double>()) + offset_view_;
        const Mat3d edges = block_size * view_from_index_;
        const double smallest = 1e-3 * edges.row(2).cwiseAbs().sum(); // keeps quotients finite
        double x_lo = 1e30;
        double x_hi = -1e30;
        double y_lo = 1e30;
        double y_hi = -1e30;
        double depth_hi = -1e30;
        bool is_behind = false;
        for (int i = 0; i < 8; ++i) {
            const Vec3d p = corner + edges.col(0) * (i & 1) + edges.col(1) * (i >> 1 & 1) +
                            edges.col(2) * (i >> 2);
            const double depth = -p.z();
            depth_hi = std::max(depth_hi, depth);
            is_behind = is_behind || depth < smallest;
            const double scale =
                is_perspective_ ? tiles_per_unit_ / std::max(depth, smallest) : tiles_per_unit_;
            x_lo = std::min(x_lo, p.x() * scale);
            x_hi = std::max(x_hi, p.x() * scale);
            y_lo = std::min(y_lo, p.y() * scale);
            y_hi = std::max(y_hi, p.y() * scale);
        }
        if (depth_hi <= 0) return {0, 0, 0, 0};
        if (is_behind && is_perspective_) return {0, columns_, 0, rows_};
        // A thousandth of a tile for the rounding of rays.
        const auto first = [](double t, int limit) {
            return static_cast<int>(std::clamp(std::floor(t - 1e-3), 0.0, double(limit)));
        };
        const auto past = [](double t, int limit) {
            return static_cast<int>(std::clamp(std::floor(t + 1e-3) + 1, 0.0, double(limit)));
        };
        return {first(centre_x_ + x_lo, columns_), past(centre_x_ + x_hi, columns_),
                first(centre_y_ + y_lo, rows_), past(centre_y_ + y_hi, rows_)};
    }

private:
    bool is_perspective_;
    int columns_;
    int rows_;
    double centre_x_; // of the picture, from the part's corner [tiles]
    double centre_y_;
    Mat3d view_from_index_;
    Vec3d offset_view_;
    double tiles_per_unit_; // at depth one, or anywhere
    Vec3d eye_block_;
    Vec3d forward_sign_;
};

struct SeenBlock {
    double order;
    std::int32_t number;
    TileBox tiles;
};

/// see(block, number) of every active block, by number.
template<class See>
auto all_blocks(const BlockRanges& ranges, const std::vector<ActivePage>& active, See see) {
    std::vector<std::int32_t> first_blocks;
    std::int32_t block_count = 0;
    for (const ActivePage& page : active) {
        first_blocks.push_back(block_count);
        block_count += std::popcount(page.blocks);
    }
    std::vector<decltype(see(Index3(), 0))> seen(static_cast<std::size_t>(block_count));
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, active.size(), 16),
        [&](const tbb::blocked_range<std::size_t>& some) {
            for (std::size_t i = some.begin(); i < some.end(); ++i) {
                const Index3 first = page_blocks * ranges.pages[active[i].page].coordinate;
                std::int32_t number = first_blocks[i];
                for (std::uint64_t rest = active[i].blocks; rest != 0; rest &= rest - 1, ++number) {
                    seen[static_cast<std::size_t>(number)] =
                        see(Index3(first + block_in_page(std::countr_zero(rest))), number);
                }
            }
        });
    return seen;
}

} // namespace

std::vector<Eigen::Vector4i> runs_of_tiles(int width, int height,
                                           const std::function<bool(std::size_t)>& is_seen) {
    std::vector<Eigen::Vector4i> runs;
    const int columns = tiles_along(width);
    for (int y = 0; y < tiles_along(height); ++y) {
        const auto is_empty = [&](int x) {
            return !is_seen(static_cast<std::size_t>(x + columns * y));
        };
        int x = 0;
        while (x < columns) {
            const int first = x;
            while (x < columns && !is_empty(x)) ++x;
            if (x > first) runs.emplace_back(first, x, y, 0);
            ++x;
        }
    }
    return runs;
}

std::vector<Eigen::Vector4i> TileLists::runs() const {
    return runs_of_tiles(tile_pixels * width, tile_pixels * height,
                         [&](std::size_t tile) { return lists[tile][1] != 0; });
}

std::vector<Eigen::Vector4i> union_of_runs(std::span<const std::vector<Eigen::Vector4i>> runs,
                                           int width, int height) {
    const int columns = tiles_along(width);
    std::vector<std::uint8_t> is_seen(static_cast<std::size_t>(columns * tiles_along(height)));
    for (const std::vector<Eigen::Vector4i>& some : runs)
        for (const Eigen::Vector4i& run : some)
            std::fill_n(is_seen.begin() + run[0] + std::ptrdiff_t{columns} * run[2],
                        run[1] - run[0], std::uint8_t{1});
    return runs_of_tiles(width, height, [&](std::size_t tile) { return is_seen[tile] != 0; });
}

std::vector<Eigen::Vector4i> grown_runs(const std::vector<Eigen::Vector4i>& runs, int width,
                                        int height) {
    std::vector<std::vector<Eigen::Vector4i>> copies;
    for (const int up : {-1, 0, 1}) {
        std::vector<Eigen::Vector4i>& moved = copies.emplace_back();
        for (const Eigen::Vector4i& run : runs)
            if (const int y = run.z() + up; y >= 0 && y < tiles_along(height))
                moved.emplace_back(std::max(run.x() - 1, 0),
                                   std::min(run.y() + 1, tiles_along(width)), y, 0);
    }
    return union_of_runs(copies, width, height);
}

TileLists list_blocks(const BlockRanges& ranges, const std::vector<ActivePage>& active,
                      const GridSpace& space, const Camera& camera, int width, int height,
                      const std::optional<PicturePart>& asked_part) {
    const PicturePart part = asked_part.value_or(PicturePart{.width = width, .height = height});
    const Viewer viewer(space, camera, width, height, part);
    std::vector<SeenBlock> seen = all_blocks(ranges, active, [&](const Index3& block, int number) {
        return SeenBlock{viewer.order_of(block), number, viewer.tiles_of(block)};
    });
    std::erase_if(seen, [](const SeenBlock& block) {
        return block.tiles.x_lo >= block.tiles.x_hi || block.tiles.y_lo >= block.tiles.y_hi;
    });
    std::ranges::sort(seen, {},
                      [](const SeenBlock& block) { return std::pair(block.order, block.number); });

    TileLists tiles{tiles_along(part.width), tiles_along(part.height), {}, {}};
    tiles.lists.assign(static_cast<std::size_t>(tiles.width * tiles.height),
                       Eigen::Vector2i::Zero());
    const auto for_each_tile = [&](const TileBox& box, int y_lo, int y_hi, auto visit) {
        for (int y = std::max(box.y_lo, y_lo); y < std::min(box.y_hi, y_hi); ++y)
            for (int x = box.x_lo; x < box.x_hi; ++x)
                visit(tiles.lists[static_cast<std::size_t>(x + tiles.width * y)]);
    };
    // Each thread takes some rows of tiles and goes through all blocks in order.
    const auto by_rows = [&](auto visit) {
        constexpr int bands = 8;
        tbb::parallel_for(0, bands, [&](int band) {
            const int y_lo = tiles.height * band / bands;
            const int y_hi = tiles.height * (band + 1) / bands;
            for (const SeenBlock& block : seen)
                for_each_tile(block.tiles, y_lo, y_hi,
                              [&](Eigen::Vector2i& list) { visit(block, list); });
        });
    };
    by_rows([](const SeenBlock&, Eigen::Vector2i& list) { ++list[1]; });
    int count = 0;
    for (Eigen::Vector2i& list : tiles.lists) {
        list[0] = count;
        count += std::exchange(list[1], 0);
    }
    tiles.blocks.resize(static_cast<std::size_t>(count));
    by_rows([&](const SeenBlock& block, Eigen::Vector2i& list) {
        tiles.blocks[static_cast<std::size_t>(list[0] + list[1]++)] = block.number;
    });
    return tiles;
}

std::vector<Eigen::Vector4i> whole_picture(int width, int height) {
    std::vector<Eigen::Vector4i> runs;
    for (int y = 0; y * tile_pixels < height; ++y) runs.emplace_back(0, tiles_along(width), y, 0);
    return runs;
}

BlockOrder order_blocks(const BlockRanges& ranges, const std::vector<ActivePage>& active,
                        const GridSpace& space, const Camera& camera) {
    const Viewer viewer(space, camera, tile_pixels, tile_pixels,
                        {.width = tile_pixels, .height = tile_pixels});
    std::vector<std::pair<double, std::int32_t>> seen =
        all_blocks(ranges, active, [&](const Index3& block, int number) {
            return std::pair(viewer.order_of(block), number);
        });
    std::ranges::sort(seen);
    BlockOrder order;
    for (const auto& [place, number] : seen) {
        if (order.blocks.empty() || place != seen[order.blocks.size() - 1].first)
            order.layers.push_back(static_cast<std::int32_t>(order.blocks.size()));
        order.blocks.push_back(number);
    }
    order.layers.push_back(static_cast<std::int32_t>(order.blocks.size()));
    return order;
}

} // namespace isocast
