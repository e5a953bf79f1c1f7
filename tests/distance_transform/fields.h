// What the tests of the transform share: data, samples of a field, comparison with the truth.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/convert.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <mutex>

namespace isocast::test {

inline std::filesystem::path shared_data(const std::string& name) {
    return std::filesystem::path(ISOCAST_SHARED_DATA) / name;
}

/// A sample of the band.
struct BandSample {
    Index3 index;
    float value;
};

inline std::vector<BandSample> band_samples(const SparseField& field) {
    std::vector<BandSample> samples;
    for (const FieldBlock& block : field.blocks())
        for (int i = 0; i < samples_per_block; ++i)
            if (block.active[i])
                samples.push_back({block_size * block.coordinate + Index3(i % 8, i / 8 % 8, i / 64),
                                   block.values[i]});
    return samples;
}

/// The band's samples by z, y, x, with the index moved by `shift`.
inline std::map<std::array<int, 3>, float> band_map(const SparseField& field,
                                                    const Index3& shift = Index3::Zero()) {
    std::map<std::array<int, 3>, float> map;
    for (const BandSample& sample : band_samples(field)) {
        const Index3 p = sample.index + shift;
        map[{p.z(), p.y(), p.x()}] = sample.value;
    }
    return map;
}

inline float ulp(float x) {
    return std::nextafter(std::abs(x), std::numeric_limits<float>::infinity()) - std::abs(x);
}

struct Comparison {
    std::int64_t samples = 0;
    double worst_error_voxels = 0; // beyond half a unit in the last place of the float value
    std::int64_t wrong_signs = 0;
};

/// Compares all samples of the band with `truth(p_world)`, a signed distance in double.
template<class Truth>
Comparison compare(const SparseField& field, const Truth& truth) {
    const std::vector<BandSample> samples = band_samples(field);
    const double voxel = field.space().voxel_size_world();
    Comparison result{.samples = std::ssize(samples)};
    std::mutex mutex;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, samples.size(), 256), [&](auto& range) {
        double worst = 0;
        std::int64_t wrong = 0;
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            const auto& [index, value] = samples[i];
            const double expected = truth(field.space().to_world(index.cast<double>()));
            // A value that is no number must not slip through comparisons.
            const double error = std::isfinite(value)
                                     ? std::abs(std::abs(double{value}) - std::abs(expected))
                                     : std::numeric_limits<double>::infinity();
            worst = std::max(worst, (error - ulp(value) / 2.0) / voxel);
            // 1e-9 voxel: nearer to the surface the oracle's own rounding decides.
            if (std::abs(expected) > 1e-9 * voxel && std::signbit(value) != (expected < 0)) ++wrong;
        }
        const std::lock_guard lock(mutex);
        result.worst_error_voxels = std::max(result.worst_error_voxels, worst);
        result.wrong_signs += wrong;
    });
    return result;
}

/// 1e-5 voxel: what the project promises; double arithmetic leaves 1e-12 or so.
inline void expect_exact(const Comparison& comparison) {
    EXPECT_GT(comparison.samples, 0);
    EXPECT_LT(comparison.worst_error_voxels, 1e-5);
    EXPECT_EQ(comparison.wrong_signs, 0);
    ::testing::Test::RecordProperty("worst_error_voxels",
                                    std::to_string(comparison.worst_error_voxels * 1e9) + "e-9");
}

inline ConvertResult convert_at(const CheckedMesh& mesh, int resolution) {
    return convert(
        mesh, {.voxel_size_world = voxel_size_for_resolution(bounding_box(mesh.mesh), resolution)});
}

/// Two fields hold the same band; values may differ in the last place, since sums in another order
/// round differently in double and so, rarely, to the neighbouring float.
inline void expect_same_band(const std::map<std::array<int, 3>, float>& a,
                             const std::map<std::array<int, 3>, float>& b) {
    ASSERT_EQ(a.size(), b.size());
    for (auto ia = a.begin(), ib = b.begin(); ia != a.end(); ++ia, ++ib) {
        ASSERT_EQ(ia->first, ib->first);
        ASSERT_NEAR(ia->second, ib->second, ulp(ia->second));
    }
}

} // namespace isocast::test
