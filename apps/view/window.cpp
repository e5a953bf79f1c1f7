// SPDX-License-Identifier: MPL-2.0
#include "apps/view/window.h"

#include "apps/view/navigation.h"
#include "gl/window.h"
#include "volume/stopwatch.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace isocast::view {

namespace {

float content_scale(GLFWwindow* window) {
    float x = 1;
    float y = 1;
    glfwGetWindowContentScale(window, &x, &y);
    return std::max(x, 1.0F);
}

} // namespace

Window& Window::of(GLFWwindow* window) {
    return *static_cast<Window*>(glfwGetWindowUserPointer(window));
}

Window::Window(gl::Context& context, const std::filesystem::path& shader_folder, Options options)
    : window_(gl::window_of(context)),
      viewer_(context, shader_folder, options.viewer, [] { glfwPostEmptyEvent(); }),
      scale_(content_scale(window_)), panels_(viewer_, scale_, options.config_folder),
      options_(std::move(options)), trace_(options_.trace) {
    glfwSetWindowUserPointer(window_, this);
    // Before ImGui's, which call these in turn.
    glfwSetMouseButtonCallback(window_, [](GLFWwindow* w, int button, int action, int modifiers) {
        of(w).on_button(button, action, modifiers);
    });
    glfwSetCursorPosCallback(window_,
                             [](GLFWwindow* w, double x, double y) { of(w).on_move(x, y); });
    glfwSetScrollCallback(window_, [](GLFWwindow* w, double, double y) { of(w).on_scroll(y); });
    glfwSetKeyCallback(window_, [](GLFWwindow* w, int key, int, int action, int modifiers) {
        of(w).on_key(key, action, modifiers);
    });
    glfwSetDropCallback(
        window_, [](GLFWwindow* w, int count, const char** paths) { of(w).on_drop(count, paths); });
    glfwSetWindowRefreshCallback(window_, [](GLFWwindow* w) { of(w).screens_due_ = 1; });
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr; // panels are where they are
    ImGui::StyleColorsDark();
    ImGui::GetStyle().ScaleAllSizes(scale_);
    ImGui::GetStyle().FrameRounding = 3 * scale_;
    ImFontConfig font;
    font.SizePixels = std::round(13 * scale_);
    ImGui::GetIO().Fonts->AddFontDefault(&font);
    ImGui_ImplGlfw_InitForOpenGL(window_, true);
    ImGui_ImplOpenGL3_Init("#version 450 core");
}

Window::~Window() {
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
}

Window::Drag Window::drag_of(int button, int modifiers) const {
    const bool has_shift = (modifiers & GLFW_MOD_SHIFT) != 0;
    const bool has_control = (modifiers & GLFW_MOD_CONTROL) != 0;
    if (options_.controls == Controls::Blender) {
        if (button != GLFW_MOUSE_BUTTON_MIDDLE) return Drag::None;
        return has_shift ? Drag::Pan : has_control ? Drag::Zoom : Drag::Rotate;
    }
    if (button == GLFW_MOUSE_BUTTON_MIDDLE) return Drag::Pan;
    if (button == GLFW_MOUSE_BUTTON_RIGHT) return Drag::Zoom;
    return has_shift ? Drag::Pan : has_control ? Drag::Roll : Drag::Rotate;
}

void Window::on_button(int button, int action, int modifiers) {
    screens_due_ = 3;
    if (action == GLFW_RELEASE) {
        const bool is_click = drag_ != Drag::None && !has_dragged_;
        drag_ = Drag::None;
        if (!is_click || button != GLFW_MOUSE_BUTTON_LEFT) return;
        const auto probe = viewer_.probe(on_canvas().x(), on_canvas().y());
        if (!probe) return;
        // Within so many seconds: as most systems have it.
        if (glfwGetTime() - pressed_at_ < 0.4) {
            viewer_.set_pivot(probe->p_world);
            trace_.event("pivot", probe->text());
        } else if (panels_.is_probing()) {
            panels_.pin(*probe);
            trace_.event("pin", probe->text());
        }
        pressed_at_ = glfwGetTime();
        return;
    }
    if (ImGui::GetIO().WantCaptureMouse) return;
    has_dragged_ = false;
    drag_ = drag_of(button, modifiers);
    if (drag_ == Drag::None) has_dragged_ = true;
}

void Window::on_move(double x, double y) {
    const Eigen::Vector2d before = on_canvas();
    cursor_ = {x, y};
    const Eigen::Vector2d step = on_canvas() - before;
    screens_due_ = std::max(screens_due_, 2);
    if (drag_ == Drag::None || !viewer_.has_scene()) {
        wants_probe_ = true;
        return;
    }
    if (step.isZero()) return;
    has_dragged_ = true;
    const Camera& camera = viewer_.camera();
    const int width = viewer_.canvas().width();
    const int height = viewer_.canvas().height();
    switch (drag_) {
    case Drag::Rotate: // half a turn over the window's height
        viewer_.set_camera(rotated(camera, viewer_.pivot(), -step.x() / height * std::numbers::pi,
                                   -step.y() / height * std::numbers::pi));
        break;
    case Drag::Pan:
        viewer_.set_camera(panned(camera, viewer_.pivot(), height, step.x(), step.y()));
        break;
    case Drag::Zoom: // twice as near over a fifth of the height
        viewer_.set_camera(zoomed(camera, viewer_.pivot(), width, height, before.x(), before.y(),
                                  std::exp2(5 * step.y() / height)));
        break;
    case Drag::Roll: {
        const Eigen::Vector2d middle(width / 2.0, height / 2.0);
        const Eigen::Vector2d from = before - middle;
        const Eigen::Vector2d to = before + step - middle;
        viewer_.set_camera(
            rolled(camera, -std::atan2(from.x() * to.y() - from.y() * to.x(), from.dot(to))));
        break;
    }
    case Drag::None:
        break;
    }
}

