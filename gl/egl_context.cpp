// Contexts without a display, through EGL. The library is loaded at run time, so that the program
// starts and converts where there is none.
// SPDX-License-Identifier: MPL-2.0
#include "gl/backends.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>
#include <fmt/format.h>

#include <cstring>

namespace isocast::gl {

namespace {

/// The functions that we use, from libEGL.so.1.
struct EglFunctions {
    PFNEGLGETPROCADDRESSPROC GetProcAddress = nullptr;
    PFNEGLGETERRORPROC GetError = nullptr;
    PFNEGLQUERYSTRINGPROC QueryString = nullptr;
    PFNEGLINITIALIZEPROC Initialize = nullptr;
    PFNEGLBINDAPIPROC BindAPI = nullptr;
    PFNEGLCHOOSECONFIGPROC ChooseConfig = nullptr;
    PFNEGLCREATECONTEXTPROC CreateContext = nullptr;
    PFNEGLDESTROYCONTEXTPROC DestroyContext = nullptr;
    PFNEGLMAKECURRENTPROC MakeCurrent = nullptr;
    PFNEGLGETPLATFORMDISPLAYEXTPROC GetPlatformDisplayEXT = nullptr;
    PFNEGLQUERYDEVICESEXTPROC QueryDevicesEXT = nullptr;
    PFNEGLQUERYDEVICESTRINGEXTPROC QueryDeviceStringEXT = nullptr;

    /// Empty if loaded, else why not.
    std::string load() {
        // Never closed: drivers do not survive being unloaded.
        void* library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
        if (!library) return dlerror();
        GetProcAddress =
            reinterpret_cast<PFNEGLGETPROCADDRESSPROC>(dlsym(library, "eglGetProcAddress"));
        if (!GetProcAddress) return "libEGL.so.1 has no eglGetProcAddress";
        const auto get = [&](auto& function, const char* name) {
            void* symbol = dlsym(library, name);
            function = symbol
                           ? reinterpret_cast<std::remove_reference_t<decltype(function)>>(symbol)
                           : reinterpret_cast<std::remove_reference_t<decltype(function)>>(
                                 GetProcAddress(name));
            return function != nullptr;
        };
        const bool has_all =
            get(GetError, "eglGetError") && get(QueryString, "eglQueryString") &&
            get(Initialize, "eglInitialize") && get(BindAPI, "eglBindAPI") &&
            get(ChooseConfig, "eglChooseConfig") && get(CreateContext, "eglCreateContext") &&
            get(DestroyContext, "eglDestroyContext") && get(MakeCurrent, "eglMakeCurrent") &&
            get(GetPlatformDisplayEXT, "eglGetPlatformDisplayEXT");
        // Devices are an extension that may be absent.
        get(QueryDevicesEXT, "eglQueryDevicesEXT");
        get(QueryDeviceStringEXT, "eglQueryDeviceStringEXT");
        return has_all ? "" : "libEGL.so.1 lacks a function of EGL 1.4 or eglGetPlatformDisplayEXT";
    }
};

bool has_word(const char* list, std::string_view word) {
    if (!list) return false;
    std::string_view rest(list);
    while (!rest.empty()) {
        const auto end = rest.find(' ');
        if (rest.substr(0, end) == word) return true;
        if (end == std::string_view::npos) break;
        rest.remove_prefix(end + 1);
    }
    return false;
}

class EglContext final : public Context {
public:
    /// throws  GlError with the cause
    EglContext(EglFunctions egl, EGLDisplay display, const std::string& name)
        : Context("egl (" + name + ")"), egl_(egl), display_(display) {
        if (display_ == EGL_NO_DISPLAY) throw GlError("no display");
        if (!egl_.Initialize(display_, nullptr, nullptr)) throw GlError(failed("eglInitialize"));
        const char* extensions = egl_.QueryString(display_, EGL_EXTENSIONS);
        if (!has_word(extensions, "EGL_KHR_surfaceless_context"))
            throw GlError("no EGL_KHR_surfaceless_context");
        if (!egl_.BindAPI(EGL_OPENGL_API)) throw GlError(failed("eglBindAPI(OpenGL)"));
        EGLConfig config = EGL_NO_CONFIG_KHR;
        if (!has_word(extensions, "EGL_KHR_no_config_context")) {
            const EGLint wanted[] = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT,
                                     EGL_NONE};
            EGLint count = 0;
            if (!egl_.ChooseConfig(display_, wanted, &config, 1, &count) || count == 0)
                throw GlError(failed("eglChooseConfig"));
        }
        const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                     4,
                                     EGL_CONTEXT_MINOR_VERSION,
                                     5,
                                     EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                     EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                     EGL_CONTEXT_OPENGL_DEBUG,
                                     reports_errors ? EGL_TRUE : EGL_FALSE,
                                     EGL_NONE};
        context_ = egl_.CreateContext(display_, config, EGL_NO_CONTEXT, attributes);
        if (context_ == EGL_NO_CONTEXT) throw GlError(failed("OpenGL 4.5 core: eglCreateContext"));
        try {
            finish();
        } catch (...) {
            release();
            throw;
        }
    }

