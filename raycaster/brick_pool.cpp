// The control samples of the active blocks on the GPU, and what certifies steps through each block.
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/brick_pool.h"

#include "filtering/bounds.h"
#include "filtering/certificate.h"
#include "filtering/subdivision.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>

namespace isocast {

namespace {

constexpr std::size_t samples_per_page = std::size_t{page_samples} * page_samples * page_samples;

/// Two texels of t_blocks; shaders/raycast/blocks.glsl.
struct BlockRecord {
    float slope;
    float bend;
    float near;
    float scale;
    std::int32_t address; // -1 where the brick is not resident
    std::uint32_t parts_lo;
    std::uint32_t parts_hi;
    std::uint32_t place; // in the table: 11 bits of x, 11 of y, 10 of z
};
using RecordWords = std::array<std::uint32_t, 8>;
static_assert(sizeof(BlockRecord) == sizeof(RecordWords));

std::uint32_t packed_place(const Index3& block) {
    return static_cast<std::uint32_t>(block.x()) | static_cast<std::uint32_t>(block.y()) << 11 |
           static_cast<std::uint32_t>(block.z()) << 22;
}

/// What certifies steps through the block, in stored units.
///
/// bounds  of scaled samples; "no bound" is a great number that shaders multiply by stored ones:
///         finite still
void set_certificate(BlockRecord& record, const Certificate& bounds, const Codec& codec) {
    const float stored_from_scaled = codec.stored_from_scaled();
    record.slope = bounds.slope * stored_from_scaled;
    record.bend = bounds.bend < no_bend ? bounds.bend * stored_from_scaled
                                        : no_bend / std::max(1.0F, codec.greatest_stored());
    record.near = bounds.near * stored_from_scaled;
    record.parts_lo = static_cast<std::uint32_t>(bounds.parts);
    record.parts_hi = static_cast<std::uint32_t>(bounds.parts >> 32);
}

/// throws  ResourceError if the table is larger than packed_place can say
void check_extent(const BlockTable& table) {
    const Index3 extent = page_blocks * table.pages;
    if (extent.x() > 2048 || extent.y() > 2048 || extent.z() > 1024) {
        throw ResourceError(
            fmt::format("the surface spans {} x {} x {} voxels, more than 16384 x 16384 x 8192",
                        block_size * extent.x(), block_size * extent.y(), block_size * extent.z()));
    }
}

/// Greatest |value - iso| of the active pages' samples.
float greatest_value_of(const BlockRanges& ranges, const std::vector<ActivePage>& active,
                        float iso) {
    float greatest = 0;
    for (const ActivePage& page : active) {
        const ValueRange& samples = ranges.pages[page.page].samples;
        greatest = std::max({greatest, std::abs(samples.min - iso), std::abs(samples.max - iso)});
    }
    return greatest;
}

} // namespace

/// What a thread needs to store a page.
struct BrickPool::Workspace {
    std::vector<float> values = std::vector<float>(samples_per_page);
    std::vector<std::uint16_t> codes = std::vector<std::uint16_t>(samples_per_page);
};

float storage_error(const BlockRanges& ranges, const std::vector<ActivePage>& active, float iso,
                    SampleFormat format) {
    return Codec(format, greatest_value_of(ranges, active, iso)).error();
}

BrickPool::BrickPool(const FieldSource& control, Kernel kernel, const BlockRanges& ranges,
                     const std::vector<ActivePage>& active, const BlockTable& table, float iso,
                     const StorageOptions& options, const Progress& progress)
    : options_(options), layout_(options, table.pages), first_page_(table.first_page),
      kernel_(kernel), control_(&control), ranges_(&ranges), iso_(iso),
      greatest_value_(greatest_value_of(ranges, active, iso)), active_(active) {
    codec_ = Codec(options.format, greatest_value_);
    check_extent(table);
    for (std::size_t i = 0; i < active.size(); ++i) {
        first_bricks_.push_back(static_cast<std::int32_t>(bricks_.size()));
        first_blocks_.push_back(static_cast<std::int32_t>(block_records_.size()));
        std::array<std::int32_t, blocks_per_page> brick_at{};
        for (std::uint64_t rest = layout_.bricks_of(active[i].blocks); rest != 0;
             rest &= rest - 1) {
            const int number = std::countr_zero(rest);
            brick_at[static_cast<std::size_t>(number)] = static_cast<std::int32_t>(bricks_.size());
            bricks_.push_back({static_cast<std::int32_t>(i), number});
        }
        const Index3 page = ranges.pages[active[i].page].coordinate - table.first_page;
        for (std::uint64_t rest = active[i].blocks; rest != 0; rest &= rest - 1) {
            const Index3 block = block_in_page(std::countr_zero(rest));
            brick_of_block_.push_back(brick_at[static_cast<std::size_t>(layout_.brick_of(block))]);
            BlockRecord record{};
            record.address = -1;
            record.place = packed_place(page_blocks * page + block);
            block_records_.push_back(std::bit_cast<RecordWords>(record));
        }
    }

    const bool is_atlas = options.fetch == Fetch::Linear;
    std::int64_t limit = options.budget_bytes / layout_.brick_bytes;
    if (!is_atlas) limit = std::min(limit, gl::max_buffer_texels() / layout_.brick_texels);
    slot_count_ = static_cast<int>(std::min<std::int64_t>(limit, brick_count()));
    if (is_atlas) {
        atlas_slots_ = atlas_slots(slot_count_, layout_.samples(), gl::max_volume_extent());
        if (atlas_slots_.prod() > limit && atlas_slots_.z() > 1) --atlas_slots_.z();
        slot_count_ = std::min(slot_count_, atlas_slots_.prod());
    }
    if (slot_count_ == 0 && brick_count() > 0) {
        throw ResourceError(fmt::format("a texture budget of {} bytes holds no {} of {}",
                                        options.budget_bytes, layout_.is_whole ? "array" : "brick",
                                        layout_.brick_bytes));
    }
    if (layout_.is_whole) slot_count_ = brick_count();
    brick_in_slot_.assign(static_cast<std::size_t>(slot_count_), -1);
    if (is_atlas && slot_count_ > 0) {
        const Index3 texels = layout_.samples() * atlas_slots_;
        atlas_ = gl::Texture::volume(texel_format(options), texels.x(), texels.y(), texels.z(),
                                     gl::Filter::Linear, "brick samples");
    } else if (!is_atlas) {
        samples_ = gl::Buffer::writable((layout_.is_whole ? 1 : slot_count_) * layout_.brick_bytes,
                                        "brick samples");
        samples_texture_ = gl::BufferTexture(samples_, texel_format(options), "brick samples");
    }
    records_ = gl::Buffer::writable(
        static_cast<std::int64_t>(block_records_.size() * sizeof(RecordWords)), "block records");
    if (holds_all()) {
        std::vector<int> all(bricks_.size());
        std::iota(all.begin(), all.end(), 0);
        for (const int brick : all) bricks_[static_cast<std::size_t>(brick)].slot = brick;
        std::ranges::copy(all, brick_in_slot_.begin());
        const int texel_bytes = gl::byte_count(texel_format(options));
        if (is_atlas)
            upload(all);
        else
            samples_.write(0, samples_.byte_count(), [&](std::span<std::byte> memory) {
                store(all, [&](int brick) {
                    return memory.data() +
                           texel_bytes * first_texel(bricks_[static_cast<std::size_t>(brick)]);
                });
                if (layout_.is_whole) store_others(table, memory.data());
            });
        resident_count_ = brick_count();
    }
    if (progress) progress("upload", 1);
    records_.write(0, records_.byte_count(), [&](std::span<std::byte> memory) {
        std::memcpy(memory.data(), block_records_.data(),
                    block_records_.size() * sizeof(RecordWords));
    });
    records_texture_ = gl::BufferTexture(records_, gl::Format::Rgba32ui, "block records");
}

std::int64_t BrickPool::first_texel(const Brick& brick) const {
    if (options_.fetch == Fetch::Linear) {
        const Index3 at = atlas_place(brick.slot);
        return at.x() + std::int64_t{atlas_row} * at.y() + std::int64_t{atlas_plane} * at.z();
    }
    if (!layout_.is_whole) return brick.slot * layout_.brick_texels;
    return first_texel_of_page(
        ranges_->pages[active_[static_cast<std::size_t>(brick.page)].page].coordinate);
}

std::int64_t BrickPool::first_texel_of_page(const Index3& page) const {
    const Index3 at = page_size * (page - first_page_);
    return at.x() + at.y() * std::int64_t{layout_.row_stride} +
           at.z() * std::int64_t{layout_.plane_stride};
}

void BrickPool::read_page(const Index3& page, Workspace& work) const {
    const Index3 first = (page_size * page.array() - filter_support_below).matrix();
    // Some fields compute a box by all threads. Alone: while this one waits for the others it would
    // otherwise begin another page, with the same memory.
    tbb::this_task_arena::isolate([&] {
        control_->copy_box({first, (first.array() + page_samples).matrix()}, 0, work.values);
    });
    for (float& value : work.values) value = codec_.scaled(value - iso_);
    if (options_.format == SampleFormat::Float32) return;
    for (std::size_t k = 0; k < samples_per_page; ++k) {
        work.codes[k] = codec_.encode(work.values[k]);
        // Bounds are those of the samples as stored.
        work.values[k] = codec_.decode(work.codes[k]);
    }
}

void BrickPool::store_brick_of(const Workspace& work, int number, std::byte* out) const {
    if (options_.format == SampleFormat::Float32)
        store_brick(layout_, work.values.data(), number, out);
    else
        store_brick(layout_, work.codes.data(), number, out);
}

/// Without bricks, the pages around those that are active: their samples belong to cells of these.
/// Of the others' any number will do for a code that does not hold it.
void BrickPool::store_others(const BlockTable& table, std::byte* memory) const {
    std::vector<std::uint8_t> is_active(static_cast<std::size_t>(table.pages.prod()), 0);
    const auto number_of = [&](const Index3& p) {
        return static_cast<std::size_t>(p.x() +
                                        table.pages.x() * (p.y() + table.pages.y() * p.z()));
    };
    for (const ActivePage& page : active_)
        is_active[number_of(ranges_->pages[page.page].coordinate - first_page_)] = 1;
    const int texel_bytes = gl::byte_count(texel_format(options_));
    tbb::enumerable_thread_specific<Workspace> workspaces;
    tbb::parallel_for(0, table.pages.z(), [&](int z) {
        for (int y = 0; y < table.pages.y(); ++y) {
            for (int x = 0; x < table.pages.x(); ++x) {
                if (is_active[number_of({x, y, z})] != 0) continue;
                const Index3 page = first_page_ + Index3(x, y, z);
                Workspace& work = workspaces.local();
                read_page(page, work);
                store_brick_of(work, 0, memory + texel_bytes * first_texel_of_page(page));
            }
        }
    });
}

BrickPool::BrickPool(const CoarseBricks& coarse, const BlockRanges& ranges,
                     const std::vector<ActivePage>& active, const BlockTable& table, float iso,
                     const StorageOptions& options)
    : options_(options), layout_(options), codec_(options.format, coarse.greatest_value),
      control_(coarse.field.get()), ranges_(&ranges), iso_(iso),
      greatest_value_(coarse.greatest_value), active_(active) {
    check_extent(table);
    const CoarseLayout layout(options.fetch, coarse.counts);
    layout_.row_stride = layout.row_stride;
    layout_.plane_stride = layout.plane_stride;
    struct Block {
        Index3 index;
        int level;
    };
    std::vector<Block> blocks;
    std::vector<BlockRecord> records;
    LevelCounts counts{};
    for (const ActivePage& page : active) {
        const Index3& coordinate = ranges.pages[page.page].coordinate;
        for (std::uint64_t rest = page.blocks; rest != 0; rest &= rest - 1) {
            const Index3 block = page_blocks * coordinate + block_in_page(std::countr_zero(rest));
            const int level = coarse.field->levels().at(block);
            blocks.push_back({block, level});
            BlockRecord record{};
            record.scale = std::exp2(-static_cast<float>(level));
            record.address = static_cast<std::int32_t>(
                layout.address(level, counts[static_cast<std::size_t>(level)]++));
            record.place = packed_place(block - page_blocks * table.first_page);
            records.push_back(record);
        }
    }
    bricks_.resize(blocks.size());
    slot_count_ = resident_count_ = brick_count();
    loaded_count_ = brick_count();
    const int texel_bytes = gl::byte_count(texel_format(options));
    samples_ = gl::Buffer::writable(layout.texels * texel_bytes, "brick samples");
    samples_.write(0, samples_.byte_count(), [&](std::span<std::byte> memory) {
        tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t i) {
            const auto& [block, level] = blocks[i];
            std::vector<double> samples =
                coarse.field->samples_at(samples_of_block(block, level), level);
            std::byte* out = memory.data() + std::int64_t{records[i].address} * texel_bytes;
            if (options.format == SampleFormat::Float32) {
                std::vector<float> values;
                for (double& sample : samples) {
                    values.push_back(codec_.scaled(static_cast<float>(sample) - iso));
                    sample = values.back();
                }
                layout.store(values.data(), level, out);
            } else {
                std::vector<std::uint16_t> codes;
                for (double& sample : samples) {
                    codes.push_back(codec_.encode(codec_.scaled(static_cast<float>(sample) - iso)));
                    sample = codec_.decode(codes.back());
                }
                layout.store(codes.data(), level, out);
            }
            set_certificate(records[i], certify_coarse_block(std::move(samples), block, level),
                            codec_);
        });
    });
    records_ = gl::Buffer(std::as_bytes(std::span(records)), "block records");
    samples_texture_ = gl::BufferTexture(samples_, texel_format(options), "brick samples");
    records_texture_ = gl::BufferTexture(records_, gl::Format::Rgba32ui, "block records");
}

