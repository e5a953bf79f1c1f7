// Environments, what mirrors them and what bends them, against optics in double.
// SPDX-License-Identifier: MPL-2.0
#include "shading_scene.h"

#include "raycaster/environment.h"

#include "../volume/random_fields.h"

#include <numbers>

namespace isocast::test {
namespace {

/// Beauty and layers are halves, and so are environments' texels.
constexpr double half_rounding = 2.0 / 2048;

double greatest_difference(const float* pixel, const Vec3d& colour) {
    return (Vec3d(pixel[0], pixel[1], pixel[2]) - colour).cwiseAbs().maxCoeff();
}

double latitude_of(const Vec3d& direction) {
    return std::atan2(direction.y(), std::hypot(direction.x(), direction.z()));
}

/// Snell's law; nothing where all is reflected. The normal is against the view; both unit length.
std::optional<Vec3d> refracted(const Vec3d& view, const Vec3d& normal, double ratio) {
    const Vec3d along =
        ratio * (view - normal * normal.dot(view)); // of length sin of the new angle
    if (along.squaredNorm() > 1) return std::nullopt;
    return Vec3d(along - normal * std::sqrt(1 - along.squaredNorm()));
}

Vec3d reflected(const Vec3d& view, const Vec3d& normal) {
    return view - 2 * normal.dot(view) * normal;
}

struct Environments : Shading {
    const std::shared_ptr<const FieldSource> sphere = sampled(builtin_field("sphere"), 64);
    Scene scene{.field = sphere};

    /// The environment alone, from a place that sees no object.
    Image background(const Environment& environment, const Camera& from) {
        Scene empty = scene;
        empty.iso_world = -5; // below all values
        empty.look.environment = environment;
        empty.look.shows_environment = true;
        camera = from;
        return draw(empty);
    }
    /// Calls visit(direction, pixel) for each pixel of six pictures that hold every direction, and
    /// more than once those at the poles and behind.
    template<class Visit>
    void for_each_direction(const Environment& environment, Visit visit) {
        for (const Vec3d& forward : {Vec3d(1, 0, 0), Vec3d(-1, 0, 0), Vec3d(0, 1, 0),
                                     Vec3d(0, -1, 0), Vec3d(0, 0, 1), Vec3d(0, 0, -1)}) {
            const Camera from{.eye_world = Vec3d::Zero(),
                              .target_world = forward,
                              .up = forward.y() == 0 ? Vec3d(0, 1, 0) : Vec3d(0.3, 0, 1),
                              .fov_y_degrees = 95};
            const Image image = background(environment, from);
            for (int y = 0; y < size; ++y)
                for (int x = 0; x < size; ++x)
                    visit(
                        camera_ray(from, size, size, x + 0.5, y + 0.5).direction_world.normalized(),
                        image.pixel(x, y));
        }
    }
    /// Calls visit(view, outward normal, pixel of `image`) for each hit on the unit sphere.
    template<class Visit>
    int for_each_hit(FrameImage image, Visit visit) {
        renderer.load(scene);
        report = renderer.draw(camera, size, size, {FrameImage::Hit, image});
        const Image hits = renderer.read(FrameImage::Hit);
        const Image texels = renderer.read(image);
        int count = 0;
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                const float* hit = hits.pixel(x, y);
                if (hit[3] == 0) {
                    EXPECT_EQ(texels.pixel(x, y)[3], 0);
                    continue;
                }
                ++count;
                const Vec3d p = camera.eye_world + Vec3d(hit[0], hit[1], hit[2]);
                visit(camera_ray(camera, size, size, x + 0.5, y + 0.5).direction_world.normalized(),
                      p.normalized(), texels.pixel(x, y));
            }
        return count;
    }
    /// Of a reflected direction on the sphere: normals of the spline of 64 samples (radius 21
    /// voxels) err by a quarter of third derivatives, 3/21^3, and turn it twice as far.
    static constexpr double direction_error = 2 * 3.0 / 4 / (21.0 * 21 * 21);

