// The production field functions on the GL against their double twins.
// SPDX-License-Identifier: MPL-2.0
#include "../volume/random_fields.h"
#include "filtering/reconstruct.h"
#include "raycaster/fetch_choice.h"
#include "raycaster/passes.h"
#include "test_context.h"
#include "volume/analytic_fields.h"

#include <glad/gl.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>
#include <utility>

namespace isocast {
namespace {

using test::Random;

/// Twin of Probe in field_probe.comp.
struct Probe {
    Eigen::Vector4f p_local;
    Eigen::Vector4f direction;
};
/// Twin of Result.
struct Result {
    Eigen::Vector4f value_and_slope;
    Eigen::Vector4f gradient;
    Eigen::Vector4f fast;
    Eigen::Vector4f fast_gradient;
};
static_assert(sizeof(Probe) == 32 && sizeof(Result) == 64);

struct Setting {
    Kernel kernel;
    StorageOptions storage;
};

std::string name_of(const testing::TestParamInfo<Setting>& test) {
    constexpr std::array kernels{"Linear", "BSpline", "CatmullRom"};
    constexpr std::array fetches{"Rows", "Samples", "Linear"};
    constexpr std::array formats{"Float32", "Float16", "Norm16"};
    const auto& [kernel, storage] = test.param;
    return std::string(kernels[static_cast<std::size_t>(kernel)]) +
           fetches[static_cast<std::size_t>(storage.fetch)] +
           formats[static_cast<std::size_t>(storage.format)] + std::to_string(storage.brick_size) +
           (storage.fraction_bits > 0 ? "Fractions" + std::to_string(storage.fraction_bits) : "");
}

/// Every kernel, fetch and format; brick sizes in turn. Linear fetches with full fractions, as
/// llvmpipe has them, and with those of 8 bits.
std::vector<Setting> settings() {
    std::vector<Setting> all;
    for (const Kernel kernel : {Kernel::Linear, Kernel::BSpline, Kernel::CatmullRom})
        for (const auto& [fetch, bits] : {std::pair{Fetch::Rows, 0}, std::pair{Fetch::Samples, 0},
                                          std::pair{Fetch::Linear, 0}, std::pair{Fetch::Linear, 8}})
            for (const SampleFormat format :
                 {SampleFormat::Float32, SampleFormat::Float16, SampleFormat::Norm16})
                all.push_back({kernel,
                               {.fetch = fetch,
                                .format = format,
                                .brick_size = 8 << (all.size() + all.size() / 3) % 3,
                                .fraction_bits = bits}});
    return all;
}

/// The greatest sum of |weights| over a point's 4^3 samples, and of |weights derived along one
/// axis| [1/voxel]: what errors of samples and roundings grow by.
struct Hull {
    double value;
    double derivative;
};

Hull hull_of(Kernel kernel) {
    double value = 0;
    double derivative = 0;
    for (int i = 0; i <= 256; ++i) {
        double sum = 0;
        double sum_d1 = 0;
        for (const double w : kernel_weights(kernel, i / 256.0)) sum += std::abs(w);
        for (const double w : kernel_weights_d1(kernel, i / 256.0)) sum_d1 += std::abs(w);
        value = std::max(value, sum);
        derivative = std::max(derivative, sum_d1);
    }
    return {value * value * value, value * value * derivative};
}

class Tricubic : public testing::TestWithParam<Setting> {
protected:
    std::unique_ptr<gl::Context> context = test::make_context();

