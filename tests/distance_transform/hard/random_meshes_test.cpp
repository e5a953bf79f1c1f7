// Random solids without a wrong sign; the long tests have 200 of them.
// SPDX-License-Identifier: MPL-2.0
#include "exact_field.h"
#include "random_solids.h"

namespace isocast::test {
namespace {

TEST(RandomSolids, RoughSpheresAreExact) {
    for (unsigned seed = 1000; seed < 1012; ++seed) {
        SCOPED_TRACE(seed);
        expect_exact_conversion(noisy_sphere(seed, 2 + int(seed % 2)), 0.15);
    }
}

TEST(RandomSolids, OverlappingShellsAreTheirUnion) {
    for (unsigned seed = 2000; seed < 2008; ++seed) {
        SCOPED_TRACE(seed);
        expect_exact_conversion(overlapping_shells(seed), 0.13);
    }
}

TEST(RandomSolids, WindingNumberAskedForIsExactToo) {
    for (unsigned seed = 3000; seed < 3008; ++seed) {
        SCOPED_TRACE(seed);
        const Mesh mesh = seed % 2 == 0 ? noisy_sphere(seed, 3) : overlapping_shells(seed);
        const SparseField field =
            convert(check(mesh), {.voxel_size_world = 0.13, .sign = SignMethod::Winding}).field;
        expect_no_faults(
            faults_of(field, brute_force_field(mesh, mesh, Sides::Closed, field.space(), 3), 3));
    }
}

// Signs of normals that contradict each other at one sample, 0.3 voxel from the surface, are too
// near for two neighbours to show it.
TEST(RandomSolids, OverlappingShellsThatContradictAtOneSampleAreTheirUnion) {
    expect_exact_conversion(overlapping_shells(157), 0.08);
}

} // namespace
} // namespace isocast::test
