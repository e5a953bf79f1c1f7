// Reading and converting on a thread of its own, while the window goes on answering.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/scene_objects.h"
#include "volume/errors.h"

#include <atomic>
#include <exception>
#include <mutex>
#include <thread>

namespace isocast::view {

/// One scene on its way.
class Loading {
public:
    /// Changes a scene before it is read.
    using Prepare = std::function<void(SceneFile&, const Progress&)>;

    /// prepare  if there is something to be found out first
    /// objects  what was read before; nobody else may use it until is_done()
    /// wake     called from the thread whenever there is news
    Loading(SceneFile scene, Prepare prepare, SceneObjects& objects, std::function<void()> wake);
    /// Cancels, and waits for the thread.
    ~Loading();
    Loading(const Loading&) = delete;

    struct State {
        std::string stage = "reading";
        double fraction = 0;
    };
    State state() const;
    void cancel() { is_cancelled_ = true; }
    bool is_cancelled() const { return is_cancelled_; }
    bool is_done() const { return is_done_; }

    /// Prepared, once done.
    const SceneFile& scene() const { return scene_; }
    /// Once done. throws  what reading threw
    Scene take();
    const std::vector<std::string>& warnings() const { return warnings_; }

private:
    void run(SceneObjects& objects);

    SceneFile scene_;
    const Prepare prepare_;
    const std::function<void()> wake_;
    std::atomic<bool> is_cancelled_ = false;
    std::atomic<bool> is_done_ = false;
    mutable std::mutex mutex_;
    State state_;
    std::vector<std::string> warnings_;
    Scene loaded_;
    std::exception_ptr failure_;
    std::thread thread_; // the last: it uses the others
};

} // namespace isocast::view
