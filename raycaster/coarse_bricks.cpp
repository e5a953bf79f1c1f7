// Bricks of lower resolution, so that all fit a texture budget.
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/coarse_bricks.h"

#include "filtering/subdivision.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <tuple>
#include <utility>

namespace isocast {

namespace {

constexpr int samples_across(int level) {
    return (block_size >> level) + filter_support_below + filter_support_above;
}
/// Rows of a plane: a multiple of 11 and of 7, which bricks of levels 0 and 1 have.
constexpr int plane_rows = 77;

/// The samples that a page's blocks read.
IndexBox box_of_page(const Index3& page) {
    const Index3 lo = (page_size * page.array() - filter_support_below).matrix();
    return {lo, (lo.array() + page_samples).matrix()};
}

using PageSamples = std::vector<float>;

PageSamples samples_of_page(const FieldSource& field, const Index3& page) {
    const IndexBox box = box_of_page(page);
    PageSamples samples(static_cast<std::size_t>(box.sample_count()));
    field.copy_box(box, 0, samples);
    return samples;
}

/// What a page's samples are if all blocks have that level.
PageSamples samples_of_page_at(const FieldSource& control, const Index3& page, int level) {
    std::array<IndexBox, coarsest_level + 1> boxes{box_of_page(page)};
    for (std::size_t l = 1; l < boxes.size(); ++l) boxes[l] = coarse_support(boxes[l - 1]);
    std::vector<double> samples =
        coarse_samples(control, boxes[static_cast<std::size_t>(level)], level);
    for (int l = level - 1; l >= 0; --l)
        samples = subdivided(std::move(samples), boxes[static_cast<std::size_t>(l)]);
    return {samples.begin(), samples.end()};
}

/// Of each cell the greatest Bezier point of the spline, in place; the cell of sample (1, 1, 1)
/// comes first, and beyond the page's cells nothing is defined.
///
/// source  filtering/certificate.cpp: hull_of
void take_greatest_of_cells(PageSamples& samples) {
    PageSamples from(samples.size());
    for (const std::size_t s : {in_page(1, 0, 0), in_page(0, 1, 0), in_page(0, 0, 1)}) {
        std::swap(from, samples);
        const float* c0 = from.data();
        const float* c1 = c0 + s;
        const float* c2 = c1 + s;
        const float* c3 = c2 + s;
        float* to = samples.data();
        const std::size_t n = from.size() - 3 * s;
        for (std::size_t i = 0; i < n; ++i) {
            const float p = (2 * c1[i] + c2[i]) * (1.0F / 3);
            const float q = (c1[i] + 2 * c2[i]) * (1.0F / 3);
            const float before = (c0[i] + 4 * c1[i] + c2[i]) * (1.0F / 6);
            const float behind = (c1[i] + 4 * c2[i] + c3[i]) * (1.0F / 6);
            const float inner = p > q ? p : q;
            const float outer = before > behind ? before : behind;
            to[i] = inner > outer ? inner : outer;
        }
    }
}

/// Of each cell upper bounds of a function and of its negative.
struct CellBounds {
    PageSamples greatest, negative;

