// A tree of boxes around primitives, for rays that start anywhere among them.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/cut.h"
#include "quadrics/splats.h"

namespace isocast {

/// As shaders/quadrics/tree.glsl takes it: world axes, from the eye, so that what is near it keeps
/// its digits.
struct PrimitiveTree {
    /// Two for each node, depth first: the box's low corner, and how many nodes the subtree has, of
    /// leaves -1 - (kind + 16 (count - 1)); its high corner, and where a leaf's first body starts
    /// [4 floats]. Corners by the bits of floats. A ray passes by a subtree in one step, so that it
    /// needs no stack.
    std::vector<Eigen::Vector4i> nodes;
    /// In the order of leaves, as put_body(); of triangles each corner with 0, the unit normal with
    /// the plane's offset; as many for each as body_floats() has it.
    std::vector<float> bodies;
    unsigned kinds = 0; // SplatKind, by bits
};

/// Of a leaf, all of one kind. 4: from 1 to 8 all take the same time
/// within 5 % (1tii, 52,000 spheres), and nodes become fewer.
inline constexpr int most_in_leaf = 4;

/// Split where the expected number of box tests is least, by 16 bins along the longest side.
///
/// primitives  checked, without dots
/// planes      with unit normals; what lies in front of one is left out
/// returns     no nodes if nothing is left
/// accuracy    boxes have 2^-21 of their corners' distance from the eye to spare, more than their
///             and the bodies' roundings
/// source      the surface area heuristic by bins: Wald 2007
PrimitiveTree tree_of(const Primitives& primitives, const Vec3d& eye_world,
                      const std::vector<CutPlane>& planes);

} // namespace isocast
