// Tests of the blocks' ranges and of the active blocks: against the reconstructed function in
// double, and against the definition, block by block.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/blocks.h"

#include "../volume/random_fields.h"
#include "filtering/certificate.h"
#include "filtering/filter.h"
#include "filtering/reconstruct.h"
#include "volume/analytic_fields.h"
#include "volume/errors.h"
#include "volume/sparsify.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <map>

namespace isocast {
namespace {

using test::Random;

constexpr std::array kernels{Kernel::Linear, Kernel::BSpline, Kernel::CatmullRom};

/// The 11^3 samples that the points of a block read: 8b - 1 ... 8b + 9 (thesis eq. 5.1).
std::vector<float> support_of(const FieldSource& field, const Index3& block) {
    const Index3 lo = (block_size * block.array() - 1).matrix();
    return test::copied(field, {lo, (lo.array() + 11).matrix()});
}

/// By the definition, block by block and cell by cell, over the blocks of `box`.
ActiveBlocks brute_force(const FieldSource& field, Kernel kernel, float iso,
                         const IndexBox& blocks) {
    ActiveBlocks active;
    test::for_each_sample(blocks, [&](const Index3& b) {
        const std::vector<float> control = support_of(field, b);
        const ValueRange range = range_of_block(control.data(), 11, 121, kernel);
        const float margin = 1e-5F * (range.max - range.min); // as active_pages documents
        if (!(range.min - margin <= iso && iso <= range.max + margin)) return;
        active.coordinates.push_back(b);
        const IndexBox all{block_size * b, (block_size * (b.array() + 1)).matrix()};
        test::for_each_sample(all, [&](const Index3& at) {
            const IndexBox cell{at, (at.array() + 2).matrix()};
            const auto corners = test::copied(field, cell);
            const auto inside =
                std::ranges::count_if(corners, [iso](float value) { return value < iso; });
            if (inside != 0 && inside != 8)
                active.surface_box = bounding_box(active.surface_box, cell);
        });
    });
    if (!field.half_width_world())
        active.surface_box = intersection(active.surface_box, field.extent());
    return active;
}

void expect_equal(const ActiveBlocks& found, const ActiveBlocks& expected) {
    EXPECT_EQ(found.coordinates, expected.coordinates);
    EXPECT_EQ(found.surface_box, expected.surface_box);
}

/// Noise of which the greatest values are rare, so that some blocks are active and some not.
DenseField rare_peaks(Random& random, const IndexBox& extent) {
    std::vector<float> values(static_cast<std::size_t>(extent.sample_count()));
    for (float& value : values) {
        value = static_cast<float>(std::pow(test::random_real(random, 0, 1), 400.0));
    }
    return {GridSpace::uniform(1), extent, values};
}

TEST(ActiveBlocks, EqualBruteForceInADenseField) {
    Random random(1);
    for (int i = 0; i < 6; ++i) {
        const DenseField field = rare_peaks(random, test::random_box(random, -20, 10, 50));
        for (const Kernel kernel : kernels) {
            // The smoothing kernel takes most of a single peak away.
            const float iso = kernel == Kernel::BSpline ? 0.2F : 0.5F;
            const ActiveBlocks expected =
                brute_force(field, kernel, iso, blocks_over(field.extent()));
            expect_equal(find_active_blocks(field, kernel, iso), expected);
        }
    }
}

TEST(ActiveBlocks, EqualBruteForceForAnalyticFieldsThatCrossTheirBorder) {
    for (const std::string name : {"gyroid", "saddle", "marschner-lobb", "cylinder"}) {
        const auto field = sampled(builtin_field(name), 41);
        for (const Kernel kernel : kernels) {
            for (const float iso : {0.0f, 0.1f}) {
                expect_equal(find_active_blocks(*field, kernel, iso),
                             brute_force(*field, kernel, iso, blocks_over(field->extent())));
            }
        }
    }
}

TEST(ActiveBlocks, EqualBruteForceInABandIncludingBlocksThatAreNotStored) {
    for (const std::string name : {"sphere", "torus"}) {
        const SparseField field = to_sparse(*sampled(builtin_field(name), 61, 3));
        const auto half_width = static_cast<float>(*field.half_width_world());
        const IndexBox around = blocks_over(dilated(field.extent(), 16, 16));
        // Also near the rim of the band, where blocks beside the stored ones become active.
        for (const float iso : {0.0f, 0.6f * half_width, -0.98f * half_width}) {
            const ActiveBlocks expected = brute_force(field, Kernel::BSpline, iso, around);
            EXPECT_FALSE(expected.coordinates.empty());
            expect_equal(find_active_blocks(field, Kernel::BSpline, iso), expected);
        }
    }
}

TEST(ActiveBlocks, OfTheInterpolatingFilterEqualBruteForce) {
    const auto sparse =
        std::make_shared<SparseField>(to_sparse(*sampled(builtin_field("torus"), 61, 3)));
    const auto control = control_samples(sparse, Filter::Interpolating);
    expect_equal(
        find_active_blocks(*control, Kernel::BSpline, 0),
        brute_force(*control, Kernel::BSpline, 0, blocks_over(dilated(sparse->extent(), 16, 16))));
}

TEST(ActiveBlocks, OfAnUnsignedSparseFieldIncludeTheStepToItsBackground) {
    Random random(2);
    FieldBlocks blocks = test::random_blocks(random, 1, 0.3, 1.0f);
    for (FieldBlock& block : blocks) {
        for (float& value : block.values) value = std::abs(value) / 2;
    }
    const SparseField field(GridSpace::uniform(1), 1.0, Outside::Background, blocks);
    const IndexBox around = blocks_over(dilated(field.extent(), 16, 16));
    for (const Kernel kernel : kernels) {
        expect_equal(find_active_blocks(field, kernel, 0.75f),
                     brute_force(field, kernel, 0.75f, around));
    }
}

TEST(ActiveBlocks, PlateauAtTheIsoValueIsActiveAndHasNoSurface) {
    const DenseField field(GridSpace::uniform(1), {{0, 0, 0}, {16, 8, 8}},
                           std::vector<float>(16 * 8 * 8, 0.0f));
    for (const Kernel kernel : kernels) {
        const ActiveBlocks active = find_active_blocks(field, kernel, 0.0f);
        EXPECT_EQ(active.coordinates, (std::vector<Index3>{{0, 0, 0}, {1, 0, 0}}));
        EXPECT_TRUE(active.surface_box.is_empty());
        EXPECT_TRUE(find_active_blocks(field, kernel, 0.5f).coordinates.empty());
    }
}

TEST(ActiveBlocks, SurfaceBoxOfASphereIsItsBox) {
    // Radius 1 over [-1.5, 1.5] with 31 cells: an odd number.
    const auto field = sampled(builtin_field("sphere"), 32);
    const ActiveBlocks active = find_active_blocks(*field, Kernel::BSpline, 0);
    const double voxel = field->space().voxel_size_world();
    for (int axis = 0; axis < 3; ++axis) {
        const double lo = active.surface_box.lo[axis] * voxel - 1.5;
        const double hi = (active.surface_box.hi[axis] - 1) * voxel - 1.5;
        // The sphere's top cell is found if one of its corners is inside: within 1.1 voxels.
        EXPECT_NEAR(lo, -1, 1.1 * voxel);
        EXPECT_NEAR(hi, 1, 1.1 * voxel);
    }
}

/// A field that counts how often it is read.
class Counted final : public FieldSource {
public:
    explicit Counted(std::shared_ptr<const FieldSource> field) : field_(std::move(field)) {}
    const GridSpace& space() const override { return field_->space(); }
    IndexBox extent() const override { return field_->extent(); }
    std::optional<double> half_width_world() const override { return field_->half_width_world(); }
    std::vector<IndexBox> active_boxes() const override { return field_->active_boxes(); }
    int finest_level(const IndexBox& box) const override { return field_->finest_level(box); }
    ValueRange value_range(const IndexBox& box) const override { return field_->value_range(box); }
    void copy_box(const IndexBox& box, int level, std::span<float> out) const override {
        ++reads;
        field_->copy_box(box, level, out);
    }