/// Cuts bricks out of the field to place(i-th of them), and makes their blocks' records.
///
/// bricks  sorted: those of a page stand together
void BrickPool::store(std::span<const int> bricks, const std::function<std::byte*(int)>& place) {
    // One task for each page.
    std::vector<std::size_t> starts;
    for (std::size_t i = 0; i < bricks.size(); ++i) {
        const auto page_of = [&](std::size_t k) {
            return bricks_[static_cast<std::size_t>(bricks[k])].page;
        };
        if (i == 0 || page_of(i) != page_of(i - 1)) starts.push_back(i);
    }
    starts.push_back(bricks.size());
    tbb::enumerable_thread_specific<Workspace> workspaces;
    tbb::parallel_for(std::size_t{0}, starts.size() - 1, [&](std::size_t task) {
        Workspace& work = workspaces.local();
        const auto active =
            static_cast<std::size_t>(bricks_[static_cast<std::size_t>(bricks[starts[task]])].page);
        const BlockPage& page = ranges_->pages[active_[active].page];
        read_page(page.coordinate, work);
        std::uint64_t numbers = 0; // of the bricks in their page
        for (std::size_t i = starts[task]; i < starts[task + 1]; ++i) {
            const int number = bricks_[static_cast<std::size_t>(bricks[i])].number;
            numbers |= std::uint64_t{1} << number;
            store_brick_of(work, number, place(static_cast<int>(i)));
        }
        auto block = static_cast<std::size_t>(first_blocks_[active]);
        for (std::uint64_t rest = active_[active].blocks; rest != 0; rest &= rest - 1, ++block) {
            const Index3 at = block_in_page(std::countr_zero(rest));
            if ((numbers >> layout_.brick_of(at) & 1U) == 0) continue;
            const Certificate bounds =
                certify_block(work.values.data() + in_page(block_size * at.x(), block_size * at.y(),
                                                           block_size * at.z()),
                              page_samples, page_samples * page_samples, kernel_);
            auto record = std::bit_cast<BlockRecord>(block_records_[block]);
            const Brick& brick = bricks_[static_cast<std::size_t>(brick_of_block_[block])];
            set_certificate(record, bounds, codec_);
            record.scale = 1;
            record.address =
                static_cast<std::int32_t>(first_texel(brick) + layout_.address_in_brick(at));
            block_records_[block] = std::bit_cast<RecordWords>(record);
        }
    });
    loaded_count_ += std::ssize(bricks);
}

