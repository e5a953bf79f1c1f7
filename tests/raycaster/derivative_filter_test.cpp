// Gradients by another filter than values.
// SPDX-License-Identifier: MPL-2.0
#include "../volume/random_fields.h"
#include "raycaster/reference.h"
#include "raycaster/renderer.h"
#include "test_context.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace isocast {
namespace {

const std::filesystem::path shader_folder = std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders";

constexpr int n = 32;

struct DerivativeFilter : testing::Test {
    std::unique_ptr<gl::Context> context = test::make_context();
    Renderer renderer{*context, shader_folder};
    // Filters differ most on noise; voxels are not cubes, so that turning gradients matters.
    std::shared_ptr<const FieldSource> field = [] {
        test::Random random(3);
        GridSpace space;
        space.world_from_index.linear() = Vec3d(1, 1.25, 0.75).asDiagonal();
        const IndexBox extent{Index3::Zero(), Index3::Constant(n)};
        const DenseField noise = test::random_dense(random, extent);
        return std::make_shared<DenseField>(
            space, extent, std::vector<float>(noise.values().begin(), noise.values().end()));
    }();
    Camera camera{.eye_world = {70, 60, 90}, .target_world = {16, 20, 12}, .fov_y_degrees = 25};

    struct Pictures {
        Image hits;
        Image gradients;
        std::int64_t field_bytes = 0;
        int programs = 0;
    };
    Pictures draw(Filter filter, std::optional<Filter> derivative_filter,
                  const StorageOptions& storage = {}) {
        renderer.load({.field = field,
                       .filter = filter,
                       .derivative_filter = derivative_filter,
                       .storage = storage});
        const FrameReport report =
            renderer.draw(camera, 64, 64, {FrameImage::Hit, FrameImage::Gradient});
        return {renderer.read(FrameImage::Hit), renderer.read(FrameImage::Gradient),
                report.field_bytes, report.programs_compiled};
    }

    /// Greatest difference of a picture's gradients from the double twin's, at its hits [world].
    /// storage_error  of a sample [world]
    double worst_of_allowed(const Pictures& pictures, Filter derivative_filter,
                            double storage_error) const;
};

double DerivativeFilter::worst_of_allowed(const Pictures& pictures, Filter derivative_filter,
                                          double storage_error) const {
    const Kernel kernel = kernel_of(derivative_filter);
    const ReferenceCaster twin(*control_samples(field, derivative_filter), 0, {.kernel = kernel});
    const Mat3d index_from_world = field->space().world_from_index.linear().inverse();
    double worst = 0;
    int count = 0;
    for (std::size_t i = 0; i < pictures.hits.rgba.size(); i += 4) {
        const auto vector = [&](const Image& image) {
            return Vec3d(image.rgba[i], image.rgba[i + 1], image.rgba[i + 2]);
        };
        if (pictures.hits.rgba[i + 3] == 0) continue;
        const Vec3d p = field->space().to_index(camera.eye_world + vector(pictures.hits));
        // Derivatives of the linear kernel jump between cells; 1e-4: as far as coordinates round.
        if (kernel == Kernel::Linear && (p.array() - p.array().round()).abs().minCoeff() < 1e-4)
            continue;
        ++count;
        const Vec3d expected = index_from_world.transpose() * twin.gradient(p);
        // Samples lie in [-1, 1] and control samples in [-3, 3] (c = 2 f - a mean of f; those of
        // exact are a little larger). Eye-relative hits of 120 round by 8e-6 [world], and second
        // derivatives are at most 3 * 4 * 3 [1/voxel^2]; sums of |weights of a gradient| are at
        // most 2 * 1.25^2, of roundings 2^-20; all divided by the smallest voxel.
        const double allowed = (36 * 3e-5 + 3.2 * (3 * 0x1p-20 + storage_error)) / 0.75;
        worst = std::max(worst, (vector(pictures.gradients) - expected).norm() / allowed);
    }
    EXPECT_GT(count, 1000);
    return worst;
}

TEST_F(DerivativeFilter, OfTheValueAddsNothing) {
    for (const Filter filter : {Filter::Interpolating, Filter::CatmullRom}) {
        const Pictures none = draw(filter, std::nullopt);
        const Pictures same = draw(filter, filter);
        EXPECT_EQ(same.field_bytes, none.field_bytes);
        EXPECT_EQ(same.programs, none.programs);
        EXPECT_EQ(same.hits.rgba, none.hits.rgba);
        EXPECT_EQ(same.gradients.rgba, none.gradients.rgba);
    }
}

TEST_F(DerivativeFilter, GivesTheTwinsGradientAndLeavesHitsAsTheyAre) {
    for (const Filter filter : {Filter::Linear, Filter::BSpline, Filter::Interpolating}) {
        const Pictures plain = draw(filter, std::nullopt);
        EXPECT_LE(worst_of_allowed(plain, filter, 0), 1);
        for (const Filter other : {Filter::Linear, Filter::BSpline, Filter::Interpolating,
                                   Filter::Exact, Filter::CatmullRom}) {
            if (other == filter) continue;
            SCOPED_TRACE(std::string(filter_name(filter)) + ", derivatives " +
                         std::string(filter_name(other)));
            for (const Fetch fetch : {Fetch::Rows, Fetch::Linear}) {
                const Pictures p = draw(filter, other, {.fetch = fetch});
                if (fetch == Fetch::Rows) {
                    EXPECT_EQ(p.hits.rgba, plain.hits.rgba);
                    // A second pool only for other control samples.
                    if (share_control_samples(filter, other)) {
                        EXPECT_EQ(p.field_bytes, plain.field_bytes);
                    } else {
                        EXPECT_GT(double(p.field_bytes), 1.9 * double(plain.field_bytes));
                    }
                }
                EXPECT_LE(worst_of_allowed(p, other, 0), 1);
                // The gradient of the value's filter is another one.
                EXPECT_GT(worst_of_allowed(p, filter, 0), 10);
            }
        }
    }
}

TEST_F(DerivativeFilter, StoresControlSamplesThatAreLargerThanTheValues) {
    // Codes of 16 bits once would have had the range of the value's control samples, [-1, 1].
    for (const SampleFormat format : {SampleFormat::Float16, SampleFormat::Norm16}) {
        const Pictures p = draw(Filter::Linear, Filter::Interpolating, {.format = format});
        // 2^-11 of samples up to 3, and a step of 2^-15 of up to twice that, halved.
        EXPECT_LE(worst_of_allowed(p, Filter::Interpolating, 3 * 0x1p-11), 1);
    }
}

TEST_F(DerivativeFilter, IsTheSameHoweverFewBricksFit) {
    const Pictures all = draw(Filter::Linear, Filter::Interpolating);
    // Half the budget is for values, half for derivatives.
    const Pictures few = draw(Filter::Linear, Filter::Interpolating,
                              {.budget_bytes = 2 * 5 * BrickLayout(StorageOptions{}).brick_bytes});
    EXPECT_EQ(renderer.pool().resident_count(), 5);
    EXPECT_LT(few.field_bytes, all.field_bytes / 2);
    EXPECT_EQ(few.hits.rgba, all.hits.rgba);
    EXPECT_EQ(few.gradients.rgba, all.gradients.rgba);
}

} // namespace
} // namespace isocast
