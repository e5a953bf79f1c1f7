// What certifies a ray's steps through a block.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/certificate.h"

#include "filtering/bounds.h"
#include "filtering/lanes.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace isocast {

namespace {

// A B-spline's piece over a cell lies within the hull of its Bezier points. Along one axis they are
// means of neighbouring control points with positive weights; so bounds of control points give
// bounds of Bezier points, one axis after the other: x, y, z.
//
// Derivatives are splines of lower orders, whose control points are differences of the samples:
//
//   order   control points of a cell   its Bezier points
//     3       c0 c1 c2 c3              (c0 + 4 c1 + c2)/6, (2 c1 + c2)/3, (c1 + 2 c2)/3, ...
//     2       c0 c1 c2                 (c0 + c1)/2, c1, (c1 + c2)/2
//     1       c0 c1                    c0, c1
//
// A row of n cells has n + order control points, and its hulls are taken four cells at once: a
// strip, of which the lanes are neighbours along x.

constexpr int cells = block_size;
constexpr int support = cells + 3;
constexpr int strips = cells / lanes;

/// What hull_of and take_hulls give is this times too large.
constexpr float denominator(int order) {
    return order == 3 ? 3 : order == 2 ? 2 : 1;
}

/// The greatest or least Bezier points of four cells of a row.
///
/// row  the first cell's first control point
template<int order, class Extreme>
Lanes hull_of(const float* row, Extreme extreme) {
    const Lanes c0 = load(row);
    const Lanes c1 = load(row + 1);
    if constexpr (order == 1) {
        return extreme(c0, c1);
    } else if constexpr (order == 2) {
        const Lanes c2 = load(row + 2);
        return c1 + extreme(c1, extreme(c0, c2));
    } else {
        const Lanes c2 = load(row + 2);
        const Lanes c3 = load(row + 3);
        // Three times the inner points. The outer ones are halved rather than these doubled, since
        // processors multiply beside adding.
        const Lanes p = c1 + c1 + c2;
        const Lanes q = c1 + (c2 + c2);
        const Lanes twice_ends = extreme((c0 + (c1 + c1)) + p, q + ((c2 + c2) + c3));
        return extreme(extreme(p, q), 0.5F * twice_ends);
    }
}

/// The same for n cells, one after the other; neighbours share the point between them.
///
/// value(i)    their control points, i < n + order
/// put(i, h)   takes their hulls; values up to i + order were read before
template<int order, int n, class Extreme, class Value, class Put>
void take_hulls(Extreme extreme, Value value, Put put) {
    if constexpr (order == 1) {
        Lanes c0 = value(0);
        for (int i = 0; i < n; ++i) {
            const Lanes c1 = value(i + 1);
            put(i, extreme(c0, c1));
            c0 = c1;
        }
    } else if constexpr (order == 2) {
        Lanes c0 = value(0);
        Lanes c1 = value(1);
        for (int i = 0; i < n; ++i) {
            const Lanes c2 = value(i + 2);
            put(i, c1 + extreme(c1, extreme(c0, c2)));
            c0 = c1;
            c1 = c2;
        }
    } else {
        Lanes c1 = value(1);
        Lanes c2 = value(2);
        Lanes twice_c2 = c2 + c2;
        Lanes p = c1 + c1 + c2;
        Lanes q = c1 + twice_c2;
        Lanes before = (value(0) + (c1 + c1)) + p;
        for (int i = 0; i < n; ++i) {
            const Lanes c3 = value(i + 3);
            const Lanes inner = extreme(p, q);
            p = twice_c2 + c3;
            const Lanes behind = q + p;
            put(i, extreme(inner, 0.5F * extreme(before, behind)));
            before = behind;
            twice_c2 = c3 + c3;
            q = c2 + twice_c2;
            c2 = c3;
        }
    }
}

struct Least {
    Lanes operator()(Lanes a, Lanes b) const { return less(a, b); }
};
struct Greatest {
    Lanes operator()(Lanes a, Lanes b) const { return greater(a, b); }
};

/// Samples as a caller has them.
struct Control {
    const float* first;
    std::ptrdiff_t stride_y, stride_z;

