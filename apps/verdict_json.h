// The condition of a mesh as JSON, the same wherever a verb reports it.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/checked_mesh.h"

#include <nlohmann/json_fwd.hpp>

namespace isocast {

nlohmann::ordered_json to_json(const MeshVerdict& verdict);

/// Prints `json` to stdout. Bytes of file names that are no UTF-8 are replaced.
void print_json(const nlohmann::ordered_json& json);

} // namespace isocast
