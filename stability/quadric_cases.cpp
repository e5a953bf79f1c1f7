// Rays against primitives, in double and in the float32 of the shaders: tangent, far, thin, along
// axes and sides, against the definitions in long double. Bounds on screen likewise.
// SPDX-License-Identifier: MPL-2.0
#include "quadrics/quadric.h"
#include "quadrics/screen_bounds.h"
#include "quadrics/superquadric.h"
#include "stability/cases.h"
#include "stability/random.h"

namespace isocast::stability {

namespace {

using Long = long double;
using Vec3l = Eigen::Vector3<Long>;
using Mat3l = Eigen::Matrix3<Long>;

/// A hit, from the ray's origin: so far from the world's origin long double has few digits, too.
struct Place {
    Vec3d origin;
    Vec3l step;
    Vec3l from(const Vec3d& p) const { return step - (p.cast<Long>() - origin.cast<Long>()); }
};

/// How far a point is off a surface, to first order.
Long off(const Sphere& s, const Place& p) {
    return p.from(s.centre_world).norm() - s.radius_world;
}
Long off(const Ellipsoid& e, const Place& p) {
    const Mat3l inverse = e.axes_world.cast<Long>().inverse();
    const Vec3l q = inverse * p.from(e.centre_world);
    return (q.dot(q) - 1) / (2 * (inverse.transpose() * q).norm());
}
Long off(const Cone& c, const Place& p) {
    const Vec3l d = c.b_world.cast<Long>() - c.a_world.cast<Long>();
    const Vec3l from_a = p.from(c.a_world);
    const Long along = from_a.dot(d) / d.dot(d);
    const Long slope = (Long(c.radius_b_world) - c.radius_a_world) / d.norm();
    const Long rho = (from_a - along * d).norm();
    return (rho - c.radius_a_world - along * slope * d.norm()) / std::hypot(Long(1), slope);
}
Long off(const Cylinder& c, const Place& p) {
    return off(Cone{c.a_world, c.b_world, c.radius_world, c.radius_world}, p);
}
Long off(const ClippedQuadric& k, const Place& p) {
    const Mat3l inverse = k.axes_world.cast<Long>().inverse();
    const Vec3l q = inverse * p.from(k.centre_world);
    const Mat3l a = k.a.cast<Long>();
    const Vec3l b = k.b.cast<Long>();
    return (q.dot(a * q) + 2 * b.dot(q) + k.c) / (2 * (inverse.transpose() * (a * q + b)).norm());
}

/// A ray, and whether it is known to hit.
struct Ray {
    Vec3d origin, direction;
    bool hits;
    bool is_clear = true; // not as near to a silhouette as rounding decides
};

/// Shoots a ray: how far hits lie off the surface, in roundings of the distance of the origin.
template<class Real, class Primitive>
void shoot(Worst& worst, const Primitive& primitive, const Ray& ray) {
    const Eigen::Vector3<Real> direction = ray.direction.cast<Real>();
    const Quadric quadric = quadric_of(primitive);
    const auto hit = first_hit(seen_from<Real>(quadric, ray.origin), direction, Real(0));
    if (ray.is_clear) worst.must(hit.has_value() == ray.hits);
    if (!hit || hit->cap != 0) return;
    const Place p{ray.origin, Long(hit->t) * direction.template cast<Long>()};
    const Vec3d middle = quadric.anchor_world + quadric.centre_from_anchor;
    const Long scale = std::max(Long((ray.origin - middle).norm()), Long(p.from(middle).norm()));
    worst.see(static_cast<double>(std::abs(off(primitive, p)) / scale) /
              (std::is_same_v<Real, float> ? 0x1p-24 : 0x1p-53));
}

/// A ray whose closest approach to `centre` is `offset` radii from it.
Ray past(const Vec3d& origin, const Vec3d& centre, double radius, double offset, Random& random) {
    const Vec3d to_centre = centre - origin;
    const double sine = offset * radius / to_centre.norm();
    const Vec3d side = to_centre.cross(random.unit()).normalized();
    return {origin,
            to_centre.normalized() * std::sqrt(std::max(0.0, 1 - sine * sine)) + side * sine,
            offset < 1};
}

template<class Real>
Worst spheres_at(double ratio, const Vec3d& shift) {
    Random random(1);
    Worst worst;
    for (int i = 0; i < 1000; ++i) {
        const Sphere s{.centre_world = random.in_cube() + shift, .radius_world = ratio};
        Ray ray = past(s.centre_world + random.unit(), s.centre_world, ratio,
                       random.uniform(0, 1.2), random);
        // By what a direction's and the centre's rounding may move the ray.
        const double doubt = (std::is_same_v<Real, float> ? 0x1p-22 : 0x1p-50) *
                             (1 + shift.norm() * 0x1p-29) / ratio;
        const double offset = (s.centre_world - ray.origin).cross(ray.direction).norm() / ratio;
        ray.is_clear = std::abs(offset - 1) > doubt;
        shoot<Real>(worst, s, ray);
    }
    return worst;
}

template<class Real>
Worst grazing() {
    Random random(2);
    Worst worst;
    for (int i = 0; i < 2000; ++i) {
        const double sign = i % 2 ? 1 : -1;
        const double deviation = random.log_uniform(1e-15, 1e-3);
        const Sphere s{.centre_world = random.in_cube(),
                       .radius_world = random.log_uniform(0.1, 10)};
        const double distance = s.radius_world * random.log_uniform(1.01, 100);
        Ray ray = past(s.centre_world + distance * random.unit(), s.centre_world, s.radius_world,
                       1 + sign * deviation, random);
        ray.is_clear = deviation > (std::is_same_v<Real, float> ? 0x1p-20 : 0x1p-48) * distance /
                                       s.radius_world;
        shoot<Real>(worst, s, ray);
    }
    return worst;
}

/// Into the inside of a primitive from all around: all must hit, be it at a cap.
template<class Real, class Make>
Worst into(Make make, const Vec3d& shift = Vec3d::Zero()) {
    Random random(3);
    Worst worst;
    for (int i = 0; i < 1000; ++i) {
        const auto [primitive, inside, size] = make(random, shift);
        const Vec3d origin = inside + size * random.uniform(3, 10) * random.unit();
        // Any length.
        shoot<Real>(worst, primitive,
                    {origin, (inside - origin) * random.log_uniform(0.1, 10), true});
    }
    return worst;
}

template<class Primitive>
struct Aimed {
    Primitive primitive;
    Vec3d inside;
    double size;
};

/// Semi-axes 1, 1 or `thin`, and `thin`.
auto thin_ellipsoids(double thin, bool is_needle) {
    return [=](Random& random, const Vec3d& shift) {
        const Ellipsoid e{.centre_world = random.in_cube() + shift,
                          .axes_world = random.rotation() *
                                        Vec3d(1, is_needle ? thin : 1, thin).asDiagonal()};
        return Aimed<Ellipsoid>{e, e.centre_world + e.axes_world * random.in_cube(0.3), 1};
    };
}

auto any_cylinders(double thin) {
    return [=](Random& random, const Vec3d& shift) {
        const Vec3d a = random.in_cube() + shift;
        const Vec3d axis = random.unit();
        const Cylinder c{
            .a_world = a, .b_world = a + axis, .radius_world = thin, .is_capped = true};
        return Aimed<Cylinder>{c, a + random.uniform(0.1, 0.9) * axis, 1};
    };
}

auto any_cones(Random& random, const Vec3d& shift) {
    const Vec3d a = random.in_cube() + shift;
    const Vec3d axis = random.unit();
    const Cone c{.a_world = a, .b_world = a + axis, .radius_a_world = random.uniform(0.1, 1)};
    return Aimed<Cone>{c, a + random.uniform(0.1, 0.8) * axis, 1};
}

/// Rays along directions in which alpha is 0, or almost: of a paraboloid, along its axis.
template<class Real>
Worst paraboloids(double tilt) {
    Random random(4);
    Worst worst;
    for (int i = 0; i < 1000; ++i) {
        const ClippedQuadric k{.centre_world = random.in_cube(),
                               .a = Vec3d(1, 1, 0).asDiagonal(),
                               .b = {0, 0, 0.5},
                               .c = -0.2};
        const Vec3d q(random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4), 0);
        shoot<Real>(worst, k,
                    {k.centre_world + q + Vec3d(0, 0, 4),
                     Vec3d(tilt * random.uniform(-1, 1), 0, -1), true});
    }
    return worst;
}

/// Parallel to a side of a cone, inside of it: one root is at infinity.
template<class Real>
Worst along_a_side() {
    Random random(5);
    Worst worst;
    for (int i = 0; i < 1000; ++i) {
        const Cone c{.a_world = {0, 0, 1},
                     .b_world = {0, 0, -1},
                     .radius_a_world = 0,
                     .radius_b_world = random.uniform(0.2, 1),
                     .is_capped = false};
        const Vec3d side = Vec3d(c.radius_b_world, 0, -2);
        // From outside, beyond the axis, to the side that is not parallel.
        const double depth = random.uniform(0.1, 0.8);
        const Vec3d target = c.a_world + depth * Vec3d(-c.radius_b_world, 0, -2);
        shoot<Real>(worst, c, {target - side * random.uniform(1, 3), side, true});
    }
    return worst;
}

/// Along the axis of a cylinder: an open one lets all pass, a capped one stops them at its end.
template<class Real>
Worst along_an_axis() {
    Random random(6);
    Worst worst;
    for (int i = 0; i < 300; ++i) {
        Cylinder c{.a_world = {0, 0, -1}, .b_world = {0, 0, 2}, .radius_world = 0.5};
        const Vec3d start =
            Vec3d(random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), random.log_uniform(3, 1e6));
        shoot<Real>(worst, c, {start, {0, 0, -1}, false});
        c.is_capped = true;
        const auto hit = first_hit(seen_from<Real>(quadric_of(c), start),
                                   Eigen::Vector3<Real>(0, 0, -1), Real(0));
        worst.must(hit.has_value());
        if (hit)
            worst.see(std::abs(double(hit->t) - (start.z() - 2)) / start.z() /
                      (std::is_same_v<Real, float> ? 0x1p-24 : 0x1p-53));
    }
    return worst;
}

