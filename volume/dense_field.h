// A field that stores every sample of a box.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/field_source.h"

namespace isocast {

/// A sampled box. Beyond it the samples at its border continue.
class DenseField final : public FieldSource {
public:
    /// values  extent.sample_count(), x fastest
    /// throws  InputError if the counts differ or the extent is empty
    DenseField(GridSpace space, IndexBox extent, std::vector<float> values,
               std::optional<double> half_width_world = std::nullopt);

    const GridSpace& space() const override { return space_; }
    IndexBox extent() const override { return extent_; }
    std::optional<double> half_width_world() const override { return half_width_world_; }
    std::vector<IndexBox> active_boxes() const override { return {extent_}; }
    int finest_level(const IndexBox&) const override { return 0; }
    ValueRange value_range(const IndexBox& box) const override;
    void copy_box(const IndexBox& box, int level, std::span<float> out) const override;

    std::span<const float> values() const { return values_; }

private:
    GridSpace space_;
    IndexBox extent_;
    std::vector<float> values_;
    std::optional<double> half_width_world_;
};

} // namespace isocast
