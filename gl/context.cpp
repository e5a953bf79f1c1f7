// SPDX-License-Identifier: MPL-2.0
#include "gl/context.h"

#include "gl/backends.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glad/gl.h>

#include <utility>

namespace isocast::gl {

namespace {

std::string text(GLenum name) {
    const auto* value = reinterpret_cast<const char*>(glGetString(name));
    return value ? value : "";
}

// Throwing from here would unwind through the driver: the message waits for throw_pending_error.
void GLAPIENTRY on_message(GLenum, GLenum type, GLuint, GLenum, GLsizei length,
                           const GLchar* message, const void* pending_error) {
    auto& pending = *static_cast<std::string*>(const_cast<void*>(pending_error));
    if (type == GL_DEBUG_TYPE_ERROR && pending.empty())
        pending.assign(message, static_cast<std::size_t>(length));
}

} // namespace

Backend backend_from_name(std::string_view name) {
    if (name == "auto") return Backend::Auto;
    if (name == "window") return Backend::Window;
    if (name == "egl") return Backend::Egl;
    if (name == "osmesa") return Backend::Osmesa;
    throw GlError(fmt::format("unknown backend '{}' (known: auto, window, egl, osmesa)", name));
}

void Context::make_current() {
    bind();
    if (gladLoadGL(get_proc()) == 0) throw GlError("the driver gives no OpenGL functions");
}

void Context::finish() {
    make_current();
    driver_.vendor = text(GL_VENDOR);
    driver_.renderer = text(GL_RENDERER);
    driver_.version = text(GL_VERSION);
    if (!GLAD_GL_VERSION_4_5)
        throw GlError(
            fmt::format("OpenGL 4.5 is needed, {} has {}", driver_.renderer, driver_.version));
    if (reports_errors) {
        glEnable(GL_DEBUG_OUTPUT);
        glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
        glDebugMessageCallback(on_message, &pending_error_);
    }
}

void Context::throw_pending_error() {
    if (pending_error_.empty()) return;
    throw GlError("OpenGL: " + std::exchange(pending_error_, {}));
}

std::unique_ptr<Context> make_context(const ContextOptions& options) {
    std::vector<std::string> failures;
    std::unique_ptr<Context> context;
    switch (options.backend) {
    case Backend::Auto:
        context = make_egl_context(failures);
        if (!context) context = make_osmesa_context(failures);
        break;
    case Backend::Window:
        context = make_window_context(options, failures);
        break;
    case Backend::Egl:
        context = make_egl_context(failures);
        break;
    case Backend::Osmesa:
        context = make_osmesa_context(failures);
        break;
    }
    if (!context)
        throw NoContextError(
            fmt::format("no usable OpenGL 4.5 core context; tried {}", fmt::join(failures, "; ")));
    return context;
}

} // namespace isocast::gl
