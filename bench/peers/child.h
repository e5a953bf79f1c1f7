// Peers that run as programs of their own: a folder for their files, their output.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace isocast {

/// A new folder in the system's place for temporary files; removed with all that is in it.
class ScratchFolder {
public:
    /// throws  ResourceError
    ScratchFolder();
    ~ScratchFolder();
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;

    /// The path of a file in the folder.
    std::string operator/(const std::string& name) const { return (path_ / name).string(); }

private:
    std::filesystem::path path_;
};

/// Runs a command of the shell and waits for it.
/// returns  what it wrote to its outputs
/// throws   ResourceError that quotes them, unless it ended well
std::string run_child(const std::string& command);

/// The samples of a binary PGM file of 8 bits, row by row from the top; true unless 0.
/// throws  ResourceError unless there are width * height of them
std::vector<bool> read_mask(const std::string& path, int width, int height);

} // namespace isocast
