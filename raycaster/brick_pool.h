// The control samples of the active blocks on the GPU, in bricks of equal size, and what certifies
// steps through each block (thesis section 6.2.2).
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "filtering/filter.h"
#include "gl/program.h"
#include "raycaster/block_table.h"
#include "raycaster/brick_layout.h"
#include "raycaster/coarse_bricks.h"
#include "volume/progress.h"

namespace isocast {

/// Greatest error of samples of the active pages as they are stored [world].
float storage_error(const BlockRanges& ranges, const std::vector<ActivePage>& active, float iso,
                    SampleFormat format);

/// A cache: it holds the bricks of all active blocks if the budget allows, else those that rays
/// asked for last.
///
/// Blocks are numbered as in BlockTable.
class BrickPool {
public:
    BrickPool() = default;
    /// Loads all bricks if they fit, else none.
    ///
    /// control  the control samples of `kernel`; must outlive the pool, and so must `ranges`
    /// throws   ResourceError if the surface is larger than a pool can number, or the budget holds
    ///          no brick
    BrickPool(const FieldSource& control, Kernel kernel, const BlockRanges& ranges,
              const std::vector<ActivePage>& active, const BlockTable& table, float iso,
              const StorageOptions& options, const Progress& progress = {});
    /// Loads all bricks, each at its level.
    BrickPool(const CoarseBricks& coarse, const BlockRanges& ranges,
              const std::vector<ActivePage>& active, const BlockTable& table, float iso,
              const StorageOptions& options);

    Fetch fetch() const { return options_.fetch; }
    int brick_count() const { return static_cast<int>(bricks_.size()); }
    int resident_count() const { return resident_count_; }
    bool holds_all() const { return slot_count_ == brick_count(); }
    /// Bricks loaded since the pool was made; more than brick_count() where some came twice.
    std::int64_t loaded_count() const { return loaded_count_; }
    std::int64_t byte_count() const {
        return samples_.byte_count() + atlas_.byte_count() + records_.byte_count();
    }

    /// Makes the bricks of blocks resident, in the order given as far as there is room for them,
    /// instead of those used longest ago.
    ///
    /// used    blocks whose bricks were just read; they may go too, but last
    /// wanted  blocks whose bricks are missing
    void load(std::span<const int> used, std::span<const int> wanted);

    /// Greatest |value - iso| of a sample [world].
    float greatest_value() const { return greatest_value_; }
    /// Greatest |sum| of stored samples [stored units].
    float greatest_stored() const { return codec_.greatest_stored(); }
    /// Greatest error of a stored sample [world].
    float storage_error() const { return codec_.error(); }
    /// World units of what shaders read; they reckon in stored units.
    float world_from_stored() const { return codec_.world_from_stored(); }

    /// Binds the textures of shaders/filtering/tricubic.glsl and raycast/blocks.glsl.
    void bind() const;
    /// The defines of shaders that read the pool.
    std::map<std::string, std::string> defines() const;

private:
    struct Workspace;
    struct Brick {
        std::int32_t page;   // in active_
        std::int32_t number; // in its page
        std::int32_t slot = -1;
        std::uint32_t last_use = 0;
    };

    void store(std::span<const int> bricks, const std::function<std::byte*(int)>& place);
    void store_others(const BlockTable& table, std::byte* memory) const;
    void read_page(const Index3& page, Workspace& work) const;
    void store_brick_of(const Workspace& work, int number, std::byte* out) const;
    std::int64_t first_texel(const Brick& brick) const;
    std::int64_t first_texel_of_page(const Index3& page) const;
    void upload(std::span<const int> bricks);
    Index3 atlas_place(int slot) const;

    StorageOptions options_;
    BrickLayout layout_{options_};
    Index3 first_page_ = Index3::Zero(); // of the table
    Codec codec_{SampleFormat::Float32, 0};
    Kernel kernel_ = Kernel::BSpline;
    const FieldSource* control_ = nullptr;
    const BlockRanges* ranges_ = nullptr;
    float iso_ = 0;
    float greatest_value_ = 0;

    std::vector<ActivePage> active_;
    std::vector<std::int32_t> first_bricks_; // of each active page
    std::vector<std::int32_t> first_blocks_;
    std::vector<Brick> bricks_;
    std::vector<std::int32_t> brick_of_block_;
    std::vector<std::array<std::uint32_t, 8>> block_records_;
    std::vector<std::int32_t> brick_in_slot_;
    int slot_count_ = 0;
    int resident_count_ = 0;
    std::int64_t loaded_count_ = 0;
    std::uint32_t clock_ = 0;

    gl::Buffer samples_; // those of Fetch::Linear are in atlas_
    gl::BufferTexture samples_texture_;
    Index3 atlas_slots_ = Index3::Zero();
    gl::Texture atlas_;
    gl::Buffer records_;
    gl::BufferTexture records_texture_;
};

} // namespace isocast
