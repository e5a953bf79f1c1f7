// How much memory is asked for at once. Not inline, so that compilers see no mismatched pair.
// SPDX-License-Identifier: MPL-2.0
#include "watched_allocation.h"

#include <algorithm>
#include <cstdlib>
#include <new>

std::size_t& isocast::test::largest_allocation() {
    thread_local std::size_t largest = 0;
    return largest;
}

void* operator new(std::size_t size) {
    std::size_t& largest = isocast::test::largest_allocation();
    largest = std::max(largest, size);
    // 1 GiB: nothing here has a use for that.
    void* const memory = size < std::size_t{1} << 30 ? std::malloc(size) : nullptr;
    if (memory == nullptr) throw std::bad_alloc();
    return memory;
}

void operator delete(void* memory) noexcept {
    std::free(memory);
}

void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}
