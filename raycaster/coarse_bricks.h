// Bricks of lower resolution, so that all fit a texture budget (thesis section 6.2.3): which, and
// where their samples lie.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "filtering/certificate.h"
#include "filtering/coarsened_field.h"
#include "raycaster/brick_layout.h"
#include "volume/progress.h"

#include <optional>

namespace isocast {

using LevelCounts = std::array<int, coarsest_level + 1>;

/// Where bricks of 8 / 2^l cells lie in one buffer.
///
/// All levels share the strides, so that shaders need not know a brick's. Bricks of a level lie
/// side by side in groups:
///
///                 rows: 8 texels               samples: 77 texels
///     level 0     1 x 7   bricks of 11 planes  7 x 7
///           1     2 x 11                7      11 x 11
///           2     4 x 15                5      15 x 15
///           3     8 x 19                4      19 x 19
///
/// down a plane of 77 rows, of which 11, 7, 5 and 4 waste none, none, 2 and 1.
struct CoarseLayout {
    CoarseLayout() = default;
    CoarseLayout(Fetch fetch, const LevelCounts& counts);

    Fetch fetch = Fetch::Rows;
    int row_stride = 0;
    int plane_stride = 0;
    std::int64_t texels = 0;
    LevelCounts across{}; // bricks side by side along x
    std::array<std::int64_t, coarsest_level + 1> first{};

    /// Of the first texel of the i-th brick of a level.
    std::int64_t address(int level, int i) const;
    /// Copies the (n + 3)^3 samples of a brick, floats or codes, to its first texel.
    template<class T>
    void store(const T* samples, int level, std::byte* first_texel) const;
};

/// The samples that a block of a level reads, in samples of the level: (n + 3)^3 for n cells along
/// its edge.
IndexBox samples_of_block(const Index3& block, int level);

/// certify_block of a block's samples at its level.
///
/// source  the same function's samples at level 0, by subdivision in double and rounded once
Certificate certify_coarse_block(std::vector<double> samples, const Index3& block, int level);

/// A field whose bricks fit a budget.
struct CoarseBricks {
    std::shared_ptr<const CoarsenedField> field;
    LevelCounts counts{}; // of active blocks
    /// |F - f| is at most this wherever F, the coarsened function, or f, the one before, crosses
    /// the iso value [world]: to first order no hit moves by more than this over the slope along
    /// the ray.
    float greatest_residual = 0;
    /// Greatest |value - iso| of a stored sample [world].
    float greatest_value = 0;

    int block_count() const { return counts[0] + coarse_count(); }
    int coarse_count() const { return counts[1] + counts[2] + counts[3]; }
};

/// Halves bricks, the least residual for the memory that it frees first, until those of all active
/// blocks fit the budget. By the residual alone, bricks of 4 cells would be halved, which frees
/// little, where more bricks of 8 cells could be: on the bunny at a quarter of the memory hits are
/// then 2.6 times as far from the surface.
///
/// The surface moves, so that blocks become active which were not: their bricks count, and may be
/// halved too.
///
/// control  the kernel's control samples; `ranges` and `active` theirs, which become those of the
///          coarsened field
/// returns  nothing if all bricks fit as they are
/// throws   InputError for kernels other than the B-spline and for bricks other than of 8 cells;
///          ResourceError, with what is needed, if bricks of one cell do not fit
std::optional<CoarseBricks> coarsen(const std::shared_ptr<const FieldSource>& control,
                                    Kernel kernel, BlockRanges& ranges,
                                    std::vector<ActivePage>& active, float iso,
                                    const StorageOptions& options, const Progress& progress = {});

/// Bricks as fine as an adaptive field's finest leaf in each block.
///
/// field    whose finest_level() tells; blocks where that is below 0 are not drawn
/// control  the kernel's control samples of it
/// ranges, active  are found here
/// returns  nothing if no block is coarse, the bricks do not fit, or the kernel or the storage
///          cannot have coarse ones: the field is then drawn at full resolution
std::optional<CoarseBricks> adapt(const FieldSource& field,
                                  const std::shared_ptr<const FieldSource>& control, Kernel kernel,
                                  BlockRanges& ranges, std::vector<ActivePage>& active, float iso,
                                  const StorageOptions& options, const Progress& progress = {});

} // namespace isocast
