// A dense field of samples of any type, as they lie in a file or in memory.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/field_source.h"

#include <bit>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace isocast {

enum class SampleType { Int8, UInt8, Int16, UInt16, Int32, UInt32, Float, Double };

/// int8, uint8, …, float, double.
std::string_view name_of(SampleType type);
std::size_t byte_count(SampleType type);

/// Samples, x fastest, and how they become values.
struct TypedSamples {
    SampleType type = SampleType::Float;
    std::endian byte_order = std::endian::native;
    /// Value = slope * sample + intercept.
    double slope = 1;
    double intercept = 0;
    std::span<const std::byte> bytes;
    /// What `bytes` lie in: a MappedFile or a buffer.
    std::shared_ptr<const void> owner;
};

/// A box of samples from (0, 0, 0) that keep their type: 8 bits stay 8 bits, and those of a mapped
/// file stay in the file. Beyond the box the samples at its border continue. There is no band.
///
/// Values are float32, so that 32-bit integers beyond 2^24 and doubles are rounded.
class TypedField final : public FieldSource {
public:
    /// name    of the file, for messages
    /// throws  InputError that names the file if `size` and the number of bytes differ, if an axis
    ///         has no samples, or if the map to world space has no inverse
    TypedField(std::string name, GridSpace space, const Index3& size, TypedSamples samples);

    const GridSpace& space() const override { return space_; }
    IndexBox extent() const override { return {Index3::Zero(), size_}; }
    std::optional<double> half_width_world() const override { return std::nullopt; }
    std::vector<IndexBox> active_boxes() const override { return {extent()}; }
    int finest_level(const IndexBox&) const override { return 0; }
    /// The tightest range. Reads every sample of the box.
    /// throws  as copy_box
    ValueRange value_range(const IndexBox& box) const override;
    /// throws  InputError that names the file and the sample's index where a value is NaN or
    ///         infinite. Such samples are found here and not on opening, which would read all of
    ///         a file that may be larger than memory.
    void copy_box(const IndexBox& box, int level, std::span<float> out) const override;

    SampleType sample_type() const { return samples_.type; }

private:
    /// The values of `count` samples, `stride_bytes` apart.
    using Convert = void (*)(const TypedSamples& samples, const std::byte* first,
                             std::ptrdiff_t stride_bytes, int count, float* out);

    [[noreturn]] void refuse_sample(const Index3& first, int level,
                                    std::span<const float> row) const;

    std::string name_;
    GridSpace space_;
    Index3 size_;
    TypedSamples samples_;
    Convert convert_;
};

} // namespace isocast
