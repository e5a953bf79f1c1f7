// How bricks of samples are stored.
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/brick_layout.h"

#include "volume/errors.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>
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
    const auto row_bytes = static_cast<std::size_t>(layout.samples()) * sizeof(T);
    for (int z = 0; z < layout.samples(); ++z) {
        for (int y = 0; y < layout.samples(); ++y) {
            const T* row = page + in_page(lo.x(), lo.y() + y, lo.z() + z);
            if (layout.fetch == Fetch::Samples) {
                std::memcpy(out, row, row_bytes);
                out += row_bytes;
                continue;
            }
            for (int x = 0; x < layout.brick_size; ++x) {
                std::memcpy(out, row + x, 4 * sizeof(T));
                out += 4 * sizeof(T);
            }
        }
    }
}

} // namespace

Fetch fetch_from_name(std::string_view name) {
    if (name == "rows") return Fetch::Rows;
    if (name == "samples") return Fetch::Samples;
    throw InputError(fmt::format("'{}' is not one of rows, samples", name));
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

BrickLayout::BrickLayout(const StorageOptions& options)
    : fetch(options.fetch), brick_size(options.brick_size),
      row_stride(fetch == Fetch::Rows ? brick_size : samples()),
      plane_stride(row_stride * samples()), brick_texels(std::int64_t{plane_stride} * samples()),
      brick_bytes(brick_texels * gl::byte_count(texel_format(options))) {
    if (brick_size != 8 && brick_size != 16 && brick_size != 32)
        throw InputError(fmt::format("bricks of {} cells: must be 8, 16 or 32", brick_size));
}

int BrickLayout::brick_of(const Index3& block_in_page) const {
    const Index3 brick = block_in_page / (brick_size / block_size);
    return brick.x() + per_page() * (brick.y() + per_page() * brick.z());
}

std::int64_t BrickLayout::address_in_brick(const Index3& block_in_page) const {
    const int per_brick = brick_size / block_size;
    const Index3 cell = block_size * (block_in_page - per_brick * (block_in_page / per_brick));
    return cell.x() + std::int64_t{cell.y()} * row_stride + std::int64_t{cell.z()} * plane_stride;
}

std::uint64_t BrickLayout::bricks_of(std::uint64_t blocks) const {
    std::uint64_t bricks = 0;
    for (; blocks != 0; blocks &= blocks - 1)
        bricks |= std::uint64_t{1} << brick_of(block_in_page(std::countr_zero(blocks)));
    return bricks;
}

Codec::Codec(SampleFormat format, float greatest) : format_(format), greatest_(greatest) {
    if (format == SampleFormat::Float32 || greatest == 0) return;
    // Halves are normal between 2^-14 and 2^15, codes of 16 bits reach 32767 steps above zero.
    scale_ = std::exp2(std::ceil(std::log2(greatest)) - 15);
    if (greatest > 32767 * scale_) scale_ *= 2;
}

std::uint16_t Codec::encode(float value) const {
    const float scaled = value / scale_;
    if (format_ == SampleFormat::Float16) return half_from(scaled);
    return static_cast<std::uint16_t>(std::lrint(scaled) + std::lrint(zero_code));
}

float Codec::decode(std::uint16_t code) const {
    if (format_ == SampleFormat::Float16) return float_from(code) * scale_;
    return (static_cast<float>(code) - zero_code) * scale_;
}

float Codec::world_from_stored() const {
    // A texel of GL_R16 reads as code / 65535.
    return format_ == SampleFormat::Norm16 ? 65535 * scale_ : scale_;
}

float Codec::greatest_stored() const {
    // Texels of GL_R16 lie in [0, 1], and what stands for zero is taken off last.
    return format_ == SampleFormat::Norm16 ? 1 : greatest_ / world_from_stored();
}

float Codec::error() const {
    switch (format_) {
    case SampleFormat::Float32:
        return 0;
    case SampleFormat::Float16:
        return greatest_ * 0x1p-11F;
    case SampleFormat::Norm16:
        return scale_ / 2;
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
