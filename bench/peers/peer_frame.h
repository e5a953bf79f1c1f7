// What the peers share: clocks, frames from masks.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "median.h"
#include "peers/peers.h"

#include <chrono>
#include <functional>

namespace isocast {

inline double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Median seconds of `repeats` calls of `draw`, after one that does not count.
double median_seconds(int repeats, const std::function<void()>& draw);

/// covered  size * size of the scene
PeerFrame peer_frame(std::string name, std::string note, double setup_seconds, double frame_seconds,
                     std::vector<bool> covered);

} // namespace isocast
