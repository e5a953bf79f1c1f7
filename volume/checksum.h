// Checksums of files' parts.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <cstdint>
#include <string_view>

namespace isocast {

/// CRC-32 as zlib's, of bytes that follow those with the checksum `before`.
std::uint32_t checksum(std::string_view bytes, std::uint32_t before = 0);

/// A number or a record as it lies in memory.
template<class Value>
std::string_view bytes_of(const Value& value) {
    return {reinterpret_cast<const char*>(&value), sizeof value};
}

} // namespace isocast
