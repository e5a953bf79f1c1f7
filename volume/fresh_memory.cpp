// Memory for large arrays that several threads fill: untouched until they do, in huge pages or in a
// scratch file.
// SPDX-License-Identifier: MPL-2.0
#include "volume/fresh_memory.h"

#include "volume/errors.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/magic.h>
#include <sys/mman.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>

namespace isocast {

namespace {

/// Huge pages of x86 and of 64-bit ARM with 4 KiB base pages.
constexpr std::size_t huge_page_bytes = std::size_t{1} << 21;

/// Pages of a file that has no name any more: it goes with its mapping.
void* map_scratch_file(std::size_t bytes) {
    const char* const wanted = std::getenv("TMPDIR");
    // Not /tmp, which lies in memory on many systems.
    const std::string folder = wanted != nullptr && *wanted != '\0' ? wanted : "/var/tmp";
    int descriptor = -1;
    const auto fail = [&](const std::string& cause) {
        if (descriptor >= 0) ::close(descriptor);
        throw ResourceError(fmt::format("a scratch file of {:.3g} GiB in {} (TMPDIR): {}",
                                        static_cast<double>(bytes) / 0x1p30, folder, cause));
    };
    std::string name = folder + "/isocast-XXXXXX";
    descriptor = ::mkostemp(name.data(), O_CLOEXEC);
    if (descriptor < 0) fail(std::strerror(errno));
    ::unlink(name.c_str());
    struct statfs system {};
    if (::fstatfs(descriptor, &system) == 0 && system.f_type == TMPFS_MAGIC)
        fail("that folder lies in memory itself (tmpfs)");
    // Takes the room now: a disk that is full later would kill the process.
    const int error = ::posix_fallocate(descriptor, 0, static_cast<off_t>(bytes));
    if (error != 0) fail(std::strerror(error));
    void* const memory = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
    if (memory == MAP_FAILED) fail(std::strerror(errno));
    ::close(descriptor);
    return memory;
}

} // namespace

void* allocate_fresh(std::size_t bytes, std::size_t alignment, Medium medium) {
    if (medium == Medium::ScratchFile) return map_scratch_file(bytes);
    void* const memory = ::operator new(bytes, std::align_val_t(alignment));
#ifdef MADV_HUGEPAGE
    const auto address = reinterpret_cast<std::size_t>(memory);
    const std::size_t first = (address + huge_page_bytes - 1) / huge_page_bytes * huge_page_bytes;
    const std::size_t end = (address + bytes) / huge_page_bytes * huge_page_bytes;
    // A hint: where it is refused, small pages serve.
    if (first < end) madvise(reinterpret_cast<void*>(first), end - first, MADV_HUGEPAGE);
#endif
    return memory;
}

void free_fresh(void* memory, std::size_t bytes, std::size_t alignment, Medium medium) noexcept {
    if (medium == Medium::ScratchFile) {
        ::munmap(memory, bytes);
    } else {
        ::operator delete(memory, std::align_val_t(alignment));
    }
}

} // namespace isocast