/// Stores bricks in the slots that they have.
void BrickPool::upload(std::span<const int> bricks) {
    // 64 MiB at a time: little beside the budget, and many pages for all threads.
    const auto brick_bytes = static_cast<std::size_t>(layout_.brick_bytes);
    const std::size_t most = std::max<std::size_t>(1, (std::size_t{64} << 20) / brick_bytes);
    std::vector<std::byte> staging(std::min(most, bricks.size()) * brick_bytes);
    for (; !bricks.empty(); bricks = bricks.subspan(std::min(most, bricks.size()))) {
        const auto some = bricks.first(std::min(most, bricks.size()));
        const auto staged = [&](std::size_t i) {
            return std::span(staging).subspan(i * brick_bytes, brick_bytes);
        };
        store(some, [&](int i) { return staged(static_cast<std::size_t>(i)).data(); });
        for (std::size_t i = 0; i < some.size(); ++i) {
            const int slot = bricks_[static_cast<std::size_t>(some[i])].slot;
            if (options_.fetch == Fetch::Linear) {
                const Index3 at = atlas_place(slot);
                const int n = layout_.samples();
                atlas_.upload_box(at.x(), at.y(), at.z(), n, n, n, staged(i));
            } else {
                samples_.write(slot * layout_.brick_bytes, layout_.brick_bytes,
                               [&](std::span<std::byte> memory) {
                                   std::ranges::copy(staged(i), memory.begin());
                               });
            }
        }
    }
}

