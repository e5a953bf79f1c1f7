// What the programs of this folder share.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <string_view>

namespace isocast {

/// A program's main(): runs `make` if it has as many arguments as `usage` has words.
///
/// usage  "NAME ARGUMENT ..."
template<class Make>
int run_program(int argc, std::string_view usage, Make make) {
    if (argc != 1 + std::ranges::count(usage, ' ')) {
        fmt::print(stderr, "usage: {}\n", usage);
        return 2;
    }
    try {
        make();
        return 0;
    } catch (const std::exception& error) {
        fmt::print(stderr, "{}: {}\n", usage.substr(0, usage.find(' ')), error.what());
        return 1;
    }
}

} // namespace isocast
