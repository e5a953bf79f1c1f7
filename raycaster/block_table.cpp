// The table that rays walk: which blocks are active, and how far the empty ones reach.
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/block_table.h"

#include "volume/errors.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <limits>

namespace isocast {

namespace {

/// A box of pages as an array, x fastest.
struct PageBox {
    Index3 first;
    Index3 size;

    int count() const { return size.prod(); }
    int number(const Index3& page) const {
        const Index3 p = page - first;
        return p.x() + size.x() * (p.y() + size.y() * p.z());
    }
    bool contains(const Index3& page) const {
        return ((page - first).array() >= 0).all() && ((page - first - size).array() < 0).all();
    }
};

/// The active pages and a ring around them.
PageBox box_of(const BlockRanges& ranges, const std::vector<ActivePage>& active) {
    if (active.empty()) return {Index3::Zero(), Index3::Ones()};
    Index3 lo = Index3::Constant(std::numeric_limits<int>::max());
    Index3 hi = Index3::Constant(std::numeric_limits<int>::min());
    for (const ActivePage& page : active) {
        lo = lo.cwiseMin(ranges.pages[page.page].coordinate);
        hi = hi.cwiseMax(ranges.pages[page.page].coordinate);
    }
    const PageBox box{(lo.array() - 1).matrix(), (hi - lo).array() + 3};
    const double count = box.size.cast<double>().prod();
    constexpr double limit = 1 << 28; // of the words of a buffer texture, with room for blocks
    if (count > limit) {
        throw ResourceError(fmt::format("the surface spans {} x {} x {} pages of 32^3 voxels, more "
                                        "than a table of 2^28 holds; use a coarser voxel size",
                                        box.size.x(), box.size.y(), box.size.z()));
    }
    return box;
}

/// Chebyshev distance to the nearest page with distance 0, in place; at most `far`.
///
/// Two sweeps, each over the half of the 26 neighbours that came before. They are exact: a shortest
/// path takes its steps in any order, so those that the first sweep follows may come last.
void spread_distances(std::vector<std::uint32_t>& distance, const Index3& size) {
    const auto sweep = [&](int direction) {
        for (int k = 0; k < size.z(); ++k) {
            for (int j = 0; j < size.y(); ++j) {
                for (int i = 0; i < size.x(); ++i) {
                    const Index3 p = direction > 0 ? Index3(i, j, k)
                                                   : Index3(size - Index3(i + 1, j + 1, k + 1));
                    const int at = p.x() + size.x() * (p.y() + size.y() * p.z());
                    std::uint32_t nearest = distance[static_cast<std::size_t>(at)];
                    if (nearest == 0) continue;
                    const auto look = [&](int dx, int dy, int dz) {
                        const Index3 q = p - direction * Index3(dx, dy, dz);
                        if ((q.array() < 0).any() || (q.array() >= size.array()).any()) return;
                        const int from = q.x() + size.x() * (q.y() + size.y() * q.z());
                        nearest = std::min(nearest, distance[static_cast<std::size_t>(from)] + 1);
                    };
                    for (int dy = -1; dy <= 1; ++dy) {
                        for (int dx = -1; dx <= 1; ++dx) look(dx, dy, 1);
                    }
                    for (int dx = -1; dx <= 1; ++dx) look(dx, 1, 0);
                    look(1, 0, 0);
                    distance[static_cast<std::size_t>(at)] = nearest;
                }
            }
        }
    };
    sweep(1);
    sweep(-1);
}

/// Active blocks of a page and its 26 neighbours: bit x of row (y, z), 12 of each.
struct Neighbourhood {
    static constexpr int size = 3 * page_blocks;
    std::array<std::array<std::uint32_t, size>, size> rows{}; // [z][y]

