// Which fetch is chosen, and that its probe measures what it says.
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/fetch_choice.h"
#include "test_context.h"
#include "volume/analytic_fields.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>

namespace isocast {
namespace {

const std::filesystem::path shader_folder = std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders";

TEST(FetchChoice, TakesTheFastestAndSaysWhatWasMeasured) {
    for (const Fetch best : {Fetch::Rows, Fetch::Samples, Fetch::Linear}) {
        std::vector<FetchTime> times;
        for (const Fetch fetch : {Fetch::Rows, Fetch::Samples, Fetch::Linear})
            times.push_back({fetch, fetch == best ? 0.25 : 1.5});
        const FetchChoice choice = fastest_fetch(times);
        EXPECT_EQ(choice.fetch, best);
        for (const FetchTime& time : times)
            EXPECT_NE(choice.reason.find(fetch_name(time.fetch)), std::string::npos);
        EXPECT_NE(choice.reason.find("0.250 ms"), std::string::npos) << choice.reason;
        EXPECT_NE(choice.reason.find("1.500 ms"), std::string::npos) << choice.reason;
    }
}

TEST(FetchChoice, TakesTheFirstOfEqualTimes) {
    EXPECT_EQ(
        fastest_fetch(std::array{FetchTime{Fetch::Rows, 1}, FetchTime{Fetch::Linear, 1}}).fetch,
        Fetch::Rows);
}

TEST(FetchChoice, KnowsSoftwareRasterisers) {
    EXPECT_TRUE(is_software_rasteriser("llvmpipe (LLVM 15.0.6, 256 bits)"));
    EXPECT_TRUE(is_software_rasteriser("softpipe"));
    EXPECT_FALSE(is_software_rasteriser("NVIDIA GeForce RTX 3080/PCIe/SSE2"));
}

struct ProbedFetches : testing::Test {
    std::unique_ptr<gl::Context> context = test::make_context();
    Renderer renderer{*context, shader_folder};
};

TEST_F(ProbedFetches, AreThoseThatTheFilterAllows) {
    const auto fetches = [&](Filter filter) {
        std::vector<Fetch> all;
        for (const FetchTime& time : time_fetches(renderer, filter, {}, 32)) {
            all.push_back(time.fetch);
            EXPECT_GT(time.milliseconds, 0);
            EXPECT_LT(time.milliseconds, std::numeric_limits<double>::infinity());
        }
        return all;
    };
    EXPECT_EQ(fetches(Filter::Interpolating),
              (std::vector{Fetch::Rows, Fetch::Samples, Fetch::Linear}));
    EXPECT_EQ(fetches(Filter::CatmullRom), (std::vector{Fetch::Rows, Fetch::Samples}));
}

TEST_F(ProbedFetches, CompileNoProgramThatTheChosenOneDoesNotUse) {
    time_fetches(renderer, Filter::Interpolating, {}, 32);
    const Camera camera{.eye_world = {1.5, 1, 4}, .target_world = Vec3d::Zero()};
    const auto programs = [&] {
        return renderer.draw(camera, 16, 16, {FrameImage::Gradient}).programs_compiled;
    };
    const int after_probe = programs();
    renderer.load({.field = sampled(builtin_field("gyroid"), 32)});
    EXPECT_EQ(programs(), after_probe);
}

TEST_F(ProbedFetches, AreNotMeasuredOnSoftwareRasterisers) {
    const FetchChoice choice =
        choose_fetch(renderer, {.renderer = "llvmpipe"}, Filter::Interpolating, {});
    EXPECT_EQ(choice.fetch, Fetch::Rows);
    renderer.load({.field = sampled(builtin_field("torus"), 32)});
    EXPECT_EQ(renderer.draw({.eye_world = {0, 0, 4}}, 16, 16, {FrameImage::Hit}).programs_compiled,
              1);
}

} // namespace
} // namespace isocast
