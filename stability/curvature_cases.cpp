// Principal curvatures at and near umbilics, of planes, where the gradient vanishes, for any normal
// and any unit; in double and in float32 GLSL, both against long double.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/curvature.h"
#include "stability/cases.h"
#include "stability/random.h"
#include "stability/shader_probe.h"
#include "volume/analytic_fields.h"

#include <glad/gl.h>

namespace isocast::stability {

namespace {

using Long = long double;
using Vec3l = Eigen::Vector3<Long>;
using Mat3l = Eigen::Matrix3<Long>;

struct Derivatives {
    Vec3d gradient;
    Mat3d hessian;
};

/// Curvatures by Gram and Schmidt's basis, which shares nothing with the one that is judged.
struct Truth {
    Long k1, k2;
    Vec3l n;
    Mat3l shape; // P H P / |g|
};

Truth truth_of(const Derivatives& d) {
    const Vec3l g = d.gradient.cast<Long>();
    const Vec3l n = g.normalized();
    int least = 0;
    n.cwiseAbs().minCoeff(&least);
    Vec3l u = Vec3l::Unit(least);
    u = (u - n * n.dot(u)).normalized();
    u = (u - n * n.dot(u)).normalized();
    const Vec3l v = n.cross(u);
    const Mat3l h = d.hessian.cast<Long>() / g.norm();
    const Long uu = u.dot(h * u), uv = u.dot(h * v), vv = v.dot(h * v);
    const Long root = std::hypot(uu - vv, 2 * uv);
    const Mat3l p = Mat3l::Identity() - n * n.transpose();
    return {(uu + vv + root) / 2, (uu + vv - root) / 2, n, p * h * p};
}

/// Errors of curvatures, of their difference and of directions, by the greatest entry of H/|g| and
/// `rounding`: how far S d - k d and the frame's products are from what they should be.
void see(Worst& worst, const Derivatives& d, const Curvatures& c, double rounding) {
    const Truth t = truth_of(d);
    const double unit = rounding * d.hessian.cwiseAbs().maxCoeff() / d.gradient.norm();
    const auto error = [&](Long e) { worst.see(static_cast<double>(std::abs(e)) / unit); };
    error(c.k1 - t.k1);
    error(c.k2 - t.k2);
    error((c.k1 - c.k2) - (t.k1 - t.k2));
    for (const auto& [k, direction] :
         {std::pair{t.k1, c.direction1}, std::pair{t.k2, c.direction2}}) {
        const Vec3l e = direction.cast<Long>();
        error((t.shape * e - k * e).norm());
        worst.see(static_cast<double>(std::abs(e.norm() - 1)) / rounding);
        worst.see(static_cast<double>(std::abs(e.dot(t.n))) / rounding);
    }
    worst.see(std::abs(c.direction1.dot(c.direction2)) / rounding);
}

/// Curvatures 1 ± difference/2 about random normals, and slopes off the surface beside them.
std::vector<Derivatives> near_umbilics(double difference) {
    Random random(1);
    std::vector<Derivatives> all;
    for (int i = 0; i < 200; ++i) {
        const Mat3d r = i == 0 ? Mat3d(Mat3d::Identity()) : random.rotation();
        Mat3d h = Mat3d(Vec3d(1 + difference / 2, 1 - difference / 2, 0).asDiagonal());
        h(0, 2) = h(2, 0) = random.uniform(-1, 1);
        h(2, 2) = random.uniform(-1, 1);
        const double length = i % 2 ? 1 : random.log_uniform(1e-3, 1e3);
        all.push_back({length * r.col(2), length * r * h * r.transpose()});
    }
    return all;
}

Mat3d symmetric(Random& random) {
    Mat3d h;
    h << random.in_cube(), random.in_cube(), random.in_cube();
    return (h + h.transpose()) / 2;
}

std::vector<Derivatives> any_normals() {
    Random random(2);
    std::vector<Vec3d> normals{{1, 0, 0},     {0, 1, 0},           {0, 0, 1},
                               {-1, 0, 0},    {0, -1, 0},          {0, 0, -1},
                               {1e-9, 0, -1}, {1e-30, -1e-30, -1}, {1e-17, 1e-17, 1}};
    for (int i = 0; i < 300; ++i) normals.push_back(random.unit());
    std::vector<Derivatives> all;
    for (const Vec3d& n : normals) all.push_back({n, symmetric(random)});
    return all;
}

std::vector<Derivatives> in_units(double unit) {
    std::vector<Derivatives> all = any_normals();
    for (Derivatives& d : all) {
        d.gradient *= unit;
        d.hessian *= unit;
    }
    return all;
}

/// Where eq. 6.8 as printed is the zero vector: a12 = 0 and k = a11.
std::vector<Derivatives> principal_bases() {
    std::vector<Derivatives> all;
    for (const Vec3d& pure : {Vec3d(3, 1, 0), Vec3d(1, 3, 0), Vec3d(-1, -3, 2), Vec3d(0, 5, 0)})
        for (int axis = 0; axis < 3; ++axis) {
            const Vec3d turned(pure[axis], pure[(axis + 1) % 3], pure[(axis + 2) % 3]);
            all.push_back({Vec3d::Unit((5 - axis) % 3), turned.asDiagonal()});
        }
    return all;
}

std::vector<Derivatives> exact_umbilics() {
    Random random(3);
    std::vector<Derivatives> all;
    for (int i = 0; i < 100; ++i) all.push_back({random.unit(), 2 * Mat3d::Identity()});
    for (int axis = 0; axis < 3; ++axis) all.push_back({Vec3d::Unit(axis), Mat3d::Identity()});
    return all;
}

/// No bend along the surface: of planes H has a part along n alone.
std::vector<Derivatives> planes() {
    Random random(4);
    std::vector<Derivatives> all;
    for (int i = 0; i < 100; ++i) {
        const Vec3d n = i < 3 ? Vec3d(Vec3d::Unit(i)) : random.unit();
        all.push_back({n, n * n.transpose()});
    }
    return all;
}

Worst in_double(const std::vector<Derivatives>& all) {
    Worst worst;
    for (const Derivatives& d : all)
        see(worst, d, principal_curvatures(d.gradient, d.hessian), 0x1p-53);
    return worst;
}

Worst in_glsl(Device& device, std::vector<Derivatives> all) {
    using Vec4f = Eigen::Vector4f;
    const auto padded = [](const Vec3d& v) {
        return Vec4f(float(v.x()), float(v.y()), float(v.z()), 0);
    };
    std::vector<Vec4f> in;
    for (Derivatives& d : all) {
        // What the shader sees.
        d.gradient = d.gradient.cast<float>().cast<double>();
        d.hessian = d.hessian.cast<float>().cast<double>();
        in.push_back(padded(d.gradient));
        for (int k = 0; k < 3; ++k) in.push_back(padded(d.hessian.col(k)));
    }
    const std::vector<Vec4f> out = run_curvature_probe(device, in);
    const auto vector = [&](std::size_t i) -> Vec3d { return out[i].head<3>().cast<double>(); };
    Worst worst;
    for (std::size_t i = 0; i < all.size(); ++i)
        see(worst, all[i], {out[3 * i][0], out[3 * i][1], vector(3 * i + 1), vector(3 * i + 2)},
            0x1p-24);
    return worst;
}

/// Of distances, whose curvatures are known, over forty powers of two.
Worst spheres_of_any_size() {
    Random random(5);
    Worst worst;
    for (int i = 0; i < 1000; ++i) {
        const Vec3d p = random.unit() * std::exp2(random.uniform(-20, 20));
        const Jet jet = sphere_field(Vec3d::Zero(), 1).jet(p);
        const Curvatures c = principal_curvatures(jet.gradient, jet.hessian);
        worst.see(std::abs(c.k1 * p.norm() - 1) / 0x1p-53);
        worst.see(std::abs(c.k2 * p.norm() - 1) / 0x1p-53);
    }
    return worst;
}

Worst tori_of_any_thickness() {
    Random random(6);
    Worst worst;
    for (int i = 0; i < 1000; ++i) {
        const double minor = random.log_uniform(1e-4, 0.99);
        const double u = random.uniform(-3.14, 3.14), v = random.uniform(-3.14, 3.14);
        const double ring = 1 + minor * std::cos(v);
        const Vec3d p(ring * std::cos(u), ring * std::sin(u), minor * std::sin(v));
        const Jet jet = torus_field(Vec3d::Zero(), Vec3d::UnitZ(), 1, minor).jet(p);
        const Curvatures c = principal_curvatures(jet.gradient, jet.hessian);
        // The tube's own radius is a difference of numbers near 1.
        const double unit = 0x1p-53 / (minor * minor);
        worst.see(std::abs(c.k1 - 1 / minor) / unit);
        worst.see(std::abs(c.k2 - std::cos(v) / ring) / unit);
    }
    return worst;
}

Worst zero_where_the_gradient_vanishes() {
    Worst worst;
    for (const double x : {0.0, -0.0}) {
        const Curvatures c = principal_curvatures(Vec3d(x, 0, 0), Mat3d::Ones());
        worst.see(std::abs(c.k1) + std::abs(c.k2) + c.direction1.norm() + c.direction2.norm());
        worst.see(std::abs(normal_curvature(Vec3d(x, 0, 0), Mat3d::Ones(), Vec3d::UnitX())));
        worst.see(flow_line_curvature(Vec3d(x, 0, 0), Mat3d::Ones()));
    }
    return worst;
}

Worst normal_curvature_is_eulers() {
    Random random(7);
    Worst worst;
    for (const Derivatives& d : any_normals()) {
        const Curvatures c = principal_curvatures(d.gradient, d.hessian);
        const double angle = random.uniform(-3, 3);
        const Vec3d direction = std::cos(angle) * c.direction1 + std::sin(angle) * c.direction2;
        worst.see(std::abs(normal_curvature(d.gradient, d.hessian, direction) -
                           c.k1 * std::pow(std::cos(angle), 2) -
                           c.k2 * std::pow(std::sin(angle), 2)) /
                  0x1p-53);
    }
    return worst;
}

Worst distances_have_straight_flow_lines() {
    Random random(8);
    Worst worst;
    for (const char* name : {"sphere", "torus", "cylinder"})
        for (int i = 0; i < 300; ++i) {
            const Jet jet = builtin_field(name).jet(random.in_cube(1.4));
            worst.see(flow_line_curvature(jet.gradient, jet.hessian) /
                      (0x1p-53 * std::max(1.0, jet.hessian.norm())));
        }
    return worst;
}

} // namespace

void append_curvature_cases(std::vector<Case>& cases) {
    const char* compares = "k1, k2, k1 - k2, residuals of directions and long double [roundings of "
                           "the greatest entry]";
    const char* from = "some ten products and sums of a rounding or two each";
    const auto both = [&](const std::string& name, std::vector<Derivatives> (*make)()) {
        cases.push_back({"curvature." + name + ".double", compares, 32, from,
                         [make](Devices&) { return in_double(make()); }});
        append(cases, {"curvature." + name, compares, 32, from,
                       [make](Device& device) { return in_glsl(device, make()); }});
    };
    for (const char* difference : {"1", "1e-02", "1e-04", "1e-06", "1e-08", "1e-10", "1e-12"}) {
        const double value = std::stod(difference);
        const std::string name = std::string("curvature.umbilic-") + difference;
        cases.push_back({name + ".double", compares, 32, from,
                         [value](Devices&) { return in_double(near_umbilics(value)); }});
        append(cases, {name, compares, 32, from,
                       [value](Device& device) { return in_glsl(device, near_umbilics(value)); }});
    }
    both("umbilic-exact", exact_umbilics);
    both("eq-6.8-zero", principal_bases);
    both("plane", planes);
    both("any-normal", any_normals);
    both("units-of-1e-9", [] { return in_units(1e-9); });
    both("units-of-1e9", [] { return in_units(1e9); });
    const auto add = [&](const char* name, const char* what, double bound, const char* why,
                         auto run) {
        cases.push_back({std::string("curvature.") + name, what, bound, why,
                         [run](Devices&) { return run(); }});
    };
    add("units-of-1e-150.double", compares, 32, from, [] { return in_double(in_units(1e-150)); });
    add("units-of-1e150.double", compares, 32, from, [] { return in_double(in_units(1e150)); });
    add("sphere-2^-20-to-2^20", "k1 and k2 of spheres times their radius and 1 [roundings]", 32,
        from, spheres_of_any_size);
    add("torus-1e-4-to-1",
        "k1 and k2 of tori and those of their circles [roundings over minor "
        "radius squared]",
        64, "the field's own distances add four roundings", tori_of_any_thickness);
    add("no-gradient", "all curvatures and directions where the gradient is zero and zero", 0,
        "defined so", zero_where_the_gradient_vanishes);
    add("eulers-formula", "normal curvature and Euler's mix of k1 and k2 [roundings]", 32, from,
        normal_curvature_is_eulers);
    add("flow-lines-of-distances", "flow line curvature of distances and none [roundings of H]", 32,
        from, distances_have_straight_flow_lines);
}

} // namespace isocast::stability