    explicit CellBounds(const PageSamples& f) : greatest(f), negative(f) {
        for (float& value : negative) value = -value;
        take_greatest_of_cells(greatest);
        take_greatest_of_cells(negative);
    }
    bool holds(std::size_t cell, float iso, float slack) const {
        return greatest[cell] >= iso - slack && negative[cell] >= -iso - slack;
    }
};

/// The greatest |g - f| in a block.
struct Residual {
    float at_surface = -1; // in the cells where f or g can be iso; -1 if there are none
    float anywhere = 0;
};

/// Of the blocks of a page.
std::array<Residual, blocks_per_page> residuals_of(const PageSamples& f, const PageSamples& g,
                                                   std::uint64_t blocks, float iso) {
    const CellBounds f_bounds(f);
    const CellBounds g_bounds(g);
    PageSamples difference(f.size());
    float magnitude = 0;
    for (std::size_t i = 0; i < f.size(); ++i) {
        difference[i] = std::abs(g[i] - f[i]);
        magnitude = std::max({magnitude, std::abs(f[i]), std::abs(g[i])});
    }
    take_greatest_of_cells(difference);
    // 2^-20: a dozen roundings on the way to a Bezier point, and some to spare.
    const float slack = 0x1p-20F * magnitude;
    std::array<Residual, blocks_per_page> residuals{};
    for (; blocks != 0; blocks &= blocks - 1) {
        const int place = std::countr_zero(blocks);
        const Index3 lo = block_size * block_in_page(place);
        Residual& residual = residuals[static_cast<std::size_t>(place)];
        for (int z = lo.z(); z < lo.z() + block_size; ++z) {
            for (int y = lo.y(); y < lo.y() + block_size; ++y) {
                for (int x = lo.x(); x < lo.x() + block_size; ++x) {
                    const std::size_t i = in_page(x, y, z);
                    const float here = difference[i] + slack;
                    residual.anywhere = std::max(residual.anywhere, here);
                    if (f_bounds.holds(i, iso, slack) || g_bounds.holds(i, iso, slack))
                        residual.at_surface = std::max(residual.at_surface, here);
                }
            }
        }
    }
    return residuals;
}

/// A block whose level is to be chosen.
struct Candidate {
    Index3 block;
    /// Of each level, no less than that of the level before [world].
    std::array<float, coarsest_level + 1> residual{};
    int level = 0;
};

/// Blocks by pages; sorted, so that results do not depend on hashes.
struct LessZyx {
    bool operator()(const Index3& a, const Index3& b) const { return zyx_less(a, b); }
};
using BlocksOfPages = std::map<Index3, std::uint64_t, LessZyx>;

/// Calls use(block) for blocks of a page.
template<class Use>
void for_blocks(const Index3& page, std::uint64_t blocks, Use use) {
    for (; blocks != 0; blocks &= blocks - 1)
        use(Index3(page_blocks * page + block_in_page(std::countr_zero(blocks))));
}

/// Appends blocks with their residuals.
void add_candidates(const FieldSource& control, const BlocksOfPages& blocks, float iso,
                    std::vector<Candidate>& candidates, const Progress& progress) {
    const std::vector<std::pair<Index3, std::uint64_t>> pages(blocks.begin(), blocks.end());
    std::vector<std::array<std::array<Residual, blocks_per_page>, coarsest_level + 1>> residuals(
        pages.size());
    tbb::parallel_for(std::size_t{0}, pages.size(), [&](std::size_t i) {
        const auto& [page, mask] = pages[i];
        const PageSamples f = samples_of_page(control, page);
        for (int level = 1; level <= coarsest_level; ++level)
            residuals[i][static_cast<std::size_t>(level)] =
                residuals_of(f, samples_of_page_at(control, page, level), mask, iso);
    });
    if (progress) progress("residuals", 1);
    for (std::size_t i = 0; i < pages.size(); ++i) {
        for (std::uint64_t rest = pages[i].second; rest != 0; rest &= rest - 1) {
            const int place = std::countr_zero(rest);
            Candidate candidate{page_blocks * pages[i].first + block_in_page(place)};
            for (std::size_t level = 1; level <= coarsest_level; ++level) {
                const Residual& own = residuals[i][level][static_cast<std::size_t>(place)];
                candidate.residual[level] =
                    std::max(candidate.residual[level - 1],
                             own.at_surface >= 0 ? own.at_surface : own.anywhere);
            }
            candidates.push_back(candidate);
        }
    }
}

/// The texels that may be used.
struct Budget {
    std::int64_t texels;
    int texel_bytes;
    Fetch fetch;

