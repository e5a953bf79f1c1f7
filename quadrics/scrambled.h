// Numbers that look random and are always the same.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <cstdint>

namespace isocast {

/// source  splitmix64's finaliser, Steele, Lea and Flood 2014
inline std::uint64_t scrambled(std::uint64_t number) {
    std::uint64_t x = (number + 1) * 0x9e3779b97f4a7c15;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9;
    x = (x ^ x >> 27) * 0x94d049bb133111eb;
    return x ^ x >> 31;
}

} // namespace isocast
