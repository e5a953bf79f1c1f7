// SPDX-License-Identifier: MPL-2.0
#include "apps/console.h"

#include "volume/errors.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>

namespace isocast {

namespace {

// The one mutable variable of this kind: a signal handler can reach nothing else.
std::atomic<bool> interrupt_was_asked = false;
static_assert(std::atomic<bool>::is_always_lock_free);

extern "C" void on_interrupt(int) {
    interrupt_was_asked = true;
}

} // namespace

Console::Console() : is_terminal_(::isatty(STDERR_FILENO) == 1) {
    struct sigaction action {};
    action.sa_handler = on_interrupt;
    // Back to the default after the first one, so that a second kills.
    action.sa_flags = SA_RESETHAND | SA_RESTART;
    ::sigaction(SIGINT, &action, nullptr);
    // A file size limit shall be an error of the write that meets it.
    std::signal(SIGXFSZ, SIG_IGN);
}

Console::~Console() {
    end_progress();
}

Progress Console::progress() {
    return [this](std::string_view stage, double fraction) {
        if (interrupt_was_asked) throw Interrupted();
        if (is_terminal_) show(stage, fraction);
    };
}

void Console::note(std::string_view message) {
    end_progress();
    fmt::print(stderr, "isocast: {}\n", message);
}

void Console::warn(std::string_view message) {
    end_progress();
    fmt::print(stderr, "isocast: warning: {}\n", message);
}

void Console::error(std::string_view message) {
    end_progress();
    fmt::print(stderr, "isocast: {}\n", message);
}

void Console::show(std::string_view stage, double fraction) {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    const auto now = std::chrono::steady_clock::now();
    // 10 a second: more cannot be read. A thread that finds another one printing has no news.
    if (!lock || (line_is_shown_ && now - shown_at_ < std::chrono::milliseconds(100))) return;
    // \x1b[K clears to the end of the line.
    fmt::print(stderr, "\r{} {:.0f} %\x1b[K", stage, 100 * fraction);
    std::fflush(stderr);
    line_is_shown_ = true;
    shown_at_ = now;
}

void Console::end_progress() {
    const std::lock_guard lock(mutex_);
    if (line_is_shown_) fmt::print(stderr, "\r\x1b[K");
    line_is_shown_ = false;
}

std::int64_t peak_memory_bytes() {
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return std::int64_t{usage.ru_maxrss} * 1024; // Linux counts in KiB
}

} // namespace isocast
