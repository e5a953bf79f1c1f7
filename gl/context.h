// OpenGL 4.5 core contexts, chosen by name at run time.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "gl/errors.h"

#include <memory>
#include <string>
#include <string_view>

namespace isocast::gl {

enum class Backend {
    Auto,   // EGL, then OSMesa
    Window, // GLFW; needs a display
    Egl,    // without a display: hardware devices, then surfaceless, then software devices
    Osmesa, // Mesa's software rasteriser in memory, loaded at run time
};

/// throws  GlError that lists the known names: auto, window, egl, osmesa
Backend backend_from_name(std::string_view name);

struct DriverInfo {
    std::string backend; // "egl (surfaceless)", "osmesa", "window"
    std::string vendor;
    std::string renderer;
    std::string version;
};

struct ContextOptions {
    Backend backend = Backend::Auto;
    int window_width = 1280;
    int window_height = 800;
    std::string window_title = "isocast";
    bool window_visible = true;
};

/// A context, current on the thread that made it. All rendering goes to framebuffer objects; a
/// window's own framebuffer exists only for Backend::Window.
class Context {
public:
    virtual ~Context() = default;
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;

    /// Makes this context current and loads its functions. Only one context is current at a time in
    /// the whole process, since the loader's function table is one.
    void make_current();

    const DriverInfo& driver() const { return driver_; }

    /// Throws GlError with the first error that the driver reported since the last call. In release
    /// builds the driver is not asked to report, and this does nothing.
    void throw_pending_error();

protected:
    using GetProc = void (*(*)(const char*))();
    explicit Context(std::string backend) { driver_.backend = std::move(backend); }
    /// Loads functions, checks the version and switches on error reports.
    void finish();

    virtual void bind() = 0;
    virtual GetProc get_proc() const = 0;

private:
    DriverInfo driver_;
    std::string pending_error_;
};

/// throws  NoContextError that lists every way that was tried and why it failed
std::unique_ptr<Context> make_context(const ContextOptions& options = {});

} // namespace isocast::gl
