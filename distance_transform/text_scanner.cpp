// Tokens, lines and numbers of a text in memory.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/text_scanner.h"

#include "volume/errors.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace isocast {

namespace {

bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}

bool is_newline(char c) {
    return c == '\n' || c == '\r';
}

} // namespace

std::string quoted(std::string_view token) {
    constexpr std::size_t longest = 40; // enough to recognise it, short enough for one line
    std::string text = "'";
    for (const char c : token.substr(0, longest)) text += c >= ' ' && c <= '~' ? c : '?';
    return text + (token.size() > longest ? "…'" : "'");
}

std::size_t TextScanner::newline_length(std::size_t at) const {
    if (at >= text_.size() || !is_newline(text_[at])) return 0;
    return text_[at] == '\r' && at + 1 < text_.size() && text_[at + 1] == '\n' ? 2 : 1;
}

void TextScanner::skip_blanks() {
    while (position_ < text_.size()) {
        const char c = text_[position_];
        if (is_blank(c)) {
            ++position_;
        } else if (c == '\\' && syntax_.backslash_continuation && newline_length(position_ + 1)) {
            position_ += 1 + newline_length(position_ + 1);
            ++line_;
        } else if (c == '#' && syntax_.hash_comments) {
            while (position_ < text_.size() && !is_newline(text_[position_])) ++position_;
        } else {
            return;
        }
    }
}

std::string_view TextScanner::token_on_line() {
    skip_blanks();
    const std::size_t first = position_;
    while (position_ < text_.size()) {
        const char c = text_[position_];
        if (is_blank(c) || is_newline(c)) break;
        if (c == '\\' && syntax_.backslash_continuation && newline_length(position_ + 1)) break;
        ++position_;
    }
    return text_.substr(first, position_ - first);
}

std::string_view TextScanner::token() {
    for (;;) {
        const std::string_view found = token_on_line();
        if (!found.empty() || is_at_end()) return found;
        next_line();
    }
}

void TextScanner::next_line() {
    while (position_ < text_.size() && !is_newline(text_[position_])) ++position_;
    if (position_ < text_.size()) ++line_;
    position_ += newline_length(position_);
}

double TextScanner::number_on_line(std::string_view what) {
    const std::string_view found = token_on_line();
    if (found.empty()) fail(fmt::format("{} is missing", what));
    const double value = number(found, what);
    if (!std::isfinite(value)) fail(fmt::format("{} is not finite: {}", what, quoted(found)));
    return value;
}

std::int64_t TextScanner::integer_on_line(std::string_view what) {
    const std::string_view found = token_on_line();
    if (found.empty()) fail(fmt::format("{} is missing", what));
    return integer(found, what);
}

double TextScanner::number(std::string_view token, std::string_view what) const {
    // from_chars knows no leading plus sign.
    const bool plus = token.size() > 1 && token[0] == '+' && token[1] != '-';
    const char* const first = token.data() + (plus ? 1 : 0);
    const char* const last = token.data() + token.size();
    double value = 0;
    const auto [end, error] = std::from_chars(first, last, value);
    if (error == std::errc::result_out_of_range)
        fail(fmt::format("{} does not fit a double: {}", what, quoted(token)));
    if (error != std::errc{} || end != last)
        fail(fmt::format("{} is not a number: {}", what, quoted(token)));
    return value;
}

std::int64_t TextScanner::integer(std::string_view token, std::string_view what) const {
    const char* const last = token.data() + token.size();
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(token.data(), last, value);
    if (error != std::errc{} || end != last)
        fail(fmt::format("{} is not an integer: {}", what, quoted(token)));
    return value;
}

void TextScanner::fail(std::string_view cause) const {
    throw InputError(fmt::format("{}: line {}: {}", name_, line_, cause));
}

} // namespace isocast