/// From inside: behind the eye is no hit, the inner side is one.
template<class Real>
Worst from_inside() {
    Random random(7);
    Worst worst;
    for (int i = 0; i < 1000; ++i) {
        const Sphere s{.centre_world = random.in_cube(),
                       .radius_world = random.log_uniform(1e-3, 1e3)};
        const Vec3d inside =
            s.centre_world + random.uniform(0, 0.9) * s.radius_world * random.unit();
        shoot<Real>(worst, s, {inside, random.unit(), true});
        const Vec3d n = random.unit();
        // Outwards from just outside.
        const Vec3d outside = s.centre_world + 1.001 * s.radius_world * n;
        shoot<Real>(worst, s, {outside, n, false});
    }
    return worst;
}

/// Two components of the closed form of a sphere's box on the picture, by long double.
template<class Real>
Worst bounds_of_spheres(double ratio) {
    Random random(8);
    Worst worst;
    for (int i = 0; i < 2000; ++i) {
        const Vec3d centre =
            Vec3d(random.uniform(-1, 1), random.uniform(-1, 1), -random.uniform(1, 2));
        const double radius = ratio * centre.norm();
        const Eigen::Vector3<Real> c = centre.cast<Real>();
        const Eigen::Matrix3<Real> axes = Eigen::Matrix3<Real>::Identity() * Real(radius);
        const Eigen::Vector2<Real> x = extent_along(Eigen::Vector2<Real>(1, 0), c, axes, true);
        const Long cx = c.x(), cz = c.z(), r = Real(radius);
        const Long root = std::sqrt(cx * cx + cz * cz - r * r);
        // x / -z = (-cx cz -+ r root) / (cz^2 - r^2)
        const Long lo = (-cx * cz - r * root) / (cz * cz - r * r);
        const Long hi = (-cx * cz + r * root) / (cz * cz - r * r);
        const double unit = (std::is_same_v<Real, float> ? 0x1p-24 : 0x1p-53) *
                            std::max({1.0, std::abs(double(lo)), std::abs(double(hi))});
        worst.see(static_cast<double>(std::abs(x.x() - lo)) / unit);
        worst.see(static_cast<double>(std::abs(x.y() - hi)) / unit);
    }
    return worst;
}

