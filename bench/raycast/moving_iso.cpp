// What it costs to move the iso value: a fresh load beside Renderer::set_iso, and the query alone.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/active_set.h"
#include "filtering/filter.h"
#include "peers/peer_frame.h"
#include "raycast/raycast_bench.h"

#include <fmt/format.h>

#include <bit>
#include <chrono>
#include <cstdio>
#include <optional>

namespace isocast {

namespace {

template<class Call>
double seconds_of(Call call) {
    const auto start = std::chrono::steady_clock::now();
    call();
    return seconds_since(start);
}

std::int64_t block_count(const std::vector<ActivePage>& pages) {
    std::int64_t count = 0;
    for (const ActivePage& page : pages) count += std::popcount(page.blocks);
    return count;
}

} // namespace

void run_moving_iso(Renderer& renderer, const std::string& name, const Scene& scene, double small,
                    double large, int repeats) {
    const auto control = control_samples(scene.field, scene.filter);
    const BlockRanges ranges = find_block_ranges(*control, kernel_of(scene.filter));
    std::int64_t listed = 0;
    for (const BlockPage& page : ranges.pages) listed += std::popcount(page.blocks);
    fmt::print(
        "\nMoving the iso value of {}, {}: {} blocks listed\n{:<14} {:>8} {:>8} {:>8} {:>10} "
        "{:>10} {:>10} {:>10} {:>10}\n",
        name, scene.iso_world, listed, "", "load", "set_iso", "sort", "scan", "move", "list",
        "active", "changed");
    for (const auto& [move, step] : {std::pair{"small", small}, std::pair{"large", large}}) {
        const double there = scene.iso_world + step;
        std::vector<double> load, set_iso, sort, scan, moved, list;
        std::size_t changed = 0;
        std::int64_t active = 0;
        for (int turn = 0; turn < repeats; ++turn) {
            Scene at = scene;
            at.iso_world = there;
            load.push_back(seconds_of([&] { renderer.load(at); }));
            renderer.set_iso(scene.iso_world); // sorts
            set_iso.push_back(seconds_of([&] { renderer.set_iso(there); }));
            const auto iso = static_cast<float>(scene.iso_world);
            std::optional<ActiveSet> set;
            sort.push_back(seconds_of([&] { set.emplace(ranges, iso); }));
            std::vector<ActivePage> pages;
            scan.push_back(
                seconds_of([&] { pages = active_pages(ranges, static_cast<float>(there)); }));
            ActiveChange change;
            moved.push_back(seconds_of([&] { change = set->move_to(static_cast<float>(there)); }));
            list.push_back(seconds_of([&] { pages = set->pages(); }));
            changed = change.came.size() + change.went.size();
            active = block_count(pages);
        }
        fmt::print(
            "{:<14} {:>8.4f} {:>8.4f} {:>8.4f} {:>10.6f} {:>10.6f} {:>10.6f} {:>10} {:>10}\n",
            fmt::format("{} {:.3g}", move, step), timing_of(load).median, timing_of(set_iso).median,
            timing_of(sort).median, timing_of(scan).median, timing_of(moved).median,
            timing_of(list).median, active, changed);
    }
    std::fflush(stdout);
}

} // namespace isocast
