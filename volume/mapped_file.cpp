// A file as memory.
// SPDX-License-Identifier: MPL-2.0
#include "volume/mapped_file.h"

#include "volume/errors.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace isocast {

MappedFile::MappedFile(const std::filesystem::path& path) {
    const auto cannot = [&path](int descriptor, const std::string& cause) {
        if (descriptor >= 0) ::close(descriptor);
        throw InputError(fmt::format("cannot read {}: {}", path.string(), cause));
    };
    // O_NONBLOCK: opening a pipe without a writer would wait for one.
    const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (descriptor < 0) cannot(descriptor, std::strerror(errno));
    struct stat status {};
    if (::fstat(descriptor, &status) != 0) cannot(descriptor, std::strerror(errno));
    if (S_ISDIR(status.st_mode)) cannot(descriptor, "it is a folder");
    if (!S_ISREG(status.st_mode)) cannot(descriptor, "it is not a regular file");
    if (const auto size = static_cast<std::size_t>(status.st_size); size > 0) {
        void* const memory = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, descriptor, 0);
        if (memory == MAP_FAILED) cannot(descriptor, std::strerror(errno));
        bytes_ = {static_cast<const std::byte*>(memory), size};
    }
    ::close(descriptor);
}

MappedFile::~MappedFile() {
    if (!bytes_.empty()) ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

} // namespace isocast
