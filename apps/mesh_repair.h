// `--repair`, in builds that have it.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/checked_mesh.h"

namespace isocast {

/// The mesh made manifold, closed and oriented, and checked again; its first warning says what was
/// done.
/// throws  UsageError that says how to get it, if this build cannot repair
CheckedMesh repaired(const CheckedMesh& mesh);

} // namespace isocast
