// SPDX-License-Identifier: MPL-2.0
#include "apps/view/work.h"

#include "volume/errors.h"

#include <utility>

namespace isocast::view {

Work::Work(std::function<void(const Progress&)> work, std::function<void()> wake)
    : thread_([this, work = std::move(work), wake = std::move(wake)] {
          try {
              work([&](std::string_view stage, double fraction) {
                  if (is_cancelled_) throw Interrupted();
                  {
                      const std::lock_guard lock(mutex_);
                      state_ = {std::string(stage), fraction};
                  }
                  wake();
              });
          } catch (...) {
              failure_ = std::current_exception();
          }
          is_done_ = true;
          wake();
      }) {}

Work::~Work() {
    cancel();
    thread_.join();
}

Work::State Work::state() const {
    const std::lock_guard lock(mutex_);
    return state_;
}

void Work::finish() const {
    if (failure_) std::rethrow_exception(failure_);
}

} // namespace isocast::view
