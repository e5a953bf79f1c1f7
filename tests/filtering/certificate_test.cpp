// Certificates: no point of a block exceeds them, and they are the hulls that their derivation
// says.
// SPDX-License-Identifier: MPL-2.0
#include "../volume/random_fields.h"
#include "filtering/certificate.h"

#include "filtering/bounds.h"
#include "volume/grid_space.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace isocast {
namespace {

using test::Random;
using test::random_real;
using Function = std::function<double(int x, int y, int z)>;
using Array3 = std::array<int, 3>;
constexpr std::array kernels{Kernel::Linear, Kernel::BSpline, Kernel::CatmullRom};

/// Control samples of a block or a page within rows and planes that are longer than it needs, what
/// lies between being huge.
struct Samples {
    int cells;
    std::ptrdiff_t stride_y, stride_z;
    std::vector<float> values;
    float magnitude = 0;

    Samples(int cells_, const Function& value)
        : cells(cells_), stride_y(cells + 3 + 2), stride_z(stride_y * (cells + 3 + 1)),
          values(static_cast<std::size_t>(stride_z * (cells + 3)), 1e20F) {
        for (int z = -1; z <= cells + 1; ++z) {
            for (int y = -1; y <= cells + 1; ++y) {
                for (int x = -1; x <= cells + 1; ++x) {
                    const auto sample = static_cast<float>(value(x, y, z));
                    values[place(x, y, z)] = sample;
                    magnitude = std::max(magnitude, std::abs(sample));
                }
            }
        }
    }

    std::size_t place(int x, int y, int z) const {
        return static_cast<std::size_t>(x + 1 + (y + 1) * stride_y + (z + 1) * stride_z);
    }
    double at(int x, int y, int z) const { return values[place(x, y, z)]; }
};

Certificate certified(const Samples& block, Kernel kernel) {
    return certify_block(block.values.data(), block.stride_y, block.stride_z, kernel);
}

ValueRange range_of(const Samples& block, Kernel kernel) {
    return range_of_block(block.values.data(), block.stride_y, block.stride_z, kernel);
}

int cell_of(double x) {
    return std::min(static_cast<int>(x), block_size - 1);
}

/// Whether the certificate lets the surface pass at a point.
bool can_hold_surface(const Certificate& certificate, const Vec3d& p) {
    const int part = cell_of(p.x()) / part_size + 4 * (cell_of(p.y()) / part_size) +
                     16 * (cell_of(p.z()) / part_size);
    return (certificate.parts >> part & 1U) != 0;
}

struct Jet {
    double value;
    Vec3d gradient;
    Eigen::Matrix3d hessian;
};

Jet evaluate(const Samples& block, Kernel kernel, const Vec3d& p) {
    Array3 cell{};
    std::array<std::array<std::array<double, 4>, 3>, 3> weights; // [axis][order]
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double x = p[static_cast<int>(axis)];
        cell[axis] = cell_of(x);
        const double a = x - cell[axis];
        weights[axis] = {kernel_weights(kernel, a), kernel_weights_d1(kernel, a),
                         kernel_weights_d2(kernel, a)};
    }
    const auto sum = [&](std::size_t dx, std::size_t dy, std::size_t dz) {
        double total = 0;
        for (int k = 0; k < 4; ++k) {
            for (int j = 0; j < 4; ++j) {
                double row = 0;
                for (int i = 0; i < 4; ++i) {
                    row += weights[0][dx][static_cast<std::size_t>(i)] *
                           block.at(cell[0] + i - 1, cell[1] + j - 1, cell[2] + k - 1);
                }
                total += weights[1][dy][static_cast<std::size_t>(j)] *
                         weights[2][dz][static_cast<std::size_t>(k)] * row;
            }
        }
        return total;
    };
    Jet jet{sum(0, 0, 0), {sum(1, 0, 0), sum(0, 1, 0), sum(0, 0, 1)}, {}};
    const double xy = sum(1, 1, 0);
    const double xz = sum(1, 0, 1);
    const double yz = sum(0, 1, 1);
    jet.hessian << sum(2, 0, 0), xy, xz, xy, sum(0, 2, 0), yz, xz, yz, sum(0, 0, 2);
    return jet;
}

/// A point of a cell; every third coordinate lies on a face.
Vec3d random_point(Random& random, const Array3& cell) {
    Vec3d p;
    for (int axis = 0; axis < 3; ++axis) {
        const double a = random_real(random, 0, 1);
        p[axis] = cell[static_cast<std::size_t>(axis)] + (random() % 3 == 0 ? std::round(a) : a);
    }
    return p;
}

