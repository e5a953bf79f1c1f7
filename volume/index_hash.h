// Indices of lattice points as keys of hash tables.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/grid_space.h"

#include <cstddef>

namespace isocast {

struct IndexHash {
    std::size_t operator()(const Index3& p) const {
        // Odd factors near 2^64 over powers of the golden ratio.
        return static_cast<std::size_t>(p.x()) * 0x9e3779b97f4a7c15 ^
               static_cast<std::size_t>(p.y()) * 0xbf58476d1ce4e5b9 ^
               static_cast<std::size_t>(p.z()) * 0x94d049bb133111eb;
    }
};

} // namespace isocast
