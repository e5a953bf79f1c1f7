// A field between two on one lattice (thesis section 6.4.3, "Morphing").
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/field_source.h"

#include <memory>

namespace isocast {

/// Whether the samples of two fields lie at the same places.
bool share_lattice(const FieldSource& a, const FieldSource& b);

/// (1 - t) a + t b, sample by sample, computed when it is asked for.
///
/// Reconstruction is linear, so its function is the same blend of the fields' functions, and is
/// certified by bounds of its own control samples like any other field's. With bands of half widths
/// v and w it has one of (1 - t) v + t w; with one band or none it has none, and the field that has
/// a band then ends with the extent of both.
class BlendedField final : public FieldSource {
public:
    /// throws  InputError unless the fields share a lattice and 0 <= t <= 1
    BlendedField(std::shared_ptr<const FieldSource> a, std::shared_ptr<const FieldSource> b,
                 double t);

    /// Whether one field's background inside meets the other's outside, among the samples in active
    /// boxes: there the blend is flat, and the surface stays in one band until t passes the other's
    /// share, then jumps to the other.
    bool has_plateau() const { return has_plateau_; }

    const GridSpace& space() const override { return a_->space(); }
    IndexBox extent() const override { return bounding_box(a_->extent(), b_->extent()); }
    std::optional<double> half_width_world() const override;
    /// Those of both; with a plateau the extent, since samples far from both are no background.
    std::vector<IndexBox> active_boxes() const override;
    int finest_level(const IndexBox& box) const override;
    ValueRange value_range(const IndexBox& box) const override;
    void copy_box(const IndexBox& box, int level, std::span<float> out) const override;

private:
    float mixed(float a, float b) const;
    std::vector<IndexBox> boxes_of_both() const;
    bool find_plateau() const;

    std::shared_ptr<const FieldSource> a_;
    std::shared_ptr<const FieldSource> b_;
    double t_;
    bool has_plateau_;
};

} // namespace isocast
