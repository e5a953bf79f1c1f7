// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <tbb/parallel_for.h>

#include <cstddef>

namespace isocast {

/// Calls f(i) for all i below `count`, on all cores.
template<class Function>
void in_parallel(std::size_t count, Function f) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 256),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                          for (std::size_t i = range.begin(); i < range.end(); ++i) f(i);
                      });
}

} // namespace isocast
