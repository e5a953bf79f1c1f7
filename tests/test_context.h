// The GL that tests draw with.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "gl/context.h"

#include <cstdlib>

namespace isocast::test {

/// OSMesa, the same on every machine, or what ISOCAST_TEST_BACKEND names: `egl` tries a driver.
inline std::unique_ptr<gl::Context> make_context() {
    const char* name = std::getenv("ISOCAST_TEST_BACKEND");
    return gl::make_context({.backend = gl::backend_from_name(name ? name : "osmesa")});
}

} // namespace isocast::test
