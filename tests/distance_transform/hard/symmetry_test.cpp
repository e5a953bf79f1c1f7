// What must not change a hard mesh's field, or change it as it changes the mesh.
// SPDX-License-Identifier: MPL-2.0
#include "fields.h"
#include "stability/shapes.h"

namespace isocast::test {

using namespace stability; // its meshes

namespace {

// With vertices at multiples of 2^-20 and this voxel size, moves by whole voxels and all
// differences of coordinates are exact in double.
constexpr double voxel = 0x1p-3;

using Band = std::map<std::array<int, 3>, float>; // by z, y, x

Band band_of(const Mesh& mesh) {
    return band_map(convert(check(mesh), {.voxel_size_world = voxel}).field);
}

struct Subject {
    std::string name;
    Mesh mesh;
    /// Across a hole the sign is that of a hierarchy's approximate winding number, which depends on
    /// where the axes point.
    bool is_open = false;
};

/// How GoogleTest shows a subject.
void PrintTo(const Subject& subject, std::ostream* stream) {
    *stream << subject.name;
}

class Symmetry : public ::testing::TestWithParam<Subject> {
protected:
    const Mesh& mesh() const { return GetParam().mesh; }

    /// Values may differ in the last place of the float, or, near 0, by the rounding of double
    /// coordinates of some 10 voxels (1e-14); there the sign is free.
    void expect_same(const Band& a, const Band& b) const {
        ASSERT_EQ(a.size(), b.size());
        for (auto ia = a.begin(), ib = b.begin(); ia != a.end(); ++ia, ++ib) {
            ASSERT_EQ(ia->first, ib->first);
            const float other =
                GetParam().is_open ? std::copysign(ib->second, ia->second) : ib->second;
            ASSERT_NEAR(ia->second, other, ulp(ia->second) + 1e-14 * voxel);
        }
    }
};

/// A map of the lattice onto itself.
struct LatticeMap {
    Eigen::Matrix3i turn;
    Band of(const Band& band) const {
        Band result;
        for (const auto& [zyx, value] : band) {
            const Index3 p = turn * Index3(zyx[2], zyx[1], zyx[0]);
            result[{p.z(), p.y(), p.x()}] = value;
        }
        return result;
    }
    Mesh of(const Mesh& mesh) const {
        const Mesh result =
            mapped(mesh, [&](const Vec3d& p) { return Vec3d(turn.cast<double>() * p); });
        return turn.determinant() < 0 ? turned_round(result) : result;
    }
};

// Like all that follows but for the moves by whole blocks and the scaling: to rounding, since
// the axes' products are added in another order.
TEST_P(Symmetry, QuarterTurnAboutAnyAxisTurnsTheField) {
    const Band band = band_of(mesh());
    for (int axis = 0; axis < 3; ++axis) {
        LatticeMap map{Eigen::Matrix3i::Zero()};
        map.turn(axis, axis) = 1;
        map.turn((axis + 1) % 3, (axis + 2) % 3) = -1;
        map.turn((axis + 2) % 3, (axis + 1) % 3) = 1;
        SCOPED_TRACE(axis);
        expect_same(band_of(map.of(mesh())), map.of(band));
    }
}

// To rounding: corners change places.
TEST_P(Symmetry, MirrorImageMirrorsTheField) {
    const Band band = band_of(mesh());
    for (int axis = 0; axis < 3; ++axis) {
        LatticeMap map{Eigen::Matrix3i::Identity()};
        map.turn(axis, axis) = -1;
        SCOPED_TRACE(axis);
        expect_same(band_of(map.of(mesh())), map.of(band));
    }
}

// Bit for bit: the transform sees the mesh from its lattice's anchor, a multiple of the block size.
TEST_P(Symmetry, TranslationByWholeBlocksMovesTheFieldBitForBit) {
    const Index3 shift(8 * 5, 8 * -13, 8 * 1000);
    const Vec3d by = voxel * shift.cast<double>();
    const SparseField field = convert(check(moved(mesh(), by)), {.voxel_size_world = voxel}).field;
    EXPECT_EQ(band_map(field, -shift), band_of(mesh()));
}

TEST_P(Symmetry, TranslationByWholeVoxelsMovesTheField) {
    const Index3 shift(5, -13, 1003);
    const Vec3d by = voxel * shift.cast<double>();
    const SparseField field = convert(check(moved(mesh(), by)), {.voxel_size_world = voxel}).field;
    expect_same(band_map(field, -shift), band_of(mesh()));
}

// To rounding: of equally near triangles the first may be taken, and sums begin elsewhere.
TEST_P(Symmetry, OrderOfTrianglesAndVerticesDoesNotMatter) {
    Mesh other = mesh();
    std::mt19937 random(11);
    std::shuffle(other.triangles.begin(), other.triangles.end(), random);
    std::vector<int> place(other.vertices_world.size());
    std::iota(place.begin(), place.end(), 0);
    std::shuffle(place.begin(), place.end(), random);
    for (std::size_t v = 0; v < place.size(); ++v)
        other.vertices_world[place[v]] = mesh().vertices_world[v];
    for (Triangle& triangle : other.triangles) {
        for (int& vertex : triangle) vertex = place[vertex];
        std::rotate(triangle.begin(), triangle.begin() + random() % 3, triangle.end());
    }
    expect_same(band_of(other), band_of(mesh()));
}

// Bit for bit: numbers of two scales differ in the exponent alone.
TEST_P(Symmetry, ScalingByAPowerOfTwoScalesTheFieldBitForBit) {
    for (const int exponent : {-40, 40}) {
        const double scale = std::ldexp(1, exponent);
        Band expected = band_of(mesh());
        for (auto& [zyx, value] : expected) value = std::ldexp(value, exponent);
        const SparseField field =
            convert(check(scaled(mesh(), scale)), {.voxel_size_world = voxel * scale}).field;
        EXPECT_EQ(band_map(field), expected);
    }
}

std::vector<Subject> subjects() {
    const Mesh rough = rounded(noisy_sphere(40, 3));
    Mesh open = rough;
    open.triangles.resize(470);
    return {
        {"RoughSphere", rough},
        {"CubeOnSamples", subdivided(cube(), 2)},
        {"OpenSphere", open, true},
        {"OverlappingShells", rounded(joined(sphere(2), moved(sphere(2), Vec3d(0.9, 0.2, 0.4))))},
        {"CubesThatShareAnEdge", rounded(tilted(joined(cube(), moved(cube(), Vec3d(2, 2, 0)))))}};
}

INSTANTIATE_TEST_SUITE_P(HardMeshes, Symmetry, ::testing::ValuesIn(subjects()),
                         [](const auto& subject) { return subject.param.name; });

} // namespace
} // namespace isocast::test