void Window::on_scroll(double steps) {
    screens_due_ = 3;
    if (ImGui::GetIO().WantCaptureMouse || !viewer_.has_scene()) return;
    viewer_.set_camera(zoomed(viewer_.camera(), viewer_.pivot(), viewer_.canvas().width(),
                              viewer_.canvas().height(), on_canvas().x(), on_canvas().y(),
                              std::pow(0.85, steps)));
}

Eigen::Vector2d Window::on_canvas() const {
    return pixels_per_unit_ * cursor_ - Eigen::Vector2d(margins_.x(), 0);
}

std::filesystem::path Window::free_name(const std::string& ending) {
    for (int i = 1;; ++i)
        if (const auto name = fmt::format("isocast-{}{}", i, ending);
            !std::filesystem::exists(name))
            return name;
}

void Window::on_key(int key, int action, int modifiers) {
    screens_due_ = 3;
    if (action == GLFW_RELEASE || ImGui::GetIO().WantTextInput) return;
    const bool has_control = (modifiers & GLFW_MOD_CONTROL) != 0;
    const double side = has_control ? -1 : 1;
    const auto look_from = [&](const Vec3d& direction, const Vec3d& up) {
        if (viewer_.has_scene())
            viewer_.set_camera(seen_from(viewer_.camera(), viewer_.pivot(), side * direction, up));
    };
    switch (key) {
    case GLFW_KEY_R:
        viewer_.reset_camera();
        break;
    case GLFW_KEY_F:
        viewer_.frame();
        break;
    case GLFW_KEY_1:
        look_from(Vec3d::UnitZ(), Vec3d::UnitY());
        break;
    case GLFW_KEY_3:
        look_from(Vec3d::UnitX(), Vec3d::UnitY());
        break;
    case GLFW_KEY_7:
        look_from(Vec3d::UnitY(), -Vec3d::UnitZ());
        break;
    case GLFW_KEY_O:
        if (viewer_.has_scene())
            viewer_.set_camera(with_other_projection(viewer_.camera(), viewer_.pivot()));
        break;
    case GLFW_KEY_S:
        if (has_control)
            viewer_.save_scene(free_name(".toml"));
        else
            viewer_.save_picture(free_name(".png"));
        break;
    case GLFW_KEY_H:
        panels_.toggle();
        break;
    case GLFW_KEY_SLASH:
        if ((modifiers & GLFW_MOD_SHIFT) != 0) panels_.toggle_help();
        break;
    default:
        break;
    }
}

void Window::on_drop(int count, const char** paths) {
    for (int i = 0; i < count; ++i) {
        viewer_.add_file(paths[i]);
        panels_.remember(paths[i]);
        trace_.event("drop", paths[i]);
    }
    screens_due_ = 3;
}

void Window::draw_screen() {
    const Stopwatch watch;
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    panels_.draw(pixels_per_unit_);
    ImGui::Render();
    viewer_.canvas().present(margins_.x(), margins_.y());
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    glfwSwapBuffers(window_);
    drawn_at_ = glfwGetTime();
    trace_.screen(1000 * watch.seconds());
    trace_.places(panels_.places());
}

void Window::take_events() {
    int width = 0;
    int height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    int units = 0;
    glfwGetWindowSize(window_, &units, nullptr);
    if (units == 0 || width == 0 || height == 0) return; // minimised
    pixels_per_unit_ = double(width) / units;
    margins_ = (pixels_per_unit_ * panels_.margins().cast<double>()).array().round().cast<int>();
    viewer_.resize(std::max(width - margins_.x(), 1), std::max(height - margins_.y(), 1));
}

void Window::run(const std::function<bool()>& is_ended) {
    glfwSwapInterval(1);
    std::size_t message_count = 0;
    int load_count = 0;
    // While a scene goes to the GPU.
    const auto pump = [&](std::string_view, double) {
        if (glfwWindowShouldClose(window_) || is_ended()) throw Interrupted();
    };
    while (!glfwWindowShouldClose(window_) && !is_ended()) {
        const bool is_busy = viewer_.is_busy() || screens_due_ > 0;
        if (is_busy)
            glfwPollEvents();
        else
            glfwWaitEventsTimeout(0.5); // Ctrl-C in the terminal is seen then
        take_events();
        if (viewer_.loading() != nullptr) screens_due_ = 1;
        if (const auto step = viewer_.step(pump)) {
            trace_.step(*step);
            // Parts are shown as they come, but not each by itself.
            if (step->is_coarse || step->ends_round || glfwGetTime() - drawn_at_ > 0.1)
                screens_due_ = std::max(screens_due_, 1);
        }
        if (viewer_.load_count() != load_count) {
            load_count = viewer_.load_count();
            trace_.event("scene", fmt::format("{} objects", viewer_.scene().objects.size()));
        }
        if (viewer_.messages().size() != message_count) {
            message_count = viewer_.messages().size();
            if (message_count > 0) trace_.event("message", viewer_.messages().back());
            screens_due_ = 3;
        }
        // What is under the cursor is asked for when there is nothing better to do.
        if (wants_probe_ && !viewer_.is_busy() && panels_.is_probing()) {
            wants_probe_ = false;
            panels_.set_probe(ImGui::GetIO().WantCaptureMouse
                                  ? std::nullopt
                                  : viewer_.probe(on_canvas().x(), on_canvas().y()));
            screens_due_ = std::max(screens_due_, 1);
        }
        if (screens_due_ > 0 && viewer_.canvas().width() > 0) {
            --screens_due_;
            draw_screen();
        }
    }
}

} // namespace isocast::view