    const float* row(int y, int z) const { return first + y * stride_y + z * stride_z; }
};

/// The greatest |sample| of a block's support.
float magnitude(const Control& control) {
    Lanes greatest{};
    for (int z = 0; z < support; ++z) {
        for (int y = 0; y < support; ++y) {
            const float* row = control.row(y, z);
            for (const int x : {0, lanes, support - lanes})
                greatest = greater(greatest, absolute(load(row + x)));
        }
    }
    return greatest_lane(greatest);
}

/// Rounding, outward. With u = 2^-24: an axis's sums round twice, by u of the greatest |sample|
/// each, which the next axes' means pass on; dividing rounds twice and moving outward once more,
/// together 9 u. Derivatives, whose terms are positive, round by as much of themselves, and once
/// as a difference; their squares' sums by five and the root by one more, 16 u at most.
constexpr float rounding = 0x1p-20F;

/// The least and greatest values of cells.
///
/// order      3 for a B-spline; 1 for linear interpolation, whose first sample is the cell's corner
/// n          cells along y and z
/// put(y, z, least, greatest)  takes those of four cells along x, denominator(order)^3 too large
template<int order, int n, class Put>
void for_cell_ranges(const Control& control, int x, Put put) {
    Lanes least[n + order][n];
    Lanes greatest[n + order][n];
    for (int z = 0; z < n + order; ++z) {
        Lanes lo[n + order];
        Lanes hi[n + order];
        for (int y = 0; y < n + order; ++y) {
            const float* row = control.row(y, z) + x;
            lo[y] = hull_of<order>(row, Least{});
            hi[y] = hull_of<order>(row, Greatest{});
        }
        take_hulls<order, n>(
            Least{}, [&](int y) { return lo[y]; }, [&](int y, Lanes h) { least[z][y] = h; });
        take_hulls<order, n>(
            Greatest{}, [&](int y) { return hi[y]; }, [&](int y, Lanes h) { greatest[z][y] = h; });
    }
    for (int y = 0; y < n; ++y) {
        take_hulls<order, n>(
            Least{}, [&](int z) { return least[z][y]; }, [&](int z, Lanes h) { least[z][y] = h; });
        take_hulls<order, n>(
            Greatest{}, [&](int z) { return greatest[z][y]; },
            [&](int z, Lanes h) { put(y, z, least[z][y], h); });
    }
}

/// Values by strip, z and y, the lanes along x.
struct Cells {
    Lanes at[strips][cells][cells];
};

struct CellRanges {
    Cells least;
    Cells greatest;
};

/// Where the first sample that counts is.
Control control_of(const float* control, std::ptrdiff_t stride_y, std::ptrdiff_t stride_z,
                   Kernel kernel) {
    return {kernel == Kernel::Linear ? control + 1 + stride_y + stride_z : control, stride_y,
            stride_z};
}

/// Turns what hulls are too large by into values, and moves them outward.
template<int order>
struct Outward {
    float scale = 1;
    float slack = 0;

