// Which 8^3 blocks can hold a piece of the isosurface.
// SPDX-License-Identifier: MPL-2.0
#include "volume/blocks.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <limits>
#include <unordered_map>
#include <utility>

namespace isocast {

namespace {

// Blocks are looked at in groups of 4^3, so that neighbours share the samples between them:
//
//     8g-1  8g ........ one group: 32 points along x ........ 8g+31  +32  +33
//     |<-------------------- 35 samples per axis -------------------------->|
//        | block 0: -1 … 9 | block 1: 7 … 17 | ...
constexpr int group_blocks = 4;
constexpr int group_size = group_blocks * block_size;
constexpr int group_samples = group_size + filter_support_below + filter_support_above;
constexpr int block_support = block_size + filter_support_below + filter_support_above;

/// A group of 4^3 blocks: which of them are candidates, and then which are active.
struct Group {
    Index3 coordinate = Index3::Zero();
    std::uint64_t blocks = 0; // bit x + 4 y + 16 z
    IndexBox surface_box;
};

std::uint64_t bit_of(int x, int y, int z) {
    return std::uint64_t{1} << (x + group_blocks * (y + group_blocks * z));
}

/// The blocks whose support touches an active box, in groups. Without a band the field ends at its
/// extent, where it is clamped: a surface that continues beyond is not the field's.
std::vector<Group> candidate_groups(const FieldSource& field) {
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
        const Index3 lo = floor_div(near.lo, group_blocks);
        const Index3 hi = floor_div((near.hi.array() - 1).matrix(), group_blocks);
        for (int gz = lo.z(); gz <= hi.z(); ++gz) {
            for (int gy = lo.y(); gy <= hi.y(); ++gy) {
                for (int gx = lo.x(); gx <= hi.x(); ++gx) {
                    const Index3 group(gx, gy, gz);
                    const IndexBox all{group_blocks * group,
                                       (group_blocks * (group.array() + 1)).matrix()};
                    const IndexBox part = intersection(near, all);
                    std::uint64_t mask = 0;
                    for (int z = part.lo.z(); z < part.hi.z(); ++z) {
                        for (int y = part.lo.y(); y < part.hi.y(); ++y) {
                            for (int x = part.lo.x(); x < part.hi.x(); ++x) {
                                mask |= bit_of(x - all.lo.x(), y - all.lo.y(), z - all.lo.z());
                            }
                        }
                    }
                    masks[group] |= mask;
                }
            }
        }
    }
    std::vector<Group> groups;
    groups.reserve(masks.size());
    for (const auto& [coordinate, mask] : masks) groups.push_back({coordinate, mask, {}});
    std::ranges::sort(groups, zyx_less, &Group::coordinate);
    return groups;
}

/// The samples of a group.
using Samples = std::vector<float>;

const float* sample_at(const Samples& samples, int x, int y, int z) {
    return &samples[static_cast<std::size_t>(x + group_samples * (y + group_samples * z))];
}

/// Whether the samples of a block's support hold `iso`; x, y, z is its lowest sample.
bool holds_iso(const Samples& samples, int x, int y, int z, float iso) {
    float min = std::numeric_limits<float>::infinity();
    float max = -min;
    for (int dz = 0; dz < block_support; ++dz) {
        for (int dy = 0; dy < block_support; ++dy) {
            const float* row = sample_at(samples, x, y + dy, z + dz);
            for (int dx = 0; dx < block_support; ++dx) {
                min = std::min(min, row[dx]);
                max = std::max(max, row[dx]);
            }
        }
    }
    return min <= iso && iso <= max;
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

/// Leaves only the active blocks of `group`.
void find_active(const FieldSource& field, float iso, Group& group) {
    const Index3 first = (group_size * group.coordinate.array() - filter_support_below).matrix();
    Samples samples(static_cast<std::size_t>(group_samples) * group_samples * group_samples);
    field.copy_box({first, (first.array() + group_samples).matrix()}, 0, samples);
    const std::uint64_t candidates = std::exchange(group.blocks, 0);
    const auto [min, max] = std::ranges::minmax(samples);
    if (!(min <= iso && iso <= max)) return;
    for (int z = 0; z < group_blocks; ++z) {
        for (int y = 0; y < group_blocks; ++y) {
            for (int x = 0; x < group_blocks; ++x) {
                const Index3 at = block_size * Index3(x, y, z);
                if ((candidates & bit_of(x, y, z)) == 0 ||
                    !holds_iso(samples, at.x(), at.y(), at.z(), iso)) {
                    continue;
                }
                group.blocks |= bit_of(x, y, z);
                const IndexBox cells = cells_on_both_sides(samples, at.x() + filter_support_below,
                                                           at.y() + filter_support_below,
                                                           at.z() + filter_support_below, iso);
                if (cells.is_empty()) continue;
                group.surface_box =
                    bounding_box(group.surface_box, {cells.lo + first, cells.hi + first});
            }
        }
    }
}

} // namespace

ActiveBlocks find_active_blocks(const FieldSource& field, float iso, const Progress& progress) {
    std::vector<Group> groups = candidate_groups(field);
    std::atomic<std::size_t> done = 0;
    tbb::parallel_for(std::size_t{0}, groups.size(), [&](std::size_t i) {
        find_active(field, iso, groups[i]);
        const std::size_t count = ++done;
        if (progress && count % 64 == 0) {
            progress("blocks", static_cast<double>(count) / static_cast<double>(groups.size()));
        }
    });
    ActiveBlocks active;
    for (const Group& group : groups) {
        active.surface_box = bounding_box(active.surface_box, group.surface_box);
        for (int z = 0; z < group_blocks; ++z) {
            for (int y = 0; y < group_blocks; ++y) {
                for (int x = 0; x < group_blocks; ++x) {
                    if ((group.blocks & bit_of(x, y, z)) == 0) continue;
                    active.coordinates.push_back(group_blocks * group.coordinate + Index3(x, y, z));
                }
            }
        }
    }
    // Beyond the extent a field without a band is clamped; its surface ends at the border.
    if (!field.half_width_world()) {
        active.surface_box = intersection(active.surface_box, field.extent());
    }
    std::ranges::sort(active.coordinates, zyx_less);
    return active;
}

} // namespace isocast