    /// Runs field_probe.comp at seeded points of the extent and compares with kernel_jet.
    void expect_equal_to_twin(const FieldSource& field, float iso);
};

/// Points of a lattice of 2^-12 voxel, so that coordinates do not round; half of them within a
/// voxel of a block's border, some exactly on samples and borders.
std::vector<Probe> probes_of(const FieldSource& field, const Index3& origin) {
    Random random(11);
    const Vec3d lo = field.extent().lo.cast<double>();
    const Vec3d hi = (field.extent().hi.array() - 1).matrix().cast<double>();
    std::vector<Probe> probes;
    for (int i = 0; i < 6000; ++i) {
        Vec3d p = lo + test::random_point(random, 0, 1).cwiseProduct(hi - lo);
        if (i % 2 == 0) {
            const int axis = i / 2 % 3;
            const double border = block_size * std::round(p[axis] / block_size);
            const double near = border + test::random_real(random, -1, 1);
            p[axis] = std::clamp(i % 16 == 0 ? border : near, lo[axis], hi[axis]);
        }
        if (i % 100 == 0) p = p.array().round();
        p = (0x1p12 * p).array().round() * 0x1p-12;
        Probe probe{Eigen::Vector4f::Zero(), Eigen::Vector4f::Zero()};
        probe.p_local.head<3>() = (p - origin.cast<double>()).cast<float>();
        probe.direction.head<3>() = test::random_point(random, -1, 1).normalized().cast<float>();
        probes.push_back(probe);
    }
    return probes;
}

void Tricubic::expect_equal_to_twin(const FieldSource& field, float iso) {
    const auto& [kernel, storage] = GetParam();
    const BlockRanges ranges = find_block_ranges(field, kernel);
    const std::vector<ActivePage> active = active_pages(ranges, iso);
    const FieldOnGpu on_gpu(field, field, kernel, ranges, active, iso, storage, {});
    const BrickPool& pool = on_gpu.pool();
    const Index3 origin = on_gpu.local_origin_index();

    const std::filesystem::path source(ISOCAST_SOURCE_DIR);
    gl::ShaderLibrary shaders({source / "shaders", source / "tests/shaders"});
    const gl::Program& program = shaders.program({{"field_probe.comp"}, pool.defines()});
    on_gpu.bind(program);
    program.set("u_world_from_stored", pool.world_from_stored());
    const std::vector<Probe> probes = probes_of(field, origin);
    const gl::Buffer in(std::as_bytes(std::span(probes)), "probes");
    std::vector<Result> results(probes.size());
    const gl::Buffer out(std::as_bytes(std::span(results)), "results");
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, in.id());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, out.id());
    program.use();
    glDispatchCompute(GLuint(probes.size() + 63) / 64, 1, 1);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(out.id(), 0, GLsizeiptr(results.size() * sizeof(results[0])),
                            results.data());

    std::set<std::array<int, 3>> active_blocks;
    for (const Index3& b : find_active_blocks(field, kernel, iso).coordinates)
        active_blocks.insert({b.x(), b.y(), b.z()});

