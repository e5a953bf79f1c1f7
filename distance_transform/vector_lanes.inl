// Eight vectors side by side, and numbers brought side by side.
//
// Included in the namespace of one instruction set, after lanes.inl.

namespace {

using Doubles = Lanes<double>;

struct Vector {
    Doubles x;
    Doubles y;
    Doubles z;

    friend ISOCAST_INLINE Vector operator+(const Vector& a, const Vector& b) {
        return {a.x + b.x, a.y + b.y, a.z + b.z};
    }
    friend ISOCAST_INLINE Vector operator-(const Vector& a, const Vector& b) {
        return {a.x - b.x, a.y - b.y, a.z - b.z};
    }
    friend ISOCAST_INLINE Vector operator*(const Doubles& f, const Vector& a) {
        return {f * a.x, f * a.y, f * a.z};
    }
    friend ISOCAST_INLINE Doubles dot(const Vector& a, const Vector& b) {
        return a.x * b.x + a.y * b.y + a.z * b.z;
    }
    friend ISOCAST_INLINE Vector cross(const Vector& a, const Vector& b) {
        return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    }
    friend ISOCAST_INLINE Doubles norm(const Vector& a) { return sqrt(dot(a, a)); }
    friend ISOCAST_INLINE Vector select(const Mask<double>& m, const Vector& a, const Vector& b) {
        return {select(m, a.x, b.x), select(m, a.y, b.y), select(m, a.z, b.z)};
    }
    friend ISOCAST_INLINE Vector min(const Vector& a, const Vector& b) {
        return {min(a.x, b.x), min(a.y, b.y), min(a.z, b.z)};
    }
    friend ISOCAST_INLINE Vector max(const Vector& a, const Vector& b) {
        return {max(a.x, b.x), max(a.y, b.y), max(a.z, b.z)};
    }
};

ISOCAST_INLINE Doubles absolute(const Doubles& x) {
    return max(x, Doubles(0.0) - x);
}
ISOCAST_INLINE Vector absolute(const Vector& a) {
    return {absolute(a.x), absolute(a.y), absolute(a.z)};
}
ISOCAST_INLINE Doubles clamp(const Doubles& x, const Doubles& low, const Doubles& high) {
    return max(low, min(x, high));
}
ISOCAST_INLINE Vector splat(const double* p) {
    return {p[0], p[1], p[2]};
}
/// Of length one; undefined for the zero vector.
ISOCAST_INLINE Vector normalized(const Vector& a) {
    return (Doubles(1.0) / norm(a)) * a;
}
/// A unit vector across the unit vector `a`.
ISOCAST_INLINE Vector unit_orthogonal(const Vector& a) {
    // Not along the least component, so that nothing cancels.
    const auto along_x = absolute(a.x) < 0.6;
    return normalized(select(along_x, Vector{0.0, a.z, Doubles(0.0) - a.y},
                             Vector{Doubles(0.0) - a.z, 0.0, a.x}));
}

/// Numbers that lie about in memory, brought side by side.
template<int count>
struct Gathered {
    alignas(64) double number[count][lanes];

    ISOCAST_INLINE void set(int first, int lane, const double* p) {
        for (int k = 0; k < 3; ++k) number[first + k][lane] = p[k];
    }
    ISOCAST_INLINE Doubles at(int i) const { return load(number[i]); }
    ISOCAST_INLINE Vector vector(int first) const {
        return {at(first), at(first + 1), at(first + 2)};
    }
};

/// atan of 0 … infinity as y / x, both >= 0 and not both 0; S. L. Moshier's Cephes, atan.c, with
/// the greatest argument tan(pi / 8) instead of 0.66.
ISOCAST_INLINE Doubles arc_tangent(const Doubles& y, const Doubles& x) {
    const auto is_steep = x < y;
    const Doubles q = min(x, y) / max(x, y);
    const auto is_large = Doubles(0.4142135623730950488) < q;
    const Doubles t = select(is_large, (q - 1.0) / (q + 1.0), q);
    const Doubles z = t * t;
    const Doubles p = (((z * -8.750608600031904122785E-1 - 1.615753718733365076637E1) * z -
                        7.500855792314704667340E1) *
                           z -
                       1.228866684490136173410E2) *
                          z -
                      6.485021904942025371773E1;
    const Doubles r = ((((z + 2.485846490142306297962E1) * z + 1.650270098316988542046E2) * z +
                        4.328810604912902668951E2) *
                           z +
                       4.853903996359136964868E2) *
                          z +
                      1.945506571482613964425E2;
    constexpr double half_pi = 1.57079632679489661923;
    const Doubles angle = t + t * z * p / r + select(is_large, Doubles(half_pi / 2), Doubles(0.0));
    return select(is_steep, Doubles(half_pi) - angle, angle);
}

ISOCAST_INLINE Doubles angle_between(const Vector& a, const Vector& b) {
    const Doubles sine = norm(cross(a, b));
    const Doubles cosine = dot(a, b);
    const Doubles angle = arc_tangent(sine, absolute(cosine));
    constexpr double pi = 3.14159265358979323846;
    return select(cosine < 0.0, Doubles(pi) - angle, angle);
}

} // namespace
