// How much memory is asked for at once.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <cstddef>

namespace isocast::test {

/// The largest number of bytes that this thread asked operator new for since this was set to 0.
std::size_t& largest_allocation();

} // namespace isocast::test
