// Tokens, lines and numbers of a text in memory, with the line number for messages.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace isocast {

/// `token` in quotes, shortened and with unprintable bytes shown as '?', for messages.
std::string quoted(std::string_view token);

/// Reads a text from front to back. LF, CRLF and a lone CR all end a line.
class TextScanner {
public:
    struct Syntax {
        bool hash_comments = false;          // '#' at the start of a token ends the line
        bool backslash_continuation = false; // a backslash at the end of a line joins the next
    };

    TextScanner(std::string_view text, std::string_view name, Syntax syntax)
        : text_(text), name_(name), syntax_(syntax) {}

    /// The next token of this line; empty at its end.
    std::string_view token_on_line();
    /// The next token of the text; empty at its end.
    std::string_view token();
    void next_line();

    /// The next token of this line as a finite number.
    /// what    names the number in the error
    /// throws  InputError if it is missing, no number or not finite
    double number_on_line(std::string_view what);
    /// The next token of this line as an integer.
    std::int64_t integer_on_line(std::string_view what);
    /// `token` as a number, which may be infinite or NaN.
    /// throws  InputError if it is no number or too large for a double
    double number(std::string_view token, std::string_view what) const;
    std::int64_t integer(std::string_view token, std::string_view what) const;

    bool is_at_end() const { return position_ >= text_.size(); }
    std::size_t position() const { return position_; }
    std::int64_t line() const { return line_; }
    /// throws  InputError that names the text and the line
    [[noreturn]] void fail(std::string_view cause) const;

private:
    std::size_t newline_length(std::size_t at) const;
    void skip_blanks();

    std::string_view text_;
    std::string_view name_;
    Syntax syntax_;
    std::size_t position_ = 0;
    std::int64_t line_ = 1;
};

} // namespace isocast
