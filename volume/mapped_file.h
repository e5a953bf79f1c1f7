// A file as memory: its pages come from disk when they are touched, and go when memory is short.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

namespace isocast {

/// All bytes of a file, read only. Opening reads none of them, so that the file may be larger than
/// memory. A file that another program cuts short while it is mapped ends the program with SIGBUS.
class MappedFile {
public:
    /// throws  InputError that names the file if it cannot be opened or is no regular file
    explicit MappedFile(const std::filesystem::path& path);
    ~MappedFile();
    MappedFile(const MappedFile&) = delete;
    MappedFile& operator=(const MappedFile&) = delete;

    std::span<const std::byte> bytes() const { return bytes_; }

private:
    std::span<const std::byte> bytes_;
};

} // namespace isocast