    bool holds(const LevelCounts& counts) const {
        return CoarseLayout(fetch, counts).texels <= texels;
    }
};

Budget budget_of(const StorageOptions& options) {
    const int texel_bytes = gl::byte_count(texel_format(options));
    return {std::min(options.budget_bytes / texel_bytes, gl::max_buffer_texels()), texel_bytes,
            options.fetch};
}

std::int64_t texels_of_brick(Fetch fetch, int level) {
    const std::int64_t n = samples_across(level);
    return n * n * (fetch == Fetch::Rows ? block_size >> level : n);
}

/// Halves bricks, the least residual for the memory that it frees first, until they fit.
void choose_levels(std::vector<Candidate>& candidates, const Budget& budget) {
    struct Halving {
        float cost; // residual a texel
        int level;  // after it; costs grow with it, since each frees less than the one before
        std::size_t candidate;
    };
    std::vector<Halving> halvings;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
        candidates[i].level = 0;
        for (int level = 1; level <= coarsest_level; ++level) {
            const auto freed = static_cast<float>(texels_of_brick(budget.fetch, level - 1) -
                                                  texels_of_brick(budget.fetch, level));
            halvings.push_back(
                {candidates[i].residual[static_cast<std::size_t>(level)] / freed, level, i});
        }
    }
    std::ranges::sort(halvings, {}, [](const Halving& halving) {
        return std::tuple(halving.cost, halving.level, halving.candidate);
    });
    LevelCounts counts{static_cast<int>(candidates.size())};
    auto next = halvings.begin();
    while (!budget.holds(counts)) {
        if (next == halvings.end()) {
            throw ResourceError(fmt::format(
                "{} bricks need {} bytes even with one cell each, more than a texture budget of {}",
                candidates.size(), CoarseLayout(budget.fetch, counts).texels * budget.texel_bytes,
                budget.texels * budget.texel_bytes));
        }
        candidates[next->candidate].level = next->level;
        --counts[static_cast<std::size_t>(next->level - 1)];
        ++counts[static_cast<std::size_t>(next->level)];
        ++next;
    }
}

/// Greatest |value - iso| of the samples that coarse blocks of a page are stored as.
float greatest_coarse_value(const CoarsenedField& field, const Index3& page, std::uint64_t mask,
                            float iso) {
    float greatest = 0;
    for_blocks(page, mask, [&](const Index3& block) {
        const int level = field.levels().at(block);
        if (level == 0) return;
        for (const double sample : field.samples_at(samples_of_block(block, level), level))
            greatest = std::max(greatest, std::abs(static_cast<float>(sample) - iso));
    });
    return greatest;
}

/// What is known once levels stand: residuals in `blocks`, and what is stored.
void measure(const FieldSource& control, const BlocksOfPages& blocks, float iso,
             CoarseBricks& bricks) {
    const std::vector<std::pair<Index3, std::uint64_t>> pages(blocks.begin(), blocks.end());
    std::vector<std::pair<float, float>> found(pages.size());
    tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t i) {
        const auto& [page, mask] = pages[i];
        const PageSamples f = samples_of_page(control, page);
        const PageSamples g = samples_of_page(*bricks.field, page);
        auto& [residual, value] = found[i];
        for (const Residual& block : residuals_of(f, g, mask, iso))
            residual = std::max(residual, block.at_surface);
        for (const float sample : g) value = std::max(value, std::abs(sample - iso));
        value = std::max(value, greatest_coarse_value(*bricks.field, page, mask, iso));
    });
    bricks.greatest_residual = 0;
    bricks.greatest_value = 0;
    for (const auto& [residual, value] : found) {
        bricks.greatest_residual = std::max(bricks.greatest_residual, residual);
        bricks.greatest_value = std::max(bricks.greatest_value, value);
    }
}

/// The active blocks, by their pages' coordinates.
BlocksOfPages by_pages(const BlockRanges& ranges, const std::vector<ActivePage>& active) {
    BlocksOfPages blocks;
    for (const ActivePage& page : active) blocks[ranges.pages[page.page].coordinate] = page.blocks;
    return blocks;
}

LevelCounts counts_of(const BlocksOfPages& blocks, const BlockLevels& levels) {
    LevelCounts counts{};
    for (const auto& [page, mask] : blocks) {
        for_blocks(page, mask, [&](const Index3& block) {
            ++counts[static_cast<std::size_t>(levels.at(block))];
        });
    }
    return counts;
}

} // namespace

IndexBox samples_of_block(const Index3& block, int level) {
    const Index3 lo = ((block_size >> level) * block.array() - filter_support_below).matrix();
    return {lo, (lo.array() + samples_across(level)).matrix()};
}

CoarseLayout::CoarseLayout(Fetch way, const LevelCounts& counts)
    : fetch(way), row_stride(way == Fetch::Rows ? block_size : plane_rows),
      plane_stride(row_stride * plane_rows) {
    for (std::size_t level = 0; level < counts.size(); ++level) {
        const int samples = samples_across(static_cast<int>(level));
        across[level] = row_stride / (fetch == Fetch::Rows ? block_size >> level : samples);
        const int per_group = across[level] * (plane_rows / samples);
        const int groups = (counts[level] + per_group - 1) / per_group;
        first[level] = texels;
        texels += std::int64_t{groups} * samples * plane_stride;
    }
}

