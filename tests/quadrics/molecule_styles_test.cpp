// What a molecule becomes: radii, colours, and sticks that meet.
// SPDX-License-Identifier: MPL-2.0
#include "quadrics/molecule_styles.h"

#include "molecule_writers.h"
#include "quadrics/elements.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace isocast::test {
namespace {

Molecule bonded(std::vector<Atom> atoms) {
    Molecule molecule{.atoms = std::move(atoms)};
    molecule.bonds = bonds_by_distance(molecule.atoms);
    return molecule;
}

TEST(Elements, AreFoundByTheirSymbols) {
    for (int z = 1; z <= last_atomic_number; ++z) {
        EXPECT_EQ(atomic_number_of(element_of(z).symbol), z);
        EXPECT_GT(element_of(z).covalent_angstrom, 0.2);
        EXPECT_LT(element_of(z).covalent_angstrom, 2.7);
        EXPECT_GE(element_of(z).van_der_waals_angstrom, 1.2);
        EXPECT_LT(element_of(z).van_der_waals_angstrom, 3.5);
    }
    EXPECT_EQ(atomic_number_of("FE"), 26);
    EXPECT_EQ(atomic_number_of("D"), 1);
    for (const char* none : {"", "X", "Xx", "Fee", "1"}) EXPECT_EQ(atomic_number_of(none), 0);
    EXPECT_STREQ(element_of(-1).symbol, "X");
    EXPECT_STREQ(element_of(119).symbol, "X");
}

TEST(MoleculeStyles, SpaceFillingSpheresHaveVanDerWaalsRadii) {
    const MoleculePrimitives primitives =
        primitives_of(bonded(water()), {.style = MoleculeStyle::SpaceFilling});
    ASSERT_EQ(primitives.spheres.size(), 3u);
    EXPECT_TRUE(primitives.sticks.empty());
    EXPECT_EQ(primitives.spheres[0].radius_world, 1.52); // Bondi 1964
    EXPECT_EQ(primitives.spheres[1].radius_world, 1.20);
    EXPECT_EQ(primitives.spheres[1].centre_world, Vec3d(0.757, 0.586, 0));
}

TEST(MoleculeStyles, HalvesOfSticksHaveTheirAtomsColours) {
    const Molecule molecule = bonded(water());
    for (const MoleculeStyle style : {MoleculeStyle::BallsAndSticks, MoleculeStyle::Licorice}) {
        const MoleculePrimitives primitives =
            primitives_of(molecule, {.style = style, .ends_sticks_in_balls = false});
        ASSERT_EQ(primitives.spheres.size(), 3u);
        ASSERT_EQ(primitives.sticks.size(), molecule.bonds.size());
        for (std::size_t k = 0; k < molecule.bonds.size(); ++k) {
            const auto i = std::size_t(molecule.bonds[k].i), j = std::size_t(molecule.bonds[k].j);
            const Cylinder& stick = primitives.sticks[k];
            EXPECT_EQ(stick.a_world, molecule.atoms[i].position);
            EXPECT_EQ(stick.b_world, molecule.atoms[j].position);
            EXPECT_EQ(stick.colour, primitives.spheres[i].colour);
            EXPECT_EQ(stick.colour_b, primitives.spheres[j].colour);
            EXPECT_FALSE(stick.is_capped);
            if (style == MoleculeStyle::Licorice) {
                EXPECT_EQ(stick.radius_world, primitives.spheres[i].radius_world);
            } else {
                EXPECT_EQ(stick.radius_world, 0.15);
                EXPECT_EQ(primitives.spheres[i].radius_world, i == 0 ? 0.25 * 1.52 : 0.25 * 1.2);
            }
        }
        EXPECT_NO_THROW(check(std::span<const Sphere>(primitives.spheres)));
        EXPECT_NO_THROW(check(std::span<const Cylinder>(primitives.sticks)));
    }
}

TEST(MoleculeStyles, SticksEndWhereBallsHideThem) {
    const Molecule molecule = bonded(water());
    const MoleculePrimitives whole = primitives_of(molecule, {.ends_sticks_in_balls = false});
    const MoleculePrimitives ended = primitives_of(molecule);
    ASSERT_EQ(ended.sticks.size(), 2u);
    for (std::size_t k = 0; k < 2; ++k) {
        const Cylinder& stick = ended.sticks[k];
        EXPECT_LT((stick.b_world - stick.a_world).norm(),
                  0.6 * (whole.sticks[k].b_world - whole.sticks[k].a_world).norm());
        // The same middle, and their ends' rims inside the balls.
        EXPECT_LT(
            (stick.a_world + stick.b_world - whole.sticks[k].a_world - whole.sticks[k].b_world)
                .norm(),
            1e-15);
        for (const auto& [end, ball] : {std::pair{stick.a_world, std::size_t(molecule.bonds[k].i)},
                                        std::pair{stick.b_world, std::size_t(molecule.bonds[k].j)}})
            EXPECT_LT(
                std::hypot((end - ended.spheres[ball].centre_world).norm(), stick.radius_world),
                ended.spheres[ball].radius_world);
    }
    // Where sticks are as thick as balls, nothing is hidden.
    const MoleculePrimitives licorice = primitives_of(molecule, {.style = MoleculeStyle::Licorice});
    EXPECT_EQ(licorice.sticks[0].a_world,
              licorice.spheres[std::size_t(molecule.bonds[0].i)].centre_world);
}

TEST(MoleculeStyles, ABondWithoutLengthHasNoStick) {
    Molecule molecule{
        .atoms = {atom("C", "C", "X", 1, {1, 2, 3}), atom("C", "C", "X", 1, {1, 2, 3})},
        .bonds = {{0, 1, 1}}};
    EXPECT_TRUE(primitives_of(molecule).sticks.empty());
    EXPECT_TRUE(primitives_of(Molecule{}).spheres.empty());
}

TEST(MoleculeColoursOf, ColoursAreLinear) {
    EXPECT_EQ(linear_colour(0x000000), Vec3d(0, 0, 0));
    EXPECT_EQ(linear_colour(0xffffff), Vec3d(1, 1, 1));
    // 188 is the byte next to half the light.
    EXPECT_NEAR(linear_colour(0x00bc00).y(), 0.5, 0.005);
    EXPECT_NEAR(linear_colour(0x0000ff).z(), 1, 0);
    EXPECT_NEAR(linear_colour(0x0a0000).x(), 10 / 255.0 / 12.92, 1e-12);
}

TEST(MoleculeColoursOf, ElementsAndResiduesHaveJmols) {
    const Molecule molecule{.atoms = {atom("O", "O", "ASP", 1, Vec3d::Zero()),
                                      atom("N", "N", "ADE", 2, Vec3d::Zero())}};
    const std::vector<Vec3d> elements = colours_of(molecule, MoleculeColours::Element);
    EXPECT_EQ(elements[0], linear_colour(0xff0d0d));
    EXPECT_EQ(elements[1], linear_colour(0x3050f8));
    const std::vector<Vec3d> residues = colours_of(molecule, MoleculeColours::Residue);
    EXPECT_EQ(residues[0], linear_colour(0xe60a0a));
    EXPECT_EQ(residues[1], linear_colour(0xbea06e)); // none of the amino acids
}

TEST(MoleculeColoursOf, ChainsDifferAndAtomsOfOneDoNot) {
    Molecule molecule;
    for (const char* chain : {"A", "B", "A", "C"})
        molecule.atoms.push_back(atom("C", "C", "X", 1, Vec3d::Zero(), chain));
    const std::vector<Vec3d> colours = colours_of(molecule, MoleculeColours::Chain);
    EXPECT_EQ(colours[0], colours[2]);
    EXPECT_NE(colours[0], colours[1]);
    EXPECT_NE(colours[1], colours[3]);
    EXPECT_NE(colours[0], colours[3]);
}

TEST(MoleculeColoursOf, BFactorsRunFromBlueToRedBetweenPercentiles) {
    Molecule molecule;
    for (int b = 0; b <= 100; ++b) {
        molecule.atoms.push_back(atom("C", "C", "X", 1, Vec3d::Zero()));
        molecule.atoms.back().b_factor = b;
    }
    const std::vector<Vec3d> colours = colours_of(molecule, MoleculeColours::BFactor);
    const Vec3d blue(0, 0, 1), white(1, 1, 1), red(1, 0, 0);
    for (const int b : {0, 3, 5}) EXPECT_EQ(colours[std::size_t(b)], blue);
    for (const int b : {95, 98, 100}) EXPECT_EQ(colours[std::size_t(b)], red);
    EXPECT_LT((colours[50] - white).norm(), 1e-12);
    for (std::size_t b = 6; b < 95; ++b) { // monotone: red rises, blue falls
        EXPECT_GE(colours[b].x(), colours[b - 1].x());
        EXPECT_LE(colours[b].z(), colours[b - 1].z());
    }
    for (Atom& a : molecule.atoms) a.b_factor = 7;
    EXPECT_EQ(colours_of(molecule, MoleculeColours::BFactor)[0], white);
}

} // namespace
} // namespace isocast::test