Array3 random_cell(Random& random) {
    const auto coordinate = [&] { return static_cast<int>(random() % block_size); };
    return {coordinate(), coordinate(), coordinate()};
}

Vec3d random_direction(Random& random) {
    std::normal_distribution<double> normal;
    return Vec3d(normal(random), normal(random), normal(random)).normalized();
}

struct Kind {
    std::string name;
    Function value;
};

std::vector<Kind> kinds(Random& random) {
    std::vector<Kind> kinds;
    const Vec3d k(random_real(random, -0.5, 0.5), random_real(random, -0.5, 0.5), 0.3);
    const Vec3d centre(random_real(random, -2, 10), random_real(random, -2, 10), 4.4);
    const double radius = random_real(random, 1, 5);
    const Vec3d slope(random_real(random, -1, 1), random_real(random, -1, 1), 0.3);
    const auto noise = [&random](int, int, int) { return random_real(random, -1, 1); };
    const auto wave = [k](int x, int y, int z) { return std::sin(k.dot(Vec3d(x, y, z)) - 1); };
    const auto distance = [centre, radius](int x, int y, int z) {
        return (Vec3d(x, y, z) - centre).norm() - radius;
    };
    kinds.push_back({"smooth", wave});
    kinds.push_back({"noise", noise});
    kinds.push_back({"huge noise", [noise](int x, int y, int z) { return 1e6 * noise(x, y, z); }});
    kinds.push_back({"offset", [noise, wave](int x, int y, int z) {
                         return 1e4 + wave(x, y, z) + 0.01 * noise(x, y, z);
                     }});
    kinds.push_back({"tiny", [wave](int x, int y, int z) { return 1e-6 * wave(x, y, z); }});
    kinds.push_back({"distance", distance});
    kinds.push_back({"clamped", [distance](int x, int y, int z) {
                         return std::clamp(distance(x, y, z), -3.0, 3.0);
                     }});
    kinds.push_back({"bump among far cells", [distance](int x, int y, int z) {
                         const double d = distance(x, y, z);
                         return d + (d > 3 ? 0.4 * ((x + y + z) % 2) : 0);
                     }});
    kinds.push_back({"plane", [slope](int x, int y, int z) {
                         return slope.dot(Vec3d(x - 3.3, y - 4.1, z - 4.6));
                     }});
    kinds.push_back({"steep plane", [slope](int x, int y, int z) {
                         return 1000 * slope.dot(Vec3d(x - 3.3, y - 4.1, z - 4.6));
                     }});
    kinds.push_back({"quadratic", [centre, radius](int x, int y, int z) {
                         return (Vec3d(x, y, z) - centre).squaredNorm() - radius * radius;
                     }});
    kinds.push_back({"alternating", [noise](int x, int y, int z) {
                         // Sums of neighbours cancel: c0 + 4 c1 + c2 of 2, -1, 2.
                         return (x % 2 == 0 ? 2 : -1) * (y % 2 == 0 ? 2 : -1) +
                                1e-6 * noise(x, y, z);
                     }});
    kinds.push_back({"zero", [](int, int, int) { return 0.0; }});
    return kinds;
}

TEST(Certificates, HoldAtRandomPointsOfRandomBlocks) {
    Random random(1);
    int roots = 0;
    for (int round = 0; round < 4; ++round) {
        for (const Kind& kind : kinds(random)) {
            const Samples block(block_size, kind.value);
            // Sums of 64 terms, each rounded thrice, 64 * 3 * 8 * 1.1e-16 at most (9a - 5 and the
            // like are the greatest weights) and a hundredth of that as a rule.
            const double rounding = 1e-14 * block.magnitude;
            for (const Kernel kernel : kernels) {
                const Certificate certificate = certified(block, kernel);
                const ValueRange range = range_of(block, kernel);
                for (int i = 0; i < 400; ++i) {
                    const Array3 cell = random_cell(random);
                    std::array<Jet, 8> jets;
                    std::array<Vec3d, 8> points;
                    bool is_near = false;
                    for (std::size_t j = 0; j < jets.size(); ++j) {
                        points[j] = random_point(random, cell);
                        jets[j] = evaluate(block, kernel, points[j]);
                        is_near = is_near || std::abs(jets[j].value) <= certificate.near;
                    }
                    for (std::size_t j = 0; j < jets.size(); ++j) {
                        ASSERT_GE(jets[j].value, range.min - rounding) << kind.name;
                        ASSERT_LE(jets[j].value, range.max + rounding) << kind.name;
                        ASSERT_LE(jets[j].gradient.norm(), certificate.slope + rounding)
                            << kind.name << " at " << points[j].transpose();
                        if (!is_near || certificate.bend == no_bend) continue;
                        const Vec3d d = random_direction(random);
                        ASSERT_LE(std::abs(d.dot(jets[j].hessian * d)), certificate.bend + rounding)
                            << kind.name << " at " << points[j].transpose();
                    }
                    // A root between two of the points.
                    const auto [lo, hi] = std::ranges::minmax(jets, {}, &Jet::value);
                    if (lo.value > 0 || hi.value < 0) continue;
                    Vec3d below = points[0];
                    Vec3d above = points[0];
                    for (std::size_t j = 0; j < jets.size(); ++j) {
                        if (jets[j].value == lo.value) below = points[j];
                        if (jets[j].value == hi.value) above = points[j];
                    }
                    for (int step = 0; step < 60; ++step) {
                        const Vec3d middle = (below + above) / 2;
                        (evaluate(block, kernel, middle).value < 0 ? below : above) = middle;
                    }
                    ++roots;
                    ASSERT_TRUE(can_hold_surface(certificate, below) ||
                                can_hold_surface(certificate, above))
                        << kind.name << " at " << above.transpose();
                }
            }
        }
    }
    EXPECT_GT(roots, 10000);
}