    explicit Outward(const Control& control) {
        if constexpr (order == 1) return; // exact
        scale = 1 / (denominator(order) * denominator(order) * denominator(order));
        slack = rounding * magnitude(control);
    }
    template<class Value>
    Value least(Value hull) const {
        return hull * scale - slack;
    }
    template<class Value>
    Value greatest(Value hull) const {
        return hull * scale + slack;
    }
};

template<int order>
void find_cell_ranges(const Control& control, CellRanges& ranges) {
    const Outward<order> outward(control);
    for (int strip = 0; strip < strips; ++strip) {
        for_cell_ranges<order, cells>(
            control, strip * lanes, [&](int y, int z, Lanes least, Lanes greatest) {
                ranges.least.at[strip][z][y] = outward.least(least);
                ranges.greatest.at[strip][z][y] = outward.greatest(greatest);
            });
    }
}

template<int order>
ValueRange block_range(const Control& control) {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    Lanes least = Lanes{} + infinity;
    Lanes greatest = Lanes{} - infinity;
    for (int x = 0; x < cells; x += lanes) {
        for_cell_ranges<order, cells>(control, x, [&](int, int, Lanes lo, Lanes hi) {
            least = less(least, lo);
            greatest = greater(greatest, hi);
        });
    }
    const Outward<order> outward(control);
    return {outward.least(least_lane(least)), outward.greatest(greatest_lane(greatest))};
}

/// The first sample of a page's block.
const float* first_of_block(const Control& page, int place) {
    const int x = place % page_blocks;
    const int y = place / page_blocks % page_blocks;
    const int z = place / (page_blocks * page_blocks);
    return page.row(block_size * y, block_size * z) + block_size * x;
}

template<int order>
std::array<ValueRange, blocks_per_page> page_ranges(const Control& control) {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    Lanes least[blocks_per_page];
    Lanes greatest[blocks_per_page];
    std::fill_n(least, blocks_per_page, Lanes{} + infinity);
    std::fill_n(greatest, blocks_per_page, Lanes{} - infinity);
    for (int x = 0; x < page_size; x += lanes) {
        for_cell_ranges<order, page_size>(control, x, [&](int y, int z, Lanes lo, Lanes hi) {
            const int place = place_in_page(x / block_size, y / block_size, z / block_size);
            least[place] = less(least[place], lo);
            greatest[place] = greater(greatest[place], hi);
        });
    }
    std::array<ValueRange, blocks_per_page> ranges{};
    for (int place = 0; place < blocks_per_page; ++place) {
        const Outward<order> outward(
            {first_of_block(control, place), control.stride_y, control.stride_z});
        ranges[static_cast<std::size_t>(place)] = {
            outward.least(least_lane(least[place])),
            outward.greatest(greatest_lane(greatest[place]))};
    }
    return ranges;
}

/// Where a ray passes from part to part is known to a few roundings of coordinates of up to 100
/// voxels; 1e-4 voxel holds those.
constexpr float part_margin = 1e-4F;

/// The parts with a cell that holds a value no farther from zero than `margin`.
std::uint64_t parts_of(const CellRanges& ranges, float margin) {
    static_assert(part_size == 2 && lanes == 2 * part_size);
    std::uint64_t parts = 0;
    for (int z = 0; z < cells; z += part_size) {
        for (int y = 0; y < cells; y += part_size) {
            for (int strip = 0; strip < strips; ++strip) {
                LaneMask holds{};
                for (int dz = 0; dz < part_size; ++dz) {
                    for (int dy = 0; dy < part_size; ++dy) {
                        holds |= (ranges.least.at[strip][z + dz][y + dy] <= margin) &
                                 (ranges.greatest.at[strip][z + dz][y + dy] >= -margin);
                    }
                }
                const std::uint64_t two = (holds[0] | holds[1] ? 1U : 0U) | // along x
                                          (holds[2] | holds[3] ? 2U : 0U);
                parts |= two << (2 * strip +
                                 block_parts * (y / part_size + block_parts * (z / part_size)));
            }
        }
    }
    return parts;
}

// Differences of neighbours, once or twice: `order` falls from 3 along an axis as often as they
// are taken along it, and there are 8 + order of them.

constexpr std::ptrdiff_t row_size = 12; // floats from a row to the next
constexpr std::ptrdiff_t plane_size = row_size * support;
/// The steps from one control value to the next along x, y and z.
constexpr std::ptrdiff_t step[3]{1, row_size, plane_size};

struct Lattice {
    float at[plane_size * support];
};

/// Calls use(i) for the places of four neighbours along x that cover the lattice.
template<int order_x, int order_y, int order_z, class Use>
void for_lanes(Use use) {
    for (int z = 0; z < cells + order_z; ++z) {
        for (int y = 0; y < cells + order_y; ++y) {
            const std::ptrdiff_t row = y * row_size + z * plane_size;
            use(row);
            use(row + lanes);
            use(row + cells + order_x - lanes); // overlaps the four before, which does no harm
        }
    }
}

/// Adds weight * (the greatest |derivative| of each cell)^2 to `sum`.
///
/// sizes  of the differences
template<int order_x, int order_y, int order_z>
void add_squares(const Lattice& sizes, float weight, Cells& sum) {
    constexpr float d = denominator(order_x) * denominator(order_y) * denominator(order_z);
    const float scale = weight / (d * d);
    for (int strip = 0; strip < strips; ++strip) {
        Lanes planes[cells + order_z][cells];
        for (int z = 0; z < cells + order_z; ++z) {
            Lanes rows[cells + order_y];
            for (int y = 0; y < cells + order_y; ++y) {
                rows[y] = hull_of<order_x>(sizes.at + strip * lanes + y * row_size + z * plane_size,
                                           Greatest{});
            }
            take_hulls<order_y, cells>(
                Greatest{}, [&](int y) { return rows[y]; },
                [&](int y, Lanes h) { planes[z][y] = h; });
        }
        for (int y = 0; y < cells; ++y) {
            take_hulls<order_z, cells>(
                Greatest{}, [&](int z) { return planes[z][y]; },
                [&](int z, Lanes h) { sum.at[strip][z][y] += scale * (h * h); });
        }
    }
}

/// Squares of bounds of |gradient| and of the Hessian's Frobenius norm, cell by cell: the second
/// derivative along a unit vector is no greater than that norm.
struct Steepness {
    Cells slope_squared{};
    Cells bend_squared{};
    /// The greatest |first difference|.
    Lanes first{};
};

/// Adds the second derivative along axes u and v, u the one of the first differences.
template<int u, int v>
void add_second(const Lattice& first, Steepness& steepness) {
    constexpr int x = 3 - (u == 0) - (v == 0);
    constexpr int y = 3 - (u == 1) - (v == 1);
    constexpr int z = 3 - (u == 2) - (v == 2);
    Lattice sizes;
    for_lanes<x, y, z>([&](std::ptrdiff_t i) {
        store(absolute(load(first.at + i + step[v]) - load(first.at + i)), sizes.at + i);
    });
    // Mixed derivatives stand twice in the matrix.
    add_squares<x, y, z>(sizes, u == v ? 1.0F : 2.0F, steepness.bend_squared);
}

/// Adds the first derivative along axis u and the second ones along u and the axes from u on.
template<int u>
void add_first(const Lattice& control, Steepness& steepness) {
    constexpr int x = 3 - (u == 0);
    constexpr int y = 3 - (u == 1);
    constexpr int z = 3 - (u == 2);
    Lattice first;
    Lattice sizes;
    for_lanes<x, y, z>([&](std::ptrdiff_t i) {
        const Lanes difference = load(control.at + i + step[u]) - load(control.at + i);
        const Lanes size = absolute(difference);
        store(difference, first.at + i);
        store(size, sizes.at + i);
        steepness.first = greater(steepness.first, size);
    });
    add_squares<x, y, z>(sizes, 1.0F, steepness.slope_squared);
    if constexpr (u == 0) add_second<u, 0>(first, steepness);
    if constexpr (u <= 1) add_second<u, 1>(first, steepness);
    add_second<u, 2>(first, steepness);
}

void find_steepness(const Control& control, Steepness& steepness) {
    Lattice gathered;
    for (int z = 0; z < support; ++z) {
        for (int y = 0; y < support; ++y) {
            const float* row = control.row(y, z);
            float* to = gathered.at + y * row_size + z * plane_size;
            for (const int x : {0, lanes, support - lanes}) store(load(row + x), to + x);
        }
    }
    add_first<0>(gathered, steepness);
    add_first<1>(gathered, steepness);
    add_first<2>(gathered, steepness);
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

Certificate certify_bspline(const Control& control) {
    CellRanges ranges;
    find_cell_ranges<3>(control, ranges);
    Steepness steepness;
    find_steepness(control, steepness);

    const auto for_cells = [](auto use) {
        for (int strip = 0; strip < strips; ++strip)
            for (int z = 0; z < cells; ++z)
                for (int y = 0; y < cells; ++y) use(strip, z, y);
    };
    Lanes slope{};
    for_cells([&](int strip, int z, int y) {
        slope = greater(slope, steepness.slope_squared.at[strip][z][y]);
    });
    Certificate certificate;
    certificate.slope = std::sqrt(greatest_lane(slope)) * (1 + rounding);
    certificate.parts = parts_of(ranges, part_margin * certificate.slope);
    certificate.near = certificate.slope;
    Lanes bends{};
    Lanes near_bends{};
    for_cells([&](int strip, int z, int y) {
        const Lanes bend = steepness.bend_squared.at[strip][z][y];
        const LaneMask is_near = (ranges.least.at[strip][z][y] <= certificate.near) &
                                 (ranges.greatest.at[strip][z][y] >= -certificate.near);
        bends = greater(bends, bend);
        near_bends = greater(near_bends, is_near ? bend : Lanes{});
    });
    const float bend = greatest_lane(bends);
    const float near_bend = greatest_lane(near_bends);
    // 1.5 of squares: a tenth of a second-order step, which falls with the root of the bend.
    const bool is_useful = bend > 1.5F * near_bend;
    if (!is_useful) certificate.near = std::numeric_limits<float>::max();
    // The two first differences of a second one are off by u = 2^-24 of themselves each, and nine
    // such errors stand in the matrix: together 6 u of the greatest first difference.
    certificate.bend = std::sqrt(is_useful ? near_bend : bend) * (1 + rounding) +
                       0x1p-21F * greatest_lane(steepness.first);
    return certificate;
}

} // namespace

ValueRange range_of_block(const float* control, std::ptrdiff_t stride_y, std::ptrdiff_t stride_z,
                          Kernel kernel) {
    const Control from = control_of(control, stride_y, stride_z, kernel);
    switch (kernel) {
    case Kernel::Linear:
        return block_range<1>(from);
    case Kernel::BSpline:
        return block_range<3>(from);
    case Kernel::CatmullRom:
        break;
    }
    const SplineBounds bounds = spline_bounds(control, stride_y, stride_z, cells, kernel);
    return {bounds.min, bounds.max};
}

std::array<ValueRange, blocks_per_page> ranges_of_page(const float* control,
                                                       std::ptrdiff_t stride_y,
                                                       std::ptrdiff_t stride_z, Kernel kernel) {
    const Control from = control_of(control, stride_y, stride_z, kernel);
    switch (kernel) {
    case Kernel::Linear:
        return page_ranges<1>(from);
    case Kernel::BSpline:
        return page_ranges<3>(from);
    case Kernel::CatmullRom:
        break;
    }
    std::array<ValueRange, blocks_per_page> ranges{};
    for (int place = 0; place < blocks_per_page; ++place) {
        ranges[static_cast<std::size_t>(place)] =
            range_of_block(first_of_block(from, place), stride_y, stride_z, kernel);
    }
    return ranges;
}

Certificate certify_block(const float* control, std::ptrdiff_t stride_y, std::ptrdiff_t stride_z,
                          Kernel kernel) {
    const Control from = control_of(control, stride_y, stride_z, kernel);
    if (kernel == Kernel::BSpline) return certify_bspline(from);
    Certificate certificate =
        certify_by_bounds(spline_bounds(control, stride_y, stride_z, cells, kernel));
    if (kernel == Kernel::Linear) {
        CellRanges ranges;
        find_cell_ranges<1>(from, ranges);
        certificate.parts = parts_of(ranges, part_margin * certificate.slope);
    }
    return certificate;
}

} // namespace isocast
