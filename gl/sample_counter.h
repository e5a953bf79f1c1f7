// How many fragments the GL writes, by an occlusion query.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "gl/objects.h"

#include <cstdint>

namespace isocast::gl {

/// Of the commands between start and stop: fragments that no test and no shader discards.
class SampleCounter {
public:
    SampleCounter();
    void start();
    void stop();
    /// Waits until the GL has drawn them.
    std::int64_t count() const;

private:
    Handle<delete_query> query_;
};

} // namespace isocast::gl
