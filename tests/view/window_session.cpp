// SPDX-License-Identifier: MPL-2.0
#include "window_session.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <thread>

namespace isocast::test {

namespace {

void pause_ms(int milliseconds) {
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
}

int code_of(int status) {
    return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}

/// A server on the first display that is free. returns  its process
int start_server(std::string& display) {
    int ends[2];
    if (::pipe(ends) != 0) throw std::runtime_error("no pipe");
    const int child = ::fork();
    if (child == 0) {
        ::dup2(ends[1], 3);
        ::dup2(::open("/dev/null", O_WRONLY), STDERR_FILENO);
        ::execlp("Xvfb", "Xvfb", "-displayfd", "3", "-screen", "0", "1280x800x24", nullptr);
        ::_exit(127);
    }
    ::close(ends[1]);
    display = ":";
    for (char c = 0; ::read(ends[0], &c, 1) == 1 && c != '\n';) display += c;
    ::close(ends[0]);
    if (display == ":") throw std::runtime_error("Xvfb does not start");
    return child;
}

} // namespace

WindowSession::WindowSession(std::vector<std::string> arguments) {
    server_ = start_server(display_);
    arguments.insert(arguments.begin(), "view");
    arguments.insert(arguments.end(), {"--trace", folder_ / "trace.json"});
    program_ = ::fork();
    if (program_ == 0) {
        ::setenv("DISPLAY", display_.c_str(), 1);
        ::setenv("XDG_CONFIG_HOME", (folder_ / "config").c_str(), 1);
        ::setenv("ASAN_OPTIONS", "detect_leaks=0", 1);
        if (::chdir(folder_.path().c_str()) != 0) ::_exit(126);
        ::dup2(::open("stderr", O_WRONLY | O_CREAT, 0600), STDERR_FILENO);
        std::vector<char*> argv{const_cast<char*>(ISOCAST_PROGRAM)};
        for (std::string& argument : arguments) argv.push_back(argument.data());
        argv.push_back(nullptr);
        ::execv(argv[0], argv.data());
        ::_exit(127);
    }
    wait_until("a picture of the window", 0,
               [](const Json& line) { return line.contains("screen"); });
    const Outcome found =
        run("xdotool", {"search", "--onlyvisible", "--name", "isocast"}, {{"DISPLAY", display_}});
    window_ = found.out.substr(0, found.out.find('\n'));
    xdotool("windowfocus " + window_); // there is no window manager
}

WindowSession::~WindowSession() {
    if (program_ > 0) {
        ::kill(program_, SIGKILL);
        ::waitpid(program_, nullptr, 0);
    }
    ::kill(server_, SIGTERM);
    ::waitpid(server_, nullptr, 0);
}

bool WindowSession::is_running() {
    return program_ > 0 && ::waitpid(program_, nullptr, WNOHANG) == 0;
}

int WindowSession::wait_for_end() {
    int status = 0;
    ::waitpid(program_, &status, 0);
    program_ = -1;
    return code_of(status);
}

void WindowSession::interrupt() {
    ::kill(program_, SIGINT);
}

long WindowSession::resident_kib() const {
    std::ifstream status("/proc/" + std::to_string(program_) + "/status");
    for (std::string line; std::getline(status, line);)
        if (line.starts_with("VmRSS:")) return std::stol(line.substr(6));
    return 0;
}

void WindowSession::xdotool(const std::string& commands) {
    std::istringstream stream(commands);
    std::vector<std::string> words;
    for (std::string word; stream >> word;) words.push_back(word);
    const Outcome outcome = run("xdotool", words, {{"DISPLAY", display_}});
    if (outcome.code != 0) throw std::runtime_error("xdotool " + commands + ": " + outcome.err);
}

void WindowSession::drag(int button, int x0, int y0, int x1, int y1, int steps) {
    std::ostringstream commands;
    commands << "mousemove " << x0 << ' ' << y0 << " sleep 0.1 mousedown " << button;
    for (int i = 1; i <= steps; ++i)
        commands << " mousemove " << x0 + (x1 - x0) * i / steps << ' ' << y0 + (y1 - y0) * i / steps
                 << " sleep 0.02";
    commands << " mouseup " << button;
    xdotool(commands.str());
}

void WindowSession::drop(const std::filesystem::path& file) {
    const Outcome outcome =
        run(ISOCAST_X_CLIENT, {"drop", window_, file.string()}, {{"DISPLAY", display_}});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
}

void WindowSession::close() {
    run(ISOCAST_X_CLIENT, {"close", window_}, {{"DISPLAY", display_}});
}

std::array<double, 4> WindowSession::place(const std::string& control) const {
    std::array<double, 4> box{};
    for (const Json& line : trace())
        if (line.contains("places") && line["places"].contains(control))
            box = line["places"][control].get<std::array<double, 4>>();
    EXPECT_GT(box[2], 0) << control << " was never shown";
    return box;
}

void WindowSession::click(const std::string& control, double across) {
    const auto [left, top, right, bottom] = place(control);
    xdotool("mousemove " + std::to_string(int(left + across * (right - left))) + ' ' +
            std::to_string(int((top + bottom) / 2)) + " sleep 0.2 click 1 sleep 0.2");
}

std::vector<Json> WindowSession::trace() const {
    std::vector<Json> lines;
    std::ifstream file(folder_ / "trace.json");
    for (std::string line; std::getline(file, line) && !file.eof();)
        lines.push_back(Json::parse(line));
    return lines;
}

std::vector<Json> WindowSession::trace_since(std::size_t since) const {
    std::vector<Json> lines = trace();
    lines.erase(lines.begin(), lines.begin() + static_cast<std::ptrdiff_t>(since));
    return lines;
}

void WindowSession::wait_until(const std::string& what, std::size_t since,
                               const std::function<bool(const Json&)>& is_like) {
    for (int i = 0; i < 600; ++i) {
        if (std::ranges::any_of(trace_since(since), is_like)) return;
        if (!is_running()) break;
        pause_ms(100);
    }
    throw std::runtime_error("there was never " + what + "\n" + contents_of(folder_ / "stderr"));
}

void WindowSession::wait_for_rest() {
    std::size_t before = 0;
    for (int i = 0; i < 600; ++i) {
        const std::size_t now = mark();
        if (now == before) return;
        before = now;
        pause_ms(400);
    }
    FAIL() << "it never rests";
}

std::vector<std::string> WindowSession::events(const std::string& name) const {
    std::vector<std::string> texts;
    for (const Json& line : trace())
        if (line.contains(name)) texts.push_back(line[name]);
    return texts;
}

} // namespace isocast::test
