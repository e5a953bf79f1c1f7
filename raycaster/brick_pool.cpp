// The control samples of the active blocks on the GPU, and what certifies steps through each block.
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/brick_pool.h"

#include "filtering/certificate.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace isocast {

namespace {

constexpr int apron = filter_support_below + filter_support_above;
constexpr int page_samples = page_size + apron;
constexpr std::size_t samples_per_page = std::size_t{page_samples} * page_samples * page_samples;

/// Two texels of t_blocks; shaders/raycast/blocks.glsl.
struct BlockRecord {
    float slope;
    float bend;
    float near;
    float scale;
    std::uint32_t address;
    std::uint32_t parts_lo;
    std::uint32_t parts_hi;
    std::uint32_t place; // in the table: 11 bits of x, 11 of y, 10 of z
};
static_assert(sizeof(BlockRecord) == 32);

/// float32 to float16, to the nearest, ties to even; |value| < 65520.
/// source  Giesen, "Float->half variants", float_to_half_fast3_rtne
std::uint16_t half_from(float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    const std::uint32_t sign = bits & 0x80000000U;
    const std::uint32_t magnitude = bits ^ sign;
    // Below 2^-14, the least normal half, the sum with 1/2 leaves the half's bits at its end.
    constexpr std::uint32_t denormal_magic = 126U << 23;
    const std::uint32_t denormal =
        std::bit_cast<std::uint32_t>(std::bit_cast<float>(magnitude) +
                                     std::bit_cast<float>(denormal_magic)) -
        denormal_magic;
    const std::uint32_t normal = (magnitude - (112U << 23) + 0xfffU + (magnitude >> 13 & 1U)) >> 13;
    const std::uint32_t half = magnitude < (113U << 23) ? denormal : normal;
    return static_cast<std::uint16_t>(half | sign >> 16);
}

float float_from(std::uint16_t half) {
    // The exponents differ by 112; multiplying makes denormals right too.
    const float magnitude = std::bit_cast<float>((half & 0x7fffU) << 13) * 0x1p112F;
    return (half & 0x8000U) != 0 ? -magnitude : magnitude;
}

/// How floats become stored codes and what the shader makes of them: x * code + y.
struct Codec {
    SampleFormat format;
    float scale = 1; // a power of two
    float inverse = 1;

    static constexpr float zero_code = 32768;

    /// For values up to `greatest`.
    Codec(SampleFormat stored, float greatest) : format(stored) {
        if (format == SampleFormat::Float32 || greatest == 0) return;
        // Halves are normal between 2^-14 and 2^15, codes of 16 bits reach 2^15 steps to each side.
        scale = std::exp2(std::ceil(std::log2(greatest)) - 15);
        // 32767 steps above zero, 32768 below.
        if (greatest > 32767 * scale) scale *= 2;
        inverse = 1 / scale;
    }
    std::size_t bytes() const { return format == SampleFormat::Float32 ? 4 : 2; }
    std::uint16_t encode(float value) const {
        return format == SampleFormat::Float16
                   ? half_from(value * inverse)
                   : static_cast<std::uint16_t>(std::lrint(value * inverse) + 32768);
    }
    float decode(std::uint16_t code) const {
        return format == SampleFormat::Float16 ? float_from(code) * scale
                                               : (static_cast<float>(code) - zero_code) * scale;
    }
    /// World units of what the shader reads.
    float world_from_stored() const {
        return format == SampleFormat::Norm16 ? 65535 * scale : scale;
    }
};

/// Where bricks stand in the buffer.
struct Layout {
    Fetch fetch;
    int brick_size;
    std::int64_t texel_bytes;

