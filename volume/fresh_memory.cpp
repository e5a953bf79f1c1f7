// Memory for large arrays that several threads fill: untouched until they do, in huge pages.
// SPDX-License-Identifier: MPL-2.0
#include "volume/fresh_memory.h"

#include <sys/mman.h>

#include <new>

namespace isocast {

namespace {

/// Huge pages of x86 and of 64-bit ARM with 4 KiB base pages.
constexpr std::size_t huge_page_bytes = std::size_t{1} << 21;

} // namespace

void* allocate_fresh(std::size_t bytes, std::size_t alignment) {
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

void free_fresh(void* memory, std::size_t alignment) noexcept {
    ::operator delete(memory, std::align_val_t(alignment));
}

} // namespace isocast
