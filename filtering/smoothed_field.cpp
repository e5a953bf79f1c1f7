// SPDX-License-Identifier: MPL-2.0
#include "filtering/smoothed_field.h"

#include "volume/errors.h"
#include "volume/sparse_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace isocast {

namespace {

/// Convolves lines along an axis; the result has reach samples less at both ends of them.
///
/// size  of `in`, which becomes that of the result
std::vector<float> convolved(const std::vector<float>& in, Index3& size, int axis,
                             const std::vector<double>& weights) {
    const auto reach = std::ssize(weights) - 1;
    // Elements between neighbours along the axis, and how many such lines lie side by side.
    std::ptrdiff_t stride = 1;
    for (int i = 0; i < axis; ++i) stride *= size[i];
    const std::ptrdiff_t from_line = stride * size[axis];
    size[axis] -= 2 * static_cast<int>(reach);
    const std::ptrdiff_t to_line = stride * size[axis];
    std::vector<float> out(static_cast<std::size_t>(IndexBox{Index3::Zero(), size}.sample_count()));
    std::vector<double> sums(static_cast<std::size_t>(to_line));
    for (std::ptrdiff_t line = 0; line * to_line < std::ssize(out); ++line) {
        const float* from = in.data() + line * from_line + reach * stride;
        for (std::ptrdiff_t i = 0; i < to_line; ++i)
            sums[static_cast<std::size_t>(i)] = weights[0] * from[i];
        for (std::ptrdiff_t n = 1; n <= reach; ++n) {
            const double weight = weights[static_cast<std::size_t>(n)];
            for (std::ptrdiff_t i = 0; i < to_line; ++i)
                sums[static_cast<std::size_t>(i)] +=
                    weight * (double{from[i - n * stride]} + from[i + n * stride]);
        }
        float* to = out.data() + line * to_line;
        for (std::ptrdiff_t i = 0; i < to_line; ++i)
            to[i] = static_cast<float>(sums[static_cast<std::size_t>(i)]);
    }
    return out;
}

} // namespace

std::vector<double> gaussian_weights(double variance_voxels2) {
    std::vector<double> weights;
    double sum = 0;
    while (sum < 1 - 1e-6) {
        const auto n = static_cast<double>(weights.size());
        weights.push_back(std::exp(-variance_voxels2) * std::cyl_bessel_i(n, variance_voxels2));
        sum += (n > 0 ? 2 : 1) * weights.back();
    }
    for (double& weight : weights) weight /= sum;
    return weights;
}

SmoothedField::SmoothedField(std::shared_ptr<const FieldSource> samples, double scale_voxels)
    : samples_(std::move(samples)) {
    if (!(scale_voxels >= 0 && scale_voxels <= greatest_scale_voxels))
        throw InputError(fmt::format("a scale of {} voxels: it must lie between 0 and {}",
                                     scale_voxels, greatest_scale_voxels));
    for (int axis = 0; axis < 3; ++axis) {
        const double scale = scale_voxels * space().voxel_size_world() /
                             space().world_from_index.linear().col(axis).norm();
        weights_[static_cast<std::size_t>(axis)] = gaussian_weights(scale * scale);
    }
}

IndexBox SmoothedField::with_reach(const IndexBox& box) const {
    IndexBox read = box;
    for (int axis = 0; axis < 3; ++axis) {
        const auto reach = static_cast<int>(weights_[static_cast<std::size_t>(axis)].size()) - 1;
        read.lo[axis] -= reach;
        read.hi[axis] += reach;
    }
    return read;
}

std::vector<IndexBox> SmoothedField::active_boxes() const {
    std::vector<IndexBox> boxes = samples_->active_boxes();
    std::erase_if(boxes, [](const IndexBox& box) { return box.is_empty(); });
    for (IndexBox& box : boxes) box = with_reach(box);
    return boxes.size() == 1 ? boxes : runs_of_blocks(boxes); // as they are they would overlap
}

int SmoothedField::finest_level(const IndexBox& box) const {
    return samples_->finest_level(with_reach(box));
}

ValueRange SmoothedField::value_range(const IndexBox& box) const {
    return samples_->value_range(with_reach(box)); // means; floats round to their bounds at most
}

void SmoothedField::copy_box(const IndexBox& box, int level, std::span<float> out) const {
    if (box.is_empty()) return;
    if (level > 0) {
        const int step = 1 << level;
        const IndexBox fine{step * box.lo, (step * (box.hi.array() - 1) + 1).matrix()};
        std::vector<float> values(static_cast<std::size_t>(fine.sample_count()));
        copy_box(fine, 0, values);
        const Index3 n = fine.size();
        std::size_t to = 0;
        for (int z = 0; z < n.z(); z += step)
            for (int y = 0; y < n.y(); y += step)
                for (int x = 0; x < n.x(); x += step)
                    out[to++] = values[static_cast<std::size_t>(
                        x + std::ptrdiff_t{n.x()} * (y + std::ptrdiff_t{n.y()} * z))];
        return;
    }
    const IndexBox read = with_reach(box);
    std::vector<float> values(static_cast<std::size_t>(read.sample_count()));
    samples_->copy_box(read, 0, values);
    Index3 size = read.size();
    for (const int axis : {2, 1, 0}) // the longest lines first: most is left out early
        values = convolved(values, size, axis, weights_[static_cast<std::size_t>(axis)]);
    std::ranges::copy(values, out.begin());
}

} // namespace isocast
