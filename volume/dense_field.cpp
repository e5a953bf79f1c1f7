// A field that stores every sample of a box.
// SPDX-License-Identifier: MPL-2.0
#include "volume/dense_field.h"

#include "volume/assert.h"
#include "volume/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace isocast {

DenseField::DenseField(GridSpace space, IndexBox extent, std::vector<float> values,
                       std::optional<double> half_width_world)
    : space_(std::move(space)), extent_(extent), values_(std::move(values)),
      half_width_world_(half_width_world) {
    if (extent_.is_empty()) throw InputError("a dense field needs at least one sample per axis");
    if (std::ssize(values_) != extent_.sample_count()) {
        const Index3 n = extent_.size();
        throw InputError(fmt::format("a dense field of {} x {} x {} samples got {} values", n.x(),
                                     n.y(), n.z(), values_.size()));
    }
}

ValueRange DenseField::value_range(const IndexBox& box) const {
    const Index3 last = (extent_.hi.array() - 1).matrix();
    const Index3 lo = box.lo.cwiseMax(extent_.lo).cwiseMin(last) - extent_.lo;
    const Index3 hi =
        (box.hi.array() - 1).matrix().cwiseMax(extent_.lo).cwiseMin(last) - extent_.lo;
    const Index3 n = extent_.size();
    ValueRange range{std::numeric_limits<float>::infinity(),
                     -std::numeric_limits<float>::infinity()};
    for (std::int64_t z = lo.z(); z <= hi.z(); ++z) {
        for (std::int64_t y = lo.y(); y <= hi.y(); ++y) {
            const float* row = &values_[static_cast<std::size_t>((z * n.y() + y) * n.x())];
            for (int x = lo.x(); x <= hi.x(); ++x) {
                range.min = std::min(range.min, row[x]);
                range.max = std::max(range.max, row[x]);
            }
        }
    }
    return range;
}

void DenseField::copy_box(const IndexBox& box, int level, std::span<float> out) const {
    ISOCAST_ASSERT(std::ssize(out) == box.sample_count(), "%td values for %td samples",
                   std::ssize(out), static_cast<std::ptrdiff_t>(box.sample_count()));
    const Index3 n = extent_.size();
    // Offset of the sample `index` of the level within the extent, clamped to it.
    const auto clamped = [&](int index, int axis) {
        const std::int64_t fine = std::int64_t{index} * (std::int64_t{1} << level);
        return std::clamp<std::int64_t>(fine - extent_.lo[axis], 0, n[axis] - 1);
    };
    float* to = out.data();
    for (int z = box.lo.z(); z < box.hi.z(); ++z) {
        for (int y = box.lo.y(); y < box.hi.y(); ++y) {
            const auto offset = (clamped(z, 2) * n.y() + clamped(y, 1)) * n.x();
            const float* row = &values_[static_cast<std::size_t>(offset)];
            if (level == 0) {
                // The part of the row inside the extent in one piece, its ends repeated.
                const int size = box.hi.x() - box.lo.x();
                const int begin = std::clamp(extent_.lo.x() - box.lo.x(), 0, size);
                const int end = std::clamp(extent_.hi.x() - box.lo.x(), begin, size);
                std::fill(to, to + begin, row[0]);
                std::copy_n(row + (box.lo.x() + begin - extent_.lo.x()), end - begin, to + begin);
                std::fill(to + end, to + size, row[n.x() - 1]);
                to += size;
            } else {
                for (int x = box.lo.x(); x < box.hi.x(); ++x) *to++ = row[clamped(x, 0)];
            }
        }
    }
}

} // namespace isocast
