// Control samples that make the cubic B-spline interpolate to fourth order, by a local stencil.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/quasi_interpolant.h"

#include "volume/assert.h"
#include "volume/sparse_field.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

namespace isocast {

namespace {

/// A box copied in one piece holds at most that many planes, which bounds the memory beside `out`.
constexpr int planes_at_once = 64;

IndexBox with_neighbours(const IndexBox& box) {
    return dilated(box, 1, 1);
}

} // namespace

QuasiInterpolant::QuasiInterpolant(std::shared_ptr<const FieldSource> samples)
    : samples_(std::move(samples)) {}

std::vector<IndexBox> QuasiInterpolant::active_boxes() const {
    std::vector<IndexBox> boxes = samples_->active_boxes();
    std::erase_if(boxes, [](const IndexBox& box) { return box.is_empty(); });
    if (boxes.size() == 1) return {with_neighbours(boxes[0])};
    for (IndexBox& box : boxes) box = with_neighbours(box);
    return runs_of_blocks(boxes); // as they are they would overlap
}

int QuasiInterpolant::finest_level(const IndexBox& box) const {
    return samples_->finest_level(with_neighbours(box));
}

ValueRange QuasiInterpolant::value_range(const IndexBox& box) const {
    const ValueRange f = samples_->value_range(with_neighbours(box));
    // c = 2 f - (mean of the neighbours), and that mean also lies in [a, b]. What copy_box rounds,
    // with u = 2^-24 and w = b - a: six differences of at most w, their three sums of at most 2w,
    // two of at most 4w and 6w, and twice for the product with a rounded 1/6, all over 6: to first
    // order (6 + 6 + 10 + 12) u w/6 < 6 u w. The last subtraction rounds to nearest, which keeps
    // to bounds that are floats themselves.
    const double width = double{f.max} - f.min;
    const double reach = width * (1 + 10 * 0x1p-24);
    const double lo = f.min - reach;
    const double hi = f.max + reach;
    constexpr float infinity = std::numeric_limits<float>::infinity();
    auto min = static_cast<float>(lo);
    if (min > lo) min = std::nextafter(min, -infinity);
    auto max = static_cast<float>(hi);
    if (max < hi) max = std::nextafter(max, infinity);
    return {min, max};
}

void QuasiInterpolant::copy_box(const IndexBox& box, int level, std::span<float> out) const {
    ISOCAST_ASSERT(std::ssize(out) == box.sample_count(), "%td values for %td samples",
                   std::ssize(out), static_cast<std::ptrdiff_t>(box.sample_count()));
    if (box.is_empty()) return;
    const Index3 n = box.size();
    if (n.z() > planes_at_once) {
        IndexBox slab = box;
        for (; slab.lo.z() < box.hi.z(); slab.lo.z() = slab.hi.z()) {
            slab.hi.z() = std::min(slab.lo.z() + planes_at_once, box.hi.z());
            const auto count = static_cast<std::size_t>(slab.sample_count());
            copy_box(slab, level, out.first(count));
            out = out.subspan(count);
        }
        return;
    }

    const IndexBox near = with_neighbours(box);
    const auto count = static_cast<std::size_t>(near.sample_count());
    const auto samples = std::make_unique_for_overwrite<float[]>(count);
    samples_->copy_box(near, level, {samples.get(), count});
    const std::ptrdiff_t stride_y = near.size().x();
    const std::ptrdiff_t stride_z = stride_y * near.size().y();
    float* __restrict to = out.data();
    for (int z = 0; z < n.z(); ++z) {
        for (int y = 0; y < n.y(); ++y) {
            const float* f = samples.get() + (z + 1) * stride_z + (y + 1) * stride_y + 1;
            for (int x = 0; x < n.x(); ++x) {
                // Differences first: exact between near values, zero where f is constant.
                const float at = f[x];
                const float xx = (f[x - 1] - at) + (f[x + 1] - at);
                const float yy = (f[x - stride_y] - at) + (f[x + stride_y] - at);
                const float zz = (f[x - stride_z] - at) + (f[x + stride_z] - at);
                to[x] = at - ((xx + yy) + zz) * (1.0f / 6);
            }
            to += n.x();
        }
    }
}

} // namespace isocast