    int row_texels() const { return fetch == Fetch::Rows ? brick_size : brick_size + apron; }
    int rows() const { return brick_size + apron; }
    std::int64_t brick_texels() const { return std::int64_t{row_texels()} * rows() * rows(); }
    std::int64_t brick_bytes() const { return brick_texels() * texel_bytes; }
    Eigen::Vector2i stride() const { return {row_texels(), row_texels() * rows()}; }
    /// Bricks along an edge of a page.
    int per_page() const { return page_size / brick_size; }
};

/// What a thread needs to store a page.
struct Workspace {
    std::vector<float> values = std::vector<float>(samples_per_page);
    std::vector<std::uint16_t> codes = std::vector<std::uint16_t>(samples_per_page);
};

std::size_t in_page(int x, int y, int z) {
    return static_cast<std::size_t>(x + page_samples * (y + page_samples * z));
}

/// Copies a brick's samples from its page, whose samples of type T start at `page`.
template<class T>
void store_brick(const Layout& layout, const T* page, const Index3& lo, std::byte* out) {
    const auto row_samples = static_cast<std::size_t>(layout.rows());
    for (int z = 0; z < layout.rows(); ++z) {
        for (int y = 0; y < layout.rows(); ++y) {
            const T* row = page + in_page(lo.x(), lo.y() + y, lo.z() + z);
            if (layout.fetch == Fetch::Samples) {
                std::memcpy(out, row, row_samples * sizeof(T));
                out += row_samples * sizeof(T);
                continue;
            }
            for (int x = 0; x < layout.brick_size; ++x) {
                std::memcpy(out, row + x, 4 * sizeof(T));
                out += 4 * sizeof(T);
            }
        }
    }
}

/// The bricks of a page that hold an active block, by place among the page's bricks.
std::uint64_t bricks_of(std::uint64_t blocks, const Layout& layout) {
    std::uint64_t bricks = 0;
    const int per_brick = layout.brick_size / block_size;
    const int n = layout.per_page();
    for (; blocks != 0; blocks &= blocks - 1) {
        const int place = std::countr_zero(blocks);
        const int x = place % page_blocks / per_brick;
        const int y = place / page_blocks % page_blocks / per_brick;
        const int z = place / (page_blocks * page_blocks) / per_brick;
        bricks |= std::uint64_t{1} << (x + n * (y + n * z));
    }
    return bricks;
}

gl::Format texel_format(const StorageOptions& options) {
    const bool is_row = options.fetch == Fetch::Rows;
    switch (options.format) {
    case SampleFormat::Float32:
        return is_row ? gl::Format::Rgba32f : gl::Format::R32f;
    case SampleFormat::Float16:
        return is_row ? gl::Format::Rgba16f : gl::Format::R16f;
    case SampleFormat::Norm16:
        return is_row ? gl::Format::Rgba16 : gl::Format::R16;
    }
    throw std::logic_error("unknown sample format");
}

/// Greatest |value - iso| of the active pages' samples: the blocks' ranges know it.
float greatest_value_of(const BlockRanges& ranges, const std::vector<ActivePage>& active,
                        float iso) {
    float greatest = 0;
    for (const ActivePage& page : active) {
        // All blocks of the page, since bricks of more than one block hold inactive ones too.
        for (const ValueRange& range : ranges.pages[page.page].ranges) {
            greatest = std::max({greatest, std::abs(range.min - iso), std::abs(range.max - iso)});
        }
    }
    return greatest;
}

} // namespace

