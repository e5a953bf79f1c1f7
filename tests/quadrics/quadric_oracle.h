// Where rays meet primitives by brute force, in 113 bits: the definitions of primitives.h are
// evaluated at points along the ray, and signs bracket the roots. Nothing of it knows a formula of
// quadrics/.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/primitives.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <vector>

namespace isocast::oracle {

__extension__ typedef __float128 Quad;

struct Q3 {
    Quad x, y, z;
};
inline Q3 of(const Vec3d& v) {
    return {v.x(), v.y(), v.z()};
}
inline Q3 operator+(const Q3& a, const Q3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Q3 operator-(const Q3& a, const Q3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Q3 operator*(const Q3& a, Quad s) {
    return {a.x * s, a.y * s, a.z * s};
}
inline Quad dot(const Q3& a, const Q3& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Q3 cross(const Q3& a, const Q3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Quad magnitude(Quad x) {
    return x < 0 ? -x : x;
}
/// By Cramer's rule.
inline Q3 solve(const Mat3d& m, const Q3& p) {
    const Q3 u = of(m.col(0)), v = of(m.col(1)), w = of(m.col(2));
    const Quad determinant = dot(u, cross(v, w));
    return Q3{dot(p, cross(v, w)), dot(u, cross(p, w)), dot(u, cross(v, p))} * (1 / determinant);
}

/// A primitive by its definition: the sign of `value` tells inside from outside, and the surface is
/// where `clip` <= 0 too. Caps lie where `along` is 0 or 1.
struct Definition {
    std::function<Quad(const Q3&)> value;
    std::function<Quad(const Q3&)> clip;
    std::function<Quad(const Q3&)> along;
    std::array<bool, 2> has_cap{};
    Vec3d centre_world;
    double size_world; // of a ball that holds it
};

inline Definition definition(const Sphere& s) {
    return {.value = [s](const Q3& p) -> Quad {
                const Q3 q = p - of(s.centre_world);
                return dot(q, q) - Quad(s.radius_world) * s.radius_world;
            },
            .clip = {},
            .along = {},
            .centre_world = s.centre_world,
            .size_world = s.radius_world};
}

inline Definition definition(const Ellipsoid& e) {
    return {.value = [e](const Q3& p) -> Quad {
                const Q3 q = solve(e.axes_world, p - of(e.centre_world));
                return dot(q, q) - 1;
            },
            .clip = {},
            .along = {},
            .centre_world = e.centre_world,
            .size_world = e.axes_world.norm()};
}

inline Definition definition(const Cone& c) {
    const Q3 a = of(c.a_world);
    const Q3 d = of(c.b_world) - a;
    const auto along = [a, d](const Q3& p) -> Quad { return dot(p - a, d) / dot(d, d); };
    return {.value = [=](const Q3& p) -> Quad {
                const Q3 across = cross(p - a, d);
                const Quad r =
                    c.radius_a_world + (Quad(c.radius_b_world) - c.radius_a_world) * along(p);
                return dot(across, across) / dot(d, d) - r * r;
            },
            .clip = [=](const Q3& p) -> Quad { return std::max(-along(p), along(p) - 1); },
            .along = along,
            .has_cap = {c.is_capped && c.radius_a_world > 0, c.is_capped && c.radius_b_world > 0},
            .centre_world = (c.a_world + c.b_world) / 2,
            .size_world =
                (c.b_world - c.a_world).norm() / 2 + std::max(c.radius_a_world, c.radius_b_world)};
}

inline Definition definition(const Cylinder& c) {
    return definition(Cone{.a_world = c.a_world,
                           .b_world = c.b_world,
                           .radius_a_world = c.radius_world,
                           .radius_b_world = c.radius_world,
                           .is_capped = c.is_capped});
}

inline Definition definition(const ClippedQuadric& k) {
    return {.value = [k](const Q3& p) -> Quad {
                const Q3 q = solve(k.axes_world, p - of(k.centre_world));
                const std::array<Quad, 3> x{q.x, q.y, q.z};
                Quad sum = k.c;
                for (int i = 0; i < 3; ++i) {
                    sum += 2 * k.b[i] * x[i];
                    for (int j = 0; j < 3; ++j) sum += x[i] * k.a(i, j) * x[j];
                }
                return sum;
            },
            .clip = [k](const Q3& p) -> Quad {
                const Q3 q = solve(k.axes_world, p - of(k.centre_world));
                return std::max({magnitude(q.x), magnitude(q.y), magnitude(q.z)}) - 1;
            },
            .along = {},
            .centre_world = k.centre_world,
            .size_world = k.axes_world.norm()};
}

struct Hit {
    Quad t;
    int cap = 0;
};

/// The first hit with t >= t_near. Along a ray the value is of second degree, so that it is
/// monotone on either side of its extremum; on each side a change of sign brackets one root.
inline std::optional<Hit> first_hit(const Definition& d, const Vec3d& origin,
                                    const Vec3d& direction, double t_near) {
    const auto at = [&](Quad t) -> Q3 { return of(origin) + of(direction) * t; };
    const auto value = [&](Quad t) -> Quad { return d.value(at(t)); };
    const double reach = (origin - d.centre_world).norm() + d.size_world;
    const Quad t_end = Quad(2 * reach / direction.norm()) + 1;
    // Three values give the extremum, about the point nearest to the centre.
    const Quad step = Quad(d.size_world / direction.norm());
    const Quad middle =
        dot(of(d.centre_world) - of(origin), of(direction)) / dot(of(direction), of(direction));
    const Quad low = value(middle - step), mid = value(middle), high = value(middle + step);
    const Quad bend = low - 2 * mid + high;
    Quad extremum = t_end;
    if (bend != 0) extremum = middle - step * (high - low) / (2 * bend);
    extremum = std::clamp(extremum, Quad(t_near), t_end);

    std::optional<Hit> first;
    const auto offer = [&](Quad t, int cap) {
        if (t >= t_near && (!first || t < first->t)) first = Hit{t, cap};
    };
    const std::array<std::array<Quad, 2>, 2> sides{{{Quad(t_near), extremum}, {extremum, t_end}}};
    for (auto [from, to] : sides) {
        const Quad sign = value(from);
        if ((sign < 0) == (value(to) < 0)) continue;
        // 110 halvings reach the last bit. After 40 the rest is nearly linear; secants that leave
        // the bracket are replaced by halving.
        for (int i = 0; i < 110; ++i) {
            Quad t = (from + to) / 2;
            if (i >= 40 && i % 2 == 0) {
                const Quad f0 = value(from), f1 = value(to);
                const Quad secant = from - f0 * (to - from) / (f1 - f0);
                if (secant > from && secant < to) t = secant;
            }
            if (t <= from || t >= to || (i > 50 && to - from < Quad(1e-30) * t_end)) break;
            ((value(t) < 0) == (sign < 0) ? from : to) = t;
        }
        const Quad root = (from + to) / 2;
        if (!d.clip || d.clip(at(root)) <= 0) offer(root, 0);
    }
    for (const int end : {0, 1}) {
        if (!d.has_cap[end]) continue;
        const Quad z0 = d.along(at(0)), z1 = d.along(at(1));
        if (z0 == z1) continue;
        const Quad t = (end - z0) / (z1 - z0);
        if (value(t) <= 0) offer(t, end + 1);
    }
    return first;
}

} // namespace isocast::oracle
