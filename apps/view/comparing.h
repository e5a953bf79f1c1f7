// The reference's picture, drawn on a thread of its own.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/reference_renderer.h"

#include <atomic>
#include <exception>
#include <thread>

namespace isocast::view {

/// One picture on its way; it may take minutes.
class Comparing {
public:
    /// wake  called from the thread when there is news
    Comparing(Scene scene, const Camera& camera, int width, int height, std::function<void()> wake);
    /// Cancels, and waits for the thread.
    ~Comparing();
    Comparing(const Comparing&) = delete;

    double fraction() const { return fraction_; }
    bool is_done() const { return is_done_; }
    int width() const { return width_; }
    int height() const { return height_; }
    const Camera& camera() const { return camera_; }
    /// Once done. throws  what drawing threw
    const Image& picture() const;

private:
    void run(Scene scene);

    const Camera camera_;
    const int width_;
    const int height_;
    const std::function<void()> wake_;
    std::atomic<double> fraction_ = 0;
    std::atomic<bool> is_cancelled_ = false;
    std::atomic<bool> is_done_ = false;
    Image picture_;
    std::exception_ptr failure_;
    std::thread thread_; // the last: it uses the others
};

/// How far a picture is from another of its size, where either shows a surface.
struct Difference {
    Image picture;
    double gain = 1; // of the picture: a power of two that shows the greatest
    double greatest = 0;
    double rms = 0;
};
Difference difference_of(const Image& a, const Image& b);

} // namespace isocast::view
