// Rays meet superquadrics where brute force says, from the gentlest to the sharpest; bounds touch.
// SPDX-License-Identifier: MPL-2.0
#include "superquadric_oracle.h"

namespace isocast {
namespace {

// --------------------------------------------------------------------------------------- the norm

TEST(SuperquadricNorm, IsThatOfTheDefinition) {
    Random random(1);
    double worst = 0, worst_float = 0;
    for (int k = 0; k < 20000; ++k) {
        const NormExponents<double> e{random.log_uniform(1.02, 40), random.log_uniform(1.02, 40)};
        Vec3d q = random.in_cube(1);
        if (k % 3 == 0) q = q.array().cube().cube();
        const auto n = superquadric_norm(q, e);
        const long double expected = norm_of(q.x(), q.y(), q.z(), e.p, e.r);
        worst = std::max(worst, double(std::abs(n.value - expected) / expected));
        const Eigen::Vector3f qf = q.cast<float>();
        const NormExponents<float> ef{float(e.p), float(e.r)};
        const long double expected_f = norm_of(qf.x(), qf.y(), qf.z(), ef.p, ef.r);
        worst_float =
            std::max(worst_float,
                     double(std::abs(superquadric_norm(qf, ef).value - expected_f) / expected_f));
        // Euler's identity, and the dual norm of any gradient.
        EXPECT_NEAR(n.gradient.dot(q), n.value, 16 * eps * n.value); // 8 for the gradient, a sum
        EXPECT_NEAR(superquadric_norm(n.gradient, dual(e)).value, 1, 16 * eps);
    }
    std::printf("error %.2f roundings, float %.2f\n", worst / eps, worst_float / 1.2e-7);
    EXPECT_LE(worst, 4 * eps);             // as stated
    EXPECT_LE(worst_float, 4 * 1.1921e-7); // the same in float
}

TEST(SuperquadricNorm, SurvivesAnySize) {
    const NormExponents<double> e{40, 40};
    for (const double size : {1e-300, 1e-30, 1e30, 1e300}) {
        const auto n = superquadric_norm(Vec3d(size, size, -size), e);
        EXPECT_NEAR(n.value / size, std::pow(3, 1 / 40.0), 4 * eps * 1.03);
        EXPECT_LT(n.gradient.z(), 0);
        EXPECT_TRUE(n.gradient.allFinite());
    }
    const auto at_pole = superquadric_norm(Vec3d(1e-200, 0, 1), e);
    EXPECT_EQ(at_pole.value, 1);
    EXPECT_EQ(at_pole.gradient, Vec3d(0, 0, 1));
    EXPECT_EQ(superquadric_norm(Vec3d(0, 0, 0), e).value, 0);
}

// ------------------------------------------------------------------------------------------- rays

TEST(Superquadric, FirstHitsAreThoseOfBruteForce) {
    Random random(2);
    int compared = 0;
    for (int k = 0; k < 1500; ++k) {
        const Superquadric s = random_superquadric(random);
        const double size = s.axes_world.norm();
        // From within the body to a million sizes away.
        const Vec3d origin =
            s.centre_world + random.unit() * size * random.log_uniform(0.05, k % 2 ? 1e6 : 10);
        const Vec3d target = s.centre_world + s.axes_world * random.in_cube(1.1);
        const Vec3d direction = (target - origin) * random.log_uniform(1e-3, 1e3);
        compared += expect_first_hit<double>(s, origin, direction, "double");
        expect_first_hit<float>(s, origin, direction.cast<float>().cast<double>(), "float");
    }
    EXPECT_GT(compared, 1450); // nearly none is within rounding of a miss
}

// Along an edge or a face of what is nearly a box, N hardly changes: the slowest case.
TEST(Superquadric, RaysAlongAxesAndFacesAreThoseOfBruteForce) {
    Random random(3);
    for (int k = 0; k < 400; ++k) {
        Superquadric s = random_superquadric(random);
        s.centre_world.setZero();
        s.axes_world = Mat3d::Identity();
        Vec3d direction = Vec3d::Zero(), through = random.in_cube(1.05);
        direction[k % 3] = k % 2 ? 1 : -1;
        if (k % 5 == 0) through[(k + 1) % 3] = 0;
        if (k % 7 == 0) through[(k + 1) % 3] = 1 - random.log_uniform(1e-15, 1e-3);
        if (k % 11 == 0) direction[(k + 2) % 3] = random.log_uniform(1e-300, 1e-3);
        expect_first_hit<double>(s, through - 5 * direction, direction, "axis");
        expect_first_hit<float>(s, through.cast<float>().cast<double>() - 4 * direction, direction,
                                "axis, float");
    }
    // Through the centre: the poles, exactly.
    const Superquadric box{.alpha = 0.05, .beta = 0.05};
    for (int axis = 0; axis < 3; ++axis) {
        const auto hit = intersect(box, 3 * Vec3d::Unit(axis), -Vec3d::Unit(axis));
        ASSERT_TRUE(hit);
        EXPECT_EQ(hit->t, 2);
        EXPECT_EQ(hit->normal, Vec3d(Vec3d::Unit(axis)));
    }
}

// A plane that touches the body: rays in it, moved outwards, miss; moved inwards, they hit.
TEST(Superquadric, GrazingRaysHitAndMiss) {
    Random random(4);
    int hits = 0, misses = 0;
    for (int k = 0; k < 4000; ++k) {
        const Superquadric s = random_superquadric(random);
        const Vec3d n = random.unit();
        const Vec3d touched =
            s.centre_world +
            s.axes_world * superquadric_norm(Vec3d(s.axes_world.transpose() * n),
                                             dual(NormExponents<double>{2 / s.alpha, 2 / s.beta}))
                               .gradient;
        const Vec3d direction = n.cross(random.unit()).normalized();
        const double offset = random.log_uniform(1e-16, 1e-2) * (k % 2 ? 1 : -1);
        const Vec3d origin = touched + n * offset - direction * random.log_uniform(0.1, 1e3);
        const double allowed = tolerance(s, origin, eps);
        const bool hit = intersect(s, origin, direction).has_value();
        // Outside by `offset` of the support: N is at least 1 + offset / support everywhere.
        const double outside = offset / support(s, n);
        const double at_touched = double(norm_at(s, oracle::of(touched + n * offset)) - 1);
        if (outside > allowed) {
            EXPECT_FALSE(hit) << s.alpha << " " << s.beta << " " << outside;
            ++misses;
        } else if (at_touched < -allowed) {
            EXPECT_TRUE(hit) << s.alpha << " " << s.beta << " " << at_touched;
            ++hits;
        }
    }
    EXPECT_GT(hits, 1000);
    EXPECT_GT(misses, 1000);
}

// A convex body lies on one side of its tangent plane: the support along the normal is reached.
TEST(Superquadric, NormalsAreThoseOfTheTangentPlane) {
    Random random(5);
    int hits = 0;
    for (int k = 0; k < 1000; ++k) {
        const Superquadric s = random_superquadric(random);
        const Vec3d origin = s.centre_world + random.unit() * 5;
        const Vec3d direction = s.centre_world + s.axes_world * random.in_cube(0.7) - origin;
        const auto hit = intersect(s, origin, direction);
        if (!hit) continue;
        ++hits;
        EXPECT_NEAR(hit->normal.norm(), 1, 4 * eps);
        EXPECT_LT(hit->normal.dot(direction), 0);
        const double most = support(s, hit->normal);
        // Off by the point's error, and by the normal's, which counts twice only.
        EXPECT_NEAR(hit->normal.dot(origin + direction * hit->t - s.centre_world), most,
                    4 * tolerance(s, origin, eps) * most);
    }
    EXPECT_GT(hits, 800);
}

TEST(Superquadric, CutOnesShowTheirInside) {
    Random random(6);
    int shown = 0;
    for (int k = 0; k < 500; ++k) {
        const Superquadric s = random_superquadric(random);
        const Vec3d origin = s.centre_world + random.unit() * 5;
        const Vec3d direction = s.centre_world + s.axes_world * random.in_cube(0.5) - origin;
        const BruteForce expected = brute_force(s, origin, direction);
        if (expected.least > 0.9) continue;
        const double first = double(*expected.first), last = double(*expected.last);
        const auto hit = intersect(s, origin, direction, (first + last) / 2);
        ASSERT_TRUE(hit);
        EXPECT_TRUE(hit->is_inside);
        EXPECT_GT(hit->normal.dot(direction), 0); // outwards, as of quadrics
        // Along a ray that goes straight in, N falls by some 0.1 per half chord at least.
        EXPECT_NEAR(hit->t, last, 10 * tolerance(s, origin, eps) * (last - first));
        EXPECT_FALSE(intersect(s, origin, direction, last + 0.01 * (last - first)));
        EXPECT_FALSE(intersect(s, origin, -direction));
        ++shown;
    }
    EXPECT_GT(shown, 200);
}

// ----------------------------------------------------------------------------------------- limits

TEST(Superquadric, WithBothExponents1ItIsTheEllipsoid) {
    Random random(7);
    for (int k = 0; k < 2000; ++k) {
        Superquadric s = random_superquadric(random);
        s.alpha = s.beta = 1;
        const Ellipsoid e{.centre_world = s.centre_world, .axes_world = s.axes_world};
        const Vec3d origin = s.centre_world + random.unit() * random.log_uniform(2, 100);
        const Vec3d direction = s.centre_world + s.axes_world * random.in_cube(0.5) - origin;
        const auto hit = intersect(s, origin, direction),
                   expected = intersect(e, origin, direction);
        ASSERT_TRUE(hit && expected); // 0.5 sqrt(3) < 1
        // By a cosine of at least 0.5 between the ray and the local normal, both within tolerance.
        EXPECT_NEAR(hit->t, expected->t, 4 * tolerance(s, origin, eps) * 2);
        EXPECT_LE((hit->normal - expected->normal).norm(),
                  1e3 * tolerance(s, origin, eps)); // axes to 1 : 10, hence normals 100 times
    }
}

// max(M, |z|) <= N <= 2^(1/r) max(M, |z|): the body lies in the cylinder, and scaled by 2^(beta/2)
// around it. Likewise M between the square and the circle, and boxes.
TEST(Superquadric, LiesBetweenACylinderAndASmallerOne) {
    Random random(8);
    int hits = 0;
    for (int k = 0; k < 2000; ++k) {
        const double radius = random.log_uniform(0.1, 1), half_length = random.log_uniform(0.1, 1);
        const Mat3d rotation = random.rotation();
        Superquadric s{.centre_world = random.in_cube(1),
                       .axes_world = rotation * Vec3d(radius, radius, half_length).asDiagonal(),
                       .alpha = 1,
                       .beta = random.log_uniform(0.05, 0.5)};
        const Vec3d half = rotation.col(2) * half_length;
        const Cylinder cylinder{.a_world = s.centre_world - half,
                                .b_world = s.centre_world + half,
                                .radius_world = radius,
                                .is_capped = true};
        Superquadric larger = s;
        larger.axes_world *= std::pow(2, s.beta / 2);
        const Vec3d origin = s.centre_world + random.unit() * 4;
        const Vec3d direction =
            (s.centre_world + s.axes_world * random.in_cube(1) - origin).normalized();
        const auto hit = intersect(s, origin, direction);
        const auto of_cylinder = intersect(cylinder, origin, direction);
        const auto of_larger = intersect(larger, origin, direction);
        if (hit) {
            ASSERT_TRUE(of_cylinder);
            EXPECT_LE(of_cylinder->t, hit->t + 1e-13); // roundings of the distance 4, some 50
            ++hits;
        }
        if (of_cylinder) {
            ASSERT_TRUE(of_larger);
            EXPECT_LE(of_larger->t, of_cylinder->t + 1e-13);
        }
    }
    EXPECT_GT(hits, 1000);
}

TEST(Superquadric, LiesBetweenABoxAndASmallerOne) {
    Random random(9);
    for (int k = 0; k < 2000; ++k) {
        Superquadric s = random_superquadric(random);
        s.alpha = s.beta = random.log_uniform(0.05, 0.2);
        Superquadric larger = s; // the corner has N = 3^(1/p)
        larger.axes_world *= std::pow(3, s.beta / 2);
        const Vec3d origin = s.centre_world + random.unit() * 4;
        const Vec3d direction =
            (s.centre_world + s.axes_world * random.in_cube(1) - origin).normalized();
        const auto hit = intersect(s, origin, direction);
        const auto of_larger = intersect(larger, origin, direction);
        // The ray enters the box where it has passed all three slabs.
        const Vec3d q = s.axes_world.inverse() * (origin - s.centre_world);
        const Vec3d d = s.axes_world.inverse() * direction;
        const Vec3d a = (-1 - q.array()) / d.array(), b = (1 - q.array()) / d.array();
        const double entry = a.cwiseMin(b).maxCoeff(), exit = a.cwiseMax(b).minCoeff();
        ASSERT_LE(entry, exit); // the target is in the box
        ASSERT_TRUE(of_larger);
        // 1e-12: roundings of the distance 4, of axes down to 0.1.
        EXPECT_LE(of_larger->t, entry + 1e-12);
        if (hit) {
            EXPECT_GE(hit->t, entry - 1e-12);
        }
    }
}

// ------------------------------------------------------------------------------------ derivatives

TEST(SuperquadricDerivatives, OfBallsAreThoseOfEllipsoids) {
    Random random(10);
    for (int k = 0; k < 500; ++k) {
        Superquadric s = random_superquadric(random);
        s.alpha = s.beta = 1;
        const Vec3d p = s.centre_world + s.axes_world * random.unit();
        const QuadricDerivatives d = derivatives(s, p);
        const QuadricDerivatives e =
            derivatives(Ellipsoid{.centre_world = s.centre_world, .axes_world = s.axes_world}, p);
        const Curvatures expected = principal_curvatures(e.gradient, e.hessian);
        const Curvatures found = principal_curvatures(d.gradient, d.hessian);
        EXPECT_NEAR(found.k1, expected.k1, 1e-12 * std::abs(expected.k1)); // as quadric.h states
        EXPECT_NEAR(found.k2, expected.k2, 1e-12 * std::abs(expected.k1));
    }
}

// Of the definition in long double: central differences of fourth order, whose error is h^4 times
// a fifth derivative (up to 39^4 per size^4) and a rounding over h^2.
TEST(SuperquadricDerivatives, AreThoseOfTheDefinition) {
    Random random(11);
    double worst_gradient = 0, worst_hessian = 0;
    for (int k = 0; k < 2000; ++k) {
        NormExponents<double> e{2 / random.log_uniform(0.05, 1), 0};
        e.r = e.p * random.uniform(1, 2); // beta <= alpha
        if (k % 4 == 0) e.p = 2;
        const Vec3d direction = random.unit();
        const Vec3d q = direction / superquadric_norm(direction, e).value;
        const Vec3d gradient = superquadric_norm(q, e).gradient;
        const Mat3d hessian = superquadric_norm_hessian(q, e);
        const auto n = [&](int i, long double a, int j, long double b) {
            std::array<long double, 3> x{q.x(), q.y(), q.z()};
            x[std::size_t(i)] += a;
            x[std::size_t(j)] += b;
            return norm_of(x[0], x[1], x[2], e.p, e.r);
        };
        const long double h = 2e-4L / e.r;
        const std::array<long double, 4> at{-2 * h, -h, h, 2 * h};
        const std::array<long double, 4> weight{1 / (12 * h), -8 / (12 * h), 8 / (12 * h),
                                                -1 / (12 * h)};
        for (int i = 0; i < 3; ++i) {
            long double slope = 0;
            for (std::size_t u = 0; u < 4; ++u) slope += weight[u] * n(i, at[u], i, 0);
            worst_gradient = std::max(worst_gradient, std::abs(double(slope - gradient[i])));
            for (int j = 0; j < 3; ++j) {
                long double bend = 0;
                for (std::size_t u = 0; u < 4; ++u)
                    for (std::size_t v = 0; v < 4; ++v)
                        bend += weight[u] * weight[v] * n(i, at[u], j, at[v]);
                worst_hessian =
                    std::max(worst_hessian, std::abs(double(bend - hessian(i, j))) / e.r);
            }
        }
        // Of degree 1: no bend along q. Convex: no negative bend anywhere.
        EXPECT_LE((hessian * q).norm(), 32 * eps * std::max(hessian.norm(), 1.0));
        EXPECT_GE(Eigen::SelfAdjointEigenSolver<Mat3d>(hessian).eigenvalues().minCoeff(),
                  -32 * eps * std::max(hessian.norm(), 1.0));
    }
    std::printf("gradient %.1e, hessian %.1e\n", worst_gradient, worst_hessian);
    EXPECT_LE(worst_gradient, 1e-12);
    // Roundings of long double, 1e-19, of 16 terms over h^2, which is down to 6e-12: some 1e-7, of
    // which the exponent, up to 80, was taken.
    EXPECT_LE(worst_hessian, 1e-9);
}

TEST(SuperquadricDerivatives, AreFiniteAtPolesAndOnFaces) {
    for (const auto& [alpha, beta] :
         {std::pair(1.0, 1.0), std::pair(1.0, 0.05), std::pair(0.05, 0.05), std::pair(0.5, 0.1)})
        for (int axis = 0; axis < 3; ++axis) {
            const Superquadric s{.alpha = alpha, .beta = beta};
            const QuadricDerivatives d = derivatives(s, Vec3d::Unit(axis));
            EXPECT_EQ(d.gradient, Vec3d(Vec3d::Unit(axis)));
            ASSERT_TRUE(d.hessian.allFinite());
            const Curvatures c = principal_curvatures(d.gradient, d.hessian);
            // A face is flat; around a cylinder the curvature is 1, of a ball it is both ways.
            const bool is_side = axis < 2 && alpha == 1;
            EXPECT_NEAR(c.k1, is_side || beta == 1 ? 1 : 0, 4 * eps);
            EXPECT_NEAR(c.k2, beta == 1 ? 1 : 0, 4 * eps);
        }
}

// ------------------------------------------------------------------------------- tensors to shapes

} // namespace
} // namespace isocast
