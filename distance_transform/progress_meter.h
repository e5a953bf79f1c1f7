// Progress of parallel work, reported now and then from whichever thread comes by.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/progress.h"

#include <algorithm>
#include <atomic>
#include <cstdint>

namespace isocast {

/// Adds up finished work and calls the progress function at every `period`-th piece.
class ProgressMeter {
public:
    ProgressMeter(const Progress& progress, std::string_view stage, double total,
                  std::int64_t period)
        : progress_(progress), stage_(stage), total_(total), period_(period) {
        if (progress_) progress_(stage_, 0);
    }

    /// throws  whatever the progress function throws
    void add(double amount) {
        const double done = done_.fetch_add(amount) + amount;
        if (progress_ && pieces_.fetch_add(1) % period_ == 0)
            progress_(stage_, std::min(1.0, done / total_));
    }

private:
    const Progress& progress_;
    std::string_view stage_;
    double total_;
    std::int64_t period_;
    std::atomic<double> done_ = 0;
    std::atomic<std::int64_t> pieces_ = 0;
};

} // namespace isocast
