// Which 8^3 blocks can hold a piece of the isosurface.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/blocks.h"

#include "filtering/certificate.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <limits>
#include <unordered_map>
#include <utility>

namespace isocast {

namespace {

// Blocks are looked at by pages of 4^3, so that neighbours share the samples between them:
//
//     8p-1  8p ........ one page: 32 points  along x ........ 8p+31  +32  +33
//     |<-------------------- 35 samples per axis -------------------------->|
//        | block 0: -1 … 9 | block 1: 7 … 17 | ...
constexpr int page_samples = page_size + filter_support_below + filter_support_above;

std::uint64_t bit_of(int place) {
    return std::uint64_t{1} << place;
}

/// The blocks whose support touches an active box, by pages. Without a band the field ends at its
/// extent, where it is clamped: a surface that continues beyond is not the field's.
std::vector<BlockPage> candidate_pages(const FieldSource& field) {
    const auto hash = [](const Index3& g) {
        return (static_cast<std::size_t>(g.z()) * 73856093U) ^
               (static_cast<std::size_t>(g.y()) * 19349663U) ^
               (static_cast<std::size_t>(g.x()) * 83492791U); // Teschner et al. 2003
    };
    std::unordered_map<Index3, std::uint64_t, decltype(hash)> masks(16, hash);
    const IndexBox domain = blocks_over(field.extent());
    for (const IndexBox& box : field.active_boxes()) {
        if (box.is_empty()) continue;
        // Samples that a support reaches from the block: 8b - 1 … 8b + 9.
        IndexBox near = blocks_over(dilated(box, filter_support_above, filter_support_below));
        if (!field.half_width_world()) near = intersection(near, domain);
        const Index3 lo = floor_div(near.lo, page_blocks);
        const Index3 hi = floor_div((near.hi.array() - 1).matrix(), page_blocks);
        for (int gz = lo.z(); gz <= hi.z(); ++gz) {
            for (int gy = lo.y(); gy <= hi.y(); ++gy) {
                for (int gx = lo.x(); gx <= hi.x(); ++gx) {
                    const Index3 page(gx, gy, gz);
                    const IndexBox all{page_blocks * page,
                                       (page_blocks * (page.array() + 1)).matrix()};
                    const IndexBox part = intersection(near, all);
                    std::uint64_t mask = 0;
                    for (int z = part.lo.z(); z < part.hi.z(); ++z) {
                        for (int y = part.lo.y(); y < part.hi.y(); ++y) {
                            for (int x = part.lo.x(); x < part.hi.x(); ++x) {
                                mask |= bit_of(
                                    place_in_page(x - all.lo.x(), y - all.lo.y(), z - all.lo.z()));
                            }
                        }
                    }
                    masks[page] |= mask;
                }
            }
        }
    }
    std::vector<BlockPage> pages;
    pages.reserve(masks.size());
    for (const auto& [coordinate, mask] : masks) pages.push_back({coordinate, mask, {}, {}});
    std::ranges::sort(pages, zyx_less, &BlockPage::coordinate);
    return pages;
}

/// The samples of a page.
using Samples = std::vector<float>;

const float* sample_at(const Samples& samples, int x, int y, int z) {
    return &samples[static_cast<std::size_t>(x + page_samples * (y + page_samples * z))];
}

/// The cells of a block with corners on both sides of `iso`; x, y, z is the block's first sample.
/// Relative to the first sample of the group.
IndexBox cells_on_both_sides(const Samples& samples, int x, int y, int z, float iso) {
    constexpr int corners = block_size + 1;
    // 1 where a sample is inside; a sample at the iso value counts as outside.
    std::array<std::uint8_t, corners * corners * corners> inside{};
    const auto at = [&inside](int i, int j, int k) -> std::uint8_t& {
        return inside[static_cast<std::size_t>(i + corners * (j + corners * k))];
    };
    for (int k = 0; k < corners; ++k) {
        for (int j = 0; j < corners; ++j) {
            const float* row = sample_at(samples, x, y + j, z + k);
            for (int i = 0; i < corners; ++i) at(i, j, k) = row[i] < iso ? 1 : 0;
        }
    }
    IndexBox box;
    for (int k = 0; k < block_size; ++k) {
        for (int j = 0; j < block_size; ++j) {
            for (int i = 0; i < block_size; ++i) {
                int count = 0;
                for (int corner = 0; corner < 8; ++corner) {
                    count += at(i + (corner & 1), j + (corner >> 1 & 1), k + (corner >> 2));
                }
                if (count == 0 || count == 8) continue;
                const Index3 cell(x + i, y + j, z + k);
                box = bounding_box(box, {cell, (cell.array() + 2).matrix()});
            }
        }
    }
    return box;
}

/// The page's samples, the ones below and above its cells included, from its first one.
Index3 first_sample(const BlockPage& page) {
    return (page_size * page.coordinate.array() - filter_support_below).matrix();
}

Samples samples_of(const FieldSource& control, const BlockPage& page) {
    Samples samples(static_cast<std::size_t>(page_samples) * page_samples * page_samples);
    const Index3 first = first_sample(page);
    control.copy_box({first, (first.array() + page_samples).matrix()}, 0, samples);
    return samples;
}

/// Calls visit(place, x, y, z) for each block of the mask; x, y, z its lowest sample in the page's.
template<class Visit>
void for_each_block(std::uint64_t blocks, Visit visit) {
    for (; blocks != 0; blocks &= blocks - 1) {
        const int place = std::countr_zero(blocks);
        visit(place, block_size * (place % page_blocks),
              block_size * (place / page_blocks % page_blocks),
              block_size * (place / (page_blocks * page_blocks)));
    }
}

void find_ranges(const FieldSource& control, Kernel kernel, BlockPage& page) {
    const Samples samples = samples_of(control, page);
    page.ranges = ranges_of_page(samples.data(), page_samples, page_samples * page_samples, kernel);
    page.range = {std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()};
    const auto [least, greatest] = std::ranges::minmax(samples);
    page.samples = {least, greatest};
    for_each_block(page.blocks, [&](int place, int, int, int) {
        const ValueRange& range = page.ranges[static_cast<std::size_t>(place)];
        page.range = {std::min(page.range.min, range.min), std::max(page.range.max, range.max)};
    });
}

/// What a block's cells read of their corners: its samples and the next one along each axis.
IndexBox corners_of(const Index3& block) {
    const Index3 lo = block_size * block;
    return {lo, (lo.array() + block_size + 1).matrix()};
}

bool contains(const IndexBox& outer, const IndexBox& inner) {
    return intersection(outer, inner) == inner;
}

} // namespace

BlockRanges find_blocks(const FieldSource& control) {
    return {candidate_pages(control)};
}

BlockRanges find_block_ranges(const FieldSource& control, Kernel kernel, const Progress& progress) {
    BlockRanges ranges = find_blocks(control);
    const std::size_t count = ranges.pages.size();
    // In order, so that all threads are near each other: of a field that the system reads from a
    // file, a part is read once and can then go.
    constexpr std::size_t at_once = 1024;
    for (std::size_t first = 0; first < count; first += at_once) {
        if (progress) progress("blocks", static_cast<double>(first) / static_cast<double>(count));
        tbb::parallel_for(first, std::min(first + at_once, count),
                          [&](std::size_t i) { find_ranges(control, kernel, ranges.pages[i]); });
    }
    return ranges;
}

bool is_active(const ValueRange& range, float iso, float value_error) {
    const ValueRange wide = widened(range);
    return wide.min <= iso + value_error && iso - value_error <= wide.max;
}

std::vector<ActivePage> active_pages(const BlockRanges& ranges, float iso, float value_error) {
    std::vector<ActivePage> active;
    for (std::size_t i = 0; i < ranges.pages.size(); ++i) {
        const BlockPage& page = ranges.pages[i];
        if (!is_active(page.range, iso, value_error)) continue;
        std::uint64_t blocks = 0;
        for_each_block(page.blocks, [&](int place, int, int, int) {
            if (is_active(page.ranges[static_cast<std::size_t>(place)], iso, value_error))
                blocks |= bit_of(place);
        });
        if (blocks != 0) active.push_back({i, blocks});
    }
    return active;
}

IndexBox find_surface_box(const FieldSource& control, const BlockRanges& ranges,
                          const std::vector<ActivePage>& active, float iso) {
    struct Page {
        ActivePage active;
        IndexBox corners; // of its active blocks
        int depth = 0;    // below the border of all [samples]
    };
    std::vector<Page> pages;
    IndexBox all;
    const auto block_of = [&](const ActivePage& page, int place) -> Index3 {
        return page_blocks * ranges.pages[page.page].coordinate + block_in_page(place);
    };
    for (const ActivePage& page : active) {
        IndexBox corners;
        for_each_block(page.blocks, [&](int place, int, int, int) {
            corners = bounding_box(corners, corners_of(block_of(page, place)));
        });
        pages.push_back({page, corners});
        all = bounding_box(all, corners);
    }
    for (Page& page : pages) {
        page.depth =
            std::min((page.corners.lo - all.lo).minCoeff(), (all.hi - page.corners.hi).minCoeff());
    }
    // From the outside in: most of the others lie in the box by then and need not be looked at.
    std::ranges::sort(pages, {}, &Page::depth);
    IndexBox box;
    constexpr std::size_t at_once = 16;
    for (std::size_t first = 0; first < pages.size(); first += at_once) {
        std::array<IndexBox, at_once> found;
        tbb::parallel_for(first, std::min(first + at_once, pages.size()), [&](std::size_t i) {
            const auto& [page, corners, depth] = pages[i];
            if (contains(box, corners)) return;
            const Samples samples = samples_of(control, ranges.pages[page.page]);
            const Index3 origin = first_sample(ranges.pages[page.page]);
            IndexBox& part = found[i - first];
            for_each_block(page.blocks, [&](int place, int x, int y, int z) {
                if (contains(box, corners_of(block_of(page, place)))) return;
                const IndexBox cells =
                    cells_on_both_sides(samples, x + filter_support_below, y + filter_support_below,
                                        z + filter_support_below, iso);
                if (!cells.is_empty())
                    part = bounding_box(part, {cells.lo + origin, cells.hi + origin});
            });
        });
        for (const IndexBox& part : found) box = bounding_box(box, part);
    }
    // Beyond the extent a field without a band is clamped; its surface ends at the border.
    return control.half_width_world() ? box : intersection(box, control.extent());
}

ActiveBlocks find_active_blocks(const FieldSource& control, Kernel kernel, float iso,
                                const Progress& progress) {
    const BlockRanges ranges = find_block_ranges(control, kernel, progress);
    const std::vector<ActivePage> pages = active_pages(ranges, iso);
    ActiveBlocks active;
    for (const ActivePage& page : pages) {
        const Index3 first = page_blocks * ranges.pages[page.page].coordinate;
        for_each_block(page.blocks, [&](int, int x, int y, int z) {
            active.coordinates.push_back(first + Index3(x, y, z) / block_size);
        });
    }
    std::ranges::sort(active.coordinates, zyx_less);
    active.surface_box = find_surface_box(control, ranges, pages, iso);
    return active;
}

} // namespace isocast
