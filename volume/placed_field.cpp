// SPDX-License-Identifier: MPL-2.0
#include "volume/placed_field.h"

#include "volume/errors.h"

#include <fmt/format.h>

#include <numbers>

namespace isocast {

Eigen::Affine3d Placement::to_world() const {
    const Vec3d angles = rotation_degrees * std::numbers::pi / 180;
    return Eigen::Translation3d(translation_world) * Eigen::AngleAxisd(angles.z(), Vec3d::UnitZ()) *
           Eigen::AngleAxisd(angles.y(), Vec3d::UnitY()) *
           Eigen::AngleAxisd(angles.x(), Vec3d::UnitX()) * Eigen::Scaling(scale);
}

PlacedField::PlacedField(std::shared_ptr<const FieldSource> field, const Placement& placement)
    : field_(std::move(field)), scale_(static_cast<float>(placement.scale)) {
    if (!(scale_ > 0)) throw InputError(fmt::format("a scale of {}", placement.scale));
    // The scale that values take, so that distances fit the lattice.
    Placement rounded = placement;
    rounded.scale = scale_;
    space_.world_from_index = rounded.to_world() * field_->space().world_from_index;
    if (!space_.world_from_index.matrix().allFinite())
        throw InputError("a placement that is not finite");
}

std::optional<double> PlacedField::half_width_world() const {
    const auto half_width = field_->half_width_world();
    // Of the values as they are rounded.
    return half_width ? std::optional<double>(static_cast<float>(*half_width) * scale_)
                      : std::nullopt;
}

ValueRange PlacedField::value_range(const IndexBox& box) const {
    const ValueRange range = field_->value_range(box);
    return {range.min * scale_, range.max * scale_};
}

void PlacedField::copy_box(const IndexBox& box, int level, std::span<float> out) const {
    field_->copy_box(box, level, out);
    for (float& value : out) value *= scale_;
}

} // namespace isocast
