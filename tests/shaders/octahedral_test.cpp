// Directions that shaders keep in 32 bits.
// SPDX-License-Identifier: MPL-2.0
#include "gl/objects.h"
#include "gl/program.h"
#include "test_context.h"

#include <glad/gl.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

namespace isocast {
namespace {

TEST(OctahedralDirections, AreThereAndBackAgain) {
    const std::unique_ptr<gl::Context> context = test::make_context();
    const std::filesystem::path source(ISOCAST_SOURCE_DIR);
    gl::ShaderLibrary shaders({source / "shaders", source / "tests/shaders"});
    std::mt19937 random(1);
    std::normal_distribution<float> normal;
    std::vector<Eigen::Vector4f> directions;
    for (int i = 0; i < 100000; ++i) {
        Eigen::Vector4f v(normal(random), normal(random), normal(random), 0);
        if (i % 4 == 1) v[i / 4 % 3] = 0; // where it is folded, too
        if (i % 4 == 2) v[i / 4 % 3] *= 1e-6F;
        directions.push_back(v.normalized());
    }
    for (const float sign : {-1.0F, 1.0F})
        for (int axis = 0; axis < 3; ++axis)
            directions.push_back(sign * Eigen::Vector4f::Unit(axis));
    const gl::Buffer in(std::as_bytes(std::span(directions)), "directions");
    std::vector<Eigen::Vector4f> results(directions.size());
    const gl::Buffer out(std::as_bytes(std::span(results)), "results");
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, in.id());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, out.id());
    shaders.program({{"octahedral_probe.comp"}, {}}).use();
    glDispatchCompute(GLuint(directions.size() + 63) / 64, 1, 1);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(out.id(), 0, GLsizeiptr(results.size() * sizeof(results[0])),
                            results.data());
    double worst = 0;
    for (std::size_t i = 0; i < directions.size(); ++i)
        worst = std::max(worst, double((results[i] - directions[i]).norm()));
    // Half a step of 1/32767 each way; folding stretches it by up to 3. So does the survey's table.
    EXPECT_LT(worst, 7e-5);
    EXPECT_GT(worst, 1e-5); // it is packed at all
}

} // namespace
} // namespace isocast
