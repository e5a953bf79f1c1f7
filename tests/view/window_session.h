// `isocast view` on a screen of its own, and a user at it.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "../apps/program.h"
#include "../volume/temporary_folder.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <functional>

namespace isocast::test {

using Json = nlohmann::json;

class WindowSession {
public:
    /// Starts an X server of 1280x800 without a window manager, and the program on it in an empty
    /// folder.
    WindowSession(std::vector<std::string> arguments);
    ~WindowSession();
    WindowSession(const WindowSession&) = delete;

    const TemporaryFolder& folder() const { return folder_; }
    std::string window() const { return window_; }
    bool is_running();
    /// Waits for its end. returns  its exit code
    int wait_for_end();
    void interrupt();
    long resident_kib() const;

    /// "mousemove 1 2 click 1"; throws std::runtime_error if it fails.
    void xdotool(const std::string& commands);
    /// Straight from the one point to the other, in steps that a hand makes.
    void drag(int button, int x0, int y0, int x1, int y1, int steps = 20);
    void drop(const std::filesystem::path& file);
    void close();
    /// A point of a control that the trace names.
    void click(const std::string& control, double across = 0.5);

    /// What the trace says, as of now.
    std::vector<Json> trace() const;
    /// Lines from `since` on.
    std::vector<Json> trace_since(std::size_t since) const;
    std::size_t mark() const { return trace().size(); }
    /// Until a line after `since` is like that; fails the test after a minute.
    void wait_until(const std::string& what, std::size_t since,
                    const std::function<bool(const Json&)>& is_like);
    /// Until all is drawn, and no line is added for a third of a second.
    void wait_for_rest();
    /// The texts of events by that name.
    std::vector<std::string> events(const std::string& name) const;
    /// The least box around a control, of the last layout.
    std::array<double, 4> place(const std::string& control) const;

private:
    TemporaryFolder folder_;
    std::string display_;
    std::string window_;
    int server_ = -1;
    int program_ = -1;
};

} // namespace isocast::test