    /// How far the sky's colour can lie from its colour in a direction which errs by `angle`, or is
    /// averaged over it.
    double sky_error(const Vec3d& direction, double angle) const {
        double worst = 0;
        const double latitude = latitude_of(direction);
        const auto at = [&](double l) {
            return builtin_environment({}, {0, std::sin(l), std::cos(l)});
        };
        for (const double turn : {-angle, -angle / 2, angle / 2, angle})
            worst = std::max(worst, (at(latitude + turn) - at(latitude)).cwiseAbs().maxCoeff());
        return worst;
    }
};

TEST_F(Environments, TheSkyIsTheTwinInEveryDirection) {
    double worst = 0;
    for_each_direction({}, [&](const Vec3d& d, const float* pixel) {
        // A pixel of 95 degrees/96 at most, 0.023, is averaged between two levels of up to twice
        // that width, linearly filtered: 0.07 on either side, of which a smooth function shows
        // only its bend. Near the horizon it shows all.
        const double explained =
            std::abs(latitude_of(d)) < 0.08 ? sky_error(d, 0.07) : 0.1 * sky_error(d, 0.07);
        worst = std::max(worst, greatest_difference(pixel, builtin_environment({}, d)) - explained);
    });
    EXPECT_LT(worst, half_rounding);
}

TEST_F(Environments, StripesAreHorizontalAndLieWhereTheyShould) {
    const Environment stripes{.kind = Environment::Kind::Stripes, .stripes = 7};
    int compared = 0;
    for_each_direction(stripes, [&](const Vec3d& d, const float* pixel) {
        const double place = (latitude_of(d) / std::numbers::pi + 0.5) * 7;
        // 0.07 rad as above.
        if (std::abs(place - std::round(place)) < 0.07 / std::numbers::pi * 7) return;
        ++compared;
        EXPECT_LT(greatest_difference(pixel, builtin_environment(stripes, d)), half_rounding);
    });
    EXPECT_GT(compared, 25000);
}

TEST_F(Environments, StripesFinerThanAPixelAreGrey) {
    size = 48;
    const Environment stripes{.kind = Environment::Kind::Stripes, .stripes = 512};
    const Vec3d grey = (builtin_environment(stripes, {0, 0.001, 1}) +
                        builtin_environment(stripes, {0, -0.001, 1})) /
                       2;
    // Stripes of 0.006 rad; a pixel of 60 degrees/48 is 0.02 and 0.017 at the corners, where levels
    // of 0.0123 and 0.0245 hold one stripe pair each and more: what is left of it is below a tenth.
    const Image image = background(
        stripes, {.eye_world = Vec3d::Zero(), .target_world = {0, 0.2, -1}, .fov_y_degrees = 60});
    for (std::size_t i = 0; i < image.rgba.size(); i += 4)
        ASSERT_LT(greatest_difference(&image.rgba[i], grey), 0.1);
}

TEST_F(Environments, PicturesHaveNoSeamAndLookTheRightWay) {
    // Red is east (+x), green is south (+z, behind the default camera), blue is up.
    constexpr int width = 128;
    constexpr int height = 64;
    Image picture{width, height, {}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double longitude = ((x + 0.5) / width - 0.5) * 2 * std::numbers::pi; // 0: -z
            const double latitude = (0.5 - (y + 0.5) / height) * std::numbers::pi;
            for (const double c : {0.5 + 0.5 * std::sin(longitude), 0.5 - 0.5 * std::cos(longitude),
                                   0.5 + 0.5 * std::sin(latitude), 1.0})
                picture.rgba.push_back(static_cast<float>(c));
        }
    double worst = 0;
    for_each_direction({.kind = Environment::Kind::Picture, .picture = picture},
                       [&](const Vec3d& d, const float* pixel) {
                           const double across = std::hypot(d.x(), d.z());
                           if (across < 0.15) { // at the poles all longitudes meet
                               EXPECT_NEAR(pixel[2], 0.5 + 0.5 * d.y(), 0.003);
                               return;
                           }
                           const Vec3d expected(0.5 + 0.5 * d.x() / across,
                                                0.5 + 0.5 * d.z() / across, 0.5 + 0.5 * d.y());
                           worst = std::max(worst, greatest_difference(pixel, expected));
                       });
    // Linear between texels of 0.049 rad: 0.5 * 0.049^2/8; the pixels are finer than these.
    EXPECT_LT(worst, 0.5 * 0.049 * 0.049 / 8 + half_rounding);
}

TEST_F(Environments, ASphereMirrorsTheSky) {
    scene.look.effects.reflection.strength = 1;
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera.projection = projection;
        camera.height_world = 2.2;
        double worst = 0;
        const int count = for_each_hit(FrameImage::Reflection, [&](const Vec3d& view,
                                                                   const Vec3d& normal,
                                                                   const float* pixel) {
            const double facing = -view.dot(normal);
            if (facing < 0.3) return; // where a pixel's directions spread
            const Vec3d direction = reflected(view, normal);
            // A pixel of 0.027 on the sphere turns directions by twice that over cos, 0.18 at
            // worst; averaged as in TheSkyIsTheTwinInEveryDirection.
            const double spread = 3 * 2 * 0.027 / facing;
            const double explained = std::abs(latitude_of(direction)) < spread
                                         ? sky_error(direction, spread)
                                         : 0.25 * sky_error(direction, spread);
            worst = std::max(worst, greatest_difference(pixel, builtin_environment({}, direction)) -
                                        explained - sky_error(direction, direction_error));
            EXPECT_EQ(pixel[3], 1);
        });
        EXPECT_GT(count, 2000);
        EXPECT_LT(worst, half_rounding);
    }
}