// The same by the definition, in double: the hull of Bezier points, axis by axis.

/// Of the cells along one axis: the Bezier points of order + 1 control points each.
std::vector<std::vector<double>> bezier_points(const std::vector<double>& c, int order) {
    std::vector<std::vector<double>> points;
    for (std::size_t i = 0; i + static_cast<std::size_t>(order) < c.size(); ++i) {
        if (order == 3) {
            points.push_back({(c[i] + 4 * c[i + 1] + c[i + 2]) / 6, (2 * c[i + 1] + c[i + 2]) / 3,
                              (c[i + 1] + 2 * c[i + 2]) / 3,
                              (c[i + 1] + 4 * c[i + 2] + c[i + 3]) / 6});
        } else if (order == 2) {
            points.push_back({(c[i] + c[i + 1]) / 2, c[i + 1], (c[i + 1] + c[i + 2]) / 2});
        } else {
            points.push_back({c[i], c[i + 1]});
        }
    }
    return points;
}

/// Values by x, y and z.
struct Lattice {
    Array3 size;
    std::vector<double> values;

    explicit Lattice(const Array3& size_)
        : size(size_), values(static_cast<std::size_t>(size[0] * size[1] * size[2])) {}
    double& at(const Array3& i) {
        return values[static_cast<std::size_t>(i[0] + size[0] * (i[1] + size[1] * i[2]))];
    }
    double at(const Array3& i) const { return const_cast<Lattice&>(*this).at(i); }
};

template<class Use>
void for_all(const Array3& size, Use use) {
    for (int z = 0; z < size[2]; ++z)
        for (int y = 0; y < size[1]; ++y)
            for (int x = 0; x < size[0]; ++x) use(Array3{x, y, z});
}

using Extreme = const double& (*)(const double&, const double&);
constexpr Extreme least = std::min<double>;
constexpr Extreme greatest = std::max<double>;

Lattice hulls(Lattice v, const Array3& orders, Extreme extreme) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        Array3 size = v.size;
        size[axis] -= orders[axis];
        Lattice next(size);
        Array3 lines = size;
        lines[axis] = 1;
        for_all(lines, [&](Array3 i) {
            std::vector<double> line;
            for (i[axis] = 0; i[axis] < v.size[axis]; ++i[axis]) line.push_back(v.at(i));
            i[axis] = 0;
            for (const auto& points : bezier_points(line, orders[axis])) {
                double hull = points[0];
                for (const double point : points) hull = extreme(hull, point);
                next.at(i) = hull;
                ++i[axis];
            }
        });
        v = next;
    }
    return v;
}

Lattice differences(const Lattice& v, std::size_t axis) {
    Array3 size = v.size;
    --size[axis];
    Lattice d(size);
    for_all(size, [&](const Array3& i) {
        Array3 next = i;
        ++next[axis];
        d.at(i) = v.at(next) - v.at(i);
    });
    return d;
}

void add_squares(Lattice d, const Array3& orders, double weight, Lattice& sum) {
    for (double& value : d.values) value = std::abs(value);
    d = hulls(d, orders, greatest);
    for (std::size_t i = 0; i < sum.values.size(); ++i)
        sum.values[i] += weight * d.values[i] * d.values[i];
}

double greatest_of(const Lattice& v) {
    return *std::ranges::max_element(v.values);
}

