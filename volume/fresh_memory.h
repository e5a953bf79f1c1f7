// Memory for large arrays that several threads fill: untouched until they do, in huge pages.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <cstddef>
#include <utility>

namespace isocast {

void* allocate_fresh(std::size_t bytes, std::size_t alignment);
void free_fresh(void* memory, std::size_t alignment) noexcept;

/// An allocator for std::vector whose resizing leaves new elements as raw memory, so that the
/// thread that constructs an element (std::construct_at) is the first to touch its page.
template<class T>
struct FreshMemory {
    using value_type = T;

    FreshMemory() = default;
    template<class U>
    FreshMemory(const FreshMemory<U>&) noexcept {}

    T* allocate(std::size_t count) {
        return static_cast<T*>(allocate_fresh(count * sizeof(T), alignof(T)));
    }
    void deallocate(T* memory, std::size_t) noexcept { free_fresh(memory, alignof(T)); }

    void construct(T*) noexcept {}
    template<class U, class... Args>
    void construct(U* at, Args&&... args) {
        ::new (static_cast<void*>(at)) U(std::forward<Args>(args)...);
    }
    bool operator==(const FreshMemory&) const = default;
};

} // namespace isocast
