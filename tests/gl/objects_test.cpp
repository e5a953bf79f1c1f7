// GL objects as values.
// SPDX-License-Identifier: MPL-2.0
#include "gl/objects.h"

#include "gl/context.h"
#include "gl/timer.h"

#include <glad/gl.h>
#include <gtest/gtest.h>

#include <numeric>
#include <vector>

namespace isocast::gl {
namespace {

struct Objects : testing::Test {
    std::unique_ptr<Context> context = make_context({.backend = Backend::Osmesa});
};

TEST_F(Objects, MoveTransfersAndDestructionDeletes) {
    unsigned id = 0;
    {
        Texture a = Texture::image(Format::Rgba8, 4, 4, "a");
        id = a.id();
        Texture b = std::move(a);
        EXPECT_EQ(b.id(), id);
        EXPECT_EQ(glIsTexture(id), GL_TRUE);
    }
    EXPECT_EQ(glIsTexture(id), GL_FALSE);
}

TEST_F(Objects, CountTheirBytes) {
    EXPECT_EQ(Texture().byte_count(), 0);
    EXPECT_EQ(Texture::image(Format::Rgba16f, 3, 5, "i").byte_count(), 3 * 5 * 8);
    EXPECT_EQ(Texture::volume(Format::R32f, 3, 5, 7, Filter::Linear, "v").byte_count(),
              3 * 5 * 7 * 4);
}

TEST_F(Objects, UploadedBoxIsWhereItWasPut) {
    Texture volume = Texture::volume(Format::R32f, 4, 5, 6, Filter::Nearest, "v");
    std::vector<float> all(4 * 5 * 6, -1.0f);
    volume.upload_box(0, 0, 0, 4, 5, 6, all);
    std::vector<float> box(2 * 3 * 2);
    std::iota(box.begin(), box.end(), 0.0f);
    volume.upload_box(1, 2, 3, 2, 3, 2, box);
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    glGetTextureImage(volume.id(), 0, GL_RED, GL_FLOAT, GLsizei(all.size() * 4), all.data());
    for (int z = 0; z < 6; ++z)
        for (int y = 0; y < 5; ++y)
            for (int x = 0; x < 4; ++x) {
                const bool is_inside = x >= 1 && x < 3 && y >= 2 && y < 5 && z >= 3 && z < 5;
                const float expected =
                    is_inside ? float((x - 1) + 2 * ((y - 2) + 3 * (z - 3))) : -1.0f;
                EXPECT_EQ(all[std::size_t(x + 4 * (y + 5 * z))], expected);
            }
}

TEST_F(Objects, TimerGrowsWithTheWork) {
    // 2048^2 texels against 16^2: 16,384 times the work; the factor 4 asked for leaves room for
    // the fixed cost of a clear and for a noisy machine.
    const auto time_of_clears = [](int size) {
        const Texture image = Texture::image(Format::Rgba32f, size, size, "t");
        const Framebuffer framebuffer({&image}, "t");
        framebuffer.bind();
        const float colour[4] = {1, 2, 3, 4};
        glFinish();
        Timer timer;
        timer.start();
        for (int i = 0; i < 10; ++i) glClearBufferfv(GL_COLOR, 0, colour), glFinish();
        timer.stop();
        return timer.milliseconds();
    };
    time_of_clears(16);
    EXPECT_GT(time_of_clears(2048), 4 * time_of_clears(16));
}

} // namespace
} // namespace isocast::gl
