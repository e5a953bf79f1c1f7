// SPDX-License-Identifier: MPL-2.0
#include "program.h"

#include "../volume/temporary_folder.h"

#include <gtest/gtest.h>

#include <fcntl.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <fstream>
#include <sstream>

namespace isocast::test {

namespace {

/// In the child: becomes the program. Returns only if it cannot.
void execute(const std::filesystem::path& program, const std::vector<std::string>& arguments,
             const Environment& environment) {
    std::vector<char*> argv{const_cast<char*>(program.c_str())};
    for (const std::string& argument : arguments)
        argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    for (const auto& [name, value] : environment) ::setenv(name.c_str(), value.c_str(), 1);
    ::execvp(argv[0], argv.data());
}

int code_of(int status) {
    return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}

int wait_for(pid_t child) {
    int status = 0;
    while (::waitpid(child, &status, 0) < 0)
        if (errno != EINTR) throw std::runtime_error("waitpid failed");
    return code_of(status);
}

const Environment no_leak_check{{"ASAN_OPTIONS", "detect_leaks=0"}};

} // namespace

Outcome run(const std::filesystem::path& program, const std::vector<std::string>& arguments,
            const Environment& environment) {
    const TemporaryFolder folder;
    const auto out = folder / "out", err = folder / "err";
    const pid_t child = ::fork();
    if (child < 0) throw std::runtime_error("fork failed");
    if (child == 0) {
        const int flags = O_WRONLY | O_CREAT | O_TRUNC;
        ::dup2(::open(out.c_str(), flags, 0600), STDOUT_FILENO);
        ::dup2(::open(err.c_str(), flags, 0600), STDERR_FILENO);
        execute(program, arguments, environment);
        ::_exit(127);
    }
    const int code = wait_for(child);
    return {code, contents_of(out), contents_of(err)};
}

Outcome isocast(const std::vector<std::string>& arguments, const Environment& environment) {
    Environment all = no_leak_check;
    all.insert(all.end(), environment.begin(), environment.end());
    return run(ISOCAST_PROGRAM, arguments, all);
}

Outcome isocast_on_terminal(const std::vector<std::string>& arguments, const std::string& moment) {
    int terminal = -1;
    const pid_t child = ::forkpty(&terminal, nullptr, nullptr, nullptr);
    if (child < 0) throw std::runtime_error("forkpty failed");
    if (child == 0) {
        execute(ISOCAST_PROGRAM, arguments, no_leak_check);
        ::_exit(127);
    }
    Outcome outcome;
    bool sent = moment.empty();
    char buffer[4096];
    for (;;) {
        const ssize_t count = ::read(terminal, buffer, sizeof buffer);
        // Linux ends the terminal's output with EIO when the child closes its side.
        if (count <= 0) break;
        outcome.err.append(buffer, static_cast<std::size_t>(count));
        if (!sent && outcome.err.find(moment) != std::string::npos) {
            ::kill(child, SIGINT);
            sent = true;
        }
    }
    ::close(terminal);
    outcome.code = wait_for(child);
    return outcome;
}

std::vector<std::string> joined(std::vector<std::string> arguments,
                                const std::vector<std::string>& more) {
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
}

std::string checked_output(const Outcome& outcome) {
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return outcome.out;
}

std::string contents_of(const std::filesystem::path& path) {
    std::ostringstream text;
    text << std::ifstream(path, std::ios::binary).rdbuf();
    return text.str();
}

void write_text(const std::filesystem::path& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
}

} // namespace isocast::test
