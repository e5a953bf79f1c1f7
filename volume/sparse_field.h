// A field that stores only the 8^3 blocks near its surface.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/field_source.h"
#include "volume/fresh_memory.h"

#include <array>
#include <bitset>
#include <compare>
#include <iterator>
#include <string_view>

namespace isocast {

/// Edge of a sparse block, in samples. Equals an OpenVDB leaf's.
inline constexpr int block_size = 8;
inline constexpr int samples_per_block = block_size * block_size * block_size;

/// 8^3 samples. Sample (x, y, z) of the block, x fastest, is at x + 8 y + 64 z.
struct FieldBlock {
    /// Block coordinate: the block holds the samples 8 * coordinate … 8 * coordinate + 7.
    Index3 coordinate = Index3::Zero();
    /// Distances; ± background where not active, with the right sign.
    std::array<float, samples_per_block> values{};
    /// Samples in the band.
    std::bitset<samples_per_block> active;
};

/// In memory or in a scratch file. Resizing leaves new blocks raw: construct each before use.
using FieldBlocks = std::vector<FieldBlock, FreshMemory<FieldBlock>>;

/// throws  InputError unless both are usable, and the half width in world units is a 32-bit float
/// remedy  ends the message of one that is none, e.g. "; scale the mesh"
void require_band(double voxel_size_world, double half_width_voxels, std::string_view remedy = {});
/// throws  InputError unless it is a positive number
void require_voxel_size(double voxel_size_world);

/// What a sample has where no block is stored.
enum class Outside {
    /// ± background by the nearest stored block at lower x in the same row of blocks, at the face
    /// towards the sample (is_inside_beyond); + where there is none. Right for signed distance
    /// fields whose half width is at least one voxel, since their sign changes only inside stored
    /// blocks. A producer whose sign changes elsewhere stores blocks of ± background there.
    SignedBackground,
    /// Background as it is: unsigned fields and densities.
    Background,
};

/// The row rule of Outside::SignedBackground: true if the missing blocks at higher x of `block`
/// hold - background.
///
/// Reads the sample (7, 0, 0). Any sample of that face would do: were two of them of opposite sign,
/// two of their neighbours in the missing block would be too, although the distance there is at
/// least one voxel and changes by no more than one from a sample to the next.
inline bool is_inside_beyond(const FieldBlock& block) {
    return block.values[block_size - 1] < 0;
}

/// The blocks that hold the samples of `box` [block coordinates].
IndexBox blocks_over(const IndexBox& box);

/// The blocks that hold samples of any of the boxes, in runs along x that do not overlap [samples].
std::vector<IndexBox> runs_of_blocks(std::span<const IndexBox> boxes);

/// The numbers of the blocks by z, then y, then x of their coordinates.
std::vector<std::uint32_t> zyx_order(std::span<const FieldBlock> blocks);

/// Blocks in an order other than that of memory.
class OrderedBlocks {
public:
    class Iterator {
    public:
        using iterator_category = std::forward_iterator_tag;
        using value_type = FieldBlock;
        using difference_type = std::ptrdiff_t;
        using pointer = const FieldBlock*;
        using reference = const FieldBlock&;

        Iterator() = default;
        Iterator(const FieldBlock* blocks, const std::uint32_t* place)
            : blocks_(blocks), place_(place) {}
        reference operator*() const { return blocks_[*place_]; }
        pointer operator->() const { return &**this; }
        Iterator& operator++() {
            ++place_;
            return *this;
        }
        Iterator operator++(int) { return {blocks_, place_++}; }
        bool operator==(const Iterator&) const = default;

    private:
        const FieldBlock* blocks_ = nullptr;
        const std::uint32_t* place_ = nullptr;
    };

    OrderedBlocks(std::span<const FieldBlock> blocks, std::span<const std::uint32_t> order)
        : blocks_(blocks), order_(order) {}
    std::size_t size() const { return order_.size(); }
    bool empty() const { return order_.empty(); }
    const FieldBlock& operator[](std::size_t i) const { return blocks_[order_[i]]; }
    Iterator begin() const { return {blocks_.data(), order_.data()}; }
    Iterator end() const { return {blocks_.data(), order_.data() + order_.size()}; }

private:
    std::span<const FieldBlock> blocks_;
    std::span<const std::uint32_t> order_;
};

class SparseField final : public FieldSource {
public:
    /// blocks            in any order, each coordinate once, fewer than 2^32; they stay where they
    ///                   lie, in memory or in a scratch file
    /// background_world  > 0: the half width for signed distance fields
    /// throws            InputError if a block occurs twice, or a signed field has no half width
    SparseField(GridSpace space, double background_world, Outside outside, FieldBlocks blocks);

    const GridSpace& space() const override { return space_; }
    /// The box of the blocks; with Outside::Background two samples more on each side, so that the
    /// border is all background and the cubic filter sees all of the step down to it.
    IndexBox extent() const override { return extent_; }
    /// The background for signed fields, absent for others.
    std::optional<double> half_width_world() const override;
    /// Runs of stored blocks along x.
    std::vector<IndexBox> active_boxes() const override;
    int finest_level(const IndexBox&) const override { return 0; }
    ValueRange value_range(const IndexBox& box) const override;
    void copy_box(const IndexBox& box, int level, std::span<float> out) const override;

    double background_world() const { return background_world_; }
    Outside outside() const { return outside_; }
    /// Sorted by z, then y, then x of the coordinate.
    OrderedBlocks blocks() const { return {blocks_, order_}; }
    std::int64_t active_voxel_count() const;

private:
    /// Visits the blocks x_lo <= x < x_hi of the row (y, z), in order: stored(number of the block)
    /// or missing(x_lo, x_hi, value), all in block coordinates.
    template<class Stored, class Missing>
    void visit_row(int x_lo, int x_hi, int y, int z, Stored stored, Missing missing) const;
    /// Value of the missing blocks at higher x of a stored one.
    float value_beyond(std::size_t block) const;

    GridSpace space_;
    double background_world_;
    Outside outside_;
    FieldBlocks blocks_; // as they came: their samples are not moved
    std::vector<std::uint32_t> order_;
    // Per block in order, apart from the samples so that a search touches little memory.
    std::vector<Index3> coordinates_;
    std::vector<ValueRange> ranges_;
    IndexBox extent_;
};

} // namespace isocast
