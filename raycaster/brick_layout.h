// How bricks of samples are stored: which texels, in which format.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "filtering/blocks.h"
#include "gl/objects.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace isocast {

/// How shaders read the samples; shaders/filtering/tricubic.glsl.
enum class Fetch {
    Rows,    // a texel holds the four samples of its cell along x
    Samples, // a texel holds one sample: a quarter of the memory
    Linear,  // the same in a 3D texture, eight samples at once by the GL's filter (thesis 5.2)
};

/// How samples are stored.
enum class SampleFormat {
    Float32,
    Float16, // error 2^-11 of the value: no error to speak of at the surface, most at the far ones
    Norm16,  // in 2^16 even steps over a power of two that holds all: the same error everywhere
};

/// "rows", "samples" or "linear"; "float32", "float16" or "norm16".
/// throws  InputError that lists these
Fetch fetch_from_name(std::string_view name);
std::string_view fetch_name(Fetch fetch);
SampleFormat sample_format_from_name(std::string_view name);

/// As a brick size: one array of all pages of the block table, empty ones too; to compare with.
inline constexpr int no_bricks = 0;

/// "8", "16", "32" or "none".
/// throws  InputError that lists these
int brick_size_from_name(std::string_view name);

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
    int brick_size = 8; // cells along an edge: 8, 16 or 32; no_bricks
    /// Bytes that the samples may take.
    std::int64_t budget_bytes = std::int64_t{1} << 30;
    OverBudget over_budget = OverBudget::Stream;
    /// For studies of Fetch::Linear: bits to which shaders round the filter's fractions (0: those
    /// of the GL), and whether exact sums place hits and make gradients.
    int fraction_bits = 0;
    bool is_refined_exactly = true;

    bool operator==(const StorageOptions&) const = default;
};

gl::Format texel_format(const StorageOptions& options);
/// Those defines of shaders/filtering/tricubic.glsl that #if looks at, but for KERNEL.
std::map<std::string, std::string> fetch_defines(const StorageOptions& options);

/// Addresses of texels of Fetch::Linear: 11 bits of x, 11 of y, 9 of z; shaders/filtering/
/// tricubic.glsl.
inline constexpr int atlas_row = 1 << 11;
inline constexpr int atlas_plane = 1 << 22;

/// Bricks along the axes of a 3D texture that holds `count` of them, or as many as it can. Hardly
/// more: less than a layer, and layers are as small as their number allows.
///
/// samples  of a brick along an edge
/// extent   greatest of the texture
Index3 atlas_slots(int count, int samples, int extent);

/// A brick's texels, and the addresses of cells in them.
struct BrickLayout {
    /// table_pages  extent of the block table, for no_bricks
    explicit BrickLayout(const StorageOptions& options, const Index3& table_pages = Index3::Ones());

    Fetch fetch;
    int brick_size; // cells along an edge; a page's without bricks
    bool is_whole;  // no bricks: pages stand in one array and share the samples between them
    int row_stride; // texels from a row to the next along y
    int plane_stride;
    std::int64_t brick_texels; // without bricks, those of the whole array
    std::int64_t brick_bytes;

    /// Samples stored along an edge: one below the cells and two above, unless bricks share them.
    int samples() const {
        return is_whole ? brick_size : brick_size + filter_support_below + filter_support_above;
    }
    /// Bricks along an edge of a page.
    int per_page() const { return page_size / brick_size; }
    /// Of a page's blocks (by place_in_page), the bricks they are in, by x + n y + n^2 z.
    std::uint64_t bricks_of(std::uint64_t blocks) const;
    /// The brick of a page's block, and the address of the block's first sample from the brick's
    /// first; without bricks it can lie before.
    int brick_of(const Index3& block_in_page) const;
    std::int64_t address_in_brick(const Index3& block_in_page) const;
};

/// Floats to what is stored and back. The scale between is a power of two, which rounds nothing.
class Codec {
public:
    /// For values up to `greatest` [world].
    Codec(SampleFormat format, float greatest);

    float scaled(float value_world) const { return value_world * scaled_from_world_; }
    /// To 16 bits and back [scaled].
    std::uint16_t encode(float scaled) const;
    float decode(std::uint16_t code) const;
    /// What the shader reads of a scaled number.
    float stored_from_scaled() const;
    /// World units of what the shader reads.
    float world_from_stored() const { return world_from_scaled_ / stored_from_scaled(); }
    /// Greatest |sum| on the way to a value, in stored units: what rounding is proportional to.
    float greatest_stored() const;
    /// Greatest error of a value [world].
    float error() const;

private:
    SampleFormat format_;
    float greatest_;
    float world_from_scaled_ = 1;
    float scaled_from_world_ = 1;
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
/// out     layout.brick_bytes; without bricks, where the page's own samples start in the array
void store_brick(const BrickLayout& layout, const float* page, int number, std::byte* out);
void store_brick(const BrickLayout& layout, const std::uint16_t* page, int number, std::byte* out);

} // namespace isocast
