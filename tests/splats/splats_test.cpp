// Primitives as they are drawn, against a double ray caster.
// SPDX-License-Identifier: MPL-2.0
#include "renderer_test_base.h"
#include "some_primitives.h"
#include "splat_judge.h"

namespace isocast::test {
namespace {

struct Splat : RendererTest {
    Camera camera{.eye_world = {0.3, 0.4, 6}, .target_world = Vec3d::Zero()};
};

TEST_F(Splat, OfEveryKindIsWhatTheRaysMeet) {
    Random random(1);
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera.projection = projection;
        for (int run = 0; run < 4; ++run) {
            const Primitives primitives = some_quadrics(random, 5);
            const Judgement judgement = judge(renderer, primitives, camera, 160, 120);
            EXPECT_EQ(judgement.wrong, 0)
                << run << " at " << testing::PrintToString(judgement.pixels);
            EXPECT_GT(judgement.seen, 1000);
            EXPECT_LT(judgement.worst_error, 1e-5);
        }
    }
}

// raycaster/splats_on_gpu.h: a draw takes 2^14 rectangles at most.
TEST_F(Splat, OfManyTakesManyDraws) {
    constexpr int side = 200;
    Primitives primitives;
    for (int i = 0; i < side * side; ++i)
        primitives.spheres.push_back(
            {.centre_world = {i % side * 0.015 - 1.5, i / side * 0.015 - 1.5, 0},
             .radius_world = 0.007});
    const Judgement judgement = judge(renderer, primitives, camera, 200, 200);
    EXPECT_EQ(judgement.wrong, 0) << testing::PrintToString(judgement.pixels);
    EXPECT_GT(judgement.seen, 10000);
}

} // namespace
} // namespace isocast::test