    void insert(const Index3& offset, std::uint64_t blocks) {
        for (int z = 0; z < page_blocks; ++z) {
            for (int y = 0; y < page_blocks; ++y) {
                const auto row = static_cast<std::uint32_t>(
                    blocks >> (page_blocks * (y + page_blocks * z)) & 15U);
                rows[static_cast<std::size_t>((offset.z() + 1) * page_blocks + z)]
                    [static_cast<std::size_t>((offset.y() + 1) * page_blocks + y)] |=
                    row << ((offset.x() + 1) * page_blocks);
            }
        }
    }

    /// Grows the set by one block to all 26 sides.
    void dilate() {
        for (auto& plane : rows) {
            for (std::uint32_t& row : plane) row |= row << 1 | row >> 1;
            std::uint32_t below = 0;
            for (std::size_t y = 0; y < size; ++y) {
                const std::uint32_t above = y + 1 < size ? plane[y + 1] : 0;
                below = std::exchange(plane[y], plane[y] | below | above);
            }
        }
        auto below = decltype(rows)::value_type{};
        for (std::size_t z = 0; z < size; ++z) {
            const auto here = rows[z];
            for (std::size_t y = 0; y < size; ++y) {
                rows[z][y] |= below[y] | (z + 1 < size ? rows[z + 1][y] : 0);
            }
            below = here;
        }
    }

