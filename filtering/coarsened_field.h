// A field some of whose blocks have a lower resolution, as one B-spline: without cracks, since the
// samples between two resolutions are the coarse ones subdivided (thesis section 6.2.3).
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "filtering/blocks.h"

#include <array>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

namespace isocast {

/// The lowest resolution: one cell a block.
inline constexpr int coarsest_level = 3;
static_assert(block_size >> coarsest_level == 1);

/// The levels of blocks; level l has cells of 2^l voxels. 0 unless set.
class BlockLevels {
public:
    void set(const Index3& block, int level);
    int at(const Index3& block) const;
    /// The blocks above level 0, in any order.
    std::vector<Index3> coarse_blocks() const;

private:
    struct Hash {
        std::size_t operator()(const Index3& page) const;
    };
    std::unordered_map<Index3, std::array<std::uint8_t, blocks_per_page>, Hash> pages_;
};

/// The control samples of a cubic B-spline F that is, on each block of level l, a spline with cells
/// of 2^l voxels, and elsewhere the one of `control`. F has two continuous derivatives everywhere.
///
/// Let S_l be coarse_samples of level l, S_0 the control samples, and U knot insertion
/// (subdivided). Level by level from the coarsest on,
///
///     C_l = U C_{l+1}  within one sample of a block above level l, its faces included
///     C_l = S_l        elsewhere
///
/// and F is the spline of C_0. The 3 planes of samples around a block's faces and those inside are
/// all that F reads in it, so that in a block of level l, C_0 is U^l of the (n + 3)^3 samples of
/// C_l with n = 8 / 2^l: those suffice to store it. docs/raycasting.md has the proof.
///
/// Of an adaptive field S_l are its own samples of level l: that is all that it has.
class CoarsenedField final : public FieldSource {
public:
    CoarsenedField(std::shared_ptr<const FieldSource> control, BlockLevels levels,
                   bool is_adaptive = false);

    /// C_l in a box of samples of level l [world], each rounded to float.
    std::vector<double> samples_at(const IndexBox& box, int level) const;
    const BlockLevels& levels() const { return levels_; }

    const GridSpace& space() const override { return control_->space(); }
    IndexBox extent() const override { return control_->extent(); }
    std::optional<double> half_width_world() const override { return control_->half_width_world(); }
    std::vector<IndexBox> active_boxes() const override;
    int finest_level(const IndexBox&) const override { return 0; }
    /// For control samples in [a, b], [2a - b, 2b - a].
    ValueRange value_range(const IndexBox& box) const override;
    /// C_0, at higher levels every second one of it and so on.
    void copy_box(const IndexBox& box, int level, std::span<float> out) const override;

private:
    std::shared_ptr<const FieldSource> control_;
    BlockLevels levels_;
    bool is_adaptive_;
};

} // namespace isocast
