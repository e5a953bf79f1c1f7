// A field at another place: scaled, turned and moved.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/field_source.h"

#include <memory>

namespace isocast {

/// Scaled, then turned about x, y and z in this order, then moved.
struct Placement {
    double scale = 1;
    Vec3d rotation_degrees = Vec3d::Zero();
    Vec3d translation_world = Vec3d::Zero();

    Eigen::Affine3d to_world() const;
    bool operator==(const Placement&) const = default;
};

/// `field` moved with its lattice. Its values are scaled with it, so that distances stay distances;
/// they round once more, unless the scale is a power of two.
class PlacedField final : public FieldSource {
public:
    /// throws  InputError unless the scale is above 0 and all is finite
    PlacedField(std::shared_ptr<const FieldSource> field, const Placement& placement);

    const GridSpace& space() const override { return space_; }
    IndexBox extent() const override { return field_->extent(); }
    std::optional<double> half_width_world() const override;
    std::vector<IndexBox> active_boxes() const override { return field_->active_boxes(); }
    int finest_level(const IndexBox& box) const override { return field_->finest_level(box); }
    bool is_adaptive() const override { return field_->is_adaptive(); }
    ValueRange value_range(const IndexBox& box) const override;
    void copy_box(const IndexBox& box, int level, std::span<float> out) const override;

private:
    std::shared_ptr<const FieldSource> field_;
    GridSpace space_;
    float scale_;
};

} // namespace isocast
