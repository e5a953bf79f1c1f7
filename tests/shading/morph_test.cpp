// Pictures of morphs.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/morph.h"

#include "shading_scene.h"
#include "volume/blended_field.h"

namespace isocast::test {
namespace {

/// In [-1, 1]^3.
std::shared_ptr<const FieldSource> ball(double radius, int n,
                                        std::optional<double> half_width_voxels = {}) {
    AnalyticField field = sphere_field(Vec3d::Zero(), radius);
    field.half_extent_world = 1;
    return sampled(std::move(field), n, half_width_voxels);
}

struct Morphs : Shading {
    /// Least and greatest distance of hits from the origin.
    std::array<double, 2> radii(const std::shared_ptr<const FieldSource>& field) {
        const Image hits = draw({.field = field}, FrameImage::Hit);
        std::array<double, 2> range{1e9, 0};
        int count = 0;
        for (std::size_t i = 0; i < hits.rgba.size(); i += 4) {
            if (hits.rgba[i + 3] == 0) continue;
            ++count;
            const double r =
                (camera.eye_world + Vec3d(hits.rgba[i], hits.rgba[i + 1], hits.rgba[i + 2])).norm();
            range = {std::min(range[0], r), std::max(range[1], r)};
        }
        EXPECT_GT(count, 300);
        return range;
    }
};

TEST_F(Morphs, OfConcentricSpheresHaveTheRadiusBetween) {
    struct Pair {
        std::shared_ptr<const FieldSource> a, b;
    };
    // Whole fields, and bands whose ends are farther from the surfaces between than the 4.5 voxels
    // that support and stencil reach; each on one lattice and on two.
    for (const auto& [a, b] :
         {Pair{ball(0.5, 48), ball(0.8, 48)}, Pair{ball(0.5, 48), ball(0.8, 56)},
          Pair{ball(0.62, 48, 7), ball(0.7, 48, 7)}, Pair{ball(0.62, 48, 7), ball(0.7, 56, 7)}}) {
        const double r_a = radii(a)[0];
        const double r_b = radii(b)[0];
        for (const double t : {0.3, 0.8}) {
            const auto [least, greatest] = radii(morph(a, b, t).field);
            // The fourth-order error of the spline, (1/192) 15/r^3 h^4 a line on voxels of 2/47
            // with r = 0.5, for the two operands and a resampling.
            const double error = 3 * 3 * 15 / 0.125 / 192 * 3.3e-6;
            EXPECT_NEAR(least, (1 - t) * r_a + t * r_b, error) << t;
            EXPECT_NEAR(greatest, (1 - t) * r_a + t * r_b, error) << t;
        }
    }
}

TEST_F(Morphs, AreTheOperandsBitForBitAtTheEnds) {
    const auto a = std::shared_ptr<const FieldSource>(sampled(builtin_field("torus"), 40));
    // On a's lattice.
    const auto b = resampled(ball(0.7, 40), Filter::Interpolating, a->space(), a->extent());
    const Image of_a = draw({.field = a});
    const Image of_b = draw({.field = b});
    EXPECT_NE(of_a.rgba, of_b.rgba);
    EXPECT_EQ(draw({.field = morph(a, b, 0).field}).rgba, of_a.rgba);
    EXPECT_EQ(draw({.field = morph(a, b, 1).field}).rgba, of_b.rgba);
    // As blends that are computed, too.
    EXPECT_EQ(draw({.field = std::make_shared<BlendedField>(a, b, 0)}).rgba, of_a.rgba);
    EXPECT_EQ(draw({.field = std::make_shared<BlendedField>(a, b, 1)}).rgba, of_b.rgba);
}

TEST_F(Morphs, CanBeComposed) {
    const auto between = morph(ball(0.5, 40), ball(0.8, 40), 0.5).field;
    const Image hits = draw({.objects = {{.field = ball(0.9, 48)}, {.field = between}},
                             .tree = {{CsgOperation::Object, 0},
                                      {CsgOperation::Object, 1},
                                      {CsgOperation::Intersection}}},
                            FrameImage::Hit);
    const Image alone = draw({.field = between}, FrameImage::Hit);
    int count = 0;
    for (std::size_t i = 0; i < hits.rgba.size(); i += 4) {
        for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(hits.rgba[i + c], alone.rgba[i + c]);
        count += hits.rgba[i + 3] != 0 ? 1 : 0;
    }
    EXPECT_GT(count, 300);
}

} // namespace
} // namespace isocast::test
