// What certifies a ray's steps through a block.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/certificate.h"

#include "filtering/bounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace isocast {

namespace {

// A B-spline's piece over a cell lies within the hull of its Bezier points. Along one axis they are
// means of neighbouring control points with positive weights; so bounds of control points give
// bounds of Bezier points, one axis after the other.

constexpr int cells = block_size;
constexpr int support = cells + 3;
constexpr std::size_t row_size = 12; // floats from a row to the next
constexpr std::size_t plane_size = row_size * support;

/// Samples, differences of them or bounds: [z][y][x]; of the extent that a stage has left, the
/// first ones along each axis are meaningful.
using Lattice = std::array<float, plane_size * support>;

/// The steps from one control value to the next along x, y and z.
constexpr std::array<std::size_t, 3> step{1, row_size, plane_size};

/// Calls f(i) for the elements of the first nx x ny x nz, x fastest.
template<class Function>
void for_lattice(const std::array<int, 3>& n, Function f) {
    for (int z = 0; z < n[2]; ++z) {
        for (int y = 0; y < n[1]; ++y) {
            const std::size_t row =
                static_cast<std::size_t>(y) * row_size + static_cast<std::size_t>(z) * plane_size;
            const auto end = row + static_cast<std::size_t>(n[0]);
            for (std::size_t i = row; i < end; ++i) f(i);
        }
    }
}

/// The same for all cells.
template<class Function>
void for_cells(Function f) {
    for_lattice({cells, cells, cells}, f);
}

float greater(float a, float b) {
    return a > b ? a : b;
}
float less(float a, float b) {
    return a < b ? a : b;
}

/// Replaces the control values along an axis by the greatest (or least) of each cell's Bezier
/// points, in place.
///
/// order  3 for values, 2 for first differences along this axis, 1 for second ones
template<class Extreme>
void take_hull(Lattice& v, std::array<int, 3>& n, int axis, int order, Extreme extreme) {
    const std::size_t s = step[static_cast<std::size_t>(axis)];
    n[static_cast<std::size_t>(axis)] = cells;
    if (order == 3) {
        for_lattice(n, [&](std::size_t i) {
            const float c1 = v[i + s];
            const float c2 = v[i + 2 * s];
            // (c0 + 4 c1 + c2)/6, (2 c1 + c2)/3, (c1 + 2 c2)/3, (c1 + 4 c2 + c3)/6
            const float ends = extreme(v[i] + 4 * c1 + c2, c1 + 4 * c2 + v[i + 3 * s]) / 6;
            const float middle = (c1 + c2 + extreme(c1, c2)) / 3;
            v[i] = extreme(ends, middle);
        });
    } else if (order == 2) {
        for_lattice(n, [&](std::size_t i) {
            // (c0 + c1)/2, c1, (c1 + c2)/2
            const float c1 = v[i + s];
            v[i] = extreme(c1, (c1 + extreme(v[i], v[i + 2 * s])) / 2);
        });
    } else {
        for_lattice(n, [&](std::size_t i) { v[i] = extreme(v[i], v[i + s]); });
    }
}

/// Differences of neighbours along an axis.
void take_differences(const Lattice& in, Lattice& out, std::array<int, 3>& n, int axis) {
    const std::size_t s = step[static_cast<std::size_t>(axis)];
    --n[static_cast<std::size_t>(axis)];
    for_lattice(n, [&](std::size_t i) { out[i] = in[i + s] - in[i]; });
}

/// Adds weight * (the greatest |derivative| of each cell)^2 to `sum`.
///
/// differences  of the control values, along each axis as often as `orders` falls below 3
void add_square_of_hull(Lattice differences, std::array<int, 3> n, const std::array<int, 3>& orders,
                        float weight, Lattice& sum) {
    for_lattice(n, [&](std::size_t i) { differences[i] = std::abs(differences[i]); });
    for (int axis = 2; axis >= 0; --axis)
        take_hull(differences, n, axis, orders[static_cast<std::size_t>(axis)], greater);
    for_cells([&](std::size_t i) { sum[i] += weight * differences[i] * differences[i]; });
}

/// Rounding of the sums above, outward: a dozen roundings of 2^-24.
constexpr float rounding = 0x1p-20F;

Lattice gathered(const float* control, std::ptrdiff_t stride_y, std::ptrdiff_t stride_z) {
    Lattice c;
    for (int z = 0; z < support; ++z)
        for (int y = 0; y < support; ++y)
            std::copy_n(control + y * stride_y + z * stride_z, support,
                        c.data() + step[1] * static_cast<std::size_t>(y) +
                            step[2] * static_cast<std::size_t>(z));
    return c;
}

/// Least and greatest values of each cell, rounded outward.
struct CellRanges {
    Lattice least;
    Lattice greatest;
};

CellRanges cell_ranges(const Lattice& control, Kernel kernel) {
    CellRanges ranges{control, control};
    std::array<int, 3> n{support, support, support};
    std::array<int, 3> m = n;
    for (int axis = 2; axis >= 0; --axis) {
        if (kernel == Kernel::Linear) {
            // Of the four samples along the axis only the second and the third count.
            const std::size_t s = step[static_cast<std::size_t>(axis)];
            n[static_cast<std::size_t>(axis)] = cells;
            for_lattice(n, [&](std::size_t i) {
                ranges.least[i] = less(ranges.least[i + s], ranges.least[i + 2 * s]);
                ranges.greatest[i] = greater(ranges.greatest[i + s], ranges.greatest[i + 2 * s]);
            });
        } else {
            take_hull(ranges.least, n, axis, 3, less);
            take_hull(ranges.greatest, m, axis, 3, greater);
        }
    }
    for_cells([&](std::size_t i) {
        ranges.least[i] -= rounding * std::abs(ranges.least[i]);
        ranges.greatest[i] += rounding * std::abs(ranges.greatest[i]);
    });
    return ranges;
}

/// The parts with a cell that holds zero.
std::uint64_t parts_of(const CellRanges& cell) {
    std::uint64_t parts = 0;
    for (int z = 0; z < cells; ++z)
        for (int y = 0; y < cells; ++y)
            for (int x = 0; x < cells; ++x) {
                const std::size_t i = static_cast<std::size_t>(x) +
                                      step[1] * static_cast<std::size_t>(y) +
                                      step[2] * static_cast<std::size_t>(z);
                const bool holds = cell.least[i] <= 0 && cell.greatest[i] >= 0;
                parts |= std::uint64_t{holds} << (x / part_size + block_parts * (y / part_size) +
                                                  block_parts * block_parts * (z / part_size));
            }
    return parts;
}

/// From bounds of each derivative by itself.
Certificate certify_by_bounds(const SplineBounds& bounds) {
    const auto norm = [](float xx, float yy, float zz) {
        return std::sqrt(xx * xx + yy * yy + zz * zz) * (1 + rounding);
    };
    const auto& b = bounds.bend;
    Certificate certificate;
    certificate.slope = norm(bounds.slope[0], bounds.slope[1], bounds.slope[2]);
    certificate.bend = b[0] >= no_bend ? no_bend
                                       : norm(norm(b[0], b[1], b[2]), std::sqrt(2.0F) * b[3],
                                              std::sqrt(2.0F) * norm(b[4], b[5], 0));
    certificate.near = std::numeric_limits<float>::max();
    certificate.parts = ~std::uint64_t{0};
    return certificate;
}

} // namespace