std::int64_t CoarseLayout::address(int level, int i) const {
    const int samples = samples_across(level);
    const int n = across[static_cast<std::size_t>(level)];
    const int width = row_stride / n;
    const int per_group = n * (plane_rows / samples);
    return first[static_cast<std::size_t>(level)] +
           std::int64_t{i / per_group} * samples * plane_stride +
           std::int64_t{i % per_group / n} * samples * row_stride +
           std::int64_t{i % n} * (fetch == Fetch::Rows ? width : samples);
}

template<class T>
void CoarseLayout::store(const T* samples, int level, std::byte* first_texel) const {
    const int cells = block_size >> level;
    const int n = samples_across(level);
    const auto texel = static_cast<std::ptrdiff_t>((fetch == Fetch::Rows ? 4 : 1) * sizeof(T));
    for (int z = 0; z < n; ++z) {
        for (int y = 0; y < n; ++y, samples += n) {
            std::byte* out = first_texel + texel * (std::ptrdiff_t{y} * row_stride +
                                                    std::ptrdiff_t{z} * plane_stride);
            if (fetch == Fetch::Samples) {
                std::memcpy(out, samples, static_cast<std::size_t>(n) * sizeof(T));
                continue;
            }
            for (int x = 0; x < cells; ++x, out += texel)
                std::memcpy(out, samples + x, static_cast<std::size_t>(texel));
        }
    }
}
template void CoarseLayout::store(const float*, int, std::byte*) const;
template void CoarseLayout::store(const std::uint16_t*, int, std::byte*) const;

Certificate certify_coarse_block(std::vector<double> samples, const Index3& block, int level) {
    for (int finer = level - 1; finer >= 0; --finer)
        samples = subdivided(std::move(samples), samples_of_block(block, finer));
    const std::vector<float> fine(samples.begin(), samples.end());
    constexpr int n = samples_across(0);
    Certificate certificate = certify_block(fine.data(), n, n * n, Kernel::BSpline);
    if (level > 0) {
        // Rounding moves a sample by up to u = 2^-24 of the greatest one, a first difference by 2u
        // and a second by 4u; a gradient has three of those, a Hessian nine.
        float greatest = 0;
        for (const float sample : fine) greatest = std::max(greatest, std::abs(sample));
        certificate.slope += 0x1p-22F * greatest;
        certificate.bend += 0x1p-20F * greatest;
    }
    return certificate;
}

std::optional<CoarseBricks> coarsen(const std::shared_ptr<const FieldSource>& control,
                                    Kernel kernel, BlockRanges& ranges,
                                    std::vector<ActivePage>& active, float iso,
                                    const StorageOptions& options, const Progress& progress) {
    if (kernel != Kernel::BSpline)
        throw InputError("only bricks of cubic B-splines can be coarsened: their filters are "
                         "interpolating, bspline and exact");
    if (options.brick_size != block_size) {
        throw InputError(fmt::format("bricks of {} cells cannot be coarsened, only those of {}",
                                     options.brick_size, block_size));
    }
    const Budget budget = budget_of(options);
    BlocksOfPages fresh = by_pages(ranges, active);
    BlocksOfPages known;
    {
        const LevelCounts all = counts_of(fresh, {});
        if (all[0] * BrickLayout(options).brick_texels <= budget.texels) return std::nullopt;
    }
    std::vector<Candidate> candidates;
    // Ends: each turn adds blocks to those known, of which there are finitely many near the
    // field's.
    for (;;) {
        add_candidates(*control, fresh, iso, candidates, progress);
        for (const auto& [page, mask] : fresh) known[page] |= mask;
        choose_levels(candidates, budget);
        BlockLevels levels;
        for (const Candidate& candidate : candidates) levels.set(candidate.block, candidate.level);

        CoarseBricks bricks{.field = std::make_shared<CoarsenedField>(control, std::move(levels))};
        ranges = find_block_ranges(*bricks.field, kernel, progress);
        active = active_pages(ranges, iso);
        BlocksOfPages now = by_pages(ranges, active);
        if (options.format != SampleFormat::Float32) {
            measure(*control, now, iso, bricks);
            active =
                active_pages(ranges, iso, Codec(options.format, bricks.greatest_value).error());
            now = by_pages(ranges, active);
        }
        bricks.counts = counts_of(now, bricks.field->levels());
        fresh.clear();
        for (const auto& [page, mask] : now) {
            const auto old = known.find(page);
            const std::uint64_t added = old == known.end() ? mask : mask & ~old->second;
            if (added != 0) fresh[page] = added;
        }
        if (!budget.holds(bricks.counts)) continue;
        for (const auto& [page, mask] : fresh) known[page] |= mask;
        measure(*control, known, iso, bricks);
        return bricks;
    }
}

