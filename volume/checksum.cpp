// SPDX-License-Identifier: MPL-2.0
#include "volume/checksum.h"

#include <zlib.h>

namespace isocast {

std::uint32_t checksum(std::string_view bytes, std::uint32_t before) {
    return static_cast<std::uint32_t>(
        ::crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

} // namespace isocast
