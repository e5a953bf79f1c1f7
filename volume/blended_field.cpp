// SPDX-License-Identifier: MPL-2.0
#include "volume/blended_field.h"

#include "volume/errors.h"
#include "volume/sparse_field.h"

#include <fmt/format.h>
#include <tbb/parallel_for_each.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace isocast {

bool share_lattice(const FieldSource& a, const FieldSource& b) {
    return a.space().world_from_index.matrix() == b.space().world_from_index.matrix();
}

BlendedField::BlendedField(std::shared_ptr<const FieldSource> a,
                           std::shared_ptr<const FieldSource> b, double t)
    : a_(std::move(a)), b_(std::move(b)), t_(t) {
    if (!share_lattice(*a_, *b_)) throw InputError("the fields to blend lie on two lattices");
    if (!(t >= 0 && t <= 1)) throw InputError(fmt::format("{} does not lie in 0 ... 1", t));
    has_plateau_ = find_plateau();
}

std::optional<double> BlendedField::half_width_world() const {
    const auto a = a_->half_width_world();
    const auto b = b_->half_width_world();
    return a && b ? std::optional((1 - t_) * *a + t_ * *b) : std::nullopt;
}

std::vector<IndexBox> BlendedField::boxes_of_both() const {
    std::vector<IndexBox> boxes = a_->active_boxes();
    for (const IndexBox& box : b_->active_boxes()) boxes.push_back(box);
    std::erase_if(boxes, [](const IndexBox& box) { return box.is_empty(); });
    return runs_of_blocks(boxes); // as they are they would overlap
}

bool BlendedField::find_plateau() const {
    const auto of_a = a_->half_width_world();
    const auto of_b = b_->half_width_world();
    if (!of_a || !of_b) return false;
    std::atomic<bool> is_found = false;
    const std::vector<IndexBox> boxes = boxes_of_both();
    tbb::parallel_for_each(boxes, [&](const IndexBox& box) {
        if (is_found) return;
        std::vector<float> a(static_cast<std::size_t>(box.sample_count()));
        std::vector<float> b(a.size());
        a_->copy_box(box, 0, a);
        b_->copy_box(box, 0, b);
        const auto wide_a = static_cast<float>(*of_a);
        const auto wide_b = static_cast<float>(*of_b);
        for (std::size_t i = 0; i < a.size(); ++i)
            if (std::abs(a[i]) >= wide_a && std::abs(b[i]) >= wide_b && (a[i] < 0) != (b[i] < 0))
                is_found = true;
    });
    return is_found;
}

std::vector<IndexBox> BlendedField::active_boxes() const {
    // Without bands a field's box is all of its extent.
    if (has_plateau_ || !half_width_world()) return {extent()};
    return boxes_of_both();
}

int BlendedField::finest_level(const IndexBox& box) const {
    return std::min(a_->finest_level(box), b_->finest_level(box));
}

/// Rounded once: it grows with both, so that ranges mix as samples do; and at 0 and 1 it is exact.
float BlendedField::mixed(float a, float b) const {
    return static_cast<float>((1 - t_) * a + t_ * b);
}

ValueRange BlendedField::value_range(const IndexBox& box) const {
    const ValueRange a = a_->value_range(box);
    const ValueRange b = b_->value_range(box);
    return {mixed(a.min, b.min), mixed(a.max, b.max)};
}

void BlendedField::copy_box(const IndexBox& box, int level, std::span<float> out) const {
    std::vector<float> other(out.size());
    a_->copy_box(box, level, out);
    b_->copy_box(box, level, other);
    std::ranges::transform(out, other, out.begin(), [&](float a, float b) { return mixed(a, b); });
}

} // namespace isocast
