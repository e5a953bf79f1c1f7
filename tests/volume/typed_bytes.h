// Samples of every type as bytes, made without the code under test.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "random_fields.h"
#include "volume/typed_field.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace isocast::test {

inline constexpr SampleType all_sample_types[] = {
    SampleType::Int8,  SampleType::UInt8,  SampleType::Int16, SampleType::UInt16,
    SampleType::Int32, SampleType::UInt32, SampleType::Float, SampleType::Double};

template<class Sample>
void append(std::string& bytes, double value, std::endian order) {
    const auto sample = static_cast<Sample>(value);
    char raw[sizeof sample];
    std::memcpy(raw, &sample, sizeof sample);
    if (order != std::endian::native) std::reverse(std::begin(raw), std::end(raw));
    bytes.append(raw, sizeof raw);
}

inline void append(std::string& bytes, double value, SampleType type, std::endian order) {
    switch (type) {
    case SampleType::Int8:
        return append<std::int8_t>(bytes, value, order);
    case SampleType::UInt8:
        return append<std::uint8_t>(bytes, value, order);
    case SampleType::Int16:
        return append<std::int16_t>(bytes, value, order);
    case SampleType::UInt16:
        return append<std::uint16_t>(bytes, value, order);
    case SampleType::Int32:
        return append<std::int32_t>(bytes, value, order);
    case SampleType::UInt32:
        return append<std::uint32_t>(bytes, value, order);
    case SampleType::Float:
        return append<float>(bytes, value, order);
    case SampleType::Double:
        return append<double>(bytes, value, order);
    }
}

inline std::string bytes_of(std::span<const double> values, SampleType type, std::endian order) {
    std::string bytes;
    for (const double value : values) append(bytes, value, type, order);
    return bytes;
}

/// Values that `type` holds exactly, its least and greatest among them.
inline std::vector<double> random_values(Random& random, SampleType type, std::size_t count) {
    double min = -1;
    double max = 1;
    const auto limits = [&]<class Sample>(Sample) {
        min = static_cast<double>(std::numeric_limits<Sample>::min());
        max = static_cast<double>(std::numeric_limits<Sample>::max());
    };
    switch (type) {
    case SampleType::Int8:
        limits(std::int8_t{});
        break;
    case SampleType::UInt8:
        limits(std::uint8_t{});
        break;
    case SampleType::Int16:
        limits(std::int16_t{});
        break;
    case SampleType::UInt16:
        limits(std::uint16_t{});
        break;
    case SampleType::Int32:
        limits(std::int32_t{});
        break;
    case SampleType::UInt32:
        limits(std::uint32_t{});
        break;
    case SampleType::Float:
    case SampleType::Double:
        break;
    }
    std::vector<double> values(count);
    for (double& value : values) {
        value = random_real(random, min, max);
        if (max > 1) value = std::floor(value);
        if (type == SampleType::Float) value = static_cast<float>(value);
    }
    values.front() = min;
    values.back() = max;
    return values;
}

} // namespace isocast::test
