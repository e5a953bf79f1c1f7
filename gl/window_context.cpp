// A window with a context, through GLFW.
// SPDX-License-Identifier: MPL-2.0
#include "gl/backends.h"
#include "gl/window.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>

namespace isocast::gl {

namespace {

std::string last_error() {
    const char* description = nullptr;
    glfwGetError(&description);
    return description ? description : "unknown error";
}

class WindowContext final : public Context {
public:
    /// throws  GlError with the cause
    explicit WindowContext(const ContextOptions& options) : Context("window") {
        if (!glfwInit()) throw GlError(last_error());
        glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
        glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
        glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
        glfwWindowHint(GLFW_OPENGL_DEBUG_CONTEXT, reports_errors);
        glfwWindowHint(GLFW_VISIBLE, options.window_visible);
        glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
        window_ = glfwCreateWindow(options.window_width, options.window_height,
                                   options.window_title.c_str(), nullptr, nullptr);
        try {
            if (!window_) throw GlError(last_error());
            finish();
        } catch (...) {
            glfwTerminate();
            throw;
        }
    }
    ~WindowContext() override { glfwTerminate(); }

    GLFWwindow* window() const { return window_; }

private:
    void bind() override { glfwMakeContextCurrent(window_); }
    GetProc get_proc() const override { return glfwGetProcAddress; }

    GLFWwindow* window_ = nullptr;
};

} // namespace

GLFWwindow* window_of(Context& context) {
    return dynamic_cast<WindowContext&>(context).window();
}

std::unique_ptr<Context> make_window_context(const ContextOptions& options,
                                             std::vector<std::string>& failures) {
    try {
        return std::make_unique<WindowContext>(options);
    } catch (const GlError& error) {
        failures.push_back(fmt::format("window: {}", error.what()));
        return nullptr;
    }
}

} // namespace isocast::gl
