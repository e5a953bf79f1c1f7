// The one seam between what makes or stores a field and what consumes it.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/grid_space.h"

#include <optional>
#include <span>
#include <vector>

namespace isocast {

/// Closed interval of field values [world units].
struct ValueRange {
    float min;
    float max;
};

/// A sampled scalar field: negative inside, positive outside, distances in world units.
///
/// All members are const and may be called from several threads at once.
class FieldSource {
public:
    virtual ~FieldSource() = default;

    /// The map of index space, in which samples lie at integers, to world space.
    virtual const GridSpace& space() const = 0;

    /// The box of samples that the field defines. Beyond it a field with a band is its outside
    /// (or inside) background, and one without clamps to the border.
    virtual IndexBox extent() const = 0;

    /// Half width of the band [world]: samples farther from the surface are ± this value.
    /// Absent where every sample holds its own value.
    virtual std::optional<double> half_width_world() const = 0;

    /// Boxes that together hold every sample that is not background; they do not overlap.
    virtual std::vector<IndexBox> active_boxes() const = 0;

    /// The finest level stored anywhere in `box`: 0 everywhere but in adaptive fields.
    virtual int finest_level(const IndexBox& box) const = 0;
    /// Whether finest_level differs from box to box, so that samples of higher levels are all that
    /// the field has in some.
    virtual bool is_adaptive() const { return false; }

    /// A range that holds the value of every sample in `box`; it may be wider than the tightest.
    virtual ValueRange value_range(const IndexBox& box) const = 0;

    /// Copies the samples of `box`, x fastest. The box may reach beyond the extent.
    ///
    /// box    in units of the level: its sample i is the field's sample i * 2^level
    /// level  0 for every sample, 1 for every second, …
    /// out    box.sample_count() values
    virtual void copy_box(const IndexBox& box, int level, std::span<float> out) const = 0;
};

/// One sample, through copy_box.
float sample(const FieldSource& field, const Index3& index);

} // namespace isocast
