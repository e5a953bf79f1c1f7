// How bricks of samples are stored: which texels, in which format.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "filtering/blocks.h"
#include "gl/objects.h"

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace isocast {

/// How shaders read the samples; shaders/filtering/tricubic.glsl.
enum class Fetch {
    Rows,    // a texel holds the four samples of its cell along x
    Samples, // a texel holds one sample: a quarter of the memory
};

/// How samples are stored.
enum class SampleFormat {
    Float32,
    Float16, // error 2^-11 of the value: no error to speak of at the surface, most at the far ones
    Norm16,  // in 2^16 even steps over a power of two that holds all: the same error everywhere
};

/// "rows" or "samples"; "float32", "float16" or "norm16".
/// throws  InputError that lists these
Fetch fetch_from_name(std::string_view name);
SampleFormat sample_format_from_name(std::string_view name);

/// What happens to bricks beyond the budget.
enum class OverBudget {
    Stream,  // they are loaded when rays ask for them: the same picture, slower
    Coarsen, // those with the least detail are stored at half the resolution, or less
};

/// "stream" or "coarsen".
/// throws  InputError that lists these
OverBudget over_budget_from_name(std::string_view name);

struct StorageOptions {
    Fetch fetch = Fetch::Rows;
    SampleFormat format = SampleFormat::Float32;
    int brick_size = 8; // cells along an edge: 8, 16 or 32
    /// Bytes that the samples may take.
    std::int64_t budget_bytes = std::int64_t{1} << 30;
    OverBudget over_budget = OverBudget::Stream;
};

gl::Format texel_format(const StorageOptions& options);

/// A brick's texels, and the addresses of cells in them.
struct BrickLayout {
    explicit BrickLayout(const StorageOptions& options);

    Fetch fetch;
    int brick_size; // cells along an edge
    int row_stride; // texels from a row to the next along y
    int plane_stride;
    std::int64_t brick_texels;
    std::int64_t brick_bytes;

    /// Samples along an edge: one below the cells and two above.
    int samples() const { return brick_size + filter_support_below + filter_support_above; }
    /// Bricks along an edge of a page.
    int per_page() const { return page_size / brick_size; }
    /// Of a page's blocks (by place_in_page), the bricks they are in, by x + n y + n^2 z.
    std::uint64_t bricks_of(std::uint64_t blocks) const;
    /// The brick of a page's block, and the address of the block's first cell in it.
    int brick_of(const Index3& block_in_page) const;
    std::int64_t address_in_brick(const Index3& block_in_page) const;
};

/// Floats to stored codes and back.
class Codec {
public:
    /// For values up to `greatest`.
    Codec(SampleFormat format, float greatest);

    std::uint16_t encode(float value) const;
    float decode(std::uint16_t code) const;
    /// World units of what the shader reads.
    float world_from_stored() const;
    /// Greatest |sum| on the way to a value, in stored units: what rounding is proportional to.
    float greatest_stored() const;
    /// Greatest error of a value.
    float error() const;

private:
    SampleFormat format_;
    float greatest_;
    float scale_ = 1; // a power of two
};

/// Samples along an edge of a page, those below and above its cells included.
inline constexpr int page_samples = page_size + filter_support_below + filter_support_above;
/// The place of a sample in a page's array; (0, 0, 0) is the one below the first cell.
constexpr std::size_t in_page(int x, int y, int z) {
    return static_cast<std::size_t>(x + page_samples * (y + page_samples * z));
}

/// Copies a brick's samples out of its page's, floats or codes.
///
/// number  of the brick in its page
/// out     layout.brick_bytes
void store_brick(const BrickLayout& layout, const float* page, int number, std::byte* out);
void store_brick(const BrickLayout& layout, const std::uint16_t* page, int number, std::byte* out);

} // namespace isocast
