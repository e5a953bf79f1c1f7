// How inside is told from outside for a mesh, and why so.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/convert.h"

namespace isocast {

struct SignChoice {
    SignMethod method;
    std::string reason;
    std::vector<std::string> warnings = {};
};

/// By the verdict alone.
SignChoice chosen_sign(const MeshVerdict& verdict, SignMethod wanted);

/// For fields without a band, which cannot tell whether normals contradict each other: a narrow
/// band at that voxel size is asked.
/// throws  as convert()
SignChoice sign_by_band(const CheckedMesh& input, SignMethod wanted, double voxel_size_world,
                        double memory_bytes, const Progress& progress);

} // namespace isocast
