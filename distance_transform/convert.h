// From mesh to distance field: the one entry.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/checked_mesh.h"
#include "distance_transform/closest_block.h"
#include "distance_transform/winding_number.h"
#include "volume/dense_field.h"
#include "volume/progress.h"
#include "volume/sparse_field.h"

#include <functional>
#include <limits>
#include <optional>
#include <string_view>

namespace isocast {

enum class SignMethod {
    Auto,    // as the mesh's verdict says: see ConvertResult::sign_reason
    Normal,  // angle-weighted pseudonormal of the closest feature (Bærentzen & Aanæs 2005)
    Winding, // generalised winding number above 1/2 (Jacobson 2013, Barill 2018)
    Unsigned // none: distances are positive on both sides
};

/// throws  InputError that lists the known names: auto, normal, winding, unsigned
SignMethod sign_method_from_name(std::string_view name);
std::string_view name_of(SignMethod method);

/// How a narrow band is computed. All but Scan are kept for comparison and need a closed, oriented
/// mesh.
enum class BandMethod {
    Scan,          // scan conversion of towers, wedges and cones, exact
    PrintedPrisms, // one prism per triangle as the thesis prints it: not exact, see bench_prisms
    Csc            // characteristics/scan conversion after Mauch, one thread
};

class Sites;
struct BandTiles;

/// Blocks with exact distances at all samples of the band, in any order; signs by the winding
/// number, or by the sites' normals if it is null. evaluations  grows by the number of distances
/// computed
using BandScanner = std::function<FieldBlocks(const Sites& sites, const BandTiles& band,
                                              const WindingNumber* winding, double voxel_size_world,
                                              std::int64_t& evaluations, const Progress& progress)>;

struct ConvertOptions {
    double voxel_size_world = 0;  // > 0
    double half_width_voxels = 3; // >= 1
    SignMethod sign = SignMethod::Auto;
    BandMethod method = BandMethod::Scan;
    bool closest = false;     // also find closest points and features; BandMethod::Scan only
    BandScanner scanner = {}; // takes the place of the CPU's kernel in BandMethod::Scan
    /// What the field and the work on it may take; infinity stands for what the system says is
    /// available.
    double memory_bytes = std::numeric_limits<double>::infinity();
};

/// throws  InputError unless voxel size, half width and method can be used together
void require_usable(const ConvertOptions& options);

struct ConvertResult {
    SparseField field;
    SignMethod sign_used;
    std::string sign_reason; // in a few words, e.g. "the mesh is closed and oriented"
    /// Beside field.blocks(), if asked for.
    std::vector<ClosestBlock> closest = {};
    struct {
        double prepare_seconds = 0;
        double transform_seconds = 0;
    } time = {};
    std::int64_t distance_evaluations = 0;
    std::vector<std::string> warnings = {};
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
/// accuracy  exact distances in double, rounded once to float
/// throws    InputError for unusable options or a mesh that the method cannot take, ResourceError
/// if
///           the blocks would not fit in memory
ConvertResult convert(const CheckedMesh& input, const ConvertOptions& options,
                      const Progress& progress = {});

/// What a conversion will take, from the mesh's area alone: right to some tens of per cent for
/// surfaces that are smooth over the half width.
struct ConvertEstimate {
    double blocks = 0;
    double active_voxels = 0;
    double field_bytes = 0;
    double peak_bytes = 0;
};
ConvertEstimate estimate(const CheckedMesh& input, const ConvertOptions& options);

/// Exact signed distance at every sample of the mesh's box and `half_width_voxels` around it.
/// throws  as convert
struct DenseConvertResult {
    DenseField field;
    SignMethod sign_used;
    std::string sign_reason;
    double seconds = 0;
    std::int64_t distance_evaluations = 0;
    std::vector<std::string> warnings = {};
};
DenseConvertResult convert_dense(const CheckedMesh& input, const ConvertOptions& options,
                                 const Progress& progress = {});

/// The samples of the box over which convert_dense() works.
IndexBox dense_box(const CheckedMesh& input, const ConvertOptions& options);

} // namespace isocast
