// Output files that appear whole or not at all.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <filesystem>
#include <string>

namespace isocast {

/// A file written under a temporary name beside its final one, and renamed by commit().
/// Destroyed without commit(), it leaves nothing behind.
class AtomicFile {
public:
    /// throws  InputError if the folder does not exist or cannot be written to
    explicit AtomicFile(std::filesystem::path final_path);
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    /// Where to write. Keeps the final name's extension, since writers choose the format by it.
    const std::filesystem::path& temporary_path() const { return temporary_path_; }

    /// Moves the file to its final name. Call after the writer has closed it and seen no error.
    /// throws  ResourceError if that fails
    void commit();

private:
    std::filesystem::path final_path_;
    std::filesystem::path temporary_path_;
};

/// throws  InputError if the folder does not exist; ResourceError if it cannot be written
void write_text_file(const std::string& text, const std::filesystem::path& path);

} // namespace isocast
