// Tests of what an octree holds between its nodes: continuous over cells of several sizes, and
// exact for polynomials.
// SPDX-License-Identifier: MPL-2.0
#include "volume/octree_interpolant.h"

#include "octree_jumps.h"
#include "octree_oracle.h"
#include "volume/hanging_nodes.h"

namespace isocast {
namespace {

using test::corner_of;
using test::greatest_jump;
using test::LeafData;
using test::Random;
using test::rounding;

constexpr std::array filters = {OctreeFilter::Linear, OctreeFilter::Cubic};
constexpr int depth = 6;

/// Noise of a position and seed: values in [-1, 1], and slopes that change as much over `reach`.
HashedOctree::NodeSampler noise(std::uint32_t seed, double reach) {
    return [=](const Index3& p, std::span<float> out) {
        std::minstd_rand random(
            seed + 0x9e3779b1u * static_cast<unsigned>(p.x() + (p.y() << 10) + (p.z() << 20)));
        std::uniform_real_distribution<double> unit(-1, 1);
        for (unsigned d = 0; d < out.size(); ++d)
            out[d] = static_cast<float>(unit(random) / std::pow(reach, std::popcount(d)));
    };
}

/// A polynomial of degree 1 or 3 in each of x, y, z, all over [0, 2^depth]; and its derivatives.
class Polynomial {
public:
    Polynomial(Random& random, OctreeFilter filter) : n_(filter == OctreeFilter::Linear ? 2 : 4) {
        for (double& c : coefficients_) c = test::random_real(random, -1, 1);
    }
    double at(const Vec3d& p, unsigned derivative = 0) const {
        double sum = 0;
        for (int k = 0; k < n_; ++k)
            for (int j = 0; j < n_; ++j)
                for (int i = 0; i < n_; ++i)
                    sum += coefficients_[static_cast<std::size_t>(i + 4 * j + 16 * k)] *
                           power(p.x(), i, derivative & 1) * power(p.y(), j, derivative & 2) *
                           power(p.z(), k, derivative & 4);
        return sum;
    }
    void operator()(const Index3& p, std::span<float> out) const {
        for (unsigned d = 0; d < out.size(); ++d)
            out[d] = static_cast<float>(at(p.cast<double>(), d));
    }

private:
    static double power(double x, int n, bool derivative) {
        const double side = 1 << depth;
        if (!derivative) return std::pow(x / side, n);
        return n == 0 ? 0 : n * std::pow(x / side, n - 1) / side;
    }
    int n_;
    std::array<double, 64> coefficients_{};
};

/// Divides leaves and merges others at random; neighbours differ by any number of levels.
void change(HashedOctree& tree, Random& random, const HashedOctree::NodeSampler& sampler,
            int changes) {
    for (int i = 0; i < changes; ++i) {
        const OctreeCell leaf = tree.leaf_at(test::random_finest(random, depth).cast<double>());
        if (leaf.level > 0 && test::random_int(random, 0, 3) > 0) {
            tree.divide(leaf, sampler);
        } else if (leaf.level < depth) {
            bool can_merge = true;
            for (int j = 0; j < 8; ++j) can_merge &= !tree.is_divided(child_of(parent_of(leaf), j));
            if (can_merge) tree.merge(parent_of(leaf));
        }
    }
}

TEST(OctreeInterpolant, IsContinuousAcrossFacesOfCellsOfAnySizesOnceHangingNodesAreConstrained) {
    for (const OctreeFilter filter : filters)
        for (std::uint32_t seed = 0; seed < 10; ++seed) {
            Random random(seed);
            const auto sampler = noise(seed, 1 << test::random_int(random, 0, depth));
            HashedOctree tree(depth, filter, sampler);
            for (int i = 0; i < 3; ++i) {
                change(tree, random, sampler, 150);
                // Without: the test sees hanging nodes.
                EXPECT_GT(greatest_jump(tree, random, false), 1e4);
                tree.constrain_hanging_nodes(sampler);
                // A level of constraints rounds once, twice in faces' middles, which come from
                // edges'; then each side's result. Seen: 1.7 of linear, 1.2 of cubic.
                const double most = 2 * depth + 2;
                EXPECT_LE(greatest_jump(tree, random, false), most) << seed;
                if (filter == OctreeFilter::Cubic) {
                    EXPECT_LE(greatest_jump(tree, random, true), most) << seed;
                }
            }
        }
}

TEST(OctreeInterpolant, HoldsSampledValuesAtEachNodeThatDoesNotHang) {
    Random random(1);
    const auto sampler = noise(1, 1);
    HashedOctree tree(depth, OctreeFilter::Cubic, sampler);
    for (int i = 0; i < 20; ++i) {
        change(tree, random, sampler, 50);
        tree.constrain_hanging_nodes(sampler);
        std::size_t hanging = 0;
        tree.visit_nodes([&](const Index3& position, HashedOctree::NodeNumber node) {
            ASSERT_EQ(tree.is_constrained(node), tree.is_hanging(position));
            hanging += tree.is_constrained(node);
            std::array<float, 8> expected;
            sampler(position, expected);
            ASSERT_EQ(std::ranges::equal(expected, tree.data_of(node)), !tree.is_hanging(position))
                << position.transpose();
        });
        EXPECT_GT(hanging, 100u);
    }
}

TEST(HangingNodes, OfATreeThatGrowsAreThoseThatAreFoundAnew) {
    for (const OctreeFilter filter : filters)
        for (std::uint32_t seed = 0; seed < 5; ++seed) {
            Random random(seed);
            const auto sampler = noise(seed, 1);
            HashedOctree tree(depth, filter, sampler);
            HangingNodes hanging;
            for (int turn = 0; turn < 10; ++turn) {
                for (int i = 0; i < 40; ++i) {
                    const OctreeCell leaf =
                        tree.leaf_at(test::random_finest(random, depth).cast<double>());
                    if (leaf.level == 0) continue;
                    tree.divide(leaf, sampler);
                    hanging.add(tree, leaf);
                }
                HashedOctree anew = tree;
                anew.constrain_hanging_nodes(sampler);
                std::set<Index3, test::ZyxLess> changed;
                const HashedOctree before = tree;
                hanging.constrain(tree, sampler, [&](const Index3& position) {
                    EXPECT_TRUE(changed.insert(position).second);
                });
                tree.visit_nodes([&](const Index3& position, HashedOctree::NodeNumber node) {
                    ASSERT_EQ(tree.is_constrained(node), tree.is_hanging(position));
                    ASSERT_EQ(tree.is_constrained(node), anew.is_constrained(node));
                    const auto now = std::as_const(tree).data_of(node);
                    ASSERT_TRUE(std::ranges::equal(now, std::as_const(anew).data_of(node)));
                    ASSERT_EQ(changed.contains(position),
                              !std::ranges::equal(now, before.data_of(node)));
                });
            }
        }
}

TEST(OctreeInterpolant, IsThePolynomialOfItsDegree) {
    for (const OctreeFilter filter : filters)
        for (std::uint32_t seed = 0; seed < 10; ++seed) {
            Random random(seed);
            const Polynomial polynomial(random, filter);
            HashedOctree tree(depth, filter, polynomial);
            change(tree, random, polynomial, 200);
            tree.constrain_hanging_nodes(polynomial);
            for (int i = 0; i < 2000; ++i) {
                const Vec3d p = test::random_point(random, 0, 1 << depth);
                const LeafData leaf(tree, tree.leaf_at(p), 0);
                // Roundings as above, and that of the samples.
                EXPECT_NEAR(tree.value_at(p), polynomial.at(p),
                            (2 * depth + 2) * rounding * leaf.greatest);
            }
        }
}

TEST(OctreeInterpolant, ContinuesBeyondTheBorderAsTheValueThere) {
    Random random(2);
    const Polynomial polynomial(random, OctreeFilter::Cubic);
    HashedOctree tree(depth, OctreeFilter::Cubic, polynomial);
    change(tree, random, polynomial, 100);
    tree.constrain_hanging_nodes(polynomial);
    for (int i = 0; i < 1000; ++i) {
        const Vec3d p = test::random_point(random, -(1 << depth), 2 << depth);
        EXPECT_EQ(tree.value_at(p), tree.value_at(p.cwiseMax(0).cwiseMin(1 << depth)));
    }
}

} // namespace
} // namespace isocast