    // The renderer reckons with errors of evaluation of 2^-20 of the greatest sample: sixteen
    // roundings of a sum of 64 products. Stored samples err by storage_error(). Norm16 is read as
    // code/65535 between 0 and 1, four times the greatest |sample| at most, before zero is taken
    // off.
    const Hull hull = hull_of(kernel);
    const double size = storage.format == SampleFormat::Norm16 ? 4 : 1;
    const double rounding = 0x1p-20 * size * pool.greatest_value();
    const double value_tolerance = rounding + hull.value * pool.storage_error();
    const double derivative_tolerance = hull.derivative * (rounding + pool.storage_error());
    double worst_value = 0;
    double worst_slope = 0;
    double worst_gradient = 0;
    const bool has_full_fractions =
        storage.fraction_bits == 0 && is_software_rasteriser(context->driver().renderer);
    const bool has_fetch_error = storage.fetch == Fetch::Linear && kernel != Kernel::CatmullRom;
    double worst_fast_value = 0; // of what fetch_error() allows
    double worst_fast_slope = 0;
    double fast_value_error = 0; // world
    int count = 0;
    for (std::size_t i = 0; i < probes.size(); ++i) {
        const Vec3d p = probes[i].p_local.head<3>().cast<double>() + origin.cast<double>();
        const Index3 b = (p / block_size).array().floor().matrix().cast<int>();
        const bool is_active = active_blocks.contains({b.x(), b.y(), b.z()});
        ASSERT_EQ(results[i].value_and_slope.z() != 0, is_active) << p.transpose();
        if (!is_active) {
            EXPECT_EQ(results[i].gradient, Eigen::Vector4f::Zero());
            continue;
        }
        ++count;
        const Jet jet = kernel_jet(field, p, kernel);
        const Vec3d gradient = results[i].gradient.head<3>().cast<double>();
        const double unit = pool.world_from_stored();
        const double value = unit * results[i].value_and_slope.x();
        const double slope = unit * results[i].value_and_slope.y();
        worst_value = std::max(worst_value, std::abs(value - (jet.value - iso)));
        worst_gradient = std::max(worst_gradient, (gradient - jet.gradient).cwiseAbs().maxCoeff());
        worst_slope = std::max(
            worst_slope,
            std::abs(slope - jet.gradient.dot(probes[i].direction.head<3>().cast<double>())));

        const Result& r = results[i];
        if (!has_fetch_error) {
            ASSERT_EQ(r.fast.z(), 0);
            ASSERT_EQ(r.fast.head<2>(), r.value_and_slope.head<2>());
            ASSERT_EQ(r.fast_gradient, r.gradient);
            continue;
        }
        // With what the exact sums are allowed, docs/raycasting.md allows values fetch_error() and
        // slopes eight times that. Of it 2^-9 is due to 8 bits; llvmpipe's fractions are full, and
        // of textures up to 512 texels along an axis, as these, 2^-22 * 512 remains, a sixteenth.
        const double bound = unit * r.fast.z();
        const double value_bound = has_full_fractions ? bound / 16 : bound;
        const double value_off = std::abs(unit * r.fast.x() - (jet.value - iso));
        const double slope_off = std::max(
            (r.fast_gradient.head<3>().cast<double>() - jet.gradient).cwiseAbs().maxCoeff(),
            std::abs(unit * r.fast.y() -
                     jet.gradient.dot(probes[i].direction.head<3>().cast<double>())));
        fast_value_error = std::max(fast_value_error, value_off);
        worst_fast_value = std::max(worst_fast_value, (value_off - value_tolerance) / value_bound);
        worst_fast_slope = std::max(
            worst_fast_slope, (slope_off - std::sqrt(3.0) * derivative_tolerance) / (8 * bound));
    }
    EXPECT_GT(count, 1500);
    const auto in_units = [&](double error) {
        return std::to_string(error / (0x1p-20 * pool.greatest_value()));
    };
    RecordProperty("value_error", in_units(worst_value));
    RecordProperty("slope_error", in_units(worst_slope));
    RecordProperty("fast_value_of_allowed", std::to_string(worst_fast_value));
    RecordProperty("fast_slope_of_allowed", std::to_string(worst_fast_slope));
    EXPECT_LE(worst_fast_value, 1);
    EXPECT_LE(worst_fast_slope, 1);
    // Fractions of 8 bits are much worse than roundings: 2^-9 of neighbours' differences, here of a
    // tenth of the greatest value and more, beside 2^-20 of that.
    if (has_fetch_error && storage.fraction_bits == 8 && storage.format == SampleFormat::Float32) {
        EXPECT_GT(fast_value_error, 10 * value_tolerance);
    }
    EXPECT_LE(worst_value, value_tolerance);
    EXPECT_LE(worst_gradient, derivative_tolerance);
    // Three components at most: sqrt 3 for a unit direction.
    EXPECT_LE(worst_slope, std::sqrt(3.0) * derivative_tolerance);
}

TEST_P(Tricubic, AgreesWithTheDoubleTwinOnADistanceField) {
    const auto field = sampled(builtin_field("torus"), 40, 8.0);
    expect_equal_to_twin(*field, 0);
    // Another iso value, one that floats do not round.
    expect_equal_to_twin(*field, 0.125F);
}

TEST_P(Tricubic, AgreesWithTheDoubleTwinOnNoise) {
    // The steepest field there is: neighbours differ by up to the whole range.
    Random random(5);
    const DenseField field = test::random_dense(random, {Index3(-20, -3, 5), Index3(25, 37, 42)});
    expect_equal_to_twin(field, 0);
}

INSTANTIATE_TEST_SUITE_P(Storage, Tricubic, testing::ValuesIn(settings()), name_of);

} // namespace
} // namespace isocast
