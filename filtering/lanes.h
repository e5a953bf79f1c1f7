// Four floats at once, by an extension that gcc and clang share: what gcc 12 makes of loops over
// four lanes is four times slower.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <cstdint>
#include <cstring>

namespace isocast {

inline constexpr int lanes = 4;
using Lanes = float __attribute__((vector_size(lanes * sizeof(float))));
/// What comparisons of Lanes give: all bits of a lane or none.
using LaneMask = std::int32_t __attribute__((vector_size(lanes * sizeof(std::int32_t))));

inline Lanes load(const float* from) {
    Lanes values;
    std::memcpy(&values, from, sizeof values);
    return values;
}

inline void store(Lanes values, float* to) {
    std::memcpy(to, &values, sizeof values);
}

inline Lanes less(Lanes a, Lanes b) {
    return a < b ? a : b;
}

inline Lanes greater(Lanes a, Lanes b) {
    return a > b ? a : b;
}

inline Lanes absolute(Lanes a) {
    return reinterpret_cast<Lanes>(reinterpret_cast<LaneMask>(a) & 0x7fffffff);
}

inline float least_lane(Lanes a) {
    float least = a[0];
    for (int lane = 1; lane < lanes; ++lane) least = a[lane] < least ? a[lane] : least;
    return least;
}

inline float greatest_lane(Lanes a) {
    return -least_lane(-a);
}

} // namespace isocast
