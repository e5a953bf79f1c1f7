// Scan conversion of a mesh's sites within a block: a kernel compiled once per instruction set.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/site_data.h"

namespace isocast {

/// All sites of a mesh: faces first, then edges, then vertices.
struct SiteArrays {
    const SiteRegion* regions;
    const FaceSite* faces;
    const EdgeSite* edges;
    const VertexSite* vertices;
    std::int32_t face_count;
    std::int32_t edge_count;
};

/// A block of 8^3 samples, and the sites that can hold the nearest point of one of them.
struct ScanInput {
    const SiteArrays* sites;
    const std::int32_t* list;
    std::int32_t count;
    double first_sample[3]; // position of sample (0, 0, 0)
    double half_width;      // samples farther than this are left out
    double scale;           // of the distances given back
    bool with_sites;        // whether ScanOutput::site is wanted
};

/// Samples are x fastest.
struct ScanOutput {
    float distance[512]; // >= 0, times the scale, rounded once; where active
    /// Bit x of row y + 8 z.
    std::uint8_t active[64];
    std::uint8_t negative[64];
    std::int32_t site[512]; // number of the site that holds the nearest point
};

enum class InstructionSet { Baseline, Avx2, Avx512 };

/// Whether this program has a kernel for `set` and this machine can run it.
bool is_available(InstructionSet set);
/// The widest that is available.
InstructionSet best_instruction_set();

/// returns  how many distances were computed, all lanes counted
using ScanKernel = std::int64_t (*)(const ScanInput&, ScanOutput&);
/// All kernels compute the same bits: none contracts to fused multiply-add.
ScanKernel scan_kernel(InstructionSet set);

} // namespace isocast
