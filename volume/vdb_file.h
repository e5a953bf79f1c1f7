// Reading OpenVDB files; writing them is in files.h.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/files.h"

namespace isocast {

/// read_field for .vdb files.
///
/// Level sets become signed fields, others keep their background as it is. Tiles that hold anything
/// but the value that SparseField has there become constant blocks.
///
/// Leaves are decoded one by one out of the mapped file, so that a grid is never in memory twice.
/// Its topology is: 0.2 kB a leaf, beside 2.1 kB of samples.
/// memory_bytes  beyond it the blocks lie in a scratch file
/// throws  InputError as read_field; ResourceError if tiles would become more than 2^20 blocks, or
///         a scratch file is needed and there is no room for it
SparseField read_vdb(const std::filesystem::path& path, const std::string& grid_name,
                     double memory_bytes);

/// describe_field_file for .vdb files.
std::vector<GridDescription> describe_vdb(const std::filesystem::path& path);

} // namespace isocast
