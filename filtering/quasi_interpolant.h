// Control samples that make the cubic B-spline interpolate to fourth order, by a local stencil.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/field_source.h"

#include <memory>

namespace isocast {

/// A view of a field with c = f - ((sum of the 6 neighbours) - 6 f)/6 for each sample f, in float.
/// The neighbours at level l are those of the level, 2^l samples away; value_range is of level 0.
///
/// source  the spline of samples f is f + h^2/6 times their Laplacian, to fourth order; this takes
///         that off beforehand
class QuasiInterpolant final : public FieldSource {
public:
    explicit QuasiInterpolant(std::shared_ptr<const FieldSource> samples);

    const GridSpace& space() const override { return samples_->space(); }
    IndexBox extent() const override { return samples_->extent(); }
    std::optional<double> half_width_world() const override { return samples_->half_width_world(); }
    /// One sample more on every side; where the field has several boxes, whole blocks of 8^3.
    std::vector<IndexBox> active_boxes() const override;
    int finest_level(const IndexBox& box) const override;
    /// For samples in [a, b], [2a - b, 2b - a].
    ValueRange value_range(const IndexBox& box) const override;
    void copy_box(const IndexBox& box, int level, std::span<float> out) const override;

private:
    std::shared_ptr<const FieldSource> samples_;
};

} // namespace isocast