TEST_F(Environments, ASphereBendsTheSkyBySnellsLaw) {
    scene.look.effects.refraction = {.strength = 1, .index = 1.5};
    double worst = 0;
    const int count = for_each_hit(
        FrameImage::Refraction, [&](const Vec3d& view, const Vec3d& normal, const float* pixel) {
            if (-view.dot(normal) < 0.3) return;
            const Vec3d direction = *refracted(view, normal, 1 / 1.5);
            const double spread = 3 * 0.027 / 0.3; // less than a mirror turns
            const double explained = std::abs(latitude_of(direction)) < spread
                                         ? sky_error(direction, spread)
                                         : 0.1 * sky_error(direction, spread);
            worst = std::max(worst, greatest_difference(pixel, builtin_environment({}, direction)) -
                                        explained);
        });
    EXPECT_GT(count, 2000);
    EXPECT_LT(worst, half_rounding);
}

TEST_F(Environments, SeenThroughIndexOneIsSeenDirectly) {
    Environment stripes{.kind = Environment::Kind::Stripes};
    for (const Projection projection : {Projection::Perspective, Projection::Orthographic}) {
        camera.projection = projection;
        camera.height_world = 3;
        const Image direct = background(stripes, camera);
        scene.look.environment = stripes;
        scene.look.shows_environment = true;
        scene.look.effects.refraction = {.strength = 1, .index = 1};
        const Image through = draw(scene);
        double worst = 0;
        int hits = 0;
        for (std::size_t i = 0; i < through.rgba.size(); i += 4) {
            hits += through.rgba[i + 3] == 1;
            for (std::size_t c = 0; c < 3; ++c)
                worst = std::max(worst, double{std::abs(through.rgba[i + c] - direct.rgba[i + c])});
        }
        EXPECT_GT(hits, 1000);
        // Directions round by 2e-7; a stripe's edge changes by 0.85 within two texels of 0.0015.
        EXPECT_LT(worst, 0.85 * 2e-7 / 0.003 + half_rounding);
    }
}

TEST_F(Environments, FromInsideLightIsBentOrWhollyReflected) {
    scene.look.effects.refraction = {.strength = 1, .index = 1.5};
    scene.look.effects.reflection = {.strength = 1, .has_fresnel = true};
    // From near the surface rays meet it at all angles.
    camera = {.eye_world = {0.8, 0.1, 0.1}, .target_world = {0.8, 0.5, -1}, .fov_y_degrees = 80};
    const double critical = std::sqrt(1 - 1 / (1.5 * 1.5)); // the cosine there
    int whole = 0;
    int bent = 0;
    for_each_hit(FrameImage::Refraction,
                 [&](const Vec3d& view, const Vec3d& out, const float* pixel) {
                     const double cosine = view.dot(out);
                     if (std::abs(cosine - critical) < 0.05)
                         return; // the bent direction spreads without bound
                     const auto through = refracted(view, -out, 1.5);
                     const Vec3d direction = through ? *through : reflected(view, out);
                     (through ? bent : whole) += 1;
                     // Pixels of 0.02 rad, turned by up to 1.5/sqrt(1 - 1.5^2 sin^2) = 4 times;
                     // three times that as above.
                     EXPECT_LT(greatest_difference(pixel, builtin_environment({}, direction)),
                               sky_error(direction, 3 * 4 * 0.02) + half_rounding);
                 });
    EXPECT_GT(whole, 300);
    EXPECT_GT(bent, 150);
    for_each_hit(FrameImage::Reflection,
                 [&](const Vec3d& view, const Vec3d& out, const float* pixel) {
                     if (view.dot(out) < critical - 1e-3) {
                         EXPECT_EQ(pixel[3], 1);
                     }
                     if (view.dot(out) > critical + 1e-3) {
                         EXPECT_LT(pixel[3], 1);
                     }
                 });
}

TEST_F(Environments, FresnelsShareIsSchlicks) {
    scene.look.effects.reflection = {.strength = 1, .has_fresnel = true};
    for (const double index : {1.0, 1.5, 2.4}) {
        scene.look.effects.refraction.index = index;
        const double r0 = std::pow((index - 1) / (index + 1), 2);
        for_each_hit(FrameImage::Reflection,
                     [&](const Vec3d& view, const Vec3d& normal, const float* pixel) {
                         const double away = 1 + view.dot(normal);
                         // Slope of at most 5 in the cosine.
                         EXPECT_NEAR(pixel[3], r0 + (1 - r0) * std::pow(away, 5),
                                     5 * direction_error + half_rounding);
                     });
    }
}

TEST_F(Environments, GlassShowsNothingBrighterThanItsSurroundings) {
    scene.look.environment.kind = Environment::Kind::Stripes;
    scene.look.effects.refraction.strength = 1;
    scene.look.effects.reflection = {.strength = 1, .has_fresnel = true};
    const Image image = draw(scene);
    for (std::size_t i = 0; i < image.rgba.size(); i += 4)
        if (image.rgba[i + 3] != 0) {
            EXPECT_GE(image.rgba[i], 0.05 - half_rounding); // stripes' red
            EXPECT_LE(image.rgba[i], 0.9 + half_rounding);
        }
}

TEST_F(Environments, BuiltInOnesTakeAColumnOfTexels) {
    scene.look.effects.reflection.strength = 1;
    draw(scene);
    EXPECT_EQ(report.look_bytes, 8 * (2 * 2048 - 1)); // and all its averages
}

} // namespace
} // namespace isocast::test
