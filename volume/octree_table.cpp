// The hash table of an octree.
// SPDX-License-Identifier: MPL-2.0
#include "volume/octree_table.h"

#include "volume/assert.h"

#include <bit>
#include <utility>

namespace isocast {

namespace {

/// The slots for so many entries: a power of two, at most 7/10 full.
std::size_t slots_for(std::size_t entries) {
    return std::bit_ceil(entries * 10 / 7 + 2);
}

} // namespace

void OctreeTable::insert(const Entry& entry) {
    reserve(size_ + 1);
    std::size_t slot = home_of(entry.key);
    while (slots_[slot].key != 0) slot = next(slot);
    slots_[slot] = entry;
    ++size_;
}

void OctreeTable::erase(std::uint64_t key) {
    const Entry* entry = find(key);
    ISOCAST_ASSERT(entry, "no key %llx", static_cast<unsigned long long>(key));
    auto gap = static_cast<std::size_t>(entry - slots_.data());
    // An entry may fill the gap unless its home lies behind the gap: then no probe for it starts
    // before.
    const std::size_t mask = slots_.size() - 1;
    for (std::size_t slot = next(gap); slots_[slot].key != 0; slot = next(slot))
        if (((slot - home_of(slots_[slot].key)) & mask) >= ((slot - gap) & mask))
            slots_[std::exchange(gap, slot)] = slots_[slot];
    slots_[gap] = {};
    --size_;
}

void OctreeTable::reserve(std::size_t entries) {
    if (slots_for(entries) > slots_.size()) rehash(slots_for(entries));
}

void OctreeTable::rehash(std::size_t slots) {
    const std::vector<Entry> old = std::exchange(slots_, std::vector<Entry>(slots));
    shift_ = 64 - std::countr_zero(slots);
    for (const Entry& entry : old) {
        if (entry.key == 0) continue;
        std::size_t slot = home_of(entry.key);
        while (slots_[slot].key != 0) slot = next(slot);
        slots_[slot] = entry;
    }
}

} // namespace isocast
