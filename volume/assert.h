// Assertions about our own code: on in debug and sanitizer builds, absent elsewhere.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#ifdef ISOCAST_CHECKED
#include <cstdio>
#include <cstdlib>
/// Stops with the expression and a printf-style message that shows its values.
#define ISOCAST_ASSERT(expression, ...)                                                            \
    do {                                                                                           \
        if (!(expression)) {                                                                       \
            std::fprintf(stderr, "%s:%d: assertion failed: %s: ", __FILE__, __LINE__,              \
                         #expression);                                                             \
            std::fprintf(stderr, __VA_ARGS__);                                                     \
            std::fputc('\n', stderr);                                                              \
            std::abort();                                                                          \
        }                                                                                          \
    } while (false)
#else
#define ISOCAST_ASSERT(expression, ...) ((void)0)
#endif
