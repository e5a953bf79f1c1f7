// From mesh to narrow-band distance field: the one entry.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/checked_mesh.h"
#include "volume/progress.h"
#include "volume/sparse_field.h"

#include <optional>

namespace isocast {

enum class SignMethod {
    Auto,    // pseudonormals if the mesh is closed and oriented and their signs fit together,
             // winding number otherwise
    Normal,  // angle-weighted pseudonormal of the closest feature (Bærentzen & Aanæs 2005)
    Winding, // generalised winding number above 1/2 (Jacobson 2013, Barill 2018)
};

/// throws  InputError that lists the known names: auto, normal, winding
SignMethod sign_method_from_name(std::string_view name);
std::string_view name_of(SignMethod method);

struct ConvertOptions {
    double voxel_size_world = 0;  // > 0
    double half_width_voxels = 3; // >= 1
    SignMethod sign = SignMethod::Auto;
};

struct ConvertResult {
    SparseField field;
    SignMethod sign_used;
    struct {
        double prepare_seconds = 0;
        double transform_seconds = 0;
    } time;
    std::int64_t distance_evaluations = 0;
    std::vector<std::string> warnings;
};

/// Voxel size that puts `resolution` voxels along the longest side of `box`.
/// throws  InputError unless 1 <= resolution <= 2^20, or if the box has no size
double voxel_size_for_resolution(const WorldBox& box, int resolution);

/// Signed distance to `input` at every sample with |d| <= half width, on all cores of the current
/// TBB arena.
///
/// Samples lie at integer multiples of the voxel size; where that index would pass 2^28 the
/// transform is shifted by whole voxels.
/// returns   blocks that hold the whole band, and only blocks that hold a part of it (and, for open
///           meshes, the blocks where the winding number changes sign outside the band)
/// accuracy  exact point-triangle distances in double, rounded once to float
/// throws    InputError for unusable options, ResourceError if the blocks would not fit in memory
ConvertResult convert(const CheckedMesh& input, const ConvertOptions& options,
                      const Progress& progress = {});

} // namespace isocast
