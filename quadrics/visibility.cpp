// SPDX-License-Identifier: MPL-2.0
#include "quadrics/visibility.h"

#include "quadrics/in_parallel.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>

namespace isocast {

namespace {

constexpr float margin_pixels = 1.0F / 64;
constexpr float depth_margin = 0x1p-16F; // of a depth
constexpr int tile = 8;                  // a mask has 64 bits
constexpr int strip_tiles = 8;           // rows of tiles that one thread looks at

/// 8 x 8 pixels, as discs cover them. Two layers: all of the tile, and the pixels of a mask.
struct Tile {
    static constexpr float nothing = -std::numeric_limits<float>::infinity();
    float depth = std::numeric_limits<float>::infinity(); // all pixels are covered before it
    float mask_depth = nothing;                           // pixels of the mask are, before this
    std::uint64_t mask = 0;

    bool hides(float nearest_depth) const {
        return depth + depth_margin * std::abs(depth) < nearest_depth;
    }
    void cover(std::uint64_t pixels, float covered_depth) {
        if (!(covered_depth < depth)) return;
        mask |= pixels;
        mask_depth = std::max(mask_depth, covered_depth);
        if (mask != ~std::uint64_t{0}) return;
        depth = mask_depth;
        mask = 0;
        mask_depth = nothing;
    }
};

/// Tiles from lo to hi, both included.
struct TileBox {
    std::int16_t x_lo = std::numeric_limits<std::int16_t>::max(), x_hi = -1;
    std::int16_t y_lo = std::numeric_limits<std::int16_t>::max(), y_hi = -1;

    bool is_empty() const { return x_hi < x_lo; }
    void add(const TileBox& other) {
        x_lo = std::min(x_lo, other.x_lo);
        x_hi = std::max(x_hi, other.x_hi);
        y_lo = std::min(y_lo, other.y_lo);
        y_hi = std::max(y_hi, other.y_hi);
    }
};

std::int16_t tile_at(float pixel, int tiles) {
    return static_cast<std::int16_t>(
        std::floor(std::clamp(pixel / tile, 0.0F, static_cast<float>(tiles) - 0.5F)));
}

/// The first bits of eight of the pixels from lo on that lie in [lo, hi), as a row of a mask.
std::uint64_t row_bits(int lo, int hi) {
    const unsigned below_hi = hi >= tile ? 0xffU : (1U << std::max(hi, 0)) - 1;
    const unsigned below_lo = lo >= tile ? 0xffU : (1U << std::max(lo, 0)) - 1;
    return below_hi & ~below_lo;
}

/// A strip of the picture, front to back.
class Strip {
public:
    Strip(int width, int height, int first_row)
        : columns_((width + tile - 1) / tile), rows_((height + tile - 1) / tile),
          first_row_(static_cast<std::int16_t>(first_row)),
          last_row_(static_cast<std::int16_t>(std::min(first_row + strip_tiles, rows_) - 1)),
          tiles_(static_cast<std::size_t>(columns_) *
                 static_cast<std::size_t>(last_row_ - first_row_ + 1)) {
        // Pixels beyond the picture are covered by nothing that counts.
        for (int y = first_row_; y <= last_row_; ++y)
            for (int x = 0; x < columns_; ++x)
                at(x, y).mask = beyond(width - x * tile, height - y * tile);
    }

    /// Where the footprint can be seen in this strip; if anywhere, its disc covers what is behind.
    TileBox seen_of(const Footprint& f) {
        TileBox box{tile_at(f.x_lo - margin_pixels, columns_),
                    tile_at(f.x_hi + margin_pixels, columns_),
                    tile_at(f.y_lo - margin_pixels, rows_), tile_at(f.y_hi + margin_pixels, rows_)};
        box.y_lo = std::max(box.y_lo, first_row_);
        box.y_hi = std::min(box.y_hi, last_row_);
        TileBox seen;
        for (std::int16_t y = box.y_lo; y <= box.y_hi; ++y)
            for (std::int16_t x = box.x_lo; x <= box.x_hi; ++x)
                if (!at(x, y).hides(f.nearest_depth)) seen.add({x, x, y, y});
        if (!seen.is_empty() && f.disc_radius > margin_pixels) cover(f, box);
        return seen;
    }

private:
    Tile& at(int x, int y) {
        return tiles_[static_cast<std::size_t>(x) + static_cast<std::size_t>(columns_) *
                                                        static_cast<std::size_t>(y - first_row_)];
    }
    static std::uint64_t beyond(int width, int height) {
        std::uint64_t mask = 0;
        for (int y = 0; y < tile; ++y)
            mask |= (y < height ? row_bits(width, tile) : row_bits(0, tile)) << (tile * y);
        return mask;
    }

