// The meshes that converters find hard, by name.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/convert.h"

#include <functional>
#include <optional>
#include <vector>

namespace isocast::stability {

/// What a sample's side is checked against.
enum class Sides {
    /// The winding number of a closed surface, in or out of the band, wherever |d| > 1e-9 voxel.
    Closed,
    /// The winding number in the band, where it is more than 0.1 from 1/2: that is the error that
    /// WindingNumber's hierarchy may have.
    Open,
    None,
};

struct HardMesh {
    Mesh mesh;
    double voxel = 0.17;
    /// The same surface without what must not count (repeats, flips); `mesh` if empty.
    Mesh solid = {};
    Sides sides = Sides::Closed;
    std::optional<SignMethod> sign_used = {};
};

/// A ball with dents and spikes of `scale`.
HardMesh noisy(unsigned seed, double scale = 1, const Vec3d& shift = Vec3d::Zero());
/// An open one.
HardMesh with_hole();

struct NamedMesh {
    const char* name;
    std::function<HardMesh()> make;
};

std::vector<NamedMesh> hard_meshes();

} // namespace isocast::stability
