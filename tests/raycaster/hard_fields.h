// Fields that ray casters miss, and rays at them.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "../volume/random_fields.h"
#include "raycaster/camera.h"
#include "stability/hard_fields.h"

#include <memory>

namespace isocast::test {

using stability::hard_fields;
using stability::HardField;
using stability::needles;
using stability::smooth_noise;
using stability::thin_sheet;
using stability::thin_shell;
using stability::ThinSheet;
using stability::ThinShell;
using stability::tilted_torus;

/// Control samples value(p) in [0, n)^3, computed in double.
template<class Value>
std::shared_ptr<const DenseField> control_of(int n, Value value) {
    return stability::unit_field(n, value);
}

/// A ray from a random point outside the cube [0, n)^3 towards a random point within it.
inline Ray random_ray(Random& random, int n) {
    const Vec3d to = random_point(random, 0, n - 1);
    const Vec3d away = random_point(random, -1, 1).normalized();
    const Vec3d from = Vec3d::Constant(0.5 * (n - 1)) + 2.0 * n * away;
    return {from, (to - from).normalized()};
}

} // namespace isocast::test