    // The display stays initialised: it is the process's, and another context may use it.
    ~EglContext() override { release(); }

private:
    void bind() override {
        if (!egl_.MakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_))
            throw GlError(failed("eglMakeCurrent"));
    }
    GetProc get_proc() const override { return egl_.GetProcAddress; }

    void release() {
        egl_.MakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        egl_.DestroyContext(display_, context_);
    }
    std::string failed(const char* what) {
        return fmt::format("{} failed (EGL error 0x{:x})", what, egl_.GetError());
    }

    EglFunctions egl_;
    EGLDisplay display_;
    EGLContext context_ = EGL_NO_CONTEXT;
};

} // namespace

std::unique_ptr<Context> make_egl_context(std::vector<std::string>& failures) {
    EglFunctions egl;
    if (const std::string why = egl.load(); !why.empty()) {
        failures.push_back("egl: " + why);
        return nullptr;
    }
    const char* client_extensions = egl.QueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);

    struct Candidate {
        std::string name;
        EGLenum platform;
        void* native_display;
    };
    std::vector<Candidate> hardware, software, candidates;
    if (egl.QueryDevicesEXT && egl.QueryDeviceStringEXT &&
        has_word(client_extensions, "EGL_EXT_platform_device")) {
        EGLDeviceEXT devices[16];
        EGLint count = 0;
        if (egl.QueryDevicesEXT(16, devices, &count))
            for (EGLint i = 0; i < count; ++i) {
                const bool is_software =
                    has_word(egl.QueryDeviceStringEXT(devices[i], EGL_EXTENSIONS),
                             "EGL_MESA_device_software");
                (is_software ? software : hardware)
                    .push_back({fmt::format("device {}{}", i, is_software ? ", software" : ""),
                                EGL_PLATFORM_DEVICE_EXT, devices[i]});
            }
    }
    candidates = hardware;
    if (has_word(client_extensions, "EGL_MESA_platform_surfaceless"))
        candidates.push_back({"surfaceless", EGL_PLATFORM_SURFACELESS_MESA, nullptr});
    candidates.insert(candidates.end(), software.begin(), software.end());

    if (candidates.empty()) failures.push_back("egl: no device and no surfaceless platform");
    for (const Candidate& candidate : candidates) {
        try {
            return std::make_unique<EglContext>(
                egl,
                egl.GetPlatformDisplayEXT(candidate.platform, candidate.native_display, nullptr),
                candidate.name);
        } catch (const GlError& error) {
            failures.push_back(fmt::format("egl ({}): {}", candidate.name, error.what()));
        }
    }
    return nullptr;
}

} // namespace isocast::gl
