// GL objects as values.
// SPDX-License-Identifier: MPL-2.0
#include "gl/objects.h"

#include "gl/timer.h"
#include "test_context.h"

#include <glad/gl.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

namespace isocast::gl {
namespace {

struct Objects : testing::Test {
    std::unique_ptr<Context> context = test::make_context();
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
    volume.upload_box(0, 0, 0, 4, 5, 6, std::as_bytes(std::span(all)));
    std::vector<float> box(2 * 3 * 2);
    std::iota(box.begin(), box.end(), 0.0f);
    volume.upload_box(1, 2, 3, 2, 3, 2, std::as_bytes(std::span(box)));
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

TEST_F(Objects, WritableBufferHoldsThePiecesWrittenToIt) {
    Buffer buffer = Buffer::writable(4 * 1000, "pieces");
    const auto write = [&](int first, int count) {
        buffer.write(4 * first, 4 * count, [&](std::span<std::byte> memory) {
            std::vector<int> numbers(static_cast<std::size_t>(count));
            std::iota(numbers.begin(), numbers.end(), first);
            std::ranges::copy(std::as_bytes(std::span(numbers)), memory.begin());
        });
    };
    write(400, 600);
    write(0, 300);
    write(300, 100);
    std::vector<int> numbers(1000);
    glGetNamedBufferSubData(buffer.id(), 0, 4000, numbers.data());
    for (int i = 0; i < 1000; ++i) ASSERT_EQ(numbers[static_cast<std::size_t>(i)], i);
    buffer.write(0, 0, [](std::span<std::byte>) { FAIL() << "nothing to write"; });
}

TEST_F(Objects, ClearedImageHoldsTheNumber) {
    Texture image = Texture::image(Format::R32i, 5, 3, "numbers");
    image.clear(-7);
    std::vector<int> numbers(15);
    glGetTextureImage(image.id(), 0, GL_RED_INTEGER, GL_INT, 60, numbers.data());
    EXPECT_EQ(numbers, std::vector<int>(15, -7));
}

TEST_F(Objects, BufferTexturesHoldWhatTheStandardPromises) {
    EXPECT_GE(max_buffer_texels(), 65536); // the least that OpenGL 4.5 allows
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
