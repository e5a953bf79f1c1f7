// Fields that cases are made of.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "stability/random.h"
#include "volume/dense_field.h"

#include <memory>

namespace isocast::stability {

/// Calls at(index) for each sample of a box, x fastest.
template<class At>
void for_each_sample(const IndexBox& box, At at) {
    for (int z = box.lo.z(); z < box.hi.z(); ++z)
        for (int y = box.lo.y(); y < box.hi.y(); ++y)
            for (int x = box.lo.x(); x < box.hi.x(); ++x) at(Index3(x, y, z));
}

/// Samples value(p_world) of a box, computed in double and rounded once.
template<class Value>
std::shared_ptr<const DenseField> field_in(const GridSpace& space, const IndexBox& extent,
                                           Value value) {
    std::vector<float> values;
    values.reserve(static_cast<std::size_t>(extent.sample_count()));
    for_each_sample(extent, [&](const Index3& i) {
        values.push_back(static_cast<float>(value(Vec3d(space.to_world(i.cast<double>())))));
    });
    return std::make_shared<DenseField>(space, extent, std::move(values));
}

/// In [0, n)^3 with unit voxels, so that world space is index space.
template<class Value>
std::shared_ptr<const DenseField> unit_field(int n, Value value) {
    return field_in(GridSpace::uniform(1), {Index3::Zero(), Index3::Constant(n)}, value);
}

inline std::shared_ptr<const DenseField> white_noise(int n, unsigned seed) {
    Random random(seed);
    return unit_field(n, [&](const Vec3d&) { return random.uniform(-1, 1); });
}

/// A distance of a sphere off the lattice.
inline std::shared_ptr<const DenseField> unit_sphere_field(int n, double radius) {
    const Vec3d centre = Vec3d::Constant(0.5 * (n - 1)) + Vec3d(0.137, -0.241, 0.319);
    return unit_field(n, [=](const Vec3d& p) { return (p - centre).norm() - radius; });
}

} // namespace isocast::stability