ValueRange range_of_block(const float* control, std::ptrdiff_t stride_y, std::ptrdiff_t stride_z,
                          Kernel kernel) {
    if (kernel == Kernel::CatmullRom) {
        const SplineBounds bounds = spline_bounds(control, stride_y, stride_z, cells, kernel);
        return {bounds.min, bounds.max};
    }
    const CellRanges cell = cell_ranges(gathered(control, stride_y, stride_z), kernel);
    ValueRange range{std::numeric_limits<float>::infinity(),
                     -std::numeric_limits<float>::infinity()};
    for_cells([&](std::size_t i) {
        range = {less(range.min, cell.least[i]), greater(range.max, cell.greatest[i])};
    });
    return range;
}

Certificate certify_block(const float* control, std::ptrdiff_t stride_y, std::ptrdiff_t stride_z,
                          Kernel kernel) {
    if (kernel != Kernel::BSpline) {
        Certificate certificate =
            certify_by_bounds(spline_bounds(control, stride_y, stride_z, cells, kernel));
        if (kernel == Kernel::Linear)
            certificate.parts =
                parts_of(cell_ranges(gathered(control, stride_y, stride_z), kernel));
        return certificate;
    }
    const Lattice c = gathered(control, stride_y, stride_z);
    const CellRanges cell = cell_ranges(c, kernel);

    // Squares of bounds of |gradient| and of the Hessian's Frobenius norm, cell by cell: the second
    // derivative along a unit vector is no greater than that norm.
    Lattice slope_squared{};
    Lattice bend_squared{};
    for (int u = 0; u < 3; ++u) {
        Lattice first;
        std::array<int, 3> n{support, support, support};
        take_differences(c, first, n, u);
        std::array<int, 3> orders{3, 3, 3};
        --orders[static_cast<std::size_t>(u)];
        add_square_of_hull(first, n, orders, 1, slope_squared);
        for (int v = u; v < 3; ++v) {
            Lattice second;
            std::array<int, 3> m = n;
            take_differences(first, second, m, v);
            std::array<int, 3> second_orders = orders;
            --second_orders[static_cast<std::size_t>(v)];
            // Mixed derivatives stand twice in the matrix.
            add_square_of_hull(second, m, second_orders, u == v ? 1.0F : 2.0F, bend_squared);
        }
    }
    float slope = 0;
    float bend = 0;
    for_cells([&](std::size_t i) {
        slope = greater(slope, slope_squared[i]);
        bend = greater(bend, bend_squared[i]);
    });
    Certificate certificate;
    certificate.parts = parts_of(cell);
    certificate.slope = std::sqrt(slope) * (1 + rounding);
    certificate.near = certificate.slope;
    float near_bend = 0;
    for_cells([&](std::size_t i) {
        const bool is_near =
            cell.least[i] <= certificate.near && cell.greatest[i] >= -certificate.near;
        near_bend = greater(near_bend, is_near ? bend_squared[i] : 0);
    });
    // 1.5 of squares: a tenth of a second-order step, which falls with the root of the bend.
    const bool is_useful = bend > 1.5F * near_bend;
    if (!is_useful) certificate.near = std::numeric_limits<float>::max();
    certificate.bend = std::sqrt(is_useful ? near_bend : bend) * (1 + rounding);
    return certificate;
}

} // namespace isocast
