// The double reference caster: the true first hit of a ray with the B-spline's isosurface.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/camera.h"
#include "volume/field_source.h"

#include <optional>

namespace isocast {

/// Parameter t of the first root of the tricubic B-spline of `field` minus `iso` along
/// origin + t * direction, t >= 0.
///
/// step_voxels  distance of the samples between which a change of sign is sought; a stretch inside
///              the object shorter than this may be missed
/// returns      nothing if there is no root inside the field's extent
/// accuracy     bisection to 1e-12 of the extent's diagonal
std::optional<double> reference_hit(const FieldSource& field, double iso, const Ray& ray,
                                    double step_voxels = 1.0 / 64);

} // namespace isocast
