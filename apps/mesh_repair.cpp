// SPDX-License-Identifier: MPL-2.0
#include "apps/mesh_repair.h"

#ifdef ISOCAST_WITH_REPAIR
#include "distance_transform/repair/repair.h"

#include <fmt/format.h>
#else
#include "apps/inputs.h"
#endif

namespace isocast {

#ifdef ISOCAST_WITH_REPAIR
CheckedMesh repaired(const CheckedMesh& mesh) {
    const RepairedMesh repaired = repair(mesh.mesh);
    CheckedMesh result = check(repaired.mesh);
    result.warnings.insert(
        result.warnings.begin(),
        fmt::format("Repaired ({}): {}.", mesh.verdict.summary(), repaired.report.summary()));
    return result;
}
#else
CheckedMesh repaired(const CheckedMesh&) {
    throw UsageError("--repair: this build has none; configure with -DISOCAST_REPAIR=ON (it takes "
                     "CGAL under the GPL)");
}
#endif

} // namespace isocast