Worst bounds_across_the_eye() {
    const PictureSpace space; // the eye at 0, looking along -z
    Worst worst;
    worst.must(screen_bounds(Sphere{.centre_world = {0, 0, 0.5}}, space).extent ==
               ScreenExtent::Everything);
    worst.must(screen_bounds(Sphere{.centre_world = {3, 0, -0.5}}, space).extent ==
               ScreenExtent::Everything);
    worst.must(screen_bounds(Sphere{.centre_world = {0, 0, 5}}, space).extent ==
               ScreenExtent::Nothing);
    worst.must(screen_bounds(Sphere{.centre_world = {0, 0, -5}}, space).extent ==
               ScreenExtent::Rectangle);
    return worst;
}

/// Superquadrics of exponents 1 are ellipsoids; both by their own ways.
template<class Real>
Worst superquadric_is_ellipsoid() {
    Random random(9);
    Worst worst;
    for (int i = 0; i < 1000; ++i) {
        Mat3d axes = random.rotation();
        axes = axes * Vec3d(1, random.uniform(0.1, 1), random.uniform(0.1, 1)).asDiagonal();
        const Superquadric s{.axes_world = axes};
        const Ellipsoid e{.axes_world = axes};
        const Vec3d origin = random.uniform(2, 10) * random.unit();
        const Vec3d direction = axes * random.in_cube(0.5) - origin;
        const auto hit = first_hit(seen_from<Real>(s, origin),
                                   Eigen::Vector3<Real>(direction.cast<Real>()), Real(0));
        worst.must(hit.has_value());
        if (!hit) continue;
        const Place p{origin, Long(hit->t) * direction.cast<Real>().template cast<Long>()};
        worst.see(static_cast<double>(std::abs(off(e, p))) / origin.norm() /
                  (std::is_same_v<Real, float> ? 0x1p-24 : 0x1p-53));
    }
    return worst;
}

