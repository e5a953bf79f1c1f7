// Time spent by the GL on a stretch of commands, by timer queries.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "gl/objects.h"

namespace isocast::gl {

/// Two timestamps in the command stream.
class Timer {
public:
    Timer();
    void start();
    void stop();
    /// Milliseconds between the two; waits until the GL has passed the second.
    double milliseconds() const;

private:
    Handle<delete_query> begin_;
    Handle<delete_query> end_;
};

} // namespace isocast::gl
