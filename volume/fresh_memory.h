// Memory for large arrays that several threads fill: untouched until they do, in huge pages or in a
// scratch file.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <cstddef>
#include <type_traits>
#include <utility>

namespace isocast {

/// Where an array lies.
enum class Medium {
    Memory,
    /// A file that nobody else sees and that is gone when the process is, in TMPDIR, or else in
    /// /var/tmp. It is mapped: the system keeps of it what memory has room for.
    ScratchFile,
};

inline Medium medium_for(std::size_t bytes, double memory_bytes) {
    return static_cast<double>(bytes) <= memory_bytes ? Medium::Memory : Medium::ScratchFile;
}

/// throws  std::bad_alloc; for a scratch file ResourceError that names the folder and the cause,
///         here and not later: the disk's room is taken at once
void* allocate_fresh(std::size_t bytes, std::size_t alignment, Medium medium);
void free_fresh(void* memory, std::size_t bytes, std::size_t alignment, Medium medium) noexcept;

/// An allocator for std::vector whose resizing leaves new elements as raw memory, so that the
/// thread that constructs an element (std::construct_at) is the first to touch its page.
template<class T>
struct FreshMemory {
    using value_type = T;
    using propagate_on_container_move_assignment = std::true_type;
    using propagate_on_container_swap = std::true_type;

    Medium medium = Medium::Memory;

    FreshMemory() = default;
    explicit FreshMemory(Medium where) noexcept : medium(where) {}
    template<class U>
    FreshMemory(const FreshMemory<U>& other) noexcept : medium(other.medium) {}

    T* allocate(std::size_t count) {
        return static_cast<T*>(allocate_fresh(count * sizeof(T), alignof(T), medium));
    }
    void deallocate(T* memory, std::size_t count) noexcept {
        free_fresh(memory, count * sizeof(T), alignof(T), medium);
    }

    void construct(T*) noexcept {}
    template<class U, class... Args>
    void construct(U* at, Args&&... args) {
        ::new (static_cast<void*>(at)) U(std::forward<Args>(args)...);
    }
    bool operator==(const FreshMemory&) const = default;
};

} // namespace isocast
