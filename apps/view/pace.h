// How much of a picture can be drawn in time while something moves: from what passes took.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/renderer.h"

#include <map>
#include <string>

namespace isocast::view {

/// What is left out for speed.
struct Reduction {
    int divisor = 1;         // of the picture's sides
    bool has_effects = true; // those that cost less than hits and shading
    bool operator==(const Reduction&) const = default;
};

inline constexpr int greatest_divisor = 8;

/// Remembers what passes took.
class Pace {
public:
    /// pixels             that were drawn
    /// wall_milliseconds  from the call of draw() to its return
    void saw(const FrameReport& report, double pixels, double wall_milliseconds);

    /// The least reduction with which a picture of so many pixels should take at most so long; the
    /// greatest there is if none is enough. Nothing is reduced of what was never seen.
    Reduction reduction_for(const Look& look, double pixels, double target_milliseconds) const;

    /// Of a whole picture with, or without, the look's expensive effects.
    double expected_milliseconds(const Look& look, double pixels, bool has_effects) const;

private:
    std::map<std::string, double> per_pixel_; // by pass [ms]
    double overhead_ = 0;                     // of a picture, whatever its size [ms]
};

/// Effects that cost rays of their own, or long filters: what Reduction::has_effects leaves out.
Look without_expensive_effects(Look look);

} // namespace isocast::view
