// A field that stores only the 8^3 blocks near its surface.
// SPDX-License-Identifier: MPL-2.0
#include "volume/sparse_field.h"

#include "volume/assert.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

namespace isocast {

namespace {

int ceil_div(std::int64_t a, std::int64_t b) {
    return static_cast<int>(a >= 0 ? (a + b - 1) / b : -(-a / b));
}

} // namespace

void require_voxel_size(double voxel_size_world) {
    if (!(voxel_size_world > 0) || !std::isfinite(voxel_size_world))
        throw InputError(fmt::format("voxel size {} is not a positive number", voxel_size_world));
}

void require_band(double voxel_size_world, double half_width_voxels, std::string_view remedy) {
    require_voxel_size(voxel_size_world);
    if (!(half_width_voxels >= 1) || !std::isfinite(half_width_voxels))
        throw InputError(fmt::format("half width {} is below 1 voxel", half_width_voxels));
    const double half_width_world = half_width_voxels * voxel_size_world;
    if (!(half_width_world >= std::numeric_limits<float>::min() &&
          half_width_world <= std::numeric_limits<float>::max()))
        throw InputError(fmt::format("a half width of {:.3g} is beyond what 32-bit floats hold{}",
                                     half_width_world, remedy));
}

IndexBox blocks_over(const IndexBox& box) {
    return {floor_div(box.lo, block_size),
            (floor_div((box.hi.array() - 1).matrix(), block_size).array() + 1).matrix()};
}

std::vector<IndexBox> runs_of_blocks(std::span<const IndexBox> boxes) {
    struct Run {
        int z, y, x_lo, x_hi;
    };
    std::vector<Run> runs;
    for (const IndexBox& box : boxes) {
        const IndexBox blocks = blocks_over(box);
        for (int z = blocks.lo.z(); z < blocks.hi.z(); ++z) {
            for (int y = blocks.lo.y(); y < blocks.hi.y(); ++y) {
                runs.push_back({z, y, blocks.lo.x(), blocks.hi.x()});
            }
        }
    }
    std::ranges::sort(runs, {}, [](const Run& run) { return std::tuple(run.z, run.y, run.x_lo); });
    std::vector<IndexBox> united;
    for (auto run = runs.begin(); run != runs.end();) {
        int x_hi = run->x_hi;
        auto next = run + 1;
        for (; next != runs.end() && next->z == run->z && next->y == run->y && next->x_lo <= x_hi;
             ++next) {
            x_hi = std::max(x_hi, next->x_hi);
        }
        united.push_back({block_size * Index3(run->x_lo, run->y, run->z),
                          block_size * Index3(x_hi, run->y + 1, run->z + 1)});
        run = next;
    }
    return united;
}

namespace {

/// In eight lanes, which compilers see.
ValueRange range_of(const FieldBlock& block) {
    constexpr std::size_t lanes = 8;
    std::array<float, lanes> min;
    std::copy_n(block.values.begin(), lanes, min.begin());
    std::array<float, lanes> max = min;
    for (std::size_t i = lanes; i < block.values.size(); i += lanes) {
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            const float value = block.values[i + lane];
            min[lane] = value < min[lane] ? value : min[lane];
            max[lane] = max[lane] < value ? value : max[lane];
        }
    }
    return {std::ranges::min(min), std::ranges::max(max)};
}

struct BlockPlace {
    Index3 coordinate;
    std::uint32_t block;
};

void sort(std::vector<BlockPlace>& places) {
    tbb::parallel_sort(places, [](const BlockPlace& a, const BlockPlace& b) {
        return zyx_less(a.coordinate, b.coordinate);
    });
}

} // namespace

std::vector<std::uint32_t> zyx_order(std::span<const FieldBlock> blocks) {
    std::vector<BlockPlace> places(blocks.size());
    tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t i) {
        places[i] = {blocks[i].coordinate, static_cast<std::uint32_t>(i)};
    });
    sort(places);
    std::vector<std::uint32_t> order(blocks.size());
    std::ranges::transform(places, order.begin(), &BlockPlace::block);
    return order;
}

