// Certificates: bounds of a reconstructed function and its derivatives over one block.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/bounds.h"

#include "filtering/lanes.h"
#include "volume/assert.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace isocast {

namespace {

/// Samples, or places where differences are taken, from `first` on.
struct Grid {
    const float* first;
    std::ptrdiff_t stride_y, stride_z;
    int nx, ny, nz; // nx >= lanes
};

struct Range {
    float min, max;
};

/// The range of value(c) over the places c of the grid; `value` makes four at once.
template<class Value>
Range range_of(const Grid& grid, Value value) {
    Lanes min = value(grid.first);
    Lanes max = min;
    const auto add = [&](const float* c) {
        const Lanes values = value(c);
        min = less(min, values);
        max = greater(max, values);
    };
    for (int z = 0; z < grid.nz; ++z) {
        for (int y = 0; y < grid.ny; ++y) {
            const float* row = grid.first + z * grid.stride_z + y * grid.stride_y;
            for (int x = 0; x < grid.nx - lanes; x += lanes) add(row + x);
            add(row + grid.nx - lanes); // overlaps the four before, which does no harm
        }
    }
    return {least_lane(min), greatest_lane(max)};
}

Range range_of(const Grid& grid) {
    return range_of(grid, load);
}

float greatest_size(const Range& range) {
    return std::max(-range.min, range.max);
}

float rounded_down(double value) {
    const auto near = static_cast<float>(value);
    return near > value ? std::nextafter(near, -std::numeric_limits<float>::infinity()) : near;
}

float rounded_up(double value) {
    return -rounded_down(-value);
}

// Differences are taken in float. With u = 2^-24 a first difference computed as g is at most
// g/(1 - u) < (1 + 2u) g. A second difference is the difference of two first ones, each off by at
// most u times the slope bound s: computed as h, it is at most (1 + 2u) h + 2u s.
constexpr double slack = 0x1p-23; // 2u

/// Upper bounds of the differences of n^3 samples from `control` on, along x, y, z. Not rounded to
/// float yet: sums are made of them still.
inline std::array<double, 3> first_differences(const float* control, std::ptrdiff_t sy,
                                               std::ptrdiff_t sz, int n) {
    const auto greatest = [=](int nx, int ny, int nz, std::ptrdiff_t s) {
        const auto difference = [s](const float* c) { return load(c + s) - load(c); };
        return (1 + slack) * greatest_size(range_of({control, sy, sz, nx, ny, nz}, difference));
    };
    return {greatest(n - 1, n, n, 1), greatest(n, n - 1, n, sy), greatest(n, n, n - 1, sz)};
}

/// Likewise of the second differences, xx yy zz xy xz yz; first: see above.
inline std::array<double, 6> second_differences(const float* control, std::ptrdiff_t sy,
                                                std::ptrdiff_t sz, int n,
                                                const std::array<double, 3>& first) {
    const auto greatest = [=](int nx, int ny, int nz, const auto& difference, double slope) {
        return (1 + slack) * greatest_size(range_of({control, sy, sz, nx, ny, nz}, difference)) +
               slack * slope;
    };
    // Differences of two first differences along s, whose bound is `slope`.
    const auto twice_along = [](std::ptrdiff_t s) {
        return [s](const float* c) {
            const Lanes middle = load(c + s);
            return (load(c + 2 * s) - middle) - (middle - load(c));
        };
    };
    const auto mixed = [](std::ptrdiff_t s, std::ptrdiff_t t) {
        return [s, t](const float* c) {
            return (load(c + s + t) - load(c + t)) - (load(c + s) - load(c));
        };
    };
    const int m = n - 1;
    const int k = n - 2;
    return {
        greatest(k, n, n, twice_along(1), first[0]),  greatest(n, k, n, twice_along(sy), first[1]),
        greatest(n, n, k, twice_along(sz), first[2]), greatest(m, m, n, mixed(1, sy), first[0]),
        greatest(m, n, m, mixed(1, sz), first[0]),    greatest(n, m, m, mixed(sy, sz), first[1])};
}

// A derivative of a B-spline is a B-spline of one degree less whose control values are the
// differences of the control samples: it lies in their hull (FORMULAS.md).
SplineBounds bspline_bounds(const Range& all, const std::array<double, 3>& first,
                            const std::array<double, 6>& second) {
    SplineBounds bounds{};
    bounds.min = all.min;
    bounds.max = all.max;
    std::ranges::transform(first, bounds.slope.begin(), rounded_up);
    std::ranges::transform(second, bounds.bend.begin(), rounded_up);
    return bounds;
}

// Catmull-Rom, one axis, at i + a, with the differences d0, d1, d2 of the four samples and the
// second differences D0 = d1 - d0, D1 = d2 - d1 (the weights in bspline.cpp, summed by parts):
//
//   value  = (1-a) c[i] + a c[i+1] - (a (1-a)^2 D0 + a^2 (1-a) D1)/2
//   slope  = d1 - v0 D0 + v2 D1,   v0 = (1-a)(1-3a)/2, v2 = a(3a-2)/2
//   bend   = (2-3a) D0 + (3a-1) D1
//
// Lebesgue constants, sums of |weights|, greatest over 0 <= a <= 1:
//   value  of samples:             1 + a(1-a)                      <= 5/4   (a = 1/2)
//   slope  of first differences:   |v0| + |1-v0-v2| + |v2|         <= 3/2   (a = 1/2)
//   bend   of second differences:  |2-3a| + |3a-1|                 <= 3     (a = 0, 1)
// and of what the cubic adds to the linear interpolant and to its slope:
//   E  = value - linear, of second differences:  a(1-a)/2          <= 1/8   (a = 1/2)
//   E' = slope - d1,     of second differences:  |v0| + |v2|       <= 1/2   (a = 0, 1)
//
// In three dimensions the axes' operators commute, and norms multiply; C is Catmull-Rom's value
// along an axis (norm 5/4), L the linear one (norm 1), C = L + E.
//   value:  about the middle of the samples' range, (5/4)^3 times half the range; and
//           CCC = LLL + E CC + L E C + LL E, so that it differs from the trilinear value, which
//           lies in the hull of the block's corners, by at most ((5/4)^2 h_1 + (5/4) h_2 + h_3)/8.
//           The order of the axes is free: the greatest h takes the factor 1.
//   slope:  (3/2)(5/4)^2 g_x; and from (d1 + E') CC with d1 CC = d1 LL + d1 E C + d1 L E, where
//           a second difference along y of d1 is a difference of two mixed ones, at most 2 h_xy:
//           g_x + (5/4)^2 h_xx/2 + ((5/4) 2 h_1 + 2 h_2)/8, again with the greater as h_2.
//   bend:   3 (5/4)^2 h_xx and (3/2)^2 (5/4) h_xy. The gradient is continuous and the bend bounded
//           in every cell, so that second-order steps hold across cells.
SplineBounds catmull_rom_bounds(const Range& all, const Range& corners,
                                const std::array<double, 3>& first,
                                const std::array<double, 6>& second) {
    constexpr double c = 1.25;
    SplineBounds bounds{};

    std::array<double, 3> pure{second[0], second[1], second[2]};
    std::ranges::sort(pure);
    const double beside_linear = (c * c * pure[0] + c * pure[1] + pure[2]) / 8;
    const double middle = (double{all.min} + all.max) / 2;
    const double reach = c * c * c * (double{all.max} - all.min) / 2;
    bounds.min = rounded_down(std::max(middle - reach, corners.min - beside_linear));
    bounds.max = rounded_up(std::min(middle + reach, corners.max + beside_linear));

    constexpr std::array<std::array<std::size_t, 2>, 3> mixed{{{3, 4}, {3, 5}, {4, 5}}};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto [less, more] = std::minmax(second[mixed[axis][0]], second[mixed[axis][1]]);
        const double beside_first = c * c * second[axis] / 2 + (c * 2 * less + 2 * more) / 8;
        bounds.slope[axis] =
            rounded_up(std::min(1.5 * c * c * first[axis], first[axis] + beside_first));
        bounds.bend[axis] = rounded_up(3 * c * c * second[axis]);
        bounds.bend[3 + axis] = rounded_up(1.5 * 1.5 * c * second[3 + axis]);
    }
    return bounds;
}

