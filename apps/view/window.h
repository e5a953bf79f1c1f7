// The window: events to moves, and pictures and panels to the screen.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/view/panels.h"
#include "apps/view/trace.h"

struct GLFWwindow;

namespace isocast::view {

enum class Controls {
    Paraview, // left rotates, middle pans, right zooms
    Blender,  // middle rotates, with Shift pans, with Ctrl zooms
};

class Window {
public:
    struct Options {
        Controls controls = Controls::Paraview;
        Viewer::Options viewer;
        std::filesystem::path config_folder;
        std::filesystem::path trace; // none if empty
    };
    /// context  of Backend::Window
    Window(gl::Context& context, const std::filesystem::path& shader_folder, Options options);
    ~Window();
    Window(const Window&) = delete;

    Viewer& viewer() { return viewer_; }
    /// Until the user closes it, or `is_ended` says so.
    void run(const std::function<bool()>& is_ended);

private:
    enum class Drag { None, Rotate, Pan, Zoom, Roll };

    static Window& of(GLFWwindow* window);
    void on_button(int button, int action, int modifiers);
    void on_move(double x, double y);
    void on_scroll(double steps);
    void on_key(int key, int action, int modifiers);
    void on_drop(int count, const char** paths);
    Drag drag_of(int button, int modifiers) const;
    void take_events();
    void draw_screen();
    /// The cursor on the canvas [pixels].
    Eigen::Vector2d on_canvas() const;
    /// The first of prefix-1.ending, prefix-2.ending … that there is not.
    static std::filesystem::path free_name(const std::string& ending);

    GLFWwindow* window_;
    Viewer viewer_;
    float scale_;
    Panels panels_;
    Options options_;
    Trace trace_;
    double pixels_per_unit_ = 1;    // of the framebuffer, by units of the cursor
    Eigen::Vector2i margins_{0, 0}; // beside the canvas, on the left and at the bottom [pixels]
    Drag drag_ = Drag::None;
    Eigen::Vector2d cursor_{0, 0}; // units
    bool has_dragged_ = false;
    double pressed_at_ = -1; // seconds
    bool wants_probe_ = false;
    int screens_due_ = 3; // ImGui settles over some frames
    double drawn_at_ = 0; // the last screen [s]
};

} // namespace isocast::view
