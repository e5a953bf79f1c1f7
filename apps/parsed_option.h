// Options whose text our own functions understand.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/inputs.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

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

/// Adds an option whose text is one of some names; another is a usage error that lists these.
template<class Value, class Target>
CLI::Option* add_choice(CLI::App& app, const std::string& name, Target& value,
                        std::vector<std::pair<std::string_view, Value>> known,
                        const std::string& help) {
    return add_parsed(
        app, name, value,
        [known = std::move(known)](std::string_view text) {
            std::string names;
            for (const auto& [word, meant] : known) {
                if (word == text) return meant;
                names += fmt::format("{}{}", names.empty() ? "" : ", ", word);
            }
            throw UsageError(fmt::format("'{}' is none of {}", text, names));
        },
        help);
}

} // namespace isocast
