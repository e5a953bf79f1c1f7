// Certificates of blocks: no point of a block exceeds them, whatever the samples are.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/active_set.h"
#include "filtering/certificate.h"
#include "filtering/filter.h"
#include "filtering/reconstruct.h"
#include "stability/cases.h"
#include "stability/fields.h"
#include "volume/sparse_field.h"

namespace isocast::stability {

namespace {

using Samples = std::shared_ptr<const DenseField>; // a block's: sample (1, 1, 1) is its first

/// The block's 11^3 control samples.
template<class Value>
Samples block_of(Value value) {
    return unit_field(block_size + 3, value);
}

/// A random point of the block, in the samples' index space.
Vec3d in_block(Random& random) {
    return Vec3d::Constant(1 + block_size / 2.0) + random.in_cube(block_size / 2.0);
}

constexpr int stride = block_size + 3;

/// How much of its certificate a block uses up: 1 is all, more is wrong.
Worst share_of_certificate(const std::vector<Samples>& blocks) {
    Random random(1);
    Worst worst;
    for (const Samples& block : blocks)
        for (const Kernel kernel : {Kernel::Linear, Kernel::BSpline, Kernel::CatmullRom}) {
            const float* control = block->values().data();
            const Certificate c = certify_block(control, stride, stride * stride, kernel);
            const ValueRange range = range_of_block(control, stride, stride * stride, kernel);
            const double middle = 0.5 * (double{range.min} + range.max);
            const double half = 0.5 * (double{range.max} - range.min);
            for (int i = 0; i < 200; ++i) {
                const Jet jet = kernel_jet(*block, in_block(random), kernel);
                worst.see(half > 0 ? std::abs(jet.value - middle) / half
                                   : (jet.value == middle ? 1 : 2));
                if (jet.gradient.norm() > 0) worst.see(jet.gradient.norm() / c.slope);
                if (!is_smooth(kernel) || std::abs(jet.value) > c.near) continue;
                const Vec3d along = random.unit();
                const double bend = std::abs(along.dot(jet.hessian * along));
                if (bend > 0) worst.see(bend / c.bend);
            }
        }
    return worst;
}

/// Roots between random points of the block must lie in parts that may hold the surface.
Worst roots_are_in_parts(const std::vector<Samples>& blocks) {
    Random random(2);
    Worst worst;
    for (const Samples& block : blocks)
        for (const Kernel kernel : {Kernel::Linear, Kernel::BSpline, Kernel::CatmullRom}) {
            const Certificate c =
                certify_block(block->values().data(), stride, stride * stride, kernel);
            for (int i = 0; i < 200; ++i) {
                Vec3d inside = in_block(random), outside = in_block(random);
                if (kernel_value(*block, inside, kernel) > 0) std::swap(inside, outside);
                if (!(kernel_value(*block, inside, kernel) < 0) ||
                    !(kernel_value(*block, outside, kernel) > 0))
                    continue;
                for (int k = 0; k < 60; ++k) {
                    const Vec3d middle = 0.5 * (inside + outside);
                    (kernel_value(*block, middle, kernel) < 0 ? inside : outside) = middle;
                }
                const Index3 part =
                    ((inside.array() - 1) / part_size).floor().cast<int>().cwiseMin(3).matrix();
                worst.must(c.parts >> (part.x() + 4 * part.y() + 16 * part.z()) & 1);
            }
        }
    return worst;
}

std::vector<Samples> noise_blocks(double scale, double offset = 0) {
    Random random(3);
    std::vector<Samples> blocks;
    for (int i = 0; i < 6; ++i)
        blocks.push_back(
            block_of([&](const Vec3d&) { return offset + scale * random.uniform(-1, 1); }));
    return blocks;
}

/// Second differences which a difference of rounded first ones would lose.
std::vector<Samples> ripples() {
    Random random(4);
    std::vector<Samples> blocks;
    for (int i = 0; i < 6; ++i) {
        const Vec3d slope = random.in_cube(1e3);
        blocks.push_back(block_of([&](const Vec3d& p) {
            return slope.dot(p) + 1e-4 * (int(p.x() + p.y() + p.z()) % 2 ? 1 : -1);
        }));
    }
    return blocks;
}

std::vector<Samples> steps_and_spikes() {
    std::vector<Samples> blocks;
    for (int i = 0; i < 3; ++i) {
        blocks.push_back(block_of([&](const Vec3d& p) { return p[i] < 5 ? -1.0 : 1.0; }));
        blocks.push_back(
            block_of([&](const Vec3d& p) { return p == Vec3d(5, 4 + i, 6) ? -1.0 : 1e-3; }));
    }
    return blocks;
}

/// Blocks whose range holds iso, by brute force over the samples that their points read.
Worst active_set_follows(double scale) {
    Random random(5);
    const auto field = unit_field(40, [&](const Vec3d& p) {
        return scale * (std::sin(p.norm() / 3) + 0.01 * random.uniform(-1, 1));
    });
    const BlockRanges ranges = find_block_ranges(*field, Kernel::BSpline);
    ActiveSet moving(ranges, 0);
    Worst worst;
    for (int i = 0; i < 50; ++i) {
        const auto iso = static_cast<float>(scale * random.uniform(-1.2, 1.2));
        moving.move_to(iso);
        const std::vector<ActivePage> moved = moving.pages();
        const std::vector<ActivePage> anew = active_pages(ranges, iso);
        worst.must(moved.size() == anew.size());
        for (std::size_t k = 0; k < std::min(moved.size(), anew.size()); ++k)
            worst.must(moved[k].page == anew[k].page && moved[k].blocks == anew[k].blocks);
    }
    return worst;
}

/// Of a field that is the same everywhere, each block at that iso value and none at another: ranges
/// are rounded outward by 2^-20 of the greatest sample.
Worst plateau_is_active() {
    const auto flat = unit_field(24, [](const Vec3d&) { return 0.375; });
    const BlockRanges ranges = find_block_ranges(*flat, Kernel::BSpline);
    Worst worst;
    for (const ActivePage& page : active_pages(ranges, 0.375F))
        worst.must(page.blocks == ranges.pages[page.page].blocks);
    worst.must(active_pages(ranges, 0.375F).size() == ranges.pages.size());
    worst.must(active_pages(ranges, 0.375F + 0x1p-18F).empty());
    worst.must(find_active_blocks(*flat, Kernel::BSpline, 0.375F).surface_box.is_empty());
    return worst;
}

} // namespace

void append_certificate_cases(std::vector<Case>& cases) {
    const auto add = [&](const std::string& name, const char* compares, double bound,
                         const char* from, auto run) {
        cases.push_back(
            {"certificate." + name, compares, bound, from, [run](Devices&) { return run(); }});
    };
    struct Blocks {
        const char* name;
        std::function<std::vector<Samples>()> make;
    };
    for (const auto& [name, make] : {
             Blocks{"noise", [] { return noise_blocks(1); }},
             Blocks{"noise-of-1e-9", [] { return noise_blocks(1e-9); }},
             Blocks{"noise-of-1e9", [] { return noise_blocks(1e9); }},
             Blocks{"noise-of-1e-6-about-1", [] { return noise_blocks(1e-6, 1); }},
             Blocks{"ripples-on-a-slope", ripples},
             Blocks{"steps-and-spikes", steps_and_spikes},
         })
        add(name, "values, slopes and bends at random points and their certificates", 1,
            "it is a proof", [make = make] { return share_of_certificate(make()); });
    add("parts-hold-roots", "parts of roots in noise, ripples and steps and the certified parts", 0,
        "it is a proof", [] {
            Worst worst = roots_are_in_parts(noise_blocks(1));
            worst.see(roots_are_in_parts(noise_blocks(1e-9)));
            worst.see(roots_are_in_parts(ripples()));
            worst.see(roots_are_in_parts(steps_and_spikes()));
            return worst;
        });
    add("parts-hold-roots-of-denormals", "the same of samples near 2^-140", 0, "it is a proof",
        [] { return roots_are_in_parts(noise_blocks(0x1p-140)); });
    for (const double scale : {1.0, 1e-30, 1e30})
        add(scale == 1  ? "active-set-moves"
            : scale < 1 ? "active-set-of-1e-30"
                        : "active-set-of-1e30",
            "active blocks that follow an iso value and those found anew", 0, "the same blocks",
            [scale] { return active_set_follows(scale); });
    add("plateau-is-active", "active blocks of a constant at, and next to, the iso value", 0,
        "all, and none", plateau_is_active);
}

} // namespace isocast::stability