constexpr Array3 block_cells{block_size, block_size, block_size};

/// Per cell.
struct Reference {
    Lattice least{block_cells};
    Lattice greatest{block_cells};
    Lattice slope_squared{block_cells};
    Lattice bend_squared{block_cells};
    double first = 0; // the greatest |first difference|
};

Reference reference(const Samples& block) {
    constexpr Array3 cubic{3, 3, 3};
    Lattice c({block_size + 3, block_size + 3, block_size + 3});
    for_all(c.size, [&](const Array3& i) { c.at(i) = block.at(i[0] - 1, i[1] - 1, i[2] - 1); });
    Reference reference;
    reference.least = hulls(c, cubic, least);
    reference.greatest = hulls(c, cubic, greatest);
    for (std::size_t u = 0; u < 3; ++u) {
        const Lattice first = differences(c, u);
        for (const double d : first.values)
            reference.first = std::max(reference.first, std::abs(d));
        Array3 orders = cubic;
        --orders[u];
        add_squares(first, orders, 1, reference.slope_squared);
        for (std::size_t v = 0; v < 3; ++v) {
            Array3 second_orders = orders;
            --second_orders[v];
            add_squares(differences(first, v), second_orders, 1, reference.bend_squared);
        }
    }
    return reference;
}

/// The parts with cells that hold a value no farther than `slack` from zero.
std::uint64_t parts_of(const Reference& reference, double slack) {
    std::uint64_t parts = 0;
    for_all(block_cells, [&](const Array3& i) {
        if (reference.least.at(i) > slack || reference.greatest.at(i) < -slack) return;
        parts |= std::uint64_t{1} << (i[0] / 2 + 4 * (i[1] / 2) + 16 * (i[2] / 2));
    });
    return parts;
}

/// The greatest bend of cells that hold a value no farther than `near` from zero.
double bend_within(const Reference& reference, double near) {
    double bend = 0;
    for_all(block_cells, [&](const Array3& i) {
        if (reference.least.at(i) > near || reference.greatest.at(i) < -near) return;
        bend = std::max(bend, std::sqrt(reference.bend_squared.at(i)));
    });
    return bend;
}

TEST(Certificates, AreTheHullsOfBezierPointsRoundedOutward) {
    Random random(2);
    int with_far_cells = 0;
    for (int round = 0; round < 20; ++round) {
        for (const Kind& kind : kinds(random)) {
            const Samples block(block_size, kind.value);
            const Reference expected = reference(block);
            const Certificate certificate = certified(block, Kernel::BSpline);
            const ValueRange range = range_of(block, Kernel::BSpline);

            // Computed inward by 9 * 2^-24 of the greatest |sample| at most, moved outward by
            // 2^-20.
            const double slack = 0x1.9p-20 * block.magnitude;
            const double min = *std::ranges::min_element(expected.least.values);
            const double max = greatest_of(expected.greatest);
            EXPECT_LE(range.min, min) << kind.name;
            EXPECT_GE(range.min, min - slack) << kind.name;
            EXPECT_GE(range.max, max) << kind.name;
            EXPECT_LE(range.max, max + slack) << kind.name;

            const std::uint64_t parts = parts_of(expected, 0);
            EXPECT_EQ(certificate.parts & parts, parts) << kind.name;
            EXPECT_EQ(certificate.parts & ~parts_of(expected, slack), 0U) << kind.name;

            // 2^-20 outward after as many roundings at most.
            constexpr double outward = 1 + 0x1p-19;
            const double slope = std::sqrt(greatest_of(expected.slope_squared));
            EXPECT_GE(certificate.slope, slope) << kind.name;
            EXPECT_LE(certificate.slope, slope * outward) << kind.name;

            // Second differences lose 6 * 2^-24 of the first, and get 2^-21 more.
            const double beside = 0x1p-20 * expected.first;
            const double bend = std::sqrt(greatest_of(expected.bend_squared));
            if (certificate.near == std::numeric_limits<float>::max()) {
                EXPECT_GE(certificate.bend, bend) << kind.name;
                EXPECT_LE(certificate.bend, bend * outward + beside) << kind.name;
            } else {
                ++with_far_cells;
                EXPECT_EQ(certificate.near, certificate.slope);
                EXPECT_GE(certificate.bend, bend_within(expected, certificate.near)) << kind.name;
                EXPECT_LE(certificate.bend,
                          bend_within(expected, certificate.near + slack) * outward + beside)
                    << kind.name;
                // It is left out only where squares differ by half.
                EXPECT_GE(bend * bend * outward + beside,
                          1.5 * std::pow(bend_within(expected, certificate.near), 2))
                    << kind.name;
            }
        }
    }
    EXPECT_GT(with_far_cells, 20);
}

