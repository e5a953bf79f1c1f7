// Contexts by every backend.
// SPDX-License-Identifier: MPL-2.0
#include "gl/context.h"

#include "gl/objects.h"

#include <glad/gl.h>
#include <gtest/gtest.h>

#include <cstdlib>

namespace isocast::gl {
namespace {

class OffscreenContext : public testing::TestWithParam<Backend> {};

TEST_P(OffscreenContext, ClearsAndReadsBack) {
    const auto context = make_context({.backend = GetParam()});
    EXPECT_FALSE(context->driver().renderer.empty());
    const Texture image = Texture::image(Format::Rgba32f, 5, 3, "test");
    const Framebuffer framebuffer({&image}, "test");
    framebuffer.bind();
    const float colour[4] = {0.25f, -1.5f, 1e-20f, 7.0f};
    glClearBufferfv(GL_COLOR, 0, colour);
    std::vector<float> texels(5 * 3 * 4);
    image.read_rgba(texels);
    for (std::size_t i = 0; i < texels.size(); ++i) EXPECT_EQ(texels[i], colour[i % 4]);
    EXPECT_NO_THROW(context->throw_pending_error());
}

TEST_P(OffscreenContext, CanBeMadeAgainAfterItWasDestroyed) {
    for (int i = 0; i < 3; ++i) {
        const auto context = make_context({.backend = GetParam()});
        EXPECT_GE(max_volume_extent(), 2048); // the least that OpenGL 4.5 allows
    }
}

INSTANTIATE_TEST_SUITE_P(Backends, OffscreenContext, testing::Values(Backend::Egl, Backend::Osmesa),
                         [](const auto& test) {
                             return test.param == Backend::Egl ? "Egl" : "Osmesa";
                         });

TEST(Context, SwitchesBetweenTwoBackends) {
    const auto egl = make_context({.backend = Backend::Egl});
    const auto osmesa = make_context({.backend = Backend::Osmesa});
    for (int i = 0; i < 2; ++i)
        for (const auto* context : {&egl, &osmesa}) {
            (*context)->make_current();
            EXPECT_EQ(reinterpret_cast<const char*>(glGetString(GL_RENDERER)),
                      (*context)->driver().renderer);
        }
}

TEST(Context, ReportsDriverErrorsInCheckedBuilds) {
#ifndef ISOCAST_CHECKED
    GTEST_SKIP() << "the driver is asked to report errors only in debug and sanitizer builds";
#endif
    const auto context = make_context({.backend = Backend::Osmesa});
    glBindTextureUnit(0, 12345); // no such texture
    EXPECT_THROW(context->throw_pending_error(), GlError);
    EXPECT_NO_THROW(context->throw_pending_error()) << "an error is reported once";
}

TEST(Backend, UnknownNameListsTheKnownOnes) {
    EXPECT_EQ(backend_from_name("osmesa"), Backend::Osmesa);
    try {
        backend_from_name("vulkan");
        FAIL() << "no error";
    } catch (const GlError& error) {
        EXPECT_STREQ(error.what(), "unknown backend 'vulkan' (known: auto, window, egl, osmesa)");
    }
}

TEST(WindowContext, HasACoreContext) {
    if (!std::getenv("DISPLAY")) GTEST_SKIP() << "no display; run under xvfb-run";
    const auto context =
        make_context({.backend = Backend::Window, .window_width = 64, .window_height = 48});
    EXPECT_EQ(context->driver().backend, "window");
    EXPECT_GE(max_image_extent(), 64);
}

TEST(WindowContext, WithoutADisplaySaysWhatWasTriedAndWhyItFailed) {
    unsetenv("DISPLAY");
    unsetenv("WAYLAND_DISPLAY");
    try {
        make_context({.backend = Backend::Window});
        FAIL() << "no error";
    } catch (const NoContextError& error) {
        EXPECT_NE(std::string(error.what()).find("window: X11"), std::string::npos) << error.what();
    }
}

} // namespace
} // namespace isocast::gl
