// Scan conversion of a mesh's sites within a tile: kernels compiled once per instruction set.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/site_data.h"

namespace isocast {

/// Edge of a tile, in samples and in blocks of 8^3: few sites are in several tiles, a tile's
/// columns stay in the second cache, and its blocks are the bits of one word.
inline constexpr int tile_size = 32;
inline constexpr int tile_blocks = 4;
/// The tile of a sample, along an axis.
constexpr int tile_of(int sample) {
    return sample >> 5;
}

/// A face's samples may lie this far outside its tower [voxels]: far above rounding, and of no
/// consequence, since the distance to the plane there is wrong by 1e-18 over the distance.
inline constexpr double tower_slack = 1e-9;

/// The band's border is this much wider than asked [voxels], far above rounding: samples exactly on
/// it are all active, and the neighbours of an inactive sample are surely not on the surface.
inline constexpr double border_slack = 1e-9;

/// Squared distances of a tile's samples in columns along one axis k, u and v being the axes after
/// it: sample (k, u, v) is at k + stride_u * u + stride_v * v.
struct TileColumns {
    static constexpr int stride_u = tile_size;
    static constexpr int stride_v = tile_size * tile_size + 8; // no multiple of 4096 bytes
    static constexpr int count = tile_size * stride_v;

    /// Of each axis. Negative inside.
    double* signed_square[3];
    /// Of each axis the number of the site that holds the nearest point; null if not wanted.
    double* site[3];
    bool is_used[3];
};

/// A tile, and the sites that can hold the nearest point of one of its samples.
struct TileInput {
    const SiteArrays* sites;
    const std::int32_t* list; // ascending
    std::int64_t count;
    double first_sample[3]; // position of sample (0, 0, 0)
};

/// A block of 8^3 samples, x fastest.
struct ScannedBlock {
    float distance[512]; // rounded once; the half width where not active
    /// Bit x of row y + 8 z.
    std::uint8_t active[64];
    std::uint8_t negative[64];
    std::int32_t site[512]; // number of the site that holds the nearest point
};

enum class InstructionSet { Baseline, Avx2, Avx512 };

/// Whether this program has kernels for `set` and this machine can run them.
bool is_available(InstructionSet set);
/// The widest that is available.
InstructionSet best_instruction_set();

/// All sets of kernels compute the same bits: none contracts to fused multiply-add.
struct ScanKernels {
    /// Normals of the faces begin … end - 1. Reads vertices and triangles only.
    void (*find_normals)(const SiteArrays& sites, std::int32_t begin, std::int32_t end,
                         FaceNormal* normals);
    /// Normals and slopes of the fans begin … end - 1. Reads vertices, triangles and faces.
    ///
    /// corners, corner_begin  MeshTopology's fan_corners and fan_begin
    /// is_open                fans that do not close around their vertex
    void (*find_fans)(const SiteArrays& sites, const std::uint32_t* corners,
                      const std::uint32_t* corner_begin, const char* is_open, std::int32_t begin,
                      std::int32_t end, FanData* fans);
    /// The samples that the sites begin … end - 1 can reach, from the anchor, and the regions of
    /// those that reach several tiles.
    void (*find_regions)(const SiteArrays& sites, std::int32_t begin, std::int32_t end,
                         SampleBox* boxes, SiteRegion* regions);
    /// The sites of a list as the samples of its tile see them.
    void (*see_sites)(const TileInput& input, TileSite* seen);
    /// returns  how many distances were computed, all lanes counted
    std::int64_t (*scan)(const TileInput& input, TileColumns& columns);
    /// The least of a scanned tile's columns, in the block at (x, y, z) of its 4^3.
    ///
    /// scale    of the distances given back
    /// returns  whether any of them is in the band
    bool (*finish)(const TileColumns& columns, double half_width, double scale, int x, int y, int z,
                   ScannedBlock& block);
    /// to  `distance`, negative where the bit is set
    void (*apply_signs)(const float (&distance)[512], const std::uint8_t (&negative)[64],
                        float* to);
};

const ScanKernels& scan_kernels(InstructionSet set);

} // namespace isocast