TEST(Certificates, AreExactForPlanes) {
    // Sixteenths: every difference is exact in float.
    const Vec3d slope(0.75, -2.0, 1.0 / 16);
    const double offset = 3;
    const Samples block(block_size,
                        [&](int x, int y, int z) { return offset + slope.dot(Vec3d(x, y, z)); });
    const Certificate certificate = certified(block, Kernel::BSpline);
    EXPECT_GE(certificate.slope, slope.norm());
    EXPECT_LE(certificate.slope, slope.norm() * (1 + 0x1p-19));
    EXPECT_LE(certificate.bend, 0x1p-21 * 2.001); // of the greatest difference
    for (const Kernel kernel : {Kernel::BSpline, Kernel::Linear}) {
        // A B-spline is moved outward by 2^-20 of the samples, which reach 24.
        const double slack = kernel == Kernel::BSpline ? 24 * 0x1.1p-20 : 0;
        const ValueRange range = range_of(block, kernel);
        EXPECT_NEAR(range.min, offset + 8 * slope.cwiseMin(0).sum(), slack);
        EXPECT_NEAR(range.max, offset + 8 * slope.cwiseMax(0).sum(), slack);
    }
}

TEST(Certificates, AreExactForQuadraticsThatGrowAlongAllAxes) {
    const Samples block(block_size, [](int x, int y, int z) {
        return 3 * x * x + y * y + 2 * z * z + 5 * x * y + 3 * x * z + y * z + 10 * (x + y + z);
    });
    const Certificate certificate = certified(block, Kernel::BSpline);
    const ValueRange range = range_of(block, Kernel::BSpline);
    const Jet lowest = evaluate(block, Kernel::BSpline, Vec3d::Zero());
    const Jet highest = evaluate(block, Kernel::BSpline, Vec3d::Constant(block_size));
    EXPECT_NEAR(range.min, lowest.value, 0x1.1p-20 * block.magnitude);
    EXPECT_NEAR(range.max, highest.value, 0x1.1p-20 * block.magnitude);
    EXPECT_NEAR(certificate.slope, highest.gradient.norm(), 0x1p-19 * highest.gradient.norm());
    // The Hessian is the same everywhere; 2^-21 of first differences below 200.
    EXPECT_NEAR(certificate.bend, highest.hessian.norm(),
                0x1p-19 * highest.hessian.norm() + 200 * 0x1p-21);
}

TEST(Certificates, HoldSecondDifferencesThatFirstOnesRoundAway) {
    // 1 + e and 1 - e are 1 in float; the second difference -2 e is all the bend that there is.
    const double e = 0x1p-26;
    const Samples block(block_size, [&](int x, int, int) { return x == 3 ? e : x - 3.0; });
    const Certificate certificate = certified(block, Kernel::BSpline);
    EXPECT_GE(certificate.bend, 2 * e);
    EXPECT_LE(certificate.bend, 0x1.1p-21);
}

TEST(Certificates, LetNoSurfacePassWhereTheRangeDoesNotHoldZero) {
    Random random(3);
    for (int round = 0; round < 20; ++round) {
        for (const Kind& kind : kinds(random)) {
            const Samples block(block_size, kind.value);
            for (const Kernel kernel : {Kernel::Linear, Kernel::BSpline}) {
                const ValueRange range = range_of(block, kernel);
                const bool holds = range.min <= 0 && range.max >= 0;
                EXPECT_TRUE(holds || certified(block, kernel).parts == 0) << kind.name;
            }
        }
    }
}

TEST(Certificates, RangesOfAPageAreThoseOfItsBlocks) {
    Random random(4);
    for (const Kind& kind : kinds(random)) {
        const Samples page(page_size, kind.value);
        for (const Kernel kernel : kernels) {
            const auto ranges =
                ranges_of_page(page.values.data(), page.stride_y, page.stride_z, kernel);
            for (int place = 0; place < blocks_per_page; ++place) {
                const ValueRange expected = range_of_block(
                    &page.values[page.place(8 * (place % 4) - 1, 8 * (place / 4 % 4) - 1,
                                            8 * (place / 16) - 1)],
                    page.stride_y, page.stride_z, kernel);
                const ValueRange found = ranges[static_cast<std::size_t>(place)];
                EXPECT_EQ(found.min, expected.min) << kind.name << place;
                EXPECT_EQ(found.max, expected.max) << kind.name << place;
            }
        }
    }
}

} // namespace
} // namespace isocast
