// The terminal and the user at it: progress, warnings, Ctrl-C.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/progress.h"
#include "volume/stopwatch.h"

#include <chrono>
#include <mutex>
#include <string_view>

namespace isocast {

/// Messages on stderr. Make one, in main.
class Console {
public:
    /// From here on a first Ctrl-C makes progress() throw, and a second one kills the process.
    Console();
    ~Console();
    Console(const Console&) = delete;
    Console& operator=(const Console&) = delete;

    /// Shows the stage on one line that is rewritten in place, if stderr is a terminal, and throws
    /// Interrupted after Ctrl-C. Refers to this object.
    Progress progress();
    /// Clears that line. Call before printing to stdout, which may be the same terminal.
    void end_progress();

    void note(std::string_view message);
    void warn(std::string_view message);
    void error(std::string_view message);

private:
    void show(std::string_view stage, double fraction);

    bool is_terminal_;
    std::mutex mutex_;
    bool line_is_shown_ = false;
    std::chrono::steady_clock::time_point shown_at_;
};

/// The most memory that this process has held so far.
std::int64_t peak_memory_bytes();

} // namespace isocast
