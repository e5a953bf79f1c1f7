// Options whose text our own functions understand.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <CLI/CLI.hpp>

#include <string>

namespace isocast {

/// Adds an option that sets `value` to parse(text); what that throws becomes a usage error.
template<class Value, class Parse>
CLI::Option* add_parsed(CLI::App& app, const std::string& name, Value& value, Parse parse,
                        const std::string& help) {
    return app.add_option_function<std::string>(
        name,
        [&value, parse, name](const std::string& text) {
            try {
                value = parse(text);
            } catch (const std::exception& error) {
                throw CLI::ValidationError(name, error.what());
            }
        },
        help);
}

/// Adds --threads.
inline void add_threads(CLI::App& app, std::size_t& threads) {
    app.add_option("--threads", threads, "Use at most this many threads")
        ->check(CLI::Range(1, 4096))
        ->type_name("N");
}

} // namespace isocast