    bool holds(int x, int y, int z) const {
        return (rows[static_cast<std::size_t>(page_blocks + z)]
                    [static_cast<std::size_t>(page_blocks + y)] >>
                    (page_blocks + x) &
                1U) != 0;
    }
};

/// The words of one page with active blocks; `active` by page number, 0 where there is none.
void write_page(const PageBox& box, const std::vector<std::uint64_t>& active, const BlockPage& page,
                std::uint32_t first_block, float iso, std::span<std::uint32_t> words) {
    Neighbourhood near;
    for (int z = -1; z <= 1; ++z) {
        for (int y = -1; y <= 1; ++y) {
            for (int x = -1; x <= 1; ++x) {
                const Index3 neighbour = page.coordinate + Index3(x, y, z);
                // The ring makes sure that all neighbours are in the box.
                near.insert(Index3(x, y, z),
                            active[static_cast<std::size_t>(box.number(neighbour))]);
            }
        }
    }
    const std::uint64_t own = active[static_cast<std::size_t>(box.number(page.coordinate))];
    std::uint32_t number = first_block;
    for (int place = 0; place < blocks_per_page; ++place) {
        std::uint32_t& word = words[static_cast<std::size_t>(place)];
        if ((own >> place & 1U) != 0) {
            word = word_active | number++;
            continue;
        }
        word = page.ranges[static_cast<std::size_t>(place)].max < iso ? word_inside : 0;
    }
    // Each dilation reaches the blocks whose cubes are one smaller; nothing within four blocks, all
    // that the neighbourhood shows, means five.
    for (std::uint32_t& word : words) {
        if ((word & word_active) == 0) word |= page_blocks + 1;
    }
    for (std::uint32_t reach = 1; reach <= page_blocks; ++reach) {
        near.dilate();
        for (int place = 0; place < blocks_per_page; ++place) {
            std::uint32_t& word = words[static_cast<std::size_t>(place)];
            if ((word & word_active) != 0 || (word & word_number) <= reach) continue;
            if (near.holds(place % page_blocks, place / page_blocks % page_blocks,
                           place / (page_blocks * page_blocks))) {
                word = (word & ~word_number) | reach;
            }
        }
    }
}

} // namespace

BlockTable make_block_table(const FieldSource& samples, const BlockRanges& ranges,
                            const std::vector<ActivePage>& active, float iso) {
    const PageBox box = box_of(ranges, active);
    BlockTable table{.first_page = box.first, .pages = box.size, .words = {}, .block_count = 0};

    std::vector<std::uint64_t> blocks(static_cast<std::size_t>(box.count()));
    std::vector<std::uint32_t> first_blocks;
    for (const ActivePage& page : active) {
        blocks[static_cast<std::size_t>(box.number(ranges.pages[page.page].coordinate))] =
            page.blocks;
        first_blocks.push_back(static_cast<std::uint32_t>(table.block_count));
        table.block_count += std::popcount(page.blocks);
    }

    const auto page_count = static_cast<std::size_t>(box.count());
    constexpr std::uint32_t far = 1U << 20; // beyond any distance in the box
    std::vector<std::uint32_t>& words = table.words;
    words.assign(page_count, far);
    for (std::size_t i = 0; i < page_count; ++i) {
        if (blocks[i] != 0) words[i] = 0;
    }
    spread_distances(words, box.size);

    // Signs of pages without active blocks: where the field lists blocks by their ranges, else by
    // one sample, a plane of pages at a time.
    tbb::parallel_for(0, box.size.z(), [&](int z) {
        constexpr int level = 5;
        static_assert(page_size == 1 << level);
        const Index3 lo = box.first + Index3(0, 0, z);
        std::vector<float> corners(static_cast<std::size_t>(box.size.x() * box.size.y()));
        samples.copy_box({lo, lo + Index3(box.size.x(), box.size.y(), 1)}, level, corners);
        for (std::size_t i = 0; i < corners.size(); ++i) {
            std::uint32_t& word = words[static_cast<std::size_t>(z) * corners.size() + i];
            if (word != 0) word |= word_of_page | (corners[i] < iso ? word_inside : 0);
        }
    });
    for (const BlockPage& page : ranges.pages) {
        if (!box.contains(page.coordinate)) continue;
        std::uint32_t& word = words[static_cast<std::size_t>(box.number(page.coordinate))];
        if (word == 0) continue;
        word = (word & ~word_inside) | (page.range.max < iso ? word_inside : 0);
    }

    words.resize(page_count + active.size() * blocks_per_page);
    tbb::parallel_for(std::size_t{0}, active.size(), [&](std::size_t i) {
        const BlockPage& page = ranges.pages[active[i].page];
        const std::size_t first_word = page_count + i * blocks_per_page;
        words[static_cast<std::size_t>(box.number(page.coordinate))] =
            word_active | static_cast<std::uint32_t>(first_word);
        write_page(box, blocks, page, first_blocks[i], iso,
                   std::span(words).subspan(first_word, blocks_per_page));
    });
    return table;
}

std::vector<Eigen::Vector2i> bounding_faces(const BlockTable& table) {
    const PageBox box{table.first_page, table.pages};
    const auto is_active = [](std::uint32_t word) { return (word & word_active) != 0; };
    // Blocks from the table's corner; the ring of empty pages makes sure that neighbours are in it.
    const auto word_at = [&](const Index3& block) {
        const Index3 page = block / page_blocks;
        const std::uint32_t word =
            table.words[static_cast<std::size_t>(box.number(table.first_page + page))];
        if (!is_active(word)) return word;
        const Index3 at = block - page_blocks * page;
        return table.words[(word & word_number) +
                           static_cast<std::size_t>(place_in_page(at.x(), at.y(), at.z()))];
    };
    std::vector<Eigen::Vector2i> faces;
    for (int i = 0; i < box.count(); ++i) {
        const std::uint32_t page_word = table.words[static_cast<std::size_t>(i)];
        if (!is_active(page_word)) continue;
        const Index3 page(i % box.size.x(), i / box.size.x() % box.size.y(),
                          i / (box.size.x() * box.size.y()));
        for (int place = 0; place < blocks_per_page; ++place) {
            const Index3 block = page_blocks * page + block_in_page(place);
            const std::uint32_t word = word_at(block);
            if (!is_active(word)) continue;
            for (int face = 0; face < 6; ++face) {
                const Index3 step = (face % 2 * 2 - 1) * Index3::Unit(face / 2);
                if (!is_active(word_at(block + step)))
                    faces.emplace_back(static_cast<int>(word & word_number), face);
            }
        }
    }
    return faces;
}

} // namespace isocast
