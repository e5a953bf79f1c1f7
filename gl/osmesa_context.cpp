// Mesa's off-screen software renderer, loaded at run time: Mesa 25.1 removed it, so the program
// must start without it.
// SPDX-License-Identifier: MPL-2.0
#include "gl/backends.h"

#include <GL/osmesa.h>
#include <dlfcn.h>
#include <fmt/format.h>

#include <array>

namespace isocast::gl {

namespace {

struct OsmesaFunctions {
    decltype(&OSMesaCreateContextAttribs) CreateContextAttribs = nullptr;
    decltype(&OSMesaMakeCurrent) MakeCurrent = nullptr;
    decltype(&OSMesaDestroyContext) DestroyContext = nullptr;
    decltype(&OSMesaGetProcAddress) GetProcAddress = nullptr;

    /// Empty if loaded, else why not.
    std::string load() {
        // Never closed: LLVM does not survive being unloaded.
        void* library = dlopen("libOSMesa.so.8", RTLD_NOW | RTLD_LOCAL);
        if (!library) library = dlopen("libOSMesa.so.6", RTLD_NOW | RTLD_LOCAL);
        if (!library) return dlerror();
        const auto get = [&](auto& function, const char* name) {
            function =
                reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(library, name));
            return function != nullptr;
        };
        const bool has_all = get(CreateContextAttribs, "OSMesaCreateContextAttribs") &&
                             get(MakeCurrent, "OSMesaMakeCurrent") &&
                             get(DestroyContext, "OSMesaDestroyContext") &&
                             get(GetProcAddress, "OSMesaGetProcAddress");
        return has_all ? "" : "libOSMesa.so lacks OSMesaCreateContextAttribs";
    }
};

class OsmesaContext final : public Context {
public:
    /// throws  GlError with the cause
    explicit OsmesaContext(OsmesaFunctions osmesa) : Context("osmesa"), osmesa_(osmesa) {
        const int attributes[] = {OSMESA_FORMAT,
                                  OSMESA_RGBA,
                                  OSMESA_PROFILE,
                                  OSMESA_CORE_PROFILE,
                                  OSMESA_CONTEXT_MAJOR_VERSION,
                                  4,
                                  OSMESA_CONTEXT_MINOR_VERSION,
                                  5,
                                  0};
        context_ = osmesa_.CreateContextAttribs(attributes, nullptr);
        if (!context_) throw GlError("no OpenGL 4.5 core context (OSMesaCreateContextAttribs)");
        try {
            finish();
        } catch (...) {
            osmesa_.DestroyContext(context_);
            throw;
        }
    }
    ~OsmesaContext() override {
        osmesa_.MakeCurrent(nullptr, nullptr, 0, 0, 0);
        osmesa_.DestroyContext(context_);
    }

private:
    void bind() override {
        if (!osmesa_.MakeCurrent(context_, pixels_.data(), GL_UNSIGNED_BYTE, 1, 1))
            throw GlError("OSMesaMakeCurrent failed");
    }
    GetProc get_proc() const override { return osmesa_.GetProcAddress; }

    OsmesaFunctions osmesa_;
    OSMesaContext context_ = nullptr;
    // OSMesa needs a default framebuffer; nothing is drawn into it.
    std::array<unsigned char, 4> pixels_{};
};

} // namespace

std::unique_ptr<Context> make_osmesa_context(std::vector<std::string>& failures) {
    OsmesaFunctions osmesa;
    if (const std::string why = osmesa.load(); !why.empty()) {
        failures.push_back("osmesa: " + why);
        return nullptr;
    }
    try {
        return std::make_unique<OsmesaContext>(osmesa);
    } catch (const GlError& error) {
        failures.push_back(fmt::format("osmesa: {}", error.what()));
        return nullptr;
    }
}

} // namespace isocast::gl
