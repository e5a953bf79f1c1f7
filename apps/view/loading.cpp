// SPDX-License-Identifier: MPL-2.0
#include "apps/view/loading.h"

namespace isocast::view {

Loading::Loading(SceneFile scene, Prepare prepare, SceneObjects& objects,
                 std::function<void()> wake)
    : scene_(std::move(scene)), prepare_(std::move(prepare)), wake_(std::move(wake)),
      thread_([this, &objects] { run(objects); }) {}

Loading::~Loading() {
    cancel();
    thread_.join();
}

void Loading::run(SceneObjects& objects) {
    try {
        const Progress progress = [this](std::string_view stage, double fraction) {
            if (is_cancelled_) throw Interrupted();
            {
                const std::lock_guard lock(mutex_);
                state_ = {std::string(stage), fraction};
            }
            wake_();
        };
        if (prepare_) prepare_(scene_, progress);
        objects.open(scene_);
        progress("converting", 0);
        loaded_ = objects.compose(
            scene_, progress, [this](const std::string& warning) { warnings_.push_back(warning); });
    } catch (...) {
        failure_ = std::current_exception();
    }
    is_done_ = true;
    wake_();
}

Loading::State Loading::state() const {
    const std::lock_guard lock(mutex_);
    return state_;
}

Scene Loading::take() {
    if (failure_) std::rethrow_exception(failure_);
    return std::move(loaded_);
}

} // namespace isocast::view