namespace {

/// The levels of all blocks of some pages, by place_in_page.
std::vector<std::array<int, blocks_per_page>> levels_of(const FieldSource& field,
                                                        const BlockRanges& ranges) {
    std::vector<std::array<int, blocks_per_page>> levels(ranges.pages.size());
    tbb::parallel_for(std::size_t{0}, levels.size(), [&](std::size_t i) {
        const Index3 first = page_blocks * ranges.pages[i].coordinate;
        for (std::uint64_t rest = ranges.pages[i].blocks; rest != 0; rest &= rest - 1) {
            const int place = std::countr_zero(rest);
            const Index3 lo = block_size * (first + block_in_page(place));
            levels[i][static_cast<std::size_t>(place)] =
                field.finest_level({lo, (lo.array() + block_size + 1).matrix()});
        }
    });
    return levels;
}

/// Blocks that another field shows leave the pages.
void keep_shown(BlockRanges& ranges, const std::vector<std::array<int, blocks_per_page>>& levels) {
    for (std::size_t i = 0; i < levels.size(); ++i)
        for (int place = 0; place < blocks_per_page; ++place)
            if (levels[i][static_cast<std::size_t>(place)] < 0)
                ranges.pages[i].blocks &= ~(std::uint64_t{1} << place);
}

} // namespace

std::optional<CoarseBricks> adapt(const FieldSource& field,
                                  const std::shared_ptr<const FieldSource>& control, Kernel kernel,
                                  BlockRanges& ranges, std::vector<ActivePage>& active, float iso,
                                  const StorageOptions& options, const Progress& progress) {
    const BlockRanges blocks = find_blocks(*control);
    const auto found = levels_of(field, blocks);
    const auto with_all = [&](const FieldSource& source) {
        ranges = find_block_ranges(source, kernel, progress);
        keep_shown(ranges, found); // the same pages
        active = active_pages(ranges, iso);
    };
    BlockLevels levels;
    bool is_coarse = false;
    for (std::size_t i = 0; i < found.size(); ++i)
        for_blocks(blocks.pages[i].coordinate, blocks.pages[i].blocks, [&](const Index3& block) {
            const Index3 at = block - page_blocks * blocks.pages[i].coordinate;
            const int level =
                found[i][static_cast<std::size_t>(place_in_page(at.x(), at.y(), at.z()))];
            if (level <= 0) return;
            is_coarse = true;
            levels.set(block, std::min(level, coarsest_level));
        });
    if (is_coarse && kernel == Kernel::BSpline && options.fetch != Fetch::Linear &&
        options.brick_size == block_size) {
        CoarseBricks bricks{.field =
                                std::make_shared<CoarsenedField>(control, std::move(levels), true)};
        with_all(*bricks.field);
        const auto find_greatest_value = [&] {
            std::vector<float> values(active.size());
            tbb::parallel_for(std::size_t{0}, active.size(), [&](std::size_t i) {
                const BlockPage& page = ranges.pages[active[i].page];
                values[i] = std::max(
                    {iso - page.samples.min, page.samples.max - iso,
                     greatest_coarse_value(*bricks.field, page.coordinate, active[i].blocks, iso)});
            });
            bricks.greatest_value = values.empty() ? 0 : std::ranges::max(values);
        };
        find_greatest_value();
        if (options.format != SampleFormat::Float32) {
            active =
                active_pages(ranges, iso, Codec(options.format, bricks.greatest_value).error());
            find_greatest_value();
        }
        bricks.counts = counts_of(by_pages(ranges, active), bricks.field->levels());
        if (budget_of(options).holds(bricks.counts)) return bricks;
    }
    with_all(*control);
    return std::nullopt;
}

} // namespace isocast
