// First hits of primitives against brute force in 113 bits; normals, curvatures, and the cases that
// textbook formulas lose.
// SPDX-License-Identifier: MPL-2.0
#include "quadrics/quadric.h"

#include "filtering/curvature.h"
#include "quadric_oracle.h"
#include "random_primitives.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <limits>

namespace isocast {
namespace {

using oracle::Quad;
template<class Real>
constexpr double rounding = std::numeric_limits<Real>::epsilon() / 2.0;

/// The first hit in Real: what is made per primitive in double, then all per ray in Real, as on the
/// GPU.
template<class Real, class Primitive>
std::optional<QuadricHitOf<Real>> intersect_in(const Primitive& primitive, const Vec3d& origin,
                                               const Vec3d& direction, double t_near) {
    return first_hit(seen_from<Real>(quadric_of(primitive), origin),
                     Eigen::Vector3<Real>(direction.cast<Real>()), Real(t_near));
}

double distance_scale(const oracle::Definition& d, const Vec3d& origin) {
    return std::max((d.centre_world - origin).norm(), d.size_world);
}

Sphere scaled(Sphere s, double f, double) {
    s.radius_world *= f;
    return s;
}
Ellipsoid scaled(Ellipsoid e, double f, double) {
    e.axes_world *= f;
    return e;
}
template<class Tube>
void scale_axis(Tube& c, double f) {
    const Vec3d half = (c.b_world - c.a_world) / 2;
    const Vec3d middle = c.a_world + half;
    c.a_world = middle - half * f;
    c.b_world = middle + half * f;
}
Cylinder scaled(Cylinder c, double f, double g) {
    scale_axis(c, g);
    c.radius_world *= f;
    return c;
}
Cone scaled(Cone c, double f, double g) {
    scale_axis(c, g);
    c.radius_a_world *= f;
    c.radius_b_world *= f;
    return c;
}
ClippedQuadric scaled(ClippedQuadric k, double f, double g) {
    // Another level, and another box about the same surface.
    k.c += (f - 1) * (k.a.norm() + k.b.norm());
    k.axes_world *= g;
    k.a *= g * g;
    k.b *= g;
    return k;
}

/// What many rays showed. Errors are in roundings (2^-53, or 2^-24 in float) of the greater of the
/// distance of the ray's origin from the centre and the size of the primitive: how far hits lie off
/// the surface, and how far normals are tilted, over the greatest curvature.
struct Tally {
    long rays = 0;
    long hits = 0;
    long inner = 0;
    long caps = 0;
    long doubtful =
        0; // brute force disagrees with itself about a primitive that is a little larger
    long wrong = 0;
    double worst = 0;
    double worst_normal = 0;

