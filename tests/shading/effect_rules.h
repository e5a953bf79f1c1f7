// What every effect keeps, whatever it draws.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "../volume/random_fields.h"
#include "shading_scene.h"

#include <set>

namespace isocast::test {

/// The names of the passes that ran in the last frame.
inline std::set<std::string> passes_run(const FrameReport& report) {
    std::set<std::string> names;
    for (const PassReport& pass : report.passes)
        if (pass.ran) names.insert(pass.name);
    return names;
}

/// A look with an effect of strength 0 gives the plain picture, bit by bit, from the same passes,
/// programs and images.
inline void expect_nothing_at_strength_zero(Shading& shading, const Look& zero) {
    Scene scene{.field = sampled(builtin_field("gyroid"), 32)};
    const Image plain = shading.draw(scene);
    const FrameReport of_plain = shading.report;
    scene.look = zero;
    const Image with_zero = shading.draw(scene);
    EXPECT_EQ(with_zero.rgba, plain.rgba);
    EXPECT_EQ(passes_run(shading.report), passes_run(of_plain));
    EXPECT_EQ(shading.report.programs_compiled, of_plain.programs_compiled);
    EXPECT_EQ(shading.report.image_bytes, of_plain.image_bytes);
    EXPECT_EQ(shading.report.look_bytes, of_plain.look_bytes);
    EXPECT_TRUE(shading.report.notes.empty());
}

/// Asked for alone, the effect's image comes from `passes` and nothing else.
inline void expect_no_more_passes(Shading& shading, FrameImage image,
                                  const std::set<std::string>& passes) {
    shading.draw({.field = sampled(builtin_field("gyroid"), 32)}, image);
    EXPECT_EQ(passes_run(shading.report), passes);
}

/// Every colour is finite and every coverage in [0, 1], on noise and on a surface where the
/// gradient vanishes, from outside and from within, of both kinds of camera.
inline void expect_finite_anywhere(Shading& shading, FrameImage image) {
    shading.size = 48;
    Random random(7);
    const IndexBox box{Index3::Zero(), Index3::Constant(24)};
    const auto noise = std::make_shared<DenseField>(random_dense(random, box));
    std::vector<float> cubes; // of which cubic splines have the derivatives
    for_each_sample(box, [&](const Index3& i) {
        cubes.push_back(static_cast<float>(std::pow(i.x() - 12, 3)));
    });
    const auto flat = std::make_shared<DenseField>(GridSpace::uniform(1), box, std::move(cubes));
    for (const std::shared_ptr<const FieldSource>& field :
         {std::shared_ptr<const FieldSource>(noise), std::shared_ptr<const FieldSource>(flat)})
        for (const Vec3d& eye : {Vec3d(30, 40, 60), Vec3d(11.3, 12.1, 12.7)})
            for (const Projection projection :
                 {Projection::Perspective, Projection::Orthographic}) {
                shading.camera = {.eye_world = eye,
                                  .target_world = {11, 12, 10},
                                  .projection = projection,
                                  .height_world = 40};
                const Image drawn = shading.draw({.field = field}, image);
                const Image hits = shading.renderer.read(FrameImage::Hit);
                int hit_count = 0;
                for (std::size_t i = 3; i < hits.rgba.size(); i += 4)
                    hit_count += hits.rgba[i] != 0;
                ASSERT_GT(hit_count, 50);
                for (std::size_t i = 0; i < drawn.rgba.size(); ++i) {
                    ASSERT_TRUE(std::isfinite(drawn.rgba[i]));
                    if (i % 4 == 3) {
                        ASSERT_GE(drawn.rgba[i], 0);
                        ASSERT_LE(drawn.rgba[i], 1);
                    }
                }
            }
}

/// A point of the picture, in pixels from the top left corner.
inline Eigen::Vector2d pixel_of(const Camera& camera, int size, const Vec3d& p_world) {
    const Vec3d p_view = camera.view_from_world_rotation() * (p_world - camera.eye_world);
    const double pixels = size / (2 * camera.half_height_at(-p_view.z()));
    return {size / 2.0 + pixels * p_view.x(), size / 2.0 - pixels * p_view.y()};
}

} // namespace isocast::test
