// What shaders write reaches the CPU through mapped buffers.
// SPDX-License-Identifier: MPL-2.0
#include "gl/readback.h"

#include "test_context.h"

#include <glad/gl.h>
#include <gtest/gtest.h>

#include <cstring>
#include <numeric>
#include <vector>

namespace isocast::gl {
namespace {

struct Readback : testing::Test {
    std::unique_ptr<Context> context = test::make_context();
};

TEST_F(Readback, MappingShowsWhatTheGlWroteBeforeTheFence) {
    std::vector<int> numbers(1000);
    std::iota(numbers.begin(), numbers.end(), 7);
    const Buffer source(std::as_bytes(std::span(numbers)), "source");
    const ReadbackBuffer target(source.byte_count(), "target");
    glCopyNamedBufferSubData(source.id(), target.id(), 0, 0, source.byte_count());
    const Fence fence = Fence::after_all_commands();
    fence.wait();
    EXPECT_EQ(std::memcmp(target.data(), numbers.data(), numbers.size() * sizeof(int)), 0);
}

TEST_F(Readback, DestructionUnmapsAndDeletes) {
    unsigned id = 0;
    {
        const ReadbackBuffer buffer(64, "buffer");
        id = buffer.id();
        EXPECT_EQ(glIsBuffer(id), GL_TRUE);
    }
    EXPECT_EQ(glIsBuffer(id), GL_FALSE);
}

TEST_F(Readback, StorageBlocksHoldWhatTheStandardPromises) {
    EXPECT_GE(max_storage_bytes(), 1 << 24); // the least that OpenGL 4.5 allows
}

} // namespace
} // namespace isocast::gl