    void print(const char* what) const {
        std::printf("%-34s %6ld rays %6ld hits %6ld inner %5ld caps %3ld doubtful %2ld wrong; off "
                    "by %.1f roundings, normals by %.1f\n",
                    what, rays, hits, inner, caps, doubtful, wrong, worst, worst_normal);
    }
};

oracle::Q3 gradient_at(const oracle::Definition& d, const oracle::Q3& p) {
    const Quad h = Quad(1e-6) * d.size_world; // central differences of a quadratic are exact
    const auto along = [&](const oracle::Q3& e) {
        return (d.value(p + e * h) - d.value(p - e * h)) / (2 * h);
    };
    return {along({1, 0, 0}), along({0, 1, 0}), along({0, 0, 1})};
}
Vec3d rounded(const oracle::Q3& v) {
    return {double(v.x), double(v.y), double(v.z)};
}

template<class Real = double, class Primitive>
void check_ray(Tally& tally, const Primitive& primitive, const Vec3d& origin,
               const Vec3d& any_direction, double any_t_near) {
    ++tally.rays;
    const Vec3d direction = any_direction.cast<Real>().template cast<double>();
    const double t_near = Real(any_t_near);
    const oracle::Definition d = oracle::definition(primitive);
    const auto truth = oracle::first_hit(d, origin, direction, t_near);
    const auto hit = intersect_in<Real>(primitive, origin, direction, t_near);
    const double unit = rounding<Real> * distance_scale(d, origin);
    const auto at = [&](Quad t) { return oracle::of(origin) + oracle::of(direction) * t; };

    bool is_right = hit.has_value() == truth.has_value();
    double off = 0;
    double normal_off = 0;
    if (hit) {
        EXPECT_NEAR(hit->normal.norm(), 1, 8 * rounding<Real>); // a root and a division
        const double cosine = hit->normal.template cast<double>().dot(direction.normalized());
        EXPECT_TRUE(std::abs(cosine) < 1e-3 || hit->is_inside == (cosine > 0)) << cosine;
        EXPECT_GE(hit->t, Real(t_near));
    }
    if (is_right && hit) {
        is_right = hit->cap == truth->cap;
        const Vec3d normal = hit->normal.template cast<double>();
        const double step = std::abs(double(Quad(hit->t) - truth->t)) * direction.norm();
        const double cosine = std::abs(normal.dot(direction.normalized()));
        if (hit->cap) {
            off = step * cosine / unit;
        } else if (is_right) {
            const Vec3d gradient = rounded(gradient_at(d, at(hit->t)));
            off = std::abs(double(d.value(at(hit->t)))) / gradient.norm() / unit;
            const auto [g, h] = derivatives(primitive, rounded(at(truth->t)));
            const Curvatures k = principal_curvatures(g, h);
            // Along the surface, and off it.
            const double curvature =
                std::max({std::abs(k.k1), std::abs(k.k2), flow_line_curvature(g, h)});
            normal_off =
                normal.cross(gradient.normalized()).norm() / (unit * curvature + rounding<Real>);
            EXPECT_GT(normal.dot(gradient), 0);
        }
        // The same root: two are closer than this only where the ray grazes.
        const double grazing = 1e4 * unit;
        is_right &= step < grazing || step * cosine < grazing;
    }
    if (is_right) {
        if (!hit) return;
        ++tally.hits;
        tally.inner += hit->is_inside;
        tally.caps += hit->cap != 0;
        tally.worst = std::max(tally.worst, off);
        tally.worst_normal = std::max(tally.worst_normal, normal_off);
        return;
    }
    // Within a hundred roundings of an edge or a silhouette either answer is right.
    const double grow = 100 * unit / d.size_world;
    for (const double f : {1 - grow, 1 + grow})
        for (const double g : {1 - grow, 1 + grow}) {
            const auto other = oracle::first_hit(oracle::definition(scaled(primitive, f, g)),
                                                 origin, direction, t_near);
            if (other.has_value() != truth.has_value() ||
                (other && (other->cap != truth->cap ||
                           std::abs(double(other->t - truth->t)) * direction.norm() >
                               0.01 * d.size_world))) {
                ++tally.doubtful;
                return;
            }
        }
    if (++tally.wrong < 5)
        ADD_FAILURE() << "ray from " << origin.transpose() << " along " << direction.transpose()
                      << ": t " << (hit ? hit->t : -1) << " cap " << (hit ? hit->cap : -1)
                      << ", brute force " << (truth ? double(truth->t) : -1) << " cap "
                      << (truth ? truth->cap : -1);
}

/// Rays from all around and from inside, of any length, to points in and about the primitive; some
/// are cut.
template<class Real = double, class Make>
Tally random_rays(std::uint64_t seed, int primitives, int rays_each, Make make) {
    Random random(seed);
    Tally tally;
    for (int i = 0; i < primitives; ++i) {
        const auto primitive = make(random);
        const oracle::Definition d = oracle::definition(primitive);
        for (int j = 0; j < rays_each; ++j) {
            const Vec3d target = d.centre_world + random.in_cube(0.7) * d.size_world;
            const Vec3d origin =
                d.centre_world + random.unit() * random.log_uniform(0.1, 50) * d.size_world;
            const Vec3d direction = (target - origin) * random.log_uniform(0.1, 10);
            const double t_near =
                random.uniform(0, 1) < 0.7
                    ? 0
                    : random.uniform(0.8, 1.2) * (target - origin).norm() / direction.norm();
            check_ray<Real>(tally, primitive, origin, direction, t_near);
        }
    }
    return tally;
}

/// Three times the 10.3 roundings off and the 2.8 of normals that were measured.
constexpr double few_roundings = 32;
constexpr double few_roundings_of_normals = 9;

void expect_exact(const Tally& tally, const char* what) {
    tally.print(what);
    EXPECT_EQ(tally.wrong, 0);
    EXPECT_LT(tally.worst, few_roundings);
    EXPECT_LT(tally.worst_normal, few_roundings_of_normals);
    EXPECT_LE(tally.doubtful, 2 + tally.rays / 100);
    EXPECT_GT(tally.hits, tally.rays / 10);
}

template<class Real>
void expect_agreement(int count) {
    expect_exact(random_rays<Real>(1, count, 100, [](Random& r) { return r.sphere(); }), "spheres");
    expect_exact(random_rays<Real>(2, count, 100, [](Random& r) { return r.ellipsoid(); }),
                 "ellipsoids");
    expect_exact(random_rays<Real>(3, count, 100, [](Random& r) { return r.cylinder(); }),
                 "cylinders");
    expect_exact(random_rays<Real>(4, count, 100, [](Random& r) { return r.cone(); }), "cones");
    expect_exact(random_rays<Real>(5, count, 100, [](Random& r) { return r.clipped_quadric(); }),
                 "clipped quadrics");
}

TEST(QuadricIntersect, AgreesWithBruteForce) {
    expect_agreement<double>(200);
}
TEST(QuadricIntersect, InFloatAgreesWithBruteForceToFloatsRoundings) {
    expect_agreement<float>(100);
}

// ---- cases that textbook formulas lose

/// A ray past or into a ball of `radius` about `centre`: its closest approach is `offset` radii.
Vec3d towards(const Vec3d& origin, const Vec3d& centre, double radius, double offset,
              Random& random) {
    const Vec3d to_centre = centre - origin;
    const double distance = to_centre.norm();
    // The ray through the point at angle asin(offset radius / distance).
    const double sine = offset * radius / distance;
    const Vec3d side = to_centre.cross(random.unit()).normalized();
    return to_centre / distance * std::sqrt(std::max(0.0, 1 - sine * sine)) + side * sine;
}

TEST(QuadricIntersect, SpheresFarAwayLoseNothing) {
    for (const double ratio : {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
        Random random(11);
        Tally tally;
        for (int i = 0; i < 1000; ++i) {
            const Sphere s{.centre_world = random.in_cube(1), .radius_world = ratio};
            const Vec3d origin = s.centre_world + random.unit();
            const double offset = i % 2 ? random.uniform(0, 1.1) : 1 + random.uniform(-0.01, 0.01);
            check_ray(tally, s, origin,
                      towards(origin, s.centre_world, s.radius_world, offset, random), 0);
        }
        expect_exact(tally, ("radius / distance " + std::to_string(ratio)).c_str());
    }
}

TEST(QuadricIntersect, SilhouettesOfSpheresInFloatErrAsTheClosestApproachDoes) {
    // 100 pixels of radius. FORMULAS of the project: 2e-4, 2e-3, 2e-2 pixels at radius / distance
    // 1e-2, 1e-3, 1e-4, where the textbook form errs by 0.14, 14 and is lost.
    for (const double ratio : {1e-2, 1e-3, 1e-4}) {
        Random random(12);
        double worst = 0;
        double sum = 0;
        constexpr int count = 2000;
        for (int i = 0; i < count; ++i) {
            const Sphere s{.radius_world = ratio};
            const Vec3d origin = random.unit();
            const Eigen::Matrix3d r = random.rotation();
            const Vec3d centre = -origin;
            const Vec3d side = centre.cross(r.col(0)).normalized();
            const auto seen = seen_from<float>(quadric_of(s), origin);
            // Halve between a ray that hits and one that misses; the place of a ray is that of its
            // direction in float.
            double in = 0.5, out = 1.5;
            const auto ray = [&](double offset) {
                return Eigen::Vector3f((centre + side * (offset * ratio)).cast<float>());
            };
            for (int k = 0; k < 50; ++k) {
                const double offset = (in + out) / 2;
                (first_hit(seen, ray(offset), 0.0f) ? in : out) = offset;
            }
            const Vec3d v = ray(in).cast<double>();
            const double closest = v.cross(centre).norm() / v.norm() / ratio;
            worst = std::max(worst, std::abs(closest - 1) * 100);
            sum += std::abs(closest - 1) * 100;
        }
        std::printf("silhouette of a float sphere of 100 px, radius / distance %.0e: mean %.1e, "
                    "worst %.1e px\n",
                    ratio, sum / count, worst);
        // The ray passes within half a rounding of each coordinate of centre, direction and
        // product.
        EXPECT_LT(sum / count, 2 * 2e-6 / ratio);
        EXPECT_LT(worst, 100 * 4 * rounding<float> / ratio);
    }
}

TEST(QuadricIntersect, WorldsFarFromTheirOriginLoseNothing) {
    const Vec3d far(1e7, -1e7, 1e7);
    const auto tally_of = [&](std::uint64_t seed, auto make) {
        return random_rays(seed, 50, 100, [&](Random& r) { return make(r); });
    };
    const auto moved = [&](auto p) {
        p.centre_world += far;
        return p;
    };
    expect_exact(tally_of(21, [&](Random& r) { return moved(r.sphere()); }), "spheres at 1e7");
    expect_exact(tally_of(22, [&](Random& r) { return moved(r.ellipsoid()); }),
                 "ellipsoids at 1e7");
    expect_exact(tally_of(23, [&](Random& r) { return moved(r.clipped_quadric()); }),
                 "clipped quadrics at 1e7");
    expect_exact(tally_of(24,
                          [&](Random& r) {
                              Cone c = r.cone();
                              c.a_world += far;
                              c.b_world += far;
                              return c;
                          }),
                 "cones at 1e7");
}

TEST(QuadricIntersect, EllipsoidsAsThinAsAMillionthLoseNothing) {
    for (const double thin : {1e-2, 1e-4, 1e-6})
        for (const bool is_needle : {false, true}) {
            Random random(13);
            Tally tally;
            for (int i = 0; i < 2000; ++i) {
                const Vec3d lengths(1, is_needle ? thin : 1, thin);
                const Ellipsoid e{.centre_world = random.in_cube(1),
                                  .axes_world = random.rotation() * lengths.asDiagonal()};
                const Vec3d origin = e.centre_world + random.unit() * random.uniform(1.5, 10);
                const Vec3d target = e.centre_world + e.axes_world * random.in_cube(0.8);
                check_ray(tally, e, origin, target - origin, 0);
            }
            expect_exact(
                tally,
                (std::string(is_needle ? "needle " : "disc ") + std::to_string(thin)).c_str());
        }
}

TEST(QuadricIntersect, RaysThatGrazeAreRightToTheRoundingsOfTheirDistance) {
    // 1e-15 ... 1e-3 radii inside or outside of the silhouette.
    Random random(14);
    Tally spheres, cylinders;
    for (int i = 0; i < 5000; ++i) {
        const double offset = 1 + (random.coin() ? 1 : -1) * random.log_uniform(1e-15, 1e-3);
        const Sphere s = random.sphere();
        const Vec3d origin =
            s.centre_world + random.unit() * s.radius_world * random.log_uniform(1.01, 1000);
        check_ray(spheres, s, origin,
                  towards(origin, s.centre_world, s.radius_world, offset, random), 0);
        const Cylinder c = random.cylinder();
        const Vec3d d = (c.b_world - c.a_world).normalized();
        const Vec3d across = d.unitOrthogonal();
        const Vec3d start = c.a_world + (c.b_world - c.a_world) * random.uniform(0, 1) +
                            across * c.radius_world * random.log_uniform(1.01, 100);
        const Vec3d centre = c.a_world + d * (start - c.a_world).dot(d);
        const double sine = offset * c.radius_world / (centre - start).norm();
        const Vec3d direction = -across * std::sqrt(std::max(0.0, 1 - sine * sine)) +
                                d.cross(across) * sine + d * random.uniform(-0.1, 0.1);
        check_ray(cylinders, c, start, direction, 0);
    }
    spheres.print("spheres, grazing");
    cylinders.print("cylinders, grazing");
    for (const Tally& tally : {spheres, cylinders}) {
        EXPECT_EQ(tally.wrong, 0);
        EXPECT_LT(tally.worst, few_roundings);
        EXPECT_LT(tally.worst_normal, few_roundings_of_normals);
        EXPECT_EQ(tally.inner, 0); // even where the normal leans away
        // One offset in twelve decades is within 100 roundings at distance 1, of four at 100.
        EXPECT_LT(tally.doubtful, tally.rays / 2);
    }
}

TEST(QuadricIntersect, SilhouettesOfCylindersSeenAlmostAlongTheAxisDoNotBlurInFloat) {
    // Rays at an angle to the axis that graze the side in its middle: a component across of 1e-2
    // loses no digits.
    constexpr double distance = 10;
    for (const double angle : {1e-1, 3e-2, 1e-2}) {
        Random random(22);
        double worst = 0;
        for (int i = 0; i < 1000; ++i) {
            const Mat3d r = random.rotation();
            const Cylinder c{.a_world = -r.col(2), .b_world = r.col(2), .radius_world = 1};
            const Vec3d along = r * Vec3d(0, std::sin(angle), -std::cos(angle));
            const Vec3d origin = r * Vec3d(1, 0, random.uniform(-0.2, 0.2)) - along * distance;
            const auto seen = seen_from<float>(quadric_of(c), origin);
            // Off the tangent, across; deeper rays pass through the open ends.
            double in = -0.2 * angle * angle, out = -in;
            const auto ray = [&](double offset) {
                return Eigen::Vector3f((along * distance + r.col(0) * offset).cast<float>());
            };
            for (int k = 0; k < 50; ++k) {
                const double offset = (in + out) / 2;
                (first_hit(seen, ray(offset), 0.0f) ? in : out) = offset;
            }
            const Vec3d across = ray(in).cast<double>().cross(r.col(2)).normalized();
            worst = std::max(worst, std::abs(std::abs(origin.dot(across)) - 1));
        }
        std::printf("silhouette of a float cylinder at %.0e from its axis: within %.1e radii\n",
                    angle, worst);
        // The rounding of the distance, some times over; measured 1.5 of it.
        EXPECT_LT(worst, 4 * distance * rounding<float>);
    }
}

TEST(QuadricIntersect, RaysAlongTheAxisOfACylinderMeetItsCapsOrPass) {
    const Cylinder open{.a_world = {0, 0, -1}, .b_world = {0, 0, 2}, .radius_world = 0.5};
    Cylinder capped = open;
    capped.is_capped = true;
    for (const Vec3d& start : {Vec3d(0, 0, 5), Vec3d(0.3, 0.3, 5), Vec3d(0, 0, 1e6)}) {
        EXPECT_FALSE(intersect(open, start, Vec3d(0, 0, -1)));
        const auto hit = intersect(capped, start, Vec3d(0, 0, -1));
        ASSERT_TRUE(hit);
        EXPECT_EQ(hit->t, start.z() - 2);
        EXPECT_EQ(hit->cap, 2);
        EXPECT_EQ(hit->normal, Vec3d(0, 0, 1));
        EXPECT_FALSE(hit->is_inside);
    }
    const auto from_within = intersect(capped, Vec3d(0, 0, 0), Vec3d(0, 0, -1));
    ASSERT_TRUE(from_within);
    EXPECT_NEAR(from_within->t, 1, few_roundings * rounding<double>);
    EXPECT_EQ(from_within->cap, 1);
    EXPECT_TRUE(from_within->is_inside);
    EXPECT_FALSE(intersect(capped, Vec3d(0.51, 0, 5), Vec3d(0, 0, -1)));

    Random random(15);
    Tally tally;
    for (int i = 0; i < 5000; ++i) {
        Cylinder c = random.cylinder();
        const Vec3d d = (c.b_world - c.a_world).normalized();
        const Vec3d start =
            c.a_world - d * random.log_uniform(0.1, 100) + random.in_cube(0.9) * c.radius_world;
        check_ray(tally, c, start, d + random.in_cube(1) * random.log_uniform(1e-17, 1e-2), 0);
    }
    expect_exact(tally, "nearly along a cylinder's axis");
}

TEST(QuadricIntersect, RaysParallelToAConesSideMeetTheOther) {
    Random random(16);
    Tally tally;
    for (int i = 0; i < 5000; ++i) {
        const Cone c = random.cone();
        const Vec3d d = c.b_world - c.a_world;
        const Vec3d u = d.unitOrthogonal();
        const Vec3d side = d + u * (c.radius_b_world - c.radius_a_world);
        const Vec3d through = c.a_world + d * random.uniform(0, 1) +
                              random.in_cube(1) * std::max(c.radius_a_world, c.radius_b_world);
        const double tilt = i % 3 ? random.log_uniform(1e-17, 1e-3) : 0;
        const Vec3d direction = side * (random.coin() ? 1 : -1) + random.in_cube(tilt);
        check_ray(tally, c, through - direction * random.log_uniform(0.1, 100), direction, 0);
    }
    expect_exact(tally, "parallel to a cone's side");
}

TEST(QuadricIntersect, RaysAlongTheAxisOfAParaboloidHaveOneRoot) {
    // z = x^2 + y^2 - 1/2
    ClippedQuadric k{.a = Vec3d(1, 1, 0).asDiagonal(), .b = Vec3d(0, 0, -0.5), .c = -0.5};
    for (const double z : {3.0, 100.0, 1e6}) {
        const auto hit = intersect(k, Vec3d(0.5, 0.25, z), Vec3d(0, 0, -1));
        ASSERT_TRUE(hit);
        EXPECT_NEAR(hit->t, z + 0.1875, 4 * rounding<double> * z);
        EXPECT_TRUE(hit->is_inside); // z above is inside: the normal points down
        EXPECT_FALSE(intersect(k, Vec3d(1.5, 0.25, z), Vec3d(0, 0, -1)));
    }
    Random random(17);
    Tally tally;
    for (int i = 0; i < 5000; ++i) {
        // Directions in which the second degree vanishes: on the cone d^T A d = 0, then off by
        // 1e-17
        // ... 1e-3.
        ClippedQuadric q = random.clipped_quadric();
        const Mat3d r = random.rotation();
        const Vec3d signature = i % 2 ? Vec3d(1, random.uniform(0.3, 2), 0) : Vec3d(1, -1, 0.5);
        q.a = r * signature.asDiagonal() * r.transpose();
        q.a = ((q.a + q.a.transpose()) / 2).eval();
        const Vec3d null = i % 2 ? r.col(2) : Vec3d(r.col(0) + r.col(1));
        const Vec3d direction =
            q.axes_world * (null + random.in_cube(random.log_uniform(1e-17, 1e-3)));
        const Vec3d through = q.centre_world + q.axes_world * random.in_cube(0.9);
        check_ray(tally, q, through - direction * random.log_uniform(0.1, 100), direction, 0);
    }
    expect_exact(tally, "second degree vanishes");
}

TEST(QuadricIntersect, AnEyeJustOutsideASphereAsLargeAsTheSceneSeesItInFloatToo) {
    for (const double height : {1e-2, 1e-4, 1e-6, 1e-8}) {
        Random random(18);
        double worst = 0;
        for (int i = 0; i < 2000; ++i) {
            const Sphere s{.centre_world = random.in_cube(1000), .radius_world = 1000};
            const Vec3d up = random.unit();
            const Vec3d origin = s.centre_world + up * (1000 * (1 + height));
            // Down, but for the horizon.
            Vec3d direction = random.unit();
            if (direction.dot(up) > -0.2) continue;
            direction = direction.cast<float>().cast<double>();
            const auto truth = oracle::first_hit(oracle::definition(s), origin, direction, 0);
            const auto hit = intersect_in<float>(s, origin, direction, 0);
            ASSERT_TRUE(hit && truth);
            EXPECT_FALSE(hit->is_inside);
            worst = std::max(worst, std::abs(hit->t / double(truth->t) - 1));
        }
        std::printf("eye %.0e radii above: t in float within %.1e of itself\n", height, worst);
        // The height is known to a double's rounding of the centre's distance, in float to its own.
        EXPECT_LT(worst,
                  few_roundings * rounding<float> + few_roundings * rounding<double> / height);
    }
}

TEST(QuadricIntersect, AnEyeInsideSeesTheInnerSide) {
    Random random(19);
    for (int i = 0; i < 1000; ++i) {
        const Sphere s = random.sphere();
        const Vec3d origin = s.centre_world + random.in_cube(0.5) * s.radius_world;
        const auto hit = intersect(s, origin, random.unit());
        ASSERT_TRUE(hit);
        EXPECT_TRUE(hit->is_inside);
        Cone c = random.cone();
        c.is_capped = true;
        const double z = random.uniform(0.3, 0.7);
        const Vec3d within = c.a_world + z * (c.b_world - c.a_world);
        const auto wall = intersect(c, within, random.unit());
        ASSERT_TRUE(wall); // closed: every ray from inside meets it
        EXPECT_TRUE(wall->is_inside);
    }
}

TEST(QuadricIntersect, ACutSphereShowsItsInnerSide) {
    const Sphere s{.radius_world = 1};
    const auto whole = intersect(s, Vec3d(0, 0, 3), Vec3d(0, 0, -1), 1);
    ASSERT_TRUE(whole);
    EXPECT_EQ(whole->t, 2);
    EXPECT_FALSE(whole->is_inside);
    const auto cut = intersect(s, Vec3d(0, 0, 3), Vec3d(0, 0, -1), 2.5);
    ASSERT_TRUE(cut);
    EXPECT_EQ(cut->t, 4);
    EXPECT_TRUE(cut->is_inside);
    EXPECT_FALSE(intersect(s, Vec3d(0, 0, 3), Vec3d(0, 0, -1), 4.5));
}

TEST(QuadricIntersect, CapsLeaveNoGapAtTheirRims) {
    // Rays from afar to points on the rim of a closed cone, from all sides: within roundings of the
    // rim they meet the side, the cap, or neither where it is a silhouette; to points a little
    // within the solid they always meet something.
    Random random(20);
    for (int i = 0; i < 20000; ++i) {
        Cone c = random.cone();
        c.is_capped = true;
        c.radius_a_world = std::max(c.radius_a_world, 0.05);
        const Vec3d d = c.b_world - c.a_world;
        const Vec3d u = d.unitOrthogonal();
        const Vec3d w = d.normalized().cross(u);
        const double angle = random.uniform(0, 6.3);
        const Vec3d rim =
            c.a_world + (u * std::cos(angle) + w * std::sin(angle)) * c.radius_a_world;
        const Vec3d inner = rim + ((c.a_world + c.b_world) / 2 - rim) * 1e-12;
        const Vec3d origin = inner + random.unit() * random.log_uniform(0.01, 10);
        const auto hit = intersect(c, origin, inner - origin);
        EXPECT_TRUE(hit) << i;
    }
}

// ---- curvatures

template<class Primitive>
Curvatures curvatures_at(const Primitive& primitive, const Vec3d& p_world) {
    const auto [gradient, hessian] = derivatives(primitive, p_world);
    return principal_curvatures(gradient, hessian);
}

TEST(QuadricDerivatives, GiveTheCurvaturesOfSpheresCylindersAndCones) {
    Random random(31);
    for (int i = 0; i < 1000; ++i) {
        const Sphere s = random.sphere();
        const Curvatures round = curvatures_at(s, s.centre_world + random.unit() * s.radius_world);
        EXPECT_NEAR(round.k1 * s.radius_world, 1, 1e-12);
        EXPECT_NEAR(round.k2 * s.radius_world, 1, 1e-12);

        const Cone c = random.cone();
        const Vec3d d = c.b_world - c.a_world;
        const Vec3d u = d.unitOrthogonal();
        const double z = random.uniform(0.2, 0.8);
        const double slope = (c.radius_b_world - c.radius_a_world) / d.norm();
        const double r = c.radius_a_world + z * (c.radius_b_world - c.radius_a_world);
        // Across: of the circle of radius r, whose plane the normal leaves by the cone's angle.
        const Curvatures pointed = curvatures_at(c, c.a_world + z * d + u * r);
        EXPECT_NEAR(pointed.k1 * r * std::hypot(1, slope), 1, 1e-12);
        EXPECT_NEAR(pointed.k2 * r, 0, 1e-12);
        EXPECT_NEAR(pointed.direction2.cross((d + u * slope * d.norm()).normalized()).norm(), 0,
                    1e-10);

        const Cylinder tube = random.cylinder();
        const Vec3d axis = tube.b_world - tube.a_world;
        const Curvatures across = curvatures_at(
            tube, tube.a_world + z * axis + axis.unitOrthogonal() * tube.radius_world);
        EXPECT_NEAR(across.k1 * tube.radius_world, 1, 1e-12);
        EXPECT_NEAR(across.k2 * tube.radius_world, 0, 1e-12);
    }
}

TEST(QuadricDerivatives, GiveTheCurvaturesOfEllipsoids) {
    // With h = 1 / |(x/a^2, y/b^2, z/c^2)|: K = h^4 / (abc)^2, and k1 + k2 =
    // h^3 (a^2 + b^2 + c^2 - x^2 - y^2 - z^2) / (abc)^2.
    Random random(32);
    for (int i = 0; i < 1000; ++i) {
        const Vec3d l(random.log_uniform(0.1, 1), random.log_uniform(0.1, 1),
                      random.log_uniform(0.1, 1));
        const Mat3d r = random.rotation();
        const Ellipsoid e{.centre_world = random.in_cube(1), .axes_world = r * l.asDiagonal()};
        const Vec3d x = l.cwiseProduct(random.unit());
        const Curvatures k = curvatures_at(e, e.centre_world + r * x);
        const double h = 1 / x.cwiseQuotient(l.cwiseProduct(l)).norm();
        const double abc2 = l.prod() * l.prod();
        EXPECT_NEAR(k.k1 * k.k2 * abc2 / std::pow(h, 4), 1, 1e-10); // k2 of k1 / 1000
        const double sum = h * h * h * (l.squaredNorm() - x.squaredNorm()) / abc2;
        EXPECT_NEAR((k.k1 + k.k2) / sum, 1, 1e-12);
        EXPECT_GT(k.k2, 0);
    }
}

} // namespace
} // namespace isocast
