// Which blocks are active, kept while the iso value moves.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/active_set.h"

#include "volume/assert.h"

#include <tbb/parallel_invoke.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <bit>
#include <ranges>
#include <utility>

namespace isocast {

ActiveSet::ActiveSet(const BlockRanges& ranges, float iso, float value_error)
    : ranges_(&ranges), active_(ranges.pages.size()), iso_(iso), value_error_(value_error) {
    ISOCAST_ASSERT(ranges.pages.size() < std::size_t{1} << 26, "%zu pages", ranges.pages.size());
    std::size_t count = 0;
    for (const BlockPage& page : ranges.pages)
        count += static_cast<std::size_t>(std::popcount(page.blocks));
    lower_.reserve(count);
    upper_.reserve(count);
    for (std::size_t i = 0; i < ranges.pages.size(); ++i) {
        for (std::uint64_t rest = ranges.pages[i].blocks; rest != 0; rest &= rest - 1) {
            const auto place = static_cast<std::size_t>(std::countr_zero(rest));
            const ValueRange range = widened(ranges.pages[i].ranges[place]);
            const auto block = static_cast<std::uint32_t>(i * blocks_per_page + place);
            lower_.push_back({range.min, block});
            upper_.push_back({range.max, block});
        }
    }
    const auto sort = [](std::vector<End>& ends) {
        tbb::parallel_sort(ends, [](const End& a, const End& b) { return a.value < b.value; });
    };
    tbb::parallel_invoke([&] { sort(lower_); }, [&] { sort(upper_); });
    for (const ActivePage& page : active_pages(ranges, iso, value_error))
        active_[page.page] = page.blocks;
}

ActiveChange ActiveSet::move_to(float iso, float value_error) {
    ActiveChange change;
    const auto look_at = [&](const End& end) {
        const std::uint32_t page = end.block / blocks_per_page;
        const std::uint32_t place = end.block % blocks_per_page;
        const std::uint64_t bit = std::uint64_t{1} << place;
        const bool was = (active_[page] & bit) != 0;
        if (was == is_active(ranges_->pages[page].ranges[place], iso, value_error)) return;
        active_[page] ^= bit;
        (was ? change.went : change.came).push_back({page, place});
    };
    // A block is active if its lower end is not above iso + value_error, nor its upper end below
    // iso - value_error: those are looked at for which one of the two may have changed.
    const auto [top_lo, top_hi] = std::minmax({iso_ + value_error_, iso + value_error});
    const auto [bottom_lo, bottom_hi] = std::minmax({iso_ - value_error_, iso - value_error});
    const auto not_above = [](const std::vector<End>& ends, float value) {
        return std::ranges::upper_bound(ends, value, {}, &End::value);
    };
    const auto below = [](const std::vector<End>& ends, float value) {
        return std::ranges::lower_bound(ends, value, {}, &End::value);
    };
    std::ranges::for_each(not_above(lower_, top_lo), not_above(lower_, top_hi), look_at);
    std::ranges::for_each(below(upper_, bottom_lo), below(upper_, bottom_hi), look_at);
    iso_ = iso;
    value_error_ = value_error;
    return change;
}

std::vector<ActivePage> ActiveSet::pages() const {
    std::vector<ActivePage> pages;
    for (std::size_t i = 0; i < active_.size(); ++i)
        if (active_[i] != 0) pages.push_back({i, active_[i]});
    return pages;
}

} // namespace isocast
