// Skin surfaces of molecules, in builds that have them.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/primitives.h"

namespace isocast {

/// As skin_surface().
/// throws  InputError that says how to get it, if this build has none
TetrahedralMesh molecule_skin(std::span<const Sphere> atoms, double shrink);

} // namespace isocast
