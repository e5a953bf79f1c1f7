// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <algorithm>
#include <vector>

namespace isocast {

/// The upper one of an even number; of one value at least.
inline double median(std::vector<double> values) {
    std::ranges::nth_element(values, values.begin() + std::ssize(values) / 2);
    return values[values.size() / 2];
}

} // namespace isocast