/// The sharpest lie between a box and one that is smaller by 2^-exponents.
Worst sharpest_superquadric() {
    Random random(10);
    const Superquadric s{.alpha = 0.05, .beta = 0.05};
    // Where all three are equal: 3^(-1/40) along each axis, rounded down.
    const double inner = std::pow(3.0, -1.0 / 40);
    Worst worst;
    for (int i = 0; i < 2000; ++i) {
        const Vec3d origin = random.uniform(2, 10) * random.unit();
        const Vec3d direction = random.in_cube(0.8) - origin;
        const auto hit = intersect(s, origin, direction);
        worst.must(hit.has_value());
        if (!hit) continue;
        const double size = (origin + hit->t * direction).cwiseAbs().maxCoeff();
        worst.see(std::max(size - 1, inner - size) / (0x1p-53 * origin.norm()));
    }
    return worst;
}

} // namespace

void append_quadric_cases(std::vector<Case>& cases) {
    const char* compares = "hits and the definition in long double [roundings of the distance]; "
                           "rays that must hit or miss";
    const char* from = "some ten sums of three products, six roundings each: of the factors, "
                       "products and sums; about the closest approach, where none is larger than "
                       "the distance squared";
    const auto add = [&](const std::string& name, const char* what, double bound, const char* why,
                         auto run) {
        cases.push_back({"quadric." + name, what, bound, why, [run](Devices&) { return run(); }});
    };
    // Of a pair that is run in double and in the shaders' float.
    const auto both = [&](const std::string& name, auto in_double, auto in_float) {
        add(name + ".double", compares, 60, from, in_double);
        add(name + ".float", compares, 60, from, in_float);
    };
    for (const char* ratio : {"1e-01", "1e-02", "1e-03", "1e-04", "1e-05", "1e-06"})
        both(
            std::string("sphere-") + ratio,
            [r = std::stod(ratio)] { return spheres_at<double>(r, Vec3d::Zero()); },
            [r = std::stod(ratio)] { return spheres_at<float>(r, Vec3d::Zero()); });
    const Vec3d far(1e6, -1e6, 1e6);
    both(
        "sphere-at-1e6", [far] { return spheres_at<double>(1e-2, far); },
        [far] { return spheres_at<float>(1e-2, far); });
    both("grazing", grazing<double>, grazing<float>);
    both("from-inside", from_inside<double>, from_inside<float>);
    for (const char* thin : {"1e-02", "1e-04", "1e-06"})
        for (const bool is_needle : {false, true}) {
            const auto make = thin_ellipsoids(std::stod(thin), is_needle);
            both(
                std::string(is_needle ? "needle-" : "disc-") + thin,
                [make] { return into<double>(make); }, [make] { return into<float>(make); });
        }
    both(
        "cylinder-1e-3-thin", [] { return into<double>(any_cylinders(1e-3)); },
        [] { return into<float>(any_cylinders(1e-3)); });
    both(
        "cone", [] { return into<double>(any_cones); }, [] { return into<float>(any_cones); });
    both(
        "cone-at-1e6", [far] { return into<double>(any_cones, far); },
        [far] { return into<float>(any_cones, far); });
    both(
        "alpha-0", [] { return paraboloids<double>(0); }, [] { return paraboloids<float>(0); });
    both(
        "alpha-1e-12", [] { return paraboloids<double>(1e-6); },
        [] { return paraboloids<float>(1e-6); });
    both("along-a-cones-side", along_a_side<double>, along_a_side<float>);
    both("along-a-cylinders-axis", along_an_axis<double>, along_an_axis<float>);
    both("superquadric-of-exponents-1", superquadric_is_ellipsoid<double>,
         superquadric_is_ellipsoid<float>);
    add("superquadric-sharpest", "hits of exponents 2/0.05 between two boxes [roundings]", 32, from,
        sharpest_superquadric);
    for (const char* ratio : {"0.5", "1e-03", "1e-06"}) {
        const auto bounds = [&](const char* in, auto run) {
            add(std::string("bounds-of-a-sphere-") + ratio + in,
                "sides on the picture and the closed form in long double [roundings]", 32,
                "the discriminant is a difference of squares that do not cancel", run);
        };
        const double r = std::stod(ratio);
        bounds(".double", [r] { return bounds_of_spheres<double>(r); });
        bounds(".float", [r] { return bounds_of_spheres<float>(r); });
    }
    add("bounds-across-the-eye", "which spheres cover all, nothing or a rectangle", 0, "known",
        bounds_across_the_eye);
}

} // namespace isocast::stability
