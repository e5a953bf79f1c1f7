// A dense field of samples of any type.
// SPDX-License-Identifier: MPL-2.0
#include "volume/typed_field.h"

#include "volume/assert.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

namespace isocast {

namespace {

/// A sample from bytes that need not be aligned.
template<class Sample, bool Swap>
Sample loaded(const std::byte* from) {
    if constexpr (!Swap || sizeof(Sample) == 1) {
        Sample sample;
        std::memcpy(&sample, from, sizeof sample);
        return sample;
    } else {
        std::array<std::byte, sizeof(Sample)> turned;
        std::reverse_copy(from, from + sizeof(Sample), turned.begin());
        return std::bit_cast<Sample>(turned);
    }
}

template<class Sample, bool Swap>
void convert(const TypedSamples& samples, const std::byte* first, std::ptrdiff_t stride_bytes,
             int count, float* out) {
    const double slope = samples.slope;
    const double intercept = samples.intercept;
    if (slope != 1 || intercept != 0) {
        for (int i = 0; i < count; ++i) {
            const auto sample = static_cast<double>(loaded<Sample, Swap>(first + i * stride_bytes));
            out[i] = static_cast<float>(slope * sample + intercept);
        }
    } else if (stride_bytes == sizeof(Sample)) { // known when compiled: vectors of samples
        for (int i = 0; i < count; ++i) {
            out[i] = static_cast<float>(
                loaded<Sample, Swap>(first + i * static_cast<std::ptrdiff_t>(sizeof(Sample))));
        }
    } else {
        for (int i = 0; i < count; ++i) {
            out[i] = static_cast<float>(loaded<Sample, Swap>(first + i * stride_bytes));
        }
    }
}

template<bool Swap>
auto convert_for(SampleType type) {
    switch (type) {
    case SampleType::Int8:
        return convert<std::int8_t, Swap>;
    case SampleType::UInt8:
        return convert<std::uint8_t, Swap>;
    case SampleType::Int16:
        return convert<std::int16_t, Swap>;
    case SampleType::UInt16:
        return convert<std::uint16_t, Swap>;
    case SampleType::Int32:
        return convert<std::int32_t, Swap>;
    case SampleType::UInt32:
        return convert<std::uint32_t, Swap>;
    case SampleType::Float:
        return convert<float, Swap>;
    case SampleType::Double:
        return convert<double, Swap>;
    }
    throw std::logic_error("no such sample type");
}

/// All bits are looked at, so that the loop has no branch and runs over vectors.
bool all_finite(std::span<const float> values) {
    constexpr std::uint32_t exponent = 0x7f800000;
    unsigned bad = 0;
    for (const float value : values)
        bad |= (std::bit_cast<std::uint32_t>(value) & exponent) == exponent ? 1U : 0U;
    return bad == 0;
}

} // namespace

std::string_view name_of(SampleType type) {
    constexpr std::array<std::string_view, 8> names = {"int8",  "uint8",  "int16", "uint16",
                                                       "int32", "uint32", "float", "double"};
    return names[static_cast<std::size_t>(type)];
}

std::size_t byte_count(SampleType type) {
    constexpr std::array<std::size_t, 8> counts = {1, 1, 2, 2, 4, 4, 4, 8};
    return counts[static_cast<std::size_t>(type)];
}

TypedField::TypedField(std::string name, GridSpace space, const Index3& size, TypedSamples samples)
    : name_(std::move(name)), space_(std::move(space)), size_(size), samples_(std::move(samples)),
      convert_(samples_.byte_order == std::endian::native ? convert_for<false>(samples_.type)
                                                          : convert_for<true>(samples_.type)) {
    if (extent().is_empty())
        throw InputError(fmt::format("{}: {} x {} x {} samples: none along an axis", name_,
                                     size.x(), size.y(), size.z()));
    const double needed =
        size.cast<double>().prod() * static_cast<double>(byte_count(samples_.type));
    if (static_cast<double>(samples_.bytes.size()) != needed)
        throw InputError(fmt::format("{}: {} x {} x {} samples of {} are {:.0f} bytes, not {}",
                                     name_, size.x(), size.y(), size.z(), name_of(samples_.type),
                                     needed, samples_.bytes.size()));
    const Eigen::Matrix4d& map = space_.world_from_index.matrix();
    // A product of edges that cancels to a millionth is a flat cell, whatever rounding left of it.
    const double edges = space_.world_from_index.linear().colwise().norm().prod();
    const double volume = std::abs(space_.world_from_index.linear().determinant());
    if (!map.allFinite() || !(edges > 0) || !(volume > 1e-6 * edges))
        throw InputError(
            fmt::format("{}: its map from samples to the world has no inverse", name_));
}

ValueRange TypedField::value_range(const IndexBox& box) const {
    using Rows = tbb::blocked_range<std::int64_t>;
    const Index3 last = (size_.array() - 1).matrix();
    const Index3 lo = box.lo.cwiseMax(0).cwiseMin(last);
    const Index3 hi = (box.hi.array() - 1).matrix().cwiseMax(0).cwiseMin(last);
    const Index3 n = (hi - lo).array() + 1;
    const ValueRange none{std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity()};
    return tbb::parallel_reduce(
        Rows(0, std::int64_t{n.y()} * n.z(), 64), none,
        [&](const Rows& rows, ValueRange range) {
            std::array<float, 1024> buffer;
            for (std::int64_t row = rows.begin(); row < rows.end(); ++row) {
                const Index3 at =
                    lo + Index3(0, static_cast<int>(row % n.y()), static_cast<int>(row / n.y()));
                for (int x = 0; x < n.x(); x += static_cast<int>(buffer.size())) {
                    const int count = std::min(n.x() - x, static_cast<int>(buffer.size()));
                    const std::span part(buffer.data(), static_cast<std::size_t>(count));
                    const Index3 first = at + Index3(x, 0, 0);
                    copy_box({first, first + Index3(count, 1, 1)}, 0, part);
                    for (const float value : part) {
                        range.min = std::min(range.min, value);
                        range.max = std::max(range.max, value);
                    }
                }
            }
            return range;
        },
        [](const ValueRange& a, const ValueRange& b) {
            return ValueRange{std::min(a.min, b.min), std::max(a.max, b.max)};
        });
}

void TypedField::copy_box(const IndexBox& box, int level, std::span<float> out) const {
    ISOCAST_ASSERT(std::ssize(out) == box.sample_count(), "%td values for %td samples",
                   std::ssize(out), static_cast<std::ptrdiff_t>(box.sample_count()));
    if (box.is_empty()) return;
    const auto sample_bytes = static_cast<std::ptrdiff_t>(byte_count(samples_.type));
    const std::int64_t step = std::int64_t{1} << level;
    const auto clamped = [&](int index, int axis) {
        return std::clamp<std::int64_t>(index * step, 0, size_[axis] - 1);
    };
    // The part of a row within the extent is one run; before and after it the ends are repeated.
    const int count = box.size().x();
    const std::int64_t x_lo = box.lo.x();
    const auto begin = static_cast<int>(std::clamp<std::int64_t>(-x_lo, 0, count));
    const auto end =
        static_cast<int>(std::clamp<std::int64_t>((size_.x() - 1) / step + 1 - x_lo, begin, count));
    const bool is_integer =
        samples_.type != SampleType::Float && samples_.type != SampleType::Double;
    const bool is_always_finite = is_integer && samples_.slope == 1 && samples_.intercept == 0;
    float* to = out.data();
    for (int z = box.lo.z(); z < box.hi.z(); ++z) {
        for (int y = box.lo.y(); y < box.hi.y(); ++y, to += count) {
            const std::byte* const row =
                samples_.bytes.data() +
                (clamped(z, 2) * size_.y() + clamped(y, 1)) * size_.x() * sample_bytes;
            if (begin > 0) {
                convert_(samples_, row, sample_bytes, 1, to);
                std::fill(to + 1, to + begin, to[0]);
            }
            if (begin < end) {
                convert_(samples_, row + (x_lo + begin) * step * sample_bytes, step * sample_bytes,
                         end - begin, to + begin);
            }
            if (end < count) {
                convert_(samples_, row + (size_.x() - 1) * sample_bytes, sample_bytes, 1, to + end);
                std::fill(to + end + 1, to + count, to[end]);
            }
            if (is_always_finite) continue;
            const std::span<const float> values(to, static_cast<std::size_t>(count));
            if (!all_finite(values)) refuse_sample({box.lo.x(), y, z}, level, values);
        }
    }
}

/// first  of the row, in units of the level
void TypedField::refuse_sample(const Index3& first, int level, std::span<const float> row) const {
    const auto bad = std::ranges::find_if(row, [](float value) { return !std::isfinite(value); });
    std::array<std::int64_t, 3> at{};
    for (int axis = 0; axis < 3; ++axis) {
        const std::int64_t index = first[axis] + (axis == 0 ? bad - row.begin() : 0);
        at[static_cast<std::size_t>(axis)] =
            std::clamp<std::int64_t>(index * (std::int64_t{1} << level), 0, size_[axis] - 1);
    }
    throw InputError(fmt::format("{}: sample ({}, {}, {}) is {}, not a finite number", name_, at[0],
                                 at[1], at[2], *bad));
}

} // namespace isocast
