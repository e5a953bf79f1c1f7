// How long work takes.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <chrono>

namespace isocast {

/// Wall time since it was made, or since the last lap [s].
class Stopwatch {
public:
    double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
    double lap() {
        const double elapsed = seconds();
        start_ = Clock::now();
        return elapsed;
    }

private:
    using Clock = std::chrono::steady_clock;
    Clock::time_point start_ = Clock::now();
};

} // namespace isocast
