// Index space and its map to world space; boxes of samples.
// SPDX-License-Identifier: MPL-2.0
#include "volume/grid_space.h"


namespace isocast {

namespace {

int floor_div(int index, int divisor) {
    const int quotient = index / divisor;
    return quotient - (index % divisor < 0 ? 1 : 0);
}

} // namespace

IndexBox intersection(const IndexBox& a, const IndexBox& b) {
    return {a.lo.cwiseMax(b.lo), a.hi.cwiseMin(b.hi)};
}

IndexBox bounding_box(const IndexBox& a, const IndexBox& b) {
    if (a.is_empty()) return b;
    if (b.is_empty()) return a;
    return {a.lo.cwiseMin(b.lo), a.hi.cwiseMax(b.hi)};
}

IndexBox dilated(const IndexBox& box, int below, int above) {
    return {(box.lo.array() - below).matrix(), (box.hi.array() + above).matrix()};
}

Index3 floor_div(const Index3& index, int divisor) {
    return index.unaryExpr([divisor](int i) { return floor_div(i, divisor); });
}

GridSpace GridSpace::uniform(double voxel_size_world, const Vec3d& origin_world) {
    GridSpace space;
    space.world_from_index.linear() = voxel_size_world * Mat3d::Identity();
    space.world_from_index.translation() = origin_world;
    return space;
}

double GridSpace::voxel_size_world() const {
    return world_from_index.linear().colwise().norm().minCoeff();
}

Vec3d GridSpace::gradient_to_world(const Vec3d& gradient_index) const {
    return world_from_index.linear().inverse().transpose() * gradient_index;
}

Mat3d GridSpace::hessian_to_world(const Mat3d& hessian_index) const {
    const Mat3d index_from_world = world_from_index.linear().inverse();
    return index_from_world.transpose() * hessian_index * index_from_world;
}

} // namespace isocast
