// Fields of blocks of several resolutions: one spline, without cracks.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/coarsened_field.h"

#include "../volume/random_fields.h"
#include "filtering/reconstruct.h"
#include "filtering/subdivision.h"

#include <gtest/gtest.h>

#include <map>

namespace isocast {
namespace {

using namespace test;

DenseField dense_of(const std::vector<double>& samples, const IndexBox& box) {
    return {GridSpace::uniform(1), box, std::vector<float>(samples.begin(), samples.end())};
}

double difference(const Jet& a, const Jet& b) {
    return std::max({std::abs(a.value - b.value), (a.gradient - b.gradient).cwiseAbs().maxCoeff(),
                     (a.hessian - b.hessian).cwiseAbs().maxCoeff()});
}

TEST(Subdivision, LeavesTheFunctionAsItIs) {
    Random random(1);
    const IndexBox box{Index3(-3, 2, 5), Index3(6, 9, 13)};
    const DenseField coarse = random_dense(random, coarse_support(box));
    const std::vector<float> values = copied(coarse, coarse.extent());
    const DenseField fine = dense_of(subdivided({values.begin(), values.end()}, box), box);
    for (int i = 0; i < 200; ++i) {
        // Where all 4^3 samples lie in the box.
        Vec3d p;
        for (int axis = 0; axis < 3; ++axis)
            p[axis] = random_real(random, box.lo[axis] + 1, box.hi[axis] - 2);
        Jet expected = tricubic_jet(coarse, p / 2);
        expected.gradient /= 2;
        expected.hessian /= 4;
        // Samples of 1 are rounded by 2^-25; the sizes of a second derivative's weights sum up
        // to 4.
        EXPECT_LT(difference(tricubic_jet(fine, p), expected), 4 * 0x1p-24);
    }
}

TEST(CoarseSamples, GiveTheSameCubicAtEveryLevel) {
    // c = p - (Laplacian of p)/6 are control samples of the cubic p.
    const auto cubic = [](const Vec3d& p) {
        const double x = p.x() / 16, y = p.y() / 16, z = p.z() / 16;
        return x * x * x - 2 * x * x * y + y * y * z + x * y * z + z * z - x + 0.5;
    };
    const auto laplacian = [](const Vec3d& p) {
        const double x = p.x() / 16, y = p.y() / 16, z = p.z() / 16;
        return (6 * x - 4 * y + 2 * z + 2) / 256;
    };
    const IndexBox extent{Index3::Constant(-40), Index3::Constant(41)};
    std::vector<double> values;
    for_each_sample(extent, [&](const Index3& i) {
        const Vec3d p = i.cast<double>();
        values.push_back(cubic(p) - laplacian(p) / 6);
    });
    const DenseField control = dense_of(values, extent);
    Random random(2);
    for (int level = 1; level <= coarsest_level; ++level) {
        const IndexBox box{Index3::Constant(-3), Index3::Constant(4)};
        const DenseField coarse = dense_of(coarse_samples(control, box, level), box);
        for (int i = 0; i < 50; ++i) {
            const Vec3d p = random_point(random, -1, 1) * (1 << level);
            // Values up to 16 (at the box's corners) round by 2^-20, and weigh 1 + 12/6.
            EXPECT_NEAR(tricubic_value(coarse, p / (1 << level)), cubic(p), 3 * 0x1p-20) << level;
        }
    }
}

/// Noise all around the blocks of [-4, 4)^3, as far as their coarse samples read.
std::shared_ptr<const FieldSource> noise_from(unsigned seed) {
    Random random(seed);
    return std::make_shared<DenseField>(
        random_dense(random, {Index3::Constant(-64), Index3::Constant(64)}));
}

/// The noise with random levels of those blocks.
std::shared_ptr<const CoarsenedField> of_all_levels(std::shared_ptr<const FieldSource> noise,
                                                    unsigned seed) {
    Random random(seed);
    BlockLevels levels;
    for_each_sample({Index3::Constant(-4), Index3::Constant(4)}, [&](const Index3& block) {
        levels.set(block, random_int(random, 0, coarsest_level));
    });
    return std::make_shared<CoarsenedField>(std::move(noise), std::move(levels));
}

/// What is stored of a block.
DenseField stored(const CoarsenedField& field, const Index3& block, int level) {
    const int n = block_size >> level;
    const IndexBox box{(n * block.array() - 1).matrix(), (n * (block.array() + 1) + 2).matrix()};
    return dense_of(field.samples_at(box, level), box);
}

/// The jet [per voxel] at a point of a block or of its faces, from what is stored of it alone.
Jet jet_from_stored(const DenseField& samples, int level, const Vec3d& p_index) {
    const double step = 1 << level;
    const Vec3d p = p_index / step;
    // A point of the upper face belongs to the last cell.
    const Index3 last = (samples.extent().hi.array() - 3).matrix();
    Index3 cell;
    for (int axis = 0; axis < 3; ++axis)
        cell[axis] = std::min(static_cast<int>(std::floor(p[axis])), last[axis]);
    std::array<std::array<double, 4>, 3> w, d1, d2;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<Eigen::Index>(axis);
        const double a = p[k] - cell[k];
        w[axis] = bspline_weights(a);
        d1[axis] = bspline_weights_d1(a);
        d2[axis] = bspline_weights_d2(a);
    }
    const Index3 lo = (cell.array() - 1).matrix();
    const std::vector<float> support = copied(samples, {lo, (lo.array() + 4).matrix()});
    Jet jet{};
    for (std::size_t i = 0; i < 64; ++i) {
        const std::size_t x = i % 4, y = i / 4 % 4, z = i / 16;
        const double c = support[i];
        jet.value += c * w[0][x] * w[1][y] * w[2][z];
        jet.gradient += c / step *
                        Vec3d(d1[0][x] * w[1][y] * w[2][z], w[0][x] * d1[1][y] * w[2][z],
                              w[0][x] * w[1][y] * d1[2][z]);
        const double xy = d1[0][x] * d1[1][y] * w[2][z];
        const double xz = d1[0][x] * w[1][y] * d1[2][z];
        const double yz = w[0][x] * d1[1][y] * d1[2][z];
        Mat3d hessian;
        hessian << d2[0][x] * w[1][y] * w[2][z], xy, xz, xy, w[0][x] * d2[1][y] * w[2][z], yz, xz,
            yz, w[0][x] * w[1][y] * d2[2][z];
        jet.hessian += c / (step * step) * hessian;
    }
    return jet;
}

TEST(CoarsenedField, HasNoCrackAtFacesEdgesAndCorners) {
    double greatest = 0;
    double greatest_without = 0;
    std::map<std::pair<int, int>, int> pairs; // by kind of contact and difference of levels
    for (unsigned seed = 3; seed <= 4; ++seed) {
        const auto noise = noise_from(seed);
        const auto field = of_all_levels(noise, seed);
        // The same blocks with their own samples, not subdivided from their neighbours'.
        const auto alone = [&](const Index3& block, int level) {
            BlockLevels levels;
            levels.set(block, level);
            return stored(CoarsenedField(noise, levels), block, level);
        };
        Random random(seed);
        for_each_sample({Index3::Constant(-3), Index3::Constant(3)}, [&](const Index3& a) {
            const int level_a = field->levels().at(a);
            const DenseField stored_a = stored(*field, a, level_a);
            for_each_sample({Index3::Constant(-1), Index3::Constant(2)}, [&](const Index3& step) {
                const int axes = step.cwiseAbs().sum();
                if (axes == 0) return;
                const Index3 b = a + step;
                const int level_b = field->levels().at(b);
                // A point of the face, edge or corner that they share.
                Vec3d p;
                for (int axis = 0; axis < 3; ++axis) {
                    p[axis] = step[axis] == 0  ? 8 * a[axis] + random_real(random, 0, 8)
                              : step[axis] > 0 ? 8 * b[axis]
                                               : 8 * a[axis];
                }
                ++pairs[{axes, std::abs(level_a - level_b)}];
                const Jet jet_a = jet_from_stored(stored_a, level_a, p);
                const Jet jet_b = jet_from_stored(stored(*field, b, level_b), level_b, p);
                greatest = std::max(greatest, difference(jet_a, jet_b));
                if (seed == 3 && a.sum() == 0 && level_a != level_b) {
                    greatest_without =
                        std::max(greatest_without,
                                 difference(jet_from_stored(alone(a, level_a), level_a, p),
                                            jet_from_stored(alone(b, level_b), level_b, p)));
                }
            });
        });
    }
    for (int axes = 1; axes <= 3; ++axes) {
        for (int levels = 0; levels <= coarsest_level; ++levels)
            EXPECT_GT((pairs[{axes, levels}]), 20) << axes << ", " << levels;
    }
    // Samples reach 3; each level rounds them by 2^-23, three at most; weights of a second
    // derivative sum up to 4, on both sides.
    EXPECT_LT(greatest, 3 * 0x1p-23 * 4 * 2);
    EXPECT_GT(greatest_without, 0.1) << "blocks by themselves do not fit";
}

TEST(CoarsenedField, IsTheSplineOfWhatIsStored) {
    const auto field = of_all_levels(noise_from(5), 5);
    Random random(5);
    double greatest = 0;
    for_each_sample({Index3::Constant(-2), Index3::Constant(2)}, [&](const Index3& block) {
        const int level = field->levels().at(block);
        const DenseField samples = stored(*field, block, level);
        for (int i = 0; i < 20; ++i) {
            const Vec3d p = 8 * block.cast<double>() + random_point(random, 0, 8);
            greatest = std::max(
                greatest, difference(jet_from_stored(samples, level, p), tricubic_jet(*field, p)));
        }
    });
    EXPECT_LT(greatest, 3 * 0x1p-23 * 4 * 2); // as above
}

TEST(CoarsenedField, IsTheFieldBeforeBeyondOneSampleOfCoarseBlocks) {
    Random random(6);
    const auto noise = std::make_shared<DenseField>(
        random_dense(random, {Index3::Constant(-40), Index3::Constant(40)}));
    BlockLevels levels;
    levels.set({0, 0, 0}, 2);
    levels.set({1, 0, 0}, 1);
    const CoarsenedField field(noise, levels);
    const IndexBox near{Index3(-1, -1, -1), Index3(18, 10, 10)};
    const IndexBox box{Index3::Constant(-12), Index3::Constant(28)};
    const std::vector<float> before = copied(*noise, box);
    const std::vector<float> after = copied(field, box);
    std::size_t i = 0;
    int changed = 0;
    for_each_sample(box, [&](const Index3& index) {
        if (!near.contains(index)) {
            EXPECT_EQ(before[i], after[i]) << index.transpose();
        }
        changed += before[i] != after[i];
        ++i;
    });
    EXPECT_GT(changed, 0.9 * double(near.sample_count()));
}

TEST(CoarsenedField, SamplesDoNotDependOnTheBoxTheyAreAskedIn) {
    const auto field = of_all_levels(noise_from(7), 7);
    Random random(7);
    for (int level = 0; level <= coarsest_level; ++level) {
        const IndexBox all{Index3::Constant(-40 >> level), Index3::Constant(40 >> level)};
        const std::vector<double> samples = field->samples_at(all, level);
        for (int i = 0; i < 20; ++i) {
            const IndexBox box =
                intersection(random_box(random, all.lo.x(), all.hi.x() - 1, 12), all);
            const std::vector<double> part = field->samples_at(box, level);
            std::size_t k = 0;
            for_each_sample(box, [&](const Index3& index) {
                const Index3 at = index - all.lo;
                const Index3 n = all.size();
                ASSERT_EQ(
                    part[k++],
                    samples[static_cast<std::size_t>(at.x() + n.x() * (at.y() + n.y() * at.z()))]);
            });
        }
    }
}

TEST(CoarsenedField, IsBackgroundBeyondItsActiveBoxesAndInItsRange) {
    for (unsigned seed = 8; seed <= 12; ++seed) {
        Random random(seed);
        constexpr float background = 0.75F;
        const auto sparse = std::make_shared<SparseField>(
            GridSpace::uniform(0.25), background, Outside::SignedBackground,
            random_blocks(random, 2, 0.2, background));
        BlockLevels levels;
        for (int i = 0; i < 20; ++i) {
            levels.set(
                {random_int(random, -3, 3), random_int(random, -3, 3), random_int(random, -3, 3)},
                random_int(random, 1, coarsest_level));
        }
        const CoarsenedField field(sparse, levels);
        const IndexBox box{Index3::Constant(-40), Index3::Constant(40)};
        std::vector<std::uint8_t> is_active(static_cast<std::size_t>(box.sample_count()));
        for (const IndexBox& active : field.active_boxes()) {
            for_each_sample(intersection(active, box), [&](const Index3& index) {
                const Index3 at = index - box.lo;
                auto& count =
                    is_active[static_cast<std::size_t>(at.x() + 80 * at.y() + 6400 * at.z())];
                ++count;
                EXPECT_EQ(count, 1) << "boxes overlap";
            });
        }
        const std::vector<float> samples = copied(field, box);
        const ValueRange range = field.value_range(box);
        int beyond = 0;
        for (std::size_t i = 0; i < samples.size(); ++i) {
            EXPECT_GE(samples[i], range.min);
            EXPECT_LE(samples[i], range.max);
            if (is_active[i] != 0) continue;
            ++beyond;
            EXPECT_EQ(std::abs(samples[i]), background);
        }
        EXPECT_GT(beyond, 1000);
    }
}

} // namespace
} // namespace isocast
