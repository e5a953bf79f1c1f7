// Output files that appear whole or not at all.
// SPDX-License-Identifier: MPL-2.0
#include "volume/atomic_file.h"

#include "volume/errors.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <random>

namespace isocast {

AtomicFile::AtomicFile(std::filesystem::path final_path) : final_path_(std::move(final_path)) {
    const std::filesystem::path folder =
        final_path_.has_parent_path() ? final_path_.parent_path() : ".";
    const auto fail = [&](const std::string& cause) {
        throw InputError(fmt::format("cannot write {}: {}", final_path_.string(), cause));
    };
    if (!final_path_.has_filename()) fail("no file name");
    if (!std::filesystem::is_directory(folder)) {
        fail(fmt::format("the folder {} does not exist", folder.string()));
    }
    if (std::filesystem::is_directory(final_path_)) fail("it is a folder");
    // The random part keeps two threads of one process apart, and O_EXCL settles the rest.
    temporary_path_ =
        folder / fmt::format(".{}.{}.{:08x}.tmp{}", final_path_.stem().string(), ::getpid(),
                             std::random_device()(), final_path_.extension().string());
    const int file = ::open(temporary_path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file < 0) fail(fmt::format("{} in {}", std::strerror(errno), folder.string()));
    ::close(file);
}

AtomicFile::~AtomicFile() {
    std::error_code ignored; // nothing more can be done about it, and it may have been moved
    if (!temporary_path_.empty()) std::filesystem::remove(temporary_path_, ignored);
}

void AtomicFile::commit() {
    std::error_code error;
    std::filesystem::rename(temporary_path_, final_path_, error);
    if (error) {
        throw ResourceError(
            fmt::format("cannot write {}: {}", final_path_.string(), error.message()));
    }
    temporary_path_.clear();
}

void write_text_file(const std::string& text, const std::filesystem::path& path) {
    AtomicFile file(path);
    std::ofstream out(file.temporary_path(), std::ios::binary);
    out << text;
    out.close();
    if (!out) throw ResourceError(fmt::format("{}: cannot be written", path.string()));
    file.commit();
}

} // namespace isocast