SparseField::SparseField(GridSpace space, double background_world, Outside outside,
                         FieldBlocks blocks)
    : space_(std::move(space)), background_world_(background_world), outside_(outside),
      blocks_(std::move(blocks)) {
    if (outside_ == Outside::SignedBackground && !(background_world_ > 0)) {
        throw InputError(fmt::format("a signed distance field needs a background above 0, not {}",
                                     background_world_));
    }
    // The blocks are looked at once, in the order that they lie in: they may be in a scratch file.
    std::vector<BlockPlace> places(blocks_.size());
    std::vector<ValueRange> ranges(blocks_.size());
    tbb::parallel_for(std::size_t{0}, blocks_.size(), [&](std::size_t i) {
        places[i] = {blocks_[i].coordinate, static_cast<std::uint32_t>(i)};
        ranges[i] = range_of(blocks_[i]);
    });
    sort(places);
    for (const BlockPlace& place : places) {
        order_.push_back(place.block);
        coordinates_.push_back(place.coordinate);
        ranges_.push_back(ranges[place.block]);
    }
    const auto twice = std::ranges::adjacent_find(coordinates_);
    if (twice != coordinates_.end()) {
        throw InputError(fmt::format("the block ({}, {}, {}) occurs twice in a sparse field",
                                     twice->x(), twice->y(), twice->z()));
    }
    for (const Index3& b : coordinates_) {
        const Index3 lo = block_size * b;
        extent_ = bounding_box(extent_, {lo, (lo.array() + block_size).matrix()});
    }
    // A point reads up to two samples away from its cell: beyond this border all are background.
    if (outside_ == Outside::Background && !blocks_.empty()) extent_ = dilated(extent_, 2, 2);
}

std::optional<double> SparseField::half_width_world() const {
    if (outside_ == Outside::SignedBackground) return background_world_;
    return std::nullopt;
}

std::vector<IndexBox> SparseField::active_boxes() const {
    std::vector<IndexBox> boxes;
    for (const Index3& b : coordinates_) {
        const Index3 lo = block_size * b;
        const Index3 hi = (lo.array() + block_size).matrix();
        if (!boxes.empty() && boxes.back().hi.x() == lo.x() && boxes.back().lo.y() == lo.y() &&
            boxes.back().lo.z() == lo.z()) {
            boxes.back().hi.x() = hi.x();
        } else {
            boxes.push_back({lo, hi});
        }
    }
    return boxes;
}

float SparseField::value_beyond(std::size_t block) const {
    const auto background = static_cast<float>(background_world_);
    const bool inside = outside_ == Outside::SignedBackground && is_inside_beyond(blocks()[block]);
    return inside ? -background : background;
}

template<class Stored, class Missing>
void SparseField::visit_row(int x_lo, int x_hi, int y, int z, Stored stored,
                            Missing missing) const {
    const auto in_row = [&](std::size_t i) {
        return coordinates_[i].y() == y && coordinates_[i].z() == z;
    };
    const auto at = std::ranges::lower_bound(coordinates_, Index3(x_lo, y, z), zyx_less);
    auto i = static_cast<std::size_t>(at - coordinates_.begin());
    float value =
        i > 0 && in_row(i - 1) ? value_beyond(i - 1) : static_cast<float>(background_world_);
    int x = x_lo;
    for (; i < coordinates_.size() && in_row(i) && coordinates_[i].x() < x_hi; ++i) {
        if (x < coordinates_[i].x()) missing(x, coordinates_[i].x(), value);
        stored(i);
        value = value_beyond(i);
        x = coordinates_[i].x() + 1;
    }
    if (x < x_hi) missing(x, x_hi, value);
}

