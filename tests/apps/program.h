// Runs the built program as a user does.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace isocast::test {

struct Outcome {
    int code = 0; // exit code, or 128 + signal
    std::string out;
    std::string err;
};

using Environment = std::vector<std::pair<std::string, std::string>>;

/// Runs `program` and waits for it.
/// environment  variables set on top of ours
Outcome run(const std::filesystem::path& program, const std::vector<std::string>& arguments,
            const Environment& environment = {});

/// Runs isocast. LeakSanitizer is off: Mesa and LLVM keep what they allocate.
Outcome isocast(const std::vector<std::string>& arguments, const Environment& environment = {});

/// Runs isocast on a terminal, and sends it Ctrl-C once that shows `moment`; never if empty.
/// err  what the terminal showed, stdout and stderr
Outcome isocast_on_terminal(const std::vector<std::string>& arguments,
                            const std::string& moment = {});

/// Arguments, and more of them.
std::vector<std::string> joined(std::vector<std::string> arguments,
                                const std::vector<std::string>& more);

/// The output as JSON's text was; fails the test if the program failed.
std::string checked_output(const Outcome& outcome);

/// What a file holds.
std::string contents_of(const std::filesystem::path& path);
void write_text(const std::filesystem::path& path, const std::string& text);

} // namespace isocast::test