// Trilinear: value and slope lie in the hulls of the cells' corners and of their differences.
SplineBounds linear_bounds(const Range& corners, const std::array<double, 3>& first) {
    SplineBounds bounds{};
    bounds.min = corners.min;
    bounds.max = corners.max;
    std::ranges::transform(first, bounds.slope.begin(), rounded_up);
    bounds.bend.fill(no_bend);
    return bounds;
}

inline SplineBounds bounds_of(const float* control, std::ptrdiff_t sy, std::ptrdiff_t sz, int cells,
                              Kernel kernel) {
    // The control samples -1 … cells + 1 along each axis, and among them the cells' corners.
    const int n = cells + 3;
    const int n_corners = cells + 1;
    const float* corners = control + 1 + sy + sz;
    const Range all = range_of({control, sy, sz, n, n, n});
    const Range at_corners = kernel == Kernel::BSpline
                                 ? all
                                 : range_of({corners, sy, sz, n_corners, n_corners, n_corners});
    SplineBounds bounds{};
    if (kernel == Kernel::Linear) {
        bounds = linear_bounds(at_corners, first_differences(corners, sy, sz, n_corners));
    } else {
        const auto first = first_differences(control, sy, sz, n);
        const auto second = second_differences(control, sy, sz, n, first);
        bounds = kernel == Kernel::BSpline ? bspline_bounds(all, first, second)
                                           : catmull_rom_bounds(all, at_corners, first, second);
    }
    bounds.magnitude = greatest_size(all);
    return bounds;
}

} // namespace

SplineBounds spline_bounds(const float* control, std::ptrdiff_t stride_y, std::ptrdiff_t stride_z,
                           int cells, Kernel kernel) {
    ISOCAST_ASSERT(cells >= lanes, "%d cells", cells);
    // A constant count of cells, so that the loops over a row unroll.
    if (cells == 8) return bounds_of(control, stride_y, stride_z, 8, kernel);
    return bounds_of(control, stride_y, stride_z, cells, kernel);
}

} // namespace isocast
