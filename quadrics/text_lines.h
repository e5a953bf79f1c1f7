// The lines of a text in memory, one after the other, with their number for messages.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/errors.h"

#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <string_view>

namespace isocast {

/// LF and CRLF end a line; what follows the last one is a line too, unless it is empty.
class TextLines {
public:
    TextLines(std::string_view text, std::string_view name) : rest_(text), name_(name) {}

    bool is_at_end() const { return rest_.empty(); }
    std::string_view next() {
        ++line_;
        const std::size_t end = rest_.find('\n');
        std::string_view line = rest_.substr(0, end);
        rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
        if (line.ends_with('\r')) line.remove_suffix(1);
        return line;
    }
    /// What follows the line that next() returned.
    std::string_view rest() const { return rest_; }
    std::int64_t line() const { return line_; }
    [[noreturn]] void fail(const std::string& cause) const {
        throw InputError(fmt::format("{}:{}: {}", name_, line_, cause));
    }

private:
    std::string_view rest_;
    std::string_view name_;
    std::int64_t line_ = 0;
};

} // namespace isocast