    void cover(const Footprint& f, const TileBox& box) {
        const float radius = f.disc_radius - margin_pixels;
        for (int y = box.y_lo; y <= box.y_hi; ++y) {
            // Of each row of pixels the first one covered, and one past the last.
            int first[tile];
            int last[tile];
            for (int row = 0; row < tile; ++row) {
                const float dy = static_cast<float>(y * tile + row) + 0.5F - f.disc_y;
                const float half = std::sqrt(std::max(radius * radius - dy * dy, 0.0F));
                first[row] = static_cast<int>(std::ceil(f.disc_x - half - 0.5F));
                last[row] = half > 0 ? static_cast<int>(std::floor(f.disc_x + half - 0.5F)) + 1
                                     : first[row];
            }
            for (int x = box.x_lo; x <= box.x_hi; ++x) {
                std::uint64_t pixels = 0;
                for (int row = 0; row < tile; ++row)
                    pixels |= row_bits(first[row] - x * tile, last[row] - x * tile) << (tile * row);
                if (pixels != 0) at(x, y).cover(pixels, f.disc_depth);
            }
        }
    }

    int columns_;
    int rows_;
    std::int16_t first_row_;
    std::int16_t last_row_;
    std::vector<Tile> tiles_;
};

} // namespace

Footprint sphere_footprint(const FootprintView& view, const Vec3d& centre_eye, double radius) {
    const double depth = -centre_eye.z();
    const auto width = static_cast<float>(view.width);
    const auto height = static_cast<float>(view.height);
    const auto as_float = [](double value) { return static_cast<float>(value); };
    const Eigen::Vector2d& middle = view.middle_pixels;
    if (!view.is_perspective) {
        const Eigen::Vector2d at = middle + view.pixels_per_unit * centre_eye.head<2>();
        const double r = view.pixels_per_unit * radius;
        return {as_float(at.x() - r),     as_float(at.x() + r),
                as_float(at.y() - r),     as_float(at.y() + r),
                as_float(depth - radius), as_float(at.x()),
                as_float(at.y()),         as_float(r),
                as_float(depth)};
    }
    const double nearest = std::max(depth - radius, view.near_depth);
    if (depth - radius <= view.near_depth)
        return {0, width, 0, height, as_float(nearest), 0, 0, 0, 0};
    const double a = (depth - radius) * (depth + radius);
    const Eigen::Vector2d xy = centre_eye.head<2>();
    const Eigen::Vector2d at = middle + view.pixels_per_unit * depth / a * xy;
    const Eigen::Vector2d extent =
        view.pixels_per_unit * radius / a * (xy.array().square() + a).sqrt().matrix();
    // The silhouette is the farthest that is seen; it lies r^2/d before the centre along the view
    // of it, and r sqrt(1 - (r/d)^2) aside.
    const double distance = centre_eye.norm();
    const double sine = radius / distance;
    const double aside = xy.norm() / distance;
    const double farthest = depth * (1 - sine * sine) + radius * aside * std::sqrt(1 - sine * sine);
    return {as_float(at.x() - extent.x()),
            as_float(at.x() + extent.x()),
            as_float(at.y() - extent.y()),
            as_float(at.y() + extent.y()),
            as_float(nearest),
            as_float(at.x()),
            as_float(at.y()),
            as_float(view.pixels_per_unit * radius / std::sqrt(a)),
            as_float(std::min(farthest, depth + radius))};
}

namespace {

/// The footprints that reach into the picture, about from front to back: by 2^12 layers of equal
/// depth. What is drawn before what it hides only hides less.
std::vector<std::uint32_t> front_to_back(std::span<const Footprint> footprints, int width,
                                         int height) {
    const auto is_in = [&](const Footprint& f) {
        return f.x_hi >= 0 && f.y_hi >= 0 && f.x_lo <= static_cast<float>(width) &&
               f.y_lo <= static_cast<float>(height);
    };
    float nearest = std::numeric_limits<float>::infinity();
    float farthest = -nearest;
    for (const Footprint& f : footprints)
        if (is_in(f)) {
            nearest = std::min(nearest, f.nearest_depth);
            farthest = std::max(farthest, f.nearest_depth);
        }
    constexpr std::size_t layers = 1 << 12;
    const float scale = farthest > nearest ? (layers - 1) / (farthest - nearest) : 0;
    constexpr auto outside = static_cast<std::uint16_t>(layers);
    std::vector<std::uint16_t> layer_of(footprints.size(), outside);
    std::vector<std::uint32_t> starts(layers + 2, 0);
    for (std::size_t i = 0; i < footprints.size(); ++i) {
        if (!is_in(footprints[i])) continue;
        layer_of[i] = static_cast<std::uint16_t>((footprints[i].nearest_depth - nearest) * scale);
        ++starts[layer_of[i] + std::size_t{1}];
    }
    std::partial_sum(starts.begin(), starts.end(), starts.begin());
    std::vector<std::uint32_t> order(starts[layers]);
    for (std::uint32_t i = 0; i < footprints.size(); ++i)
        if (layer_of[i] != outside) order[starts[layer_of[i]]++] = i;
    return order;
}

} // namespace

std::vector<VisibleFootprint> visible_footprints(std::span<const Footprint> footprints, int width,
                                                 int height) {
    const std::vector<std::uint32_t> order = front_to_back(footprints, width, height);
    // In order, so that what follows goes through memory as it lies.
    const auto sorted = std::make_unique_for_overwrite<Footprint[]>(order.size());
    in_parallel(order.size(), [&](std::size_t place) { sorted[place] = footprints[order[place]]; });
    const int strips = (height + tile * strip_tiles - 1) / (tile * strip_tiles);
    struct Part {
        std::uint32_t place;
        TileBox seen;
    };
    std::vector<std::vector<Part>> of_strip(static_cast<std::size_t>(strips));
    for (std::vector<Part>& places : of_strip) places.reserve(2 * order.size() / of_strip.size());
    const auto strip_of = [&](float y) {
        return std::clamp(static_cast<int>(std::floor(y / (tile * strip_tiles))), 0, strips - 1);
    };
    for (std::uint32_t place = 0; place < order.size(); ++place) {
        const Footprint& f = sorted[place];
        const int last = strip_of(f.y_hi + margin_pixels);
        for (int strip = strip_of(f.y_lo - margin_pixels); strip <= last; ++strip)
            of_strip[static_cast<std::size_t>(strip)].push_back({place, {}});
    }
    tbb::parallel_for(0, strips, [&](int strip) {
        Strip picture(width, height, strip * strip_tiles);
        for (Part& part : of_strip[static_cast<std::size_t>(strip)])
            part.seen = picture.seen_of(sorted[part.place]);
    });
    std::vector<TileBox> seen(order.size());
    for (const std::vector<Part>& parts : of_strip)
        for (const Part& part : parts) seen[part.place].add(part.seen);
    std::vector<VisibleFootprint> visible;
    const auto end_of = [](int tiles, int pixels) { return std::min(tile * tiles, pixels); };
    for (std::size_t place = 0; place < order.size(); ++place)
        if (const TileBox& box = seen[place]; !box.is_empty())
            visible.push_back({order[place], end_of(box.x_lo, width), end_of(box.x_hi + 1, width),
                               end_of(box.y_lo, height), end_of(box.y_hi + 1, height)});
    return visible;
}

} // namespace isocast
