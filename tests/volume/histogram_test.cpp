// The statistics of volumes, on synthetic ones.
// SPDX-License-Identifier: MPL-2.0
#include "volume/histogram.h"

#include "random_fields.h"
#include "volume/analytic_fields.h"
#include "volume/sparsify.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <numeric>

namespace isocast::test {
namespace {

/// n^3 samples of value(index).
template<class Value>
DenseField volume_of(int n, const Value& value, const GridSpace& space = GridSpace::uniform(1)) {
    const IndexBox box{Index3::Zero(), Index3::Constant(n)};
    std::vector<float> values;
    values.reserve(static_cast<std::size_t>(box.sample_count()));
    for_each_sample(box, [&](const Index3& at) { values.push_back(value(at)); });
    return {space, box, std::move(values)};
}

/// From `outside` to `inside` over a blur of `sigma` voxels, on a sphere about the middle.
float blurred_sphere(const Index3& at, int n, double radius, double sigma, double outside,
                     double inside) {
    const double r = (at.cast<double>() - Vec3d::Constant(0.5 * (n - 1))).norm();
    const double share = 0.5 * std::erfc((r - radius) / (std::sqrt(2.0) * sigma));
    return static_cast<float>(outside + (inside - outside) * share);
}

TEST(Histogram, CountsEverySampleOnce) {
    Random random(1);
    std::vector<float> values(10000);
    for (float& value : values) value = static_cast<float>(random_real(random, -3, 5));
    const Histogram histogram = histogram_of(values);
    ASSERT_EQ(histogram.counts.size(), 64u);
    const auto [min, max] = std::ranges::minmax(values);
    EXPECT_EQ(histogram.edge(0), min);
    EXPECT_NEAR(histogram.edge(64), max, 1e-6);
    for (std::size_t i = 0; i < 64; ++i) {
        const auto expected = std::ranges::count_if(values, [&](float v) {
            return v >= histogram.edge(i) && (v < histogram.edge(i + 1) || i == 63);
        });
        EXPECT_EQ(histogram.counts[i], expected) << i;
    }
}

TEST(Histogram, BinsOfIntegersHoldEquallyMany) {
    std::vector<float> values(256);
    std::iota(values.begin(), values.end(), 0.0F);
    const Histogram bytes = histogram_of(values);
    EXPECT_EQ(bytes.edge(0), -0.5);
    EXPECT_EQ(bytes.counts, std::vector<std::int64_t>(64, 4));
    const Histogram few = histogram_of(std::vector<float>{3, 7, 7});
    EXPECT_EQ(few.bin_width, 1);
    EXPECT_EQ(few.counts, (std::vector<std::int64_t>{1, 0, 0, 0, 2}));
    EXPECT_EQ(histogram_of(std::vector<float>{0.3F, 0.3F}).counts, std::vector<std::int64_t>{2});
    EXPECT_TRUE(histogram_of({}).counts.empty());
}

TEST(FieldSubset, OfASmallFieldIsAllOfItWithItsSlopes) {
    GridSpace space; // anisotropic: slopes are those in the world
    space.world_from_index.linear() = Vec3d(0.5, 1, 2).asDiagonal();
    const Vec3d gradient(1, -2, 3);
    const DenseField field = volume_of(
        20,
        [&](const Index3& at) {
            return static_cast<float>(gradient.dot(space.to_world(at.cast<double>())));
        },
        space);
    const FieldSubset subset = subset_of(field);
    EXPECT_TRUE(subset.is_whole());
    std::vector<float> expected(field.values().begin(), field.values().end());
    std::vector<float> values = subset.values;
    std::ranges::sort(expected);
    std::ranges::sort(values);
    EXPECT_EQ(values, expected);
    // Inside, differences of a linear function are exact but for float32; at the border they halve.
    const auto inside = std::ranges::count_if(subset.slopes, [&](float slope) {
        return std::abs(slope - static_cast<float>(gradient.norm())) < 1e-4F;
    });
    EXPECT_EQ(inside, 18 * 18 * 18);
}

TEST(FieldSubset, OfALargeFieldIsSpreadOverIt) {
    const int n = 200;
    const DenseField field = volume_of(n, [](const Index3& at) { return float(at.z()); });
    const FieldSubset subset = subset_of(field, 1 << 17);
    EXPECT_FALSE(subset.is_whole());
    EXPECT_EQ(subset.samples_in_field, n * n * n);
    EXPECT_LE(subset.values.size(), std::size_t{1} << 17);
    EXPECT_GT(subset.values.size(), std::size_t{1} << 16);
    // The mean of n layers, whose standard deviation is 58; bars are a few hundred independent
    // ones.
    const double mean = std::accumulate(subset.values.begin(), subset.values.end(), 0.0) /
                        static_cast<double>(subset.values.size());
    EXPECT_NEAR(mean, 0.5 * (n - 1), 5);
}

// The task's own example first; then smaller spheres, more noise, and a dark object.
TEST(Histogram, SuggestsTheMiddleOfABlurredStep) {
    struct Case {
        double radius, noise, outside, inside;
    };
    const int n = 64;
    for (const Case& c : {Case{20, 2, 10, 100}, Case{20, 5, 10, 100}, Case{20, 9, 10, 100},
                          Case{6, 2, 10, 100}, Case{6, 9, 10, 100}, Case{20, 0, 10, 100},
                          Case{25, 40, 800, -1000}, Case{20, 0.002, 0, 0.1}}) {
        Random random(7);
        std::normal_distribution<double> noise(0, c.noise > 0 ? c.noise : 1);
        const DenseField field = volume_of(n, [&](const Index3& at) {
            const float value = blurred_sphere(at, n, c.radius, 1, c.outside, c.inside);
            return c.noise > 0 ? value + static_cast<float>(noise(random)) : value;
        });
        const SuggestedIso suggested = suggested_iso(field);
        const double height = std::abs(c.inside - c.outside);
        EXPECT_NEAR(suggested.iso, 0.5 * (c.inside + c.outside), 0.125 * height)
            << "radius " << c.radius << ", noise " << c.noise << ": " << suggested.reason;
    }
}

// Half a volume of tissue with structure of its own, beside air: the skin, and not the structure.
TEST(Histogram, SuggestsTheSkinOfAStructuredObject) {
    const int n = 64;
    Random random(12);
    std::normal_distribution<double> noise(0, 4);
    const DenseField field = volume_of(n, [&](const Index3& at) {
        const double tissue = 60 + 60 * ((at.x() / 5 + at.y() / 5 + at.z() / 5) % 2);
        return std::max(0.0F, blurred_sphere(at, n, 28, 1, 0, tissue) + float(noise(random)));
    });
    EXPECT_NEAR(suggested_iso(field).iso, 45, 12); // below the tissue's 60, far above the noise
}

TEST(Histogram, SuggestionOfASubsetIsThatOfTheWhole) {
    const int n = 160;
    Random random(8);
    std::normal_distribution<float> noise(0, 3);
    const DenseField field = volume_of(n, [&](const Index3& at) {
        return std::round(blurred_sphere(at, n, 50, 1, 10, 100) + noise(random));
    });
    const double whole = suggested_iso(field, subset_of(field, n * n * n)).iso;
    const double part = suggested_iso(field, subset_of(field, n * n * n / 16)).iso;
    EXPECT_NEAR(part, whole, 2); // a fortieth of the step
}

TEST(Histogram, OfALargeVolumeIsQuick) {
#ifdef ISOCAST_CHECKED
    GTEST_SKIP() << "a build with checks";
#endif
    const DenseField field = volume_of(256, [](const Index3& at) {
        return static_cast<float>((at - Index3::Constant(128)).squaredNorm() < 10000 ? 100 : 10) +
               static_cast<float>(at.x() % 7);
    });
    double least_seconds = 10;
    for (int i = 0; i < 3; ++i) { // the machine may be busy
        const auto start = std::chrono::steady_clock::now();
        const FieldSubset subset = subset_of(field);
        EXPECT_NEAR(suggested_iso(field, subset).iso, 58, 5);
        EXPECT_EQ(histogram_of(subset.values).counts.size(), 49u); // 10 … 106 in pairs
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        least_seconds = std::min(least_seconds, seconds.count());
    }
    EXPECT_LT(least_seconds, 0.3);
}

TEST(Histogram, SingleHotSamplesDoNotMatter) {
    const int n = 64;
    Random random(9);
    const DenseField plain =
        volume_of(n, [&](const Index3& at) { return blurred_sphere(at, n, 20, 1, 10, 100); });
    std::vector<float> values(plain.values().begin(), plain.values().end());
    for (int i = 0; i < 5; ++i)
        values[static_cast<std::size_t>(random_int(random, 0, n * n * n - 1))] = 30000;
    const DenseField hot(plain.space(), plain.extent(), values);
    EXPECT_NEAR(suggested_iso(hot).iso, 55, 5);
}

TEST(Histogram, DistancesSuggestTheirSurface) {
    // A torus off the axes, whose surface is not in the middle of its values.
    const auto distances = sampled(builtin_field("torus"), 48);
    EXPECT_EQ(suggested_iso(*distances).iso, 0) << suggested_iso(*distances).reason;
    const auto band = sampled(builtin_field("torus"), 48, 3);
    EXPECT_EQ(suggested_iso(*band).iso, 0);
    EXPECT_EQ(suggested_iso(to_sparse(*band)).iso, 0);
    // The same band in a file that cannot say that it is one.
    const DenseField dense(band->space(), band->extent(), copied(*band, band->extent()));
    EXPECT_EQ(suggested_iso(dense).iso, 0) << suggested_iso(dense).reason;
}

TEST(Histogram, UnsignedDistancesSuggestOneVoxel) {
    const auto band = sampled(builtin_field("torus"), 48, 3);
    const SparseField signed_field = to_sparse(*band);
    FieldBlocks blocks;
    for (const FieldBlock& block : signed_field.blocks()) {
        blocks.push_back(block);
        for (float& value : blocks.back().values) value = std::abs(value);
    }
    const SparseField field(band->space(), signed_field.background_world(), Outside::Background,
                            std::move(blocks));
    EXPECT_EQ(suggested_iso(field).iso, band->space().voxel_size_world());
}

TEST(Histogram, ConstantAndEmptyFieldsHaveASuggestion) {
    EXPECT_EQ(suggested_iso(volume_of(8, [](const Index3&) { return 7.0F; })).iso, 7);
    EXPECT_EQ(suggested_iso(SparseField(GridSpace::uniform(1), 0, Outside::Background, {})).iso, 0);
}

} // namespace
} // namespace isocast::test
