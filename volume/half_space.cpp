// SPDX-License-Identifier: MPL-2.0
#include "volume/half_space.h"

#include "volume/dense_field.h"

#include <algorithm>

namespace isocast {

HalfSpaces half_spaces(const Vec3d& normal, const Eigen::AlignedBox3d& box_world) {
    HalfSpaces out{.centre_world = box_world.center(), .normal = normal.normalized()};
    // 1e-30: the box of a point has cells, too.
    const double cell_world = std::max(box_world.sizes().maxCoeff() / 64, 1e-30);
    GridSpace space;
    space.world_from_index =
        Eigen::Translation3d(out.centre_world) * Eigen::Scaling(cell_world, cell_world, cell_world);
    // 3: beyond the border its samples continue, and the filter reaches over two of them.
    const Index3 half = (0.5 * box_world.sizes() / cell_world).array().ceil().cast<int>().matrix() +
                        Index3::Constant(3);
    const IndexBox extent{-half, half + Index3::Ones()};
    std::vector<float> values;
    values.reserve(static_cast<std::size_t>(extent.sample_count()));
    for (int z = extent.lo.z(); z < extent.hi.z(); ++z)
        for (int y = extent.lo.y(); y < extent.hi.y(); ++y)
            for (int x = extent.lo.x(); x < extent.hi.x(); ++x)
                values.push_back(static_cast<float>(-cell_world * out.normal.dot(Vec3d(x, y, z))));
    out.field = std::make_shared<DenseField>(space, extent, std::move(values));
    return out;
}

} // namespace isocast
