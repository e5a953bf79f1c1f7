// What tells inside from outside.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/pseudonormals.h"
#include "distance_transform/winding_number.h"

#include <variant>

namespace isocast {

/// The normal of the closest feature, or the winding number.
using SignOracle = std::variant<Pseudonormals, WindingNumber>;

} // namespace isocast