    mutable std::atomic<int> reads = 0;

private:
    std::shared_ptr<const FieldSource> field_;
};

TEST(ActiveBlocks, OfAClosedSurfaceFewAreReadAgainForItsBox) {
    const Counted field(sampled(builtin_field("sphere"), 260));
    const BlockRanges ranges = find_block_ranges(field, Kernel::BSpline);
    const std::vector<ActivePage> active = active_pages(ranges, 0);
    field.reads = 0;
    const IndexBox box = find_surface_box(field, ranges, active, 0);
    // Those where the sphere touches its box are: six caps, of a surface of 100 pages.
    EXPECT_LT(field.reads, static_cast<int>(active.size()) / 2);
    // Where there is no surface all are.
    field.reads = 0;
    EXPECT_TRUE(find_surface_box(field, ranges, active, -100).is_empty());
    EXPECT_EQ(field.reads, static_cast<int>(active.size()));
    EXPECT_FALSE(box.is_empty());
}

TEST(ActiveBlocks, DoNotDependOnTheNumberOfThreads) {
    const SparseField field = to_sparse(*sampled(builtin_field("torus"), 61, 3));
    const ActiveBlocks many = find_active_blocks(field, Kernel::BSpline, 0);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    expect_equal(find_active_blocks(field, Kernel::BSpline, 0), many);
}

TEST(ActiveBlocks, StopWhenInterrupted) {
    // 64 pages at least, after which progress is told.
    const auto field = sampled(builtin_field("gyroid"), 130);
    EXPECT_THROW(find_active_blocks(*field, Kernel::BSpline, 0,
                                    [](std::string_view, double) { throw Interrupted(); }),
                 Interrupted);
}

/// Fields of very different kinds, and what each is called.
std::vector<std::pair<std::string, std::shared_ptr<const FieldSource>>> fields_of_all_kinds() {
    Random random(5);
    std::vector<std::pair<std::string, std::shared_ptr<const FieldSource>>> fields{
        {"gyroid", sampled(builtin_field("gyroid"), 33)},
        {"marschner-lobb", sampled(builtin_field("marschner-lobb"), 33)},
        {"band", std::make_shared<SparseField>(to_sparse(*sampled(builtin_field("torus"), 49, 3)))},
        {"noise", std::make_shared<DenseField>(
                      test::random_dense(random, {Index3::Constant(-5), Index3::Constant(20)}))},
        {"peaks", std::make_shared<DenseField>(
                      rare_peaks(random, {Index3::Constant(-5), Index3::Constant(20)}))}};
    fields.emplace_back("interpolating", control_samples(fields[2].second, Filter::Interpolating));
    return fields;
}

TEST(BlockRanges, HoldTheReconstructedFunction) {
    Random random(3);
    for (const auto& [name, field] : fields_of_all_kinds()) {
        for (const Kernel kernel : kernels) {
            for (const BlockPage& page : find_block_ranges(*field, kernel).pages) {
                for (int place = 0; place < blocks_per_page; ++place) {
                    const Index3 block = page_blocks * page.coordinate +
                                         Index3(place % 4, place / 4 % 4, place / 16);
                    const ValueRange range = page.ranges[static_cast<std::size_t>(place)];
                    for (int i = 0; i < 60; ++i) {
                        Vec3d p = block_size * block.cast<double>() +
                                  test::random_point(random, 0, block_size);
                        // Corners of cells too, where the B-spline reaches its hull.
                        if (i % 4 == 0) p = p.array().floor();
                        const double value = kernel_value(*field, p, kernel);
                        // Sums of 64 products in double round by 2^-50 of values of 1 or so.
                        ASSERT_GE(value, range.min - 1e-15) << name << " at " << p.transpose();
                        ASSERT_LE(value, range.max + 1e-15) << name << " at " << p.transpose();
                    }
                }
            }
        }
    }
}

TEST(BlockRanges, AreNoWiderThanTheControlSamplesAndOfLinearTheSamplesThemselves) {
    for (const auto& [name, field] : fields_of_all_kinds()) {
        for (const Kernel kernel : {Kernel::Linear, Kernel::BSpline}) {
            for (const BlockPage& page : find_block_ranges(*field, kernel).pages) {
                for (int place = 0; place < blocks_per_page; ++place) {
                    const Index3 block = page_blocks * page.coordinate +
                                         Index3(place % 4, place / 4 % 4, place / 16);
                    const bool is_linear = kernel == Kernel::Linear;
                    const Index3 lo = (block_size * block.array() - (is_linear ? 0 : 1)).matrix();
                    const auto values =
                        test::copied(*field, {lo, (lo.array() + (is_linear ? 9 : 11)).matrix()});
                    const auto [min, max] = std::ranges::minmax(values);
                    const ValueRange range = page.ranges[static_cast<std::size_t>(place)];
                    // 2^-20: how far ranges are rounded outward (certificate.cpp); the hull's own
                    // roundings are a dozen of 2^-24.
                    const float slack = 0x1p-19F * std::max(std::abs(min), std::abs(max));
                    ASSERT_GE(range.min, min - slack) << name;
                    ASSERT_LE(range.max, max + slack) << name;
                    if (!is_linear) continue;
                    ASSERT_LE(range.min, min) << name;
                    ASSERT_GE(range.max, max) << name;
                }
            }
        }
    }
}

/// Samples the function `rate` times per voxel along lines along each axis, and expects each sign
/// change in an active block, there in a part that its certificate says can hold the surface.
/// Returns how many there were.
int expect_roots_in_active_parts(const FieldSource& field, Kernel kernel, float iso, int rate) {
    std::map<std::array<int, 3>, std::uint64_t> parts_of_blocks;
    for (const Index3& b : find_active_blocks(field, kernel, iso).coordinates) {
        std::vector<float> control = support_of(field, b);
        for (float& value : control) value -= iso;
        parts_of_blocks[{b.x(), b.y(), b.z()}] =
            certify_block(control.data(), 11, 121, kernel).parts;
    }
    const auto is_active = [&](const Vec3d& p_index) {
        const Index3 cell = p_index.array().floor().cast<int>().matrix();
        const Index3 b = floor_div(cell, block_size);
        const auto found = parts_of_blocks.find({b.x(), b.y(), b.z()});
        if (found == parts_of_blocks.end()) return false;
        const Index3 part = (cell - block_size * b) / part_size;
        return (found->second >> (part.x() + 4 * part.y() + 16 * part.z()) & 1U) != 0;
    };
    const Vec3d lo = field.extent().lo.cast<double>();
    const Vec3d size = (field.extent().size().array() - 1).matrix().cast<double>();
    int roots = 0;
    for (int axis = 0; axis < 3; ++axis) {
        for (double u = 0.37; u < size[(axis + 1) % 3]; u += 2.3) {
            for (double v = 0.71; v < size[(axis + 2) % 3]; v += 2.9) {
                Vec3d before = lo;
                before[(axis + 1) % 3] += u;
                before[(axis + 2) % 3] += v;
                double value_before = kernel_value(field, before, kernel) - iso;
                const int steps = static_cast<int>(size[axis]) * rate;
                for (int step = 1; step <= steps; ++step) {
                    Vec3d p = before;
                    p[axis] = lo[axis] + static_cast<double>(step) / rate;
                    const double value = kernel_value(field, p, kernel) - iso;
                    if ((value < 0) != (value_before < 0)) {
                        ++roots;
                        Vec3d a = before;
                        Vec3d b = p;
                        for (int i = 0; i < 45; ++i) { // to an ulp or so
                            const Vec3d middle = (a + b) / 2;
                            const bool same = (kernel_value(field, middle, kernel) - iso < 0) ==
                                              (value_before < 0);
                            (same ? a : b) = middle;
                        }
                        EXPECT_TRUE(is_active(a) || is_active(b)) << a.transpose();
                    }
                    before = p;
                    value_before = value;
                }
            }
        }
    }
    return roots;
}

TEST(ActiveBlocks, HoldEveryRootInABandInAPartThatCanHoldIt) {
    const auto torus =
        std::make_shared<SparseField>(to_sparse(*sampled(builtin_field("torus"), 61, 3)));
    for (const Kernel kernel : kernels) {
        EXPECT_GT(expect_roots_in_active_parts(*torus, kernel, 0, 3), 500);
        // Near the rim, where the band's edge is a kink.
        EXPECT_GT(expect_roots_in_active_parts(
                      *torus, kernel, 0.9f * static_cast<float>(torus->background_world()), 3),
                  500);
    }
    EXPECT_GT(expect_roots_in_active_parts(*control_samples(torus, Filter::Interpolating),
                                           Kernel::BSpline, 0, 3),
              500);
}

TEST(ActiveBlocks, HoldEveryRootOfAFieldThatCrossesItsBorder) {
    for (const std::string name : {"gyroid", "saddle", "marschner-lobb"}) {
        for (const Kernel kernel : kernels) {
            EXPECT_GT(expect_roots_in_active_parts(*sampled(builtin_field(name), 41), kernel, 0, 3),
                      100)
                << name;
        }
    }
}

TEST(ActiveBlocks, HoldEveryRootOfNoise) {
    Random random(4);
    const DenseField field =
        test::random_dense(random, {Index3::Constant(-3), Index3::Constant(22)});
    for (const Kernel kernel : kernels)
        EXPECT_GT(expect_roots_in_active_parts(field, kernel, 0.1F, 6), 500);
}

} // namespace
} // namespace isocast
