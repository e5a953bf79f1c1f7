// SPDX-License-Identifier: MPL-2.0
#include "apps/molecule_skin.h"

#ifdef ISOCAST_WITH_SKIN
#include "quadrics/skin/skin_surface.h"
#else
#include "volume/errors.h"
#endif

namespace isocast {

#ifdef ISOCAST_WITH_SKIN
TetrahedralMesh molecule_skin(std::span<const Sphere> atoms, double shrink) {
    return skin_surface(atoms, shrink);
}
#else
TetrahedralMesh molecule_skin(std::span<const Sphere>, double) {
    throw InputError(
        "as = \"skin\": this build has none; configure with -DISOCAST_SKIN=ON (it takes "
        "CGAL under the GPL)");
}
#endif

} // namespace isocast
