// Index space and its map to world space; boxes of samples.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <Eigen/Geometry>

#include <cstdint>
#include <tuple>

namespace isocast {

using Vec3d = Eigen::Vector3d;
using Mat3d = Eigen::Matrix3d;
using Index3 = Eigen::Vector3i;

/// Samples with lo <= index < hi on each axis. Empty if hi <= lo anywhere.
struct IndexBox {
    Index3 lo = Index3::Zero();
    Index3 hi = Index3::Zero();

    Index3 size() const { return (hi - lo).cwiseMax(0); }
    std::int64_t sample_count() const {
        const Index3 n = size();
        return std::int64_t{n.x()} * n.y() * n.z();
    }
    bool is_empty() const { return (hi.array() <= lo.array()).any(); }
    bool contains(const Index3& index) const {
        return (index.array() >= lo.array()).all() && (index.array() < hi.array()).all();
    }
    bool operator==(const IndexBox&) const = default;
};

IndexBox intersection(const IndexBox& a, const IndexBox& b);
/// The smallest box that holds both; an empty operand does not count.
IndexBox bounding_box(const IndexBox& a, const IndexBox& b);
/// `box` grown by `below` samples at its low faces and `above` at its high faces.
IndexBox dilated(const IndexBox& box, int below, int above);

/// The greatest integers that are not above index / divisor. divisor > 0
Index3 floor_div(const Index3& index, int divisor);
/// The order in which blocks and bricks are listed: by z, then y, then x.
inline bool zyx_less(const Index3& a, const Index3& b) {
    return std::tuple(a.z(), a.y(), a.x()) < std::tuple(b.z(), b.y(), b.x());
}

/// From the middle of the cube [-1, 1]^3 to its corner at the upper end of x if bit 0 of i is set,
/// of y if bit 1, of z if bit 2.
inline Vec3d corner_direction(int i) {
    return {i & 1 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0, i & 4 ? 1.0 : -1.0};
}

/// The affine map of a grid: samples lie at integer index coordinates.
struct GridSpace {
    Eigen::Affine3d world_from_index = Eigen::Affine3d::Identity();

    /// Cubic voxels, axes along the world's, sample 0 at `origin_world`.
    static GridSpace uniform(double voxel_size_world, const Vec3d& origin_world = Vec3d::Zero());

    Vec3d to_world(const Vec3d& p_index) const { return world_from_index * p_index; }
    Vec3d to_index(const Vec3d& p_world) const { return world_from_index.inverse() * p_world; }
    /// Length of the shortest edge of a voxel [world].
    double voxel_size_world() const;
    /// Index-space gradient to world space: the inverse transpose of the linear part.
    Vec3d gradient_to_world(const Vec3d& gradient_index) const;
    /// Index-space Hessian to world space: the inverse linear part on both sides.
    Mat3d hessian_to_world(const Mat3d& hessian_index) const;
};

} // namespace isocast
