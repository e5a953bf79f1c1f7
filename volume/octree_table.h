// The hash table of an octree: where the eight children of a divided cell are.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isocast {

/// Entries by key, open-addressed with linear probing: a look-up reads one or two cache lines.
/// Pointers to entries last until the next insert or erase.
class OctreeTable {
public:
    struct Entry {
        std::uint64_t key = 0; // 0: the slot is free
        std::uint32_t links = 0;
        std::uint8_t divided = 0; // bit i: child i is divided, and has an entry too
    };
    static_assert(sizeof(Entry) == 16, "four to a cache line, none across two");

    /// Null if there is none. key > 0
    const Entry* find(std::uint64_t key) const {
        for (std::size_t slot = home_of(key);; slot = next(slot)) {
            if (slots_[slot].key == key) return &slots_[slot];
            if (slots_[slot].key == 0) return nullptr;
        }
    }
    Entry* find(std::uint64_t key) {
        return const_cast<Entry*>(static_cast<const OctreeTable*>(this)->find(key));
    }

    /// The key must be new.
    void insert(const Entry& entry);
    /// The key must be there. Entries behind it move up: no slot is lost to a mark of deletion.
    void erase(std::uint64_t key);

    /// Room for so many entries without growing.
    void reserve(std::size_t entries);

    std::size_t size() const { return size_; }
    std::size_t memory_bytes() const { return slots_.capacity() * sizeof(Entry); }

private:
    /// Fibonacci's hash: 2^64 over the golden ratio spreads successive keys, in any of the key's
    /// fields, evenly over the upper bits.
    std::size_t home_of(std::uint64_t key) const {
        return static_cast<std::size_t>((key * 0x9e3779b97f4a7c15u) >> shift_);
    }
    std::size_t next(std::size_t slot) const { return (slot + 1) & (slots_.size() - 1); }
    void rehash(std::size_t slots);

    std::vector<Entry> slots_ = std::vector<Entry>(2); // a power of two, never full
    int shift_ = 63;                                   // 64 - log2 of the slots
    std::size_t size_ = 0;
};

} // namespace isocast
