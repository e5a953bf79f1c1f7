// The production field functions on the GL against their double twins.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/reconstruct.h"
#include "gl/context.h"
#include "raycaster/brick_atlas.h"
#include "volume/analytic_fields.h"
#include "volume/dense_field.h"

#include <glad/gl.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace isocast {
namespace {

struct Greatest {
    double value_error = 0;    // relative to the field's range
    double gradient_error = 0; // relative to the field's range, per voxel
};

/// Runs field_probe.comp at local points (float exactly) and compares with tricubic_jet.
Greatest compare_with_twin(const FieldSource& field, const std::vector<Eigen::Vector4f>& points,
                           const BrickAtlas& atlas) {
    const std::filesystem::path source(ISOCAST_SOURCE_DIR);
    gl::ShaderLibrary shaders({source / "shaders", source / "tests/shaders"});
    const gl::Program& program = shaders.program({{"field_probe.comp"}, {}});
    atlas.bind(program);
    const gl::Buffer in(std::as_bytes(std::span(points)), "points");
    const gl::Buffer out(std::as_bytes(std::span(points)), "results");
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, in.id());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, out.id());
    program.use();
    glDispatchCompute(GLuint(points.size() + 63) / 64, 1, 1);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    std::vector<Eigen::Vector4f> results(points.size());
    glGetNamedBufferSubData(out.id(), 0, GLsizeiptr(results.size() * sizeof(results[0])),
                            results.data());

    const ValueRange range = field.value_range(field.extent());
    const double width = double(range.max) - range.min;
    Greatest greatest;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec3d p =
            points[i].head<3>().cast<double>() + atlas.local_origin_index().cast<double>();
        const Jet expected = tricubic_jet(field, p);
        greatest.value_error =
            std::max(greatest.value_error, std::abs(results[i][0] - expected.value) / width);
        greatest.gradient_error = std::max(
            greatest.gradient_error,
            (results[i].tail<3>().cast<double>() - expected.gradient).cwiseAbs().maxCoeff() /
                width);
    }
    return greatest;
}

/// Seeded points inside the extent, half of them within a voxel of a brick's border, some exactly
/// on samples and borders.
std::vector<Eigen::Vector4f> probe_points(const FieldSource& field, const Index3& origin) {
    std::mt19937 generator(11);
    const Vec3d lo = field.extent().lo.cast<double>() + Vec3d::Constant(2);
    const Vec3d hi = field.extent().hi.cast<double>() - Vec3d::Constant(3);
    std::vector<Eigen::Vector4f> points;
    for (int i = 0; i < 20000; ++i) {
        Vec3d p;
        for (int axis = 0; axis < 3; ++axis) {
            p[axis] = std::uniform_real_distribution(lo[axis], hi[axis])(generator);
            if (i % 2 == 0 && axis == i / 2 % 3) {
                const double border = brick_size * std::round(p[axis] / brick_size);
                const double near = border + std::uniform_real_distribution(-1.0, 1.0)(generator);
                p[axis] = std::clamp(i % 16 == 0 ? border : near, lo[axis], hi[axis]);
            }
        }
        if (i % 100 == 0) p = p.array().round();
        const Vec3d local = p - origin.cast<double>();
        points.emplace_back(float(local.x()), float(local.y()), float(local.z()), 0.0f);
    }
    return points;
}

struct Tricubic : testing::Test {
    std::unique_ptr<gl::Context> context = gl::make_context({.backend = gl::Backend::Osmesa});
};

TEST_F(Tricubic, AgreesWithTheDoubleTwinOnADistanceField) {
    // Clamped far away, so that every brick is active and the range is that of a wide band.
    const auto field = sampled(builtin_field("torus"), 70, 8.0);
    const ActiveBlocks blocks = find_active_blocks(*field, 0);
    const BrickAtlas atlas(*field, 0, blocks);
    ASSERT_GE(atlas.brick_count(), 8);
    const auto points = probe_points(*field, atlas.local_origin_index());
    // Bricks that hold no surface are not stored: compare where the field is.
    std::vector<Eigen::Vector4f> stored;
    const auto bricks = bricks_of(blocks);
    for (const Eigen::Vector4f& p : points) {
        const Vec3d p_index =
            p.head<3>().cast<double>() + atlas.local_origin_index().cast<double>();
        const Index3 brick = (p_index / brick_size).array().floor().matrix().cast<int>();
        if (std::ranges::find(bricks, brick) != bricks.end()) stored.push_back(p);
    }
    ASSERT_GT(stored.size(), points.size() / 2);
    const Greatest greatest = compare_with_twin(*field, stored, atlas);
    RecordProperty("value_error", std::to_string(greatest.value_error * 1e6) + "e-6");
    // 4e-6 of the range: a texel coordinate below 128 rounds by 4e-6 along each axis, times a slope
    // of a sixteenth of the range a voxel, plus 64 roundings of weights and sums at 6e-8.
    EXPECT_LT(greatest.value_error, 4e-6);
    EXPECT_LT(greatest.gradient_error, 4e-6);
}

TEST_F(Tricubic, AgreesWithTheDoubleTwinOnNoise) {
    // The steepest field there is: neighbours differ by up to the whole range.
    const IndexBox extent{Index3(-20, -3, 5), Index3(50, 47, 50)};
    std::vector<float> values(std::size_t(extent.sample_count()));
    std::mt19937 generator(5);
    for (float& value : values) value = std::uniform_real_distribution(-1.0f, 1.0f)(generator);
    const DenseField field(GridSpace::uniform(1), extent, values);
    const BrickAtlas atlas(field, 0, find_active_blocks(field, 0));
    const Greatest greatest =
        compare_with_twin(field, probe_points(field, atlas.local_origin_index()), atlas);
    RecordProperty("value_error", std::to_string(greatest.value_error * 1e6) + "e-6");
    EXPECT_LT(greatest.value_error, 4e-6);
    // Derivatives along the axes have slopes up to twice as steep as values.
    EXPECT_LT(greatest.gradient_error, 8e-6);
}

} // namespace
} // namespace isocast
