// Scan conversion of a mesh's sites on the GPU (thesis section 4.2.4).
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/band_tiles.h"
#include "distance_transform/winding_number.h"
#include "gl/context.h"
#include "gl/program.h"
#include "volume/sparse_field.h"

namespace isocast {

struct GpuScanOptions {
    int target_extent = 2048; // of the image that holds a batch: at most, but for one tile [pixels]
};

struct GpuScan {
    FieldBlocks blocks; // those with samples in the band, in any order
    struct {
        double sections_seconds = 0; // CPU: sites and their slices, batch by batch
        double draw_seconds = 0;     // GL: both passes, by its own clock
        double wait_seconds = 0;     // CPU: for the GL
        double exact_seconds = 0;    // CPU: exact distances and signs
    } time;
    std::int64_t batches = 0;
    std::int64_t repeated_batches = 0; // had more candidates than there was room for
    std::int64_t sections = 0;         // rectangles drawn, in each of two passes
    std::int64_t candidates = 0;       // exact distances computed
};

/// Exact signed distances at the samples of all tiles, as TileTransform computes them.
///
/// Each site is drawn slice by slice as the rectangle of samples that its region meets, within each
/// tile that it reaches. The first pass keeps for each sample a bound above its distance, by
/// minimum blending; the second lists the sites that float32 cannot tell from the nearest, mostly
/// one. The CPU computes the exact distances to those while the GL draws the next batch.
///
/// context   current on this thread
/// winding   tells inside from outside; null leaves it to the sites' normals
/// accuracy  the blocks of TileTransform, to the last bit but for exact ties
///           (GpuScanOf.HasTheSamplesOfTheCpu)
/// source    thesis section 4.2.4, where the slices' polygons and the vectors at their corners come
///           from the CPU for each slice, and signs from the triangle alone
/// throws    ResourceError if the GL's buffers cannot hold a batch, gl::GlError
GpuScan scan_on_gpu(gl::Context& context, gl::ShaderLibrary& shaders, const Sites& sites,
                    const BandTiles& band, const WindingNumber* winding, double voxel_size_world,
                    const GpuScanOptions& options = {}, const Progress& progress = {});

/// All programs that scan_on_gpu uses.
std::vector<gl::ProgramKey> scan_programs();

} // namespace isocast
