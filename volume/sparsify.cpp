// Any field as sparse blocks, as files store them.
// SPDX-License-Identifier: MPL-2.0
#include "volume/sparsify.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace isocast {

namespace {

/// Blocks that hold a sample of an active box, by z, y, x.
std::vector<Index3> candidate_blocks(const FieldSource& field) {
    std::vector<Index3> candidates;
    for (const IndexBox& box : field.active_boxes()) {
        if (box.is_empty()) continue;
        const IndexBox over = blocks_over(box);
        for (int z = over.lo.z(); z < over.hi.z(); ++z) {
            for (int y = over.lo.y(); y < over.hi.y(); ++y) {
                for (int x = over.lo.x(); x < over.hi.x(); ++x) candidates.emplace_back(x, y, z);
            }
        }
    }
    std::ranges::sort(candidates, zyx_less);
    candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
    return candidates;
}

FieldBlock copy_block(const FieldSource& field, const Index3& coordinate) {
    FieldBlock block;
    block.coordinate = coordinate;
    const Index3 lo = block_size * coordinate;
    field.copy_box({lo, (lo.array() + block_size).matrix()}, 0, block.values);
    return block;
}

/// Marks the samples in the band; the others become ± `half_width`.
void mark_band(FieldBlock& block, float half_width) {
    for (std::size_t i = 0; i < block.values.size(); ++i) {
        block.active[i] = std::abs(block.values[i]) < half_width;
        if (!block.active[i]) block.values[i] = std::copysign(half_width, block.values[i]);
    }
}

/// Marks the samples of the extent; the others become `background`.
void mark_extent(FieldBlock& block, const IndexBox& extent, float background) {
    for (int i = 0; i < samples_per_block; ++i) {
        const Index3 within(i % block_size, i / block_size % block_size,
                            i / (block_size * block_size));
        const auto at = static_cast<std::size_t>(i);
        block.active[at] = extent.contains(block_size * block.coordinate + within);
        if (!block.active[at]) block.values[at] = background;
    }
}

/// The greatest |value| of the samples on the six faces of the extent.
float greatest_border_value(const FieldSource& field) {
    const IndexBox extent = field.extent();
    float greatest = 0;
    for (int axis = 0; axis < 3; ++axis) {
        for (const int at : {extent.lo[axis], extent.hi[axis] - 1}) {
            IndexBox face = extent;
            face.lo[axis] = at;
            face.hi[axis] = at + 1;
            const ValueRange range = field.value_range(face);
            greatest = std::max({greatest, std::abs(range.min), std::abs(range.max)});
        }
    }
    return greatest;
}

} // namespace

SparseField to_sparse(const FieldSource& field, const Progress& progress) {
    const std::optional<double> half_width = field.half_width_world();
    const double background = half_width ? *half_width : greatest_border_value(field);
    const auto background_sample = static_cast<float>(background);
    const std::vector<Index3> candidates = candidate_blocks(field);
    // Rows along x: within one, the sign of what is left out follows from what is kept before it.
    std::vector<std::size_t> row_begin;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
        if (i == 0 || candidates[i].tail<2>() != candidates[i - 1].tail<2>())
            row_begin.push_back(i);
    }
    const std::size_t row_count = row_begin.size();
    row_begin.push_back(candidates.size());
    std::vector<FieldBlocks> rows(row_count);
    std::atomic<std::size_t> done = 0;
    tbb::parallel_for(std::size_t{0}, row_count, [&](std::size_t row) {
        bool inside = false;
        for (std::size_t i = row_begin[row]; i < row_begin[row + 1]; ++i) {
            FieldBlock block = copy_block(field, candidates[i]);
            if (!half_width) {
                mark_extent(block, field.extent(), background_sample);
                rows[row].push_back(block);
                continue;
            }
            mark_band(block, background_sample);
            const auto is_background = [&](float value) {
                return value == (inside ? -background_sample : background_sample);
            };
            // A block outside the band is left out only if the row rule gives its samples' sign.
            if (std::ranges::all_of(block.values, is_background)) continue;
            inside = is_inside_beyond(block);
            rows[row].push_back(block);
        }
        const std::size_t count = ++done;
        if (progress && count % 64 == 0) {
            progress("blocks", static_cast<double>(count) / static_cast<double>(row_count));
        }
    });
    FieldBlocks blocks;
    for (FieldBlocks& row : rows) {
        blocks.insert(blocks.end(), row.begin(), row.end());
        FieldBlocks().swap(row);
    }
    return {field.space(), background, half_width ? Outside::SignedBackground : Outside::Background,
            std::move(blocks)};
}

} // namespace isocast