BrickPool::BrickPool(const FieldSource& control, Kernel kernel, const BlockRanges& ranges,
                     const std::vector<ActivePage>& active, const BlockTable& table, float iso,
                     const StorageOptions& options, const Progress& progress)
    : options_(options), kernel_(kernel) {
    const Layout layout{options.fetch, options.brick_size, gl::byte_count(texel_format(options))};
    std::vector<std::int64_t> first_bricks;
    std::vector<std::int64_t> first_blocks;
    std::int64_t brick_count = 0;
    std::int64_t block_count = 0;
    for (const ActivePage& page : active) {
        first_bricks.push_back(brick_count);
        first_blocks.push_back(block_count);
        brick_count += std::popcount(bricks_of(page.blocks, layout));
        block_count += std::popcount(page.blocks);
    }
    const Index3 extent = page_blocks * table.pages;
    if (extent.x() > 2048 || extent.y() > 2048 || extent.z() > 1024) {
        throw ResourceError(
            fmt::format("the surface spans {} x {} x {} voxels, more than 16384 x 16384 x 8192",
                        block_size * extent.x(), block_size * extent.y(), block_size * extent.z()));
    }
    const Index3 first_page = table.first_page;
    const auto packed = [](const Index3& block) {
        return static_cast<std::uint32_t>(block.x()) | static_cast<std::uint32_t>(block.y()) << 11 |
               static_cast<std::uint32_t>(block.z()) << 22;
    };
    if (brick_count * layout.brick_texels() > gl::max_buffer_texels()) {
        throw ResourceError(fmt::format(
            "the surface touches {} bricks of {}^3 voxels, {} MiB: more than one buffer texture of "
            "{} texels holds; use a coarser voxel size",
            brick_count, options.brick_size, brick_count * layout.brick_bytes() >> 20,
            gl::max_buffer_texels()));
    }
    brick_count_ = static_cast<int>(brick_count);
    greatest_value_ = greatest_value_of(ranges, active, iso);
    const Codec codec(options.format, greatest_value_);
    world_from_stored_ = codec.world_from_stored();
    const float stored_from_world = 1 / world_from_stored_;
    if (options.format == SampleFormat::Float16) storage_error_ = greatest_value_ * 0x1p-11F;
    if (options.format == SampleFormat::Norm16) storage_error_ = codec.scale / 2;

    samples_ = gl::Buffer::writable(brick_count * layout.brick_bytes(), "brick samples");
    records_ = gl::Buffer::writable(block_count * static_cast<std::int64_t>(sizeof(BlockRecord)),
                                    "block records");
    std::vector<BlockRecord> records(static_cast<std::size_t>(block_count));
    tbb::enumerable_thread_specific<Workspace> workspaces;
    samples_.write(0, brick_count * layout.brick_bytes(), [&](std::span<std::byte> memory) {
        tbb::parallel_for(std::size_t{0}, active.size(), [&](std::size_t i) {
            Workspace& work = workspaces.local();
            const BlockPage& page = ranges.pages[active[i].page];
            const Index3 first = (page_size * page.coordinate.array() - filter_support_below);
            control.copy_box({first, (first.array() + page_samples).matrix()}, 0, work.values);
            for (float& value : work.values) value -= iso;
            if (options.format != SampleFormat::Float32) {
                for (std::size_t k = 0; k < samples_per_page; ++k) {
                    work.codes[k] = codec.encode(work.values[k]);
                    // Bounds are those of the samples as stored.
                    work.values[k] = codec.decode(work.codes[k]);
                }
            }
            // Bricks.
            const int n = layout.per_page();
            std::array<std::int64_t, blocks_per_page> brick_at{};
            std::int64_t brick = first_bricks[i];
            for (std::uint64_t rest = bricks_of(active[i].blocks, layout); rest != 0;
                 rest &= rest - 1) {
                const int place = std::countr_zero(rest);
                const Index3 lo =
                    layout.brick_size * Index3(place % n, place / n % n, place / (n * n));
                std::byte* out = memory.data() + brick * layout.brick_bytes();
                if (options.format == SampleFormat::Float32) {
                    store_brick(layout, work.values.data(), lo, out);
                } else {
                    store_brick(layout, work.codes.data(), lo, out);
                }
                brick_at[static_cast<std::size_t>(place)] = brick++;
            }
            // Blocks.
            auto record = records.begin() + first_blocks[i];
            const int per_brick = layout.brick_size / block_size;
            for (std::uint64_t rest = active[i].blocks; rest != 0; rest &= rest - 1, ++record) {
                const int place = std::countr_zero(rest);
                const Index3 block(place % page_blocks, place / page_blocks % page_blocks,
                                   place / (page_blocks * page_blocks));
                const Certificate bounds = certify_block(
                    work.values.data() + in_page(block_size * block.x(), block_size * block.y(),
                                                 block_size * block.z()),
                    page_samples, page_samples * page_samples, kernel);
                const Index3 b = block / per_brick;
                const Index3 cell = block_size * (block - per_brick * b);
                const std::int64_t address =
                    brick_at[static_cast<std::size_t>(b.x() + n * (b.y() + n * b.z()))] *
                        layout.brick_texels() +
                    cell.x() + cell.y() * layout.stride().x() + cell.z() * layout.stride().y();
                *record = {bounds.slope * stored_from_world,
                           bounds.bend * stored_from_world,
                           bounds.near * stored_from_world,
                           1.0F,
                           static_cast<std::uint32_t>(address),
                           static_cast<std::uint32_t>(bounds.parts),
                           static_cast<std::uint32_t>(bounds.parts >> 32),
                           packed(page_blocks * (page.coordinate - first_page) + block)};
            }
        });
    });
    if (progress) progress("upload", 1);
    records_.write(0, static_cast<std::int64_t>(records.size() * sizeof(BlockRecord)),
                   [&](std::span<std::byte> memory) {
                       std::memcpy(memory.data(), records.data(), memory.size());
                   });
    samples_texture_ = gl::BufferTexture(samples_, texel_format(options), "brick samples");
    records_texture_ = gl::BufferTexture(records_, gl::Format::Rgba32ui, "block records");
}

void BrickPool::bind() const {
    samples_texture_.bind_to_unit(1);
    records_texture_.bind_to_unit(2);
}

std::map<std::string, std::string> BrickPool::defines() const {
    const Layout layout{options_.fetch, options_.brick_size,
                        gl::byte_count(texel_format(options_))};
    return {{"FETCH", std::to_string(static_cast<int>(options_.fetch))},
            {"KERNEL", std::to_string(static_cast<int>(kernel_))},
            {"ROW_STRIDE", std::to_string(layout.stride().x())},
            {"PLANE_STRIDE", std::to_string(layout.stride().y())},
            {"SAMPLE_ZERO", options_.format == SampleFormat::Norm16
                                ? "(32768.0 / 65535.0)" // of GL_R16, whose texels are code / 65535
                                : "0.0"}};
}

} // namespace isocast
