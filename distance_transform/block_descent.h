// The nearest triangle of every sample of a block: a kernel compiled once per instruction set.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/triangle_frame_data.h"

#include <cstddef>
#include <cstdint>

namespace isocast {

/// A cube of samples at unit spacing, and the triangles that may be nearest to one of them.
struct DescentInput {
    const TriangleFrame* frames; // of the whole mesh
    const int* candidates;       // numbers of frames
    int candidate_count;
    double first_sample[3]; // position of sample (0, 0, 0)
    double half_width;      // samples farther than this are left out
};

/// What the kernel knows of a block's samples (x fastest) afterwards.
struct DescentOutput {
    alignas(64) double squared_distance[512]; // 1e300 beyond the half width
    /// Of the sample over the plane of its nearest triangle, along its normal.
    alignas(64) double height[512];
    /// Place of the nearest triangle among the candidates; of equally near ones any.
    int triangle[512];
};

/// The triangles of each child of a cube, in the order of the cube's.
struct SplitOutput {
    int* list[8]; // within the workspace, until its next use
    int count[8];
};

/// Rows of 8 samples; bit x of row y + 8 z.
struct BlockBits {
    std::uint8_t active[64];
    std::uint8_t negative[64]; // where the nearest feature is a face
    std::uint8_t unsure[64];   // active, and the nearest feature is an edge or a vertex
};

/// Memory that a kernel works in; one per thread, kept from block to block.
class DescentWorkspace {
public:
    DescentWorkspace() = default;
    DescentWorkspace(const DescentWorkspace&) = delete;
    DescentWorkspace& operator=(const DescentWorkspace&) = delete;
    ~DescentWorkspace();
    /// At least `bytes`, aligned to 64.
    void* memory(std::size_t bytes);

private:
    void* memory_ = nullptr;
    std::size_t bytes_ = 0;
};

struct DescentKernels {
    /// The nearest triangle of each sample of a block.
    /// returns  how many point-triangle distances were computed, all lanes counted
    std::int64_t (*descend)(const DescentInput&, DescentWorkspace&, DescentOutput&);
    /// The triangles that may be nearest to a sample of each of the eight children, of
    /// `child_size`^3 samples, of a cube. Returns as descend.
    std::int64_t (*split)(const DescentInput&, int child_size, DescentWorkspace&, SplitOutput&);
    /// Distances times `scale`, none greater than half_width * scale, rounded once.
    void (*finish)(const DescentOutput&, double half_width, double scale, float* distances,
                   BlockBits&);
};

enum class InstructionSet { Baseline, Avx2, Avx512 };

/// Whether this program has a kernel for `set` and this machine can run it.
bool is_available(InstructionSet set);
/// All kernels compute the same bits: none contracts to fused multiply-add.
const DescentKernels& descent_kernels(InstructionSet set);
/// The widest that is available.
InstructionSet best_instruction_set();

} // namespace isocast
