// How bricks of samples are stored.
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/brick_layout.h"

#include "volume/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

namespace isocast {

namespace {

constexpr float zero_code = 32768;

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

template<class T>
void store(const BrickLayout& layout, const T* page, int number, std::byte* out) {
    const int n = layout.per_page();
    const Index3 lo = layout.brick_size * Index3(number % n, number / n % n, number / (n * n));
    // Pages that share samples store their own, which start with the second in the page's array, in
    // rows as long as the volume; bricks are packed.
    const int first = layout.is_whole ? filter_support_below : 0;
    const std::int64_t row_texels = layout.is_whole               ? layout.row_stride
                                    : layout.fetch == Fetch::Rows ? layout.brick_size
                                                                  : layout.samples();
    const std::int64_t plane_texels =
        layout.is_whole ? layout.plane_stride : row_texels * layout.samples();
    for (int z = 0; z < layout.samples(); ++z) {
        for (int y = 0; y < layout.samples(); ++y) {
            const T* row = page + in_page(lo.x(), lo.y() + first + y, lo.z() + first + z);
            const std::int64_t texel = y * row_texels + z * plane_texels;
            if (layout.fetch != Fetch::Rows) {
                std::memcpy(out + texel * std::int64_t{sizeof(T)}, row + first,
                            static_cast<std::size_t>(layout.samples()) * sizeof(T));
                continue;
            }
            for (int x = 0; x < layout.brick_size; ++x)
                std::memcpy(out + (texel + x) * std::int64_t{4 * sizeof(T)}, row + x,
                            4 * sizeof(T));
        }
    }
}

} // namespace

int brick_size_from_name(std::string_view name) {
    if (name == "8") return 8;
    if (name == "16") return 16;
    if (name == "32") return 32;
    if (name == "none") return no_bricks;
    throw InputError(fmt::format("'{}' is not one of 8, 16, 32, none", name));
}

Fetch fetch_from_name(std::string_view name) {
    for (const Fetch fetch : {Fetch::Rows, Fetch::Samples, Fetch::Linear})
        if (name == fetch_name(fetch)) return fetch;
    throw InputError(fmt::format("'{}' is not one of rows, samples, linear", name));
}

std::string_view fetch_name(Fetch fetch) {
    switch (fetch) {
    case Fetch::Rows:
        return "rows";
    case Fetch::Samples:
        return "samples";
    case Fetch::Linear:
        return "linear";
    }
    throw std::logic_error("unknown fetch");
}

SampleFormat sample_format_from_name(std::string_view name) {
    if (name == "float32") return SampleFormat::Float32;
    if (name == "float16") return SampleFormat::Float16;
    if (name == "norm16") return SampleFormat::Norm16;
    throw InputError(fmt::format("'{}' is not one of float32, float16, norm16", name));
}

OverBudget over_budget_from_name(std::string_view name) {
    if (name == "stream") return OverBudget::Stream;
    if (name == "coarsen") return OverBudget::Coarsen;
    throw InputError(fmt::format("'{}' is not one of stream, coarsen", name));
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

std::map<std::string, std::string> fetch_defines(const StorageOptions& options) {
    std::map<std::string, std::string> defines{
        {"FETCH", std::to_string(static_cast<int>(options.fetch))}};
    if (options.fetch == Fetch::Linear) {
        defines["FRACTION_BITS"] = std::to_string(options.fraction_bits);
        defines["IS_REFINED_EXACTLY"] = std::to_string(int{options.is_refined_exactly});
    }
    return defines;
}

Index3 atlas_slots(int count, int samples, int extent) {
    const int most = std::min(extent, atlas_plane / atlas_row) / samples;
    const int most_layers =
        std::min(extent, (std::numeric_limits<int>::max() / atlas_plane) + 1) / samples;
    const auto quotient = [](int a, int b) { return (a + b - 1) / b; }; // rounded up
    const int layer = std::max(1, quotient(count, most_layers));
    const int x = std::min(most, static_cast<int>(std::ceil(std::sqrt(layer))));
    const int y = std::min(most, quotient(layer, x));
    return {x, y, std::min(most_layers, quotient(count, x * y))};
}

BrickLayout::BrickLayout(const StorageOptions& options, const Index3& table_pages)
    : fetch(options.fetch),
      brick_size(options.brick_size == no_bricks ? page_size : options.brick_size),
      is_whole(options.brick_size == no_bricks), row_stride(fetch == Fetch::Rows      ? brick_size
                                                            : fetch == Fetch::Samples ? samples()
                                                                                      : atlas_row),
      plane_stride(fetch == Fetch::Linear ? atlas_plane : row_stride * samples()),
      brick_texels(std::int64_t{fetch == Fetch::Rows ? brick_size : samples()} * samples() *
                   samples()) {
    if (brick_size != 8 && brick_size != 16 && brick_size != 32)
        throw InputError(fmt::format("bricks of {} cells: must be 8, 16 or 32", brick_size));
    if (is_whole) {
        if (fetch == Fetch::Linear) throw InputError("linear fetches need bricks");
        const double texels = std::pow(page_size, 3) * table_pages.cast<double>().prod();
        if (texels > std::numeric_limits<std::int32_t>::max()) {
            throw ResourceError(
                fmt::format("without bricks {:.3g} samples: more than an array holds", texels));
        }
        row_stride = page_size * table_pages.x();
        plane_stride = row_stride * page_size * table_pages.y();
        brick_texels = std::int64_t{plane_stride} * page_size * table_pages.z();
    }
    brick_bytes = brick_texels * gl::byte_count(texel_format(options));
}

int BrickLayout::brick_of(const Index3& block_in_page) const {
    const Index3 brick = block_in_page / (brick_size / block_size);
    return brick.x() + per_page() * (brick.y() + per_page() * brick.z());
}

std::int64_t BrickLayout::address_in_brick(const Index3& block_in_page) const {
    const int per_brick = brick_size / block_size;
    const Index3 cell = block_size * (block_in_page - per_brick * (block_in_page / per_brick));
    // Of the array without bricks the first sample of a page's first cell lies in the page before.
    const int below = is_whole ? filter_support_below : 0;
    const int below_x = fetch == Fetch::Samples ? below : 0; // a row of four starts with it
    return cell.x() - below_x + std::int64_t{cell.y() - below} * row_stride +
           std::int64_t{cell.z() - below} * plane_stride;
}

std::uint64_t BrickLayout::bricks_of(std::uint64_t blocks) const {
    std::uint64_t bricks = 0;
    for (; blocks != 0; blocks &= blocks - 1)
        bricks |= std::uint64_t{1} << brick_of(block_in_page(std::countr_zero(blocks)));
    return bricks;
}

namespace {

/// The scale's exponent.
int scale_exponent(SampleFormat format, float greatest) {
    const int exponent = std::ilogb(greatest);
    // Shaders square values and divide by such squares: within 2^±40 these stay clear of the ends
    // of the floats, and so do values a million times smaller. Ordinary fields are stored as they
    // are.
    if (format == SampleFormat::Float32)
        return exponent > 40 ? exponent - 40 : std::min(exponent + 40, 0);
    // Halves are normal between 2^-14 and 2^15, codes of 16 bits reach 32767 steps above zero.
    const int above = greatest > std::ldexp(1.0F, exponent) ? exponent + 1 : exponent;
    const int enough = greatest > std::ldexp(32767.0F, above - 15) ? above - 14 : above - 15;
    return std::max(enough, -126); // both the scale and its inverse are normal
}

} // namespace

Codec::Codec(SampleFormat format, float greatest) : format_(format), greatest_(greatest) {
    if (greatest == 0) return;
    const int exponent = scale_exponent(format, greatest);
    world_from_scaled_ = std::ldexp(1.0F, exponent);
    scaled_from_world_ = std::ldexp(1.0F, -exponent);
}

std::uint16_t Codec::encode(float scaled) const {
    if (format_ == SampleFormat::Float16) return half_from(scaled);
    return static_cast<std::uint16_t>(std::lrint(scaled) + std::lrint(zero_code));
}

float Codec::decode(std::uint16_t code) const {
    if (format_ == SampleFormat::Float16) return float_from(code);
    return static_cast<float>(code) - zero_code;
}

float Codec::stored_from_scaled() const {
    // A texel of GL_R16 reads as code / 65535.
    return format_ == SampleFormat::Norm16 ? 1.0F / 65535 : 1;
}

float Codec::greatest_stored() const {
    // Texels of GL_R16 lie in [0, 1], and what stands for zero is taken off last.
    return format_ == SampleFormat::Norm16 ? 1 : scaled(greatest_);
}

float Codec::error() const {
    switch (format_) {
    case SampleFormat::Float32:
        return 0;
    case SampleFormat::Float16:
        return greatest_ * 0x1p-11F;
    case SampleFormat::Norm16:
        return world_from_scaled_ / 2;
    }
    throw std::logic_error("unknown sample format");
}

void store_brick(const BrickLayout& layout, const float* page, int number, std::byte* out) {
    store(layout, page, number, out);
}

void store_brick(const BrickLayout& layout, const std::uint16_t* page, int number, std::byte* out) {
    store(layout, page, number, out);
}

} // namespace isocast