ValueRange SparseField::value_range(const IndexBox& box) const {
    ValueRange range{std::numeric_limits<float>::infinity(),
                     -std::numeric_limits<float>::infinity()};
    const auto add = [&range](const ValueRange& other) {
        range.min = std::min(range.min, other.min);
        range.max = std::max(range.max, other.max);
    };
    const IndexBox over = blocks_over(box);
    for (int z = over.lo.z(); z < over.hi.z(); ++z) {
        for (int y = over.lo.y(); y < over.hi.y(); ++y) {
            visit_row(
                over.lo.x(), over.hi.x(), y, z, [&](std::size_t i) { add(ranges_[i]); },
                [&](int, int, float value) {
                    add({value, value});
                });
        }
    }
    return range;
}

void SparseField::copy_box(const IndexBox& box, int level, std::span<float> out) const {
    ISOCAST_ASSERT(std::ssize(out) == box.sample_count(), "%td values for %td samples",
                   std::ssize(out), static_cast<std::ptrdiff_t>(box.sample_count()));
    if (box.is_empty()) return;
    const int stride = 1 << level;
    const Index3 n = box.size();
    const IndexBox over =
        blocks_over({stride * box.lo, (stride * (box.hi.array() - 1) + 1).matrix()});
    // The samples of the level, within the box, that lie in the blocks b_lo <= b < b_hi of an axis.
    const auto samples_of = [&](int b_lo, int b_hi, int axis) {
        return std::pair(std::max(box.lo[axis], ceil_div(std::int64_t{b_lo} * block_size, stride)),
                         std::min(box.hi[axis], ceil_div(std::int64_t{b_hi} * block_size, stride)));
    };
    for (int bz = over.lo.z(); bz < over.hi.z(); ++bz) {
        const auto [z_lo, z_hi] = samples_of(bz, bz + 1, 2);
        if (z_lo >= z_hi) continue;
        for (int by = over.lo.y(); by < over.hi.y(); ++by) {
            const auto [y_lo, y_hi] = samples_of(by, by + 1, 1);
            if (y_lo >= y_hi) continue;
            // Calls write(to, x, y, z) for each row x … of the samples in blocks bx_lo … bx_hi - 1.
            const auto for_each_row = [&, y_lo = y_lo, y_hi = y_hi, z_lo = z_lo,
                                       z_hi = z_hi](int bx_lo, int bx_hi, auto write) {
                const auto [x_lo, x_hi] = samples_of(bx_lo, bx_hi, 0);
                if (x_lo >= x_hi) return;
                for (int z = z_lo; z < z_hi; ++z) {
                    for (int y = y_lo; y < y_hi; ++y) {
                        const std::int64_t row =
                            (std::int64_t{z - box.lo.z()} * n.y() + y - box.lo.y()) * n.x();
                        write(out.subspan(static_cast<std::size_t>(row + x_lo - box.lo.x()),
                                          static_cast<std::size_t>(x_hi - x_lo)),
                              x_lo * stride, y * stride, z * stride);
                    }
                }
            };
            visit_row(
                over.lo.x(), over.hi.x(), by, bz,
                [&](std::size_t i) {
                    const Index3 lo = block_size * coordinates_[i];
                    for_each_row(
                        coordinates_[i].x(), coordinates_[i].x() + 1,
                        [&](std::span<float> to, int x, int y, int z) {
                            const float* from = &blocks()[i].values[static_cast<std::size_t>(
                                x - lo.x() +
                                block_size * (y - lo.y() + block_size * (z - lo.z())))];
                            for (float& value : to) {
                                value = *from;
                                from += stride;
                            }
                        });
                },
                [&](int bx_lo, int bx_hi, float value) {
                    for_each_row(bx_lo, bx_hi, [value](std::span<float> to, int, int, int) {
                        std::ranges::fill(to, value);
                    });
                });
        }
    }
}

std::int64_t SparseField::active_voxel_count() const {
    return std::accumulate(blocks_.begin(), blocks_.end(), std::int64_t{0},
                           [](std::int64_t sum, const FieldBlock& block) {
                               return sum + static_cast<std::int64_t>(block.active.count());
                           });
}

} // namespace isocast