Index3 BrickPool::atlas_place(int slot) const {
    const Index3& n = atlas_slots_;
    return layout_.samples() * Index3(slot % n.x(), slot / n.x() % n.y(), slot / (n.x() * n.y()));
}

void BrickPool::load(std::span<const int> used, std::span<const int> wanted) {
    ++clock_;
    for (const int block : used) {
        bricks_[static_cast<std::size_t>(brick_of_block_[static_cast<std::size_t>(block)])]
            .last_use = clock_;
    }
    std::vector<int> incoming;
    for (const int block : wanted) {
        const int brick = brick_of_block_[static_cast<std::size_t>(block)];
        if (bricks_[static_cast<std::size_t>(brick)].slot < 0) incoming.push_back(brick);
    }
    std::ranges::sort(incoming);
    incoming.erase(std::unique(incoming.begin(), incoming.end()), incoming.end());
    if (incoming.size() > brick_in_slot_.size()) incoming.resize(brick_in_slot_.size());

    // Slots: empty ones, then by the last use of what is in them.
    std::vector<int> slots(brick_in_slot_.size());
    std::iota(slots.begin(), slots.end(), 0);
    const auto age = [&](int slot) -> std::uint32_t {
        const int brick = brick_in_slot_[static_cast<std::size_t>(slot)];
        return brick < 0 ? 0 : bricks_[static_cast<std::size_t>(brick)].last_use + 1;
    };
    const auto enough = slots.begin() + std::ssize(incoming);
    std::ranges::nth_element(slots, enough == slots.end() ? enough - 1 : enough, {}, age);

    std::vector<std::uint8_t> is_moved(bricks_.size(), 0);
    for (std::size_t i = 0; i < incoming.size(); ++i) {
        const int slot = slots[i];
        const int old = std::exchange(brick_in_slot_[static_cast<std::size_t>(slot)], incoming[i]);
        if (old >= 0) {
            bricks_[static_cast<std::size_t>(old)].slot = -1;
            is_moved[static_cast<std::size_t>(old)] = 1;
            --resident_count_;
        }
        Brick& brick = bricks_[static_cast<std::size_t>(incoming[i])];
        brick.slot = slot;
        brick.last_use = clock_;
        is_moved[static_cast<std::size_t>(incoming[i])] = 1;
        ++resident_count_;
    }
    upload(incoming);
    // The records of bricks that came or went; one map for all, since there may be many.
    for (std::size_t block = 0; block < block_records_.size(); ++block) {
        const auto brick = static_cast<std::size_t>(brick_of_block_[block]);
        if (is_moved[brick] == 0 || bricks_[brick].slot >= 0) continue;
        auto record = std::bit_cast<BlockRecord>(block_records_[block]);
        record.address = -1;
        block_records_[block] = std::bit_cast<RecordWords>(record);
    }
    records_.write(0, records_.byte_count(), [&](std::span<std::byte> memory) {
        std::memcpy(memory.data(), block_records_.data(), memory.size());
    });
}

void BrickPool::bind() const {
    if (options_.fetch == Fetch::Linear)
        atlas_.bind_to_unit(1);
    else
        samples_texture_.bind_to_unit(1);
    records_texture_.bind_to_unit(2);
}

std::map<std::string, std::string> BrickPool::defines() const {
    std::map<std::string, std::string> defines = fetch_defines(options_);
    defines.merge(std::map<std::string, std::string>{
        {"KERNEL", std::to_string(static_cast<int>(kernel_))},
        {"IS_STREAMED", holds_all() ? "0" : "1"},
        {"ROW_STRIDE", std::to_string(layout_.row_stride)},
        {"PLANE_STRIDE", std::to_string(layout_.plane_stride)},
        {"SAMPLE_ZERO", options_.format == SampleFormat::Norm16
                            ? "(32768.0 / 65535.0)" // of GL_R16, whose texels are code / 65535
                            : "0.0"}});
    return defines;
}

} // namespace isocast
