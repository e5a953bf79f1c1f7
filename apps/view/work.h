// Long work on a thread of its own, while the window goes on answering.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/progress.h"

#include <atomic>
#include <exception>
#include <mutex>
#include <string>
#include <thread>

namespace isocast::view {

class Work {
public:
    /// work  what is done; its progress throws Interrupted once it is cancelled
    /// wake  called from the thread whenever there is news
    Work(std::function<void(const Progress&)> work, std::function<void()> wake);
    /// Cancels, and waits for the thread.
    ~Work();
    Work(const Work&) = delete;
    Work& operator=(const Work&) = delete;

    struct State {
        std::string stage;
        double fraction = 0;
    };
    State state() const;
    void cancel() { is_cancelled_ = true; }
    bool is_cancelled() const { return is_cancelled_; }
    bool is_done() const { return is_done_; }
    /// Once done. throws  what the work threw
    void finish() const;

private:
    std::atomic<bool> is_cancelled_ = false;
    std::atomic<bool> is_done_ = false;
    mutable std::mutex mutex_;
    State state_;
    std::exception_ptr failure_;
    std::thread thread_; // the last: it uses the others
};

} // namespace isocast::view
