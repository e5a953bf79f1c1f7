// Options whose text our own functions understand.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/inputs.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <optional>
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

/// Adds --max-memory of verbs that read fields.
inline void add_field_memory(CLI::App& app, std::optional<double>& bytes) {
    add_parsed(
        app, "--max-memory", bytes, bytes_from,
        "Memory for a field's samples, e.g. 8G or 500M (default: half of what is "
        "available); beyond it a file's lie in a scratch file in TMPDIR, or in /var/tmp, and "
        "a mesh's are refused")
        ->type_name("SIZE");
}

/// Adds --threads.
inline void add_threads(CLI::App& app, std::size_t& threads) {
    app.add_option("--threads", threads, "Use at most this many threads")
        ->check(CLI::Range(1, 4096))
        ->type_name("N");
}

/// throws  UsageError that lists the known names
template<class Value>
Value choice_from(std::string_view text,
                  std::initializer_list<std::pair<std::string_view, Value>> known) {
    std::string names;
    for (const auto& [name, value] : known) {
        if (name == text) return value;
        names += fmt::format("{}{}", names.empty() ? "" : ", ", name);
    }
    throw UsageError(fmt::format("'{}' is none of {}", text, names));
}

} // namespace isocast
