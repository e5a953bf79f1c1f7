// Readers of molecules: what is known of a molecule comes out of every format.
// SPDX-License-Identifier: MPL-2.0
#include "quadrics/molecule.h"

#include "damaged_molecules.h"
#include "quadrics/elements.h"
#include "volume/errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <set>

namespace isocast::test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;
using ::testing::StartsWith;

using Pairs = std::vector<std::pair<int, int>>;

std::vector<std::string> chains_of(const Molecule& molecule) {
    std::vector<std::string> chains;
    for (const Atom& a : molecule.atoms)
        if (std::find(chains.begin(), chains.end(), a.chain) == chains.end())
            chains.push_back(a.chain);
    return chains;
}

std::vector<std::string> names_of(const Molecule& molecule) {
    std::vector<std::string> names;
    for (const Atom& a : molecule.atoms) names.push_back(a.name);
    return names;
}

std::string error_of(const std::string& extension, const std::string& text,
                     const MoleculeOptions& options = {}) {
    return message_of<InputError>([&] { read_text(extension, text, options); });
}

// ------------------------------------------------------------------------------------- formats

TEST(MoleculeFiles, EveryFormatHoldsTheSameAtomsAndBonds) {
    std::vector<Atom> atoms = alanine_dipeptide();
    for (std::size_t i = 0; i < atoms.size(); ++i) {
        atoms[i].b_factor = double(i) / 4; // two decimals hold it
        atoms[i].is_hetero = atoms[i].residue_name != "ALA";
    }
    atoms.back().insertion_code = "B";
    for (const auto& [extension, text] :
         {std::pair(".pdb", pdb_text(atoms)), std::pair(".cif", mmcif_text(atoms)),
          std::pair(".xyz", xyz_text(atoms))}) {
        const Molecule molecule = read_text(extension, text);
        EXPECT_EQ(molecule.title, "A TEST");
        EXPECT_EQ(pairs_of(molecule.bonds), alanine_dipeptide_bonds) << extension;
        const bool is_xyz = std::string_view(extension) == ".xyz";
        ASSERT_EQ(molecule.atoms.size(), atoms.size());
        for (std::size_t i = 0; i < atoms.size(); ++i) {
            const Atom &a = molecule.atoms[i], &expected = atoms[i];
            EXPECT_EQ(a.element, expected.element);
            EXPECT_EQ(a.position, expected.position) << extension << " " << i;
            EXPECT_EQ(a.model, 1);
            EXPECT_EQ(a.occupancy, 1);
            EXPECT_FALSE(a.is_water);
            if (is_xyz) continue;
            EXPECT_EQ(a.name, expected.name);
            EXPECT_EQ(a.residue_name, expected.residue_name);
            EXPECT_EQ(a.residue_number, expected.residue_number);
            EXPECT_EQ(a.chain, "A");
            EXPECT_EQ(a.b_factor, expected.b_factor);
            EXPECT_EQ(a.altloc, "");
            EXPECT_EQ(a.is_hetero, expected.is_hetero) << extension << " " << i;
            // The last atom's residue has another insertion code, and is another residue.
            EXPECT_EQ(a.insertion_code, expected.insertion_code);
        }
    }
}

TEST(MoleculeFiles, ExtensionsAreKnownInAnyCase) {
    for (const char* name : {"a.pdb", "a.PDB", "b.ent", "c.Cif", "d.mmcif", "e.xyz"})
        EXPECT_TRUE(is_molecule_file(name)) << name;
    for (const char* name : {"a.pdb.gz", "pdb", "a.mol2", "a.nrrd"})
        EXPECT_FALSE(is_molecule_file(name)) << name;
    EXPECT_EQ(molecule_file_extensions(), ".pdb, .ent, .cif, .mmcif, .xyz");
    EXPECT_THAT(error_of(".mol2", "x"), HasSubstr("known: .pdb"));
}

TEST(MoleculeFiles, PdbLinesMayEndAfterTheCoordinates) {
    const Molecule molecule =
        read_text(".pdb", "ATOM      1  CA  ALA A   1       1.000   2.000   3.000\n"
                          "HETATM    2 CA    CA A   2       1.000   2.000   9.000\n");
    ASSERT_THAT(molecule.atoms, SizeIs(2));
    EXPECT_EQ(molecule.atoms[0].element, 6); // by the columns of the name
    EXPECT_EQ(molecule.atoms[1].element, 20);
    EXPECT_EQ(molecule.atoms[0].position, Vec3d(1, 2, 3));
    EXPECT_EQ(molecule.atoms[0].occupancy, 1);
    EXPECT_EQ(molecule.atoms[0].b_factor, 0);
}

// gemmi 0.5.7 read past the end of such records; a copy of the fuzz test showed it.
TEST(MoleculeFiles, PdbRecordsThatAreNotNeededMayBeGarbage) {
    const std::string text = pdb_text(alanine_dipeptide());
    for (const char* garbage :
         {"SSBOND   1 ALA A    2    ALA A    2                          1555   1555 n", "LINK\n",
          "LINK         C   ACE A   1                 N   ALA A   2     1555   1555 i", "ANISOU",
          "AUTHOR    ,", "CRYST1    x", "SEQRES", "HELIX", "SHEET", "DBREF "})
        EXPECT_EQ(pairs_of(read_text(".pdb", garbage + ("\n" + text)).bonds),
                  alanine_dipeptide_bonds)
            << garbage;
}

TEST(MoleculeFiles, XyzTakesAtomicNumbersFurtherColumnsAndFrames) {
    const std::string text = "2\nfirst\n6 0 0 0 0.5 x\nFE +2 0 1e0\n\n1\nsecond\nd 1 2 3\n\n";
    const Molecule first = read_text(".xyz", text);
    ASSERT_THAT(first.atoms, SizeIs(2));
    EXPECT_EQ(first.atoms[0].element, 6);
    EXPECT_EQ(first.atoms[1].element, 26);
    EXPECT_EQ(first.atoms[1].position, Vec3d(2, 0, 1));
    EXPECT_EQ(first.title, "first");
    const Molecule second = read_text(".xyz", text, {.model = 2});
    ASSERT_THAT(second.atoms, SizeIs(1));
    EXPECT_EQ(second.atoms[0].element, 1);
    EXPECT_EQ(second.atoms[0].position, Vec3d(1, 2, 3));
}

// --------------------------------------------------------------------------------------- bonds

TEST(MoleculeBonds, WaterHasTwo) {
    const Molecule molecule = read_text(".pdb", pdb_text(water()), {.waters = true});
    EXPECT_EQ(pairs_of(molecule.bonds), (Pairs{{0, 1}, {0, 2}}));
    EXPECT_TRUE(molecule.atoms[0].is_water);
}

TEST(MoleculeBonds, BenzeneHasARingAndItsHydrogens) {
    const Molecule molecule = read_text(".cif", mmcif_text(benzene()));
    EXPECT_EQ(pairs_of(molecule.bonds), (Pairs{{0, 1},
                                               {0, 5},
                                               {0, 6},
                                               {1, 2},
                                               {1, 7},
                                               {2, 3},
                                               {2, 8},
                                               {3, 4},
                                               {3, 9},
                                               {4, 5},
                                               {4, 10},
                                               {5, 11}}));
}

TEST(MoleculeBonds, AHydrogenHasOneToTheNearest) {
    // In a hydrogen bond that is far too short: O-H 1.0, H…O 1.3 angstrom, within the tolerance.
    const std::vector<Atom> atoms{atom("O", "O", "X", 1, {0, 0, 0}),
                                  atom("H", "H", "X", 1, {1.0, 0, 0}),
                                  atom("O", "O", "X", 2, {2.3, 0, 0})};
    EXPECT_EQ(pairs_of(bonds_by_distance(atoms)), (Pairs{{0, 1}}));
    // Two hydrogens are bonded only if there is nothing else.
    const std::vector<Atom> pair{atom("H", "H1", "X", 1, {0, 0, 0}),
                                 atom("H", "H2", "X", 1, {0.74, 0, 0})};
    EXPECT_EQ(pairs_of(bonds_by_distance(pair)), (Pairs{{0, 1}}));
    const std::vector<Atom> crowded{atom("C", "C", "X", 1, {0, 0, 0}),
                                    atom("H", "H1", "X", 1, {1.09, 0, 0}),
                                    atom("H", "H2", "X", 1, {0.9, 0.6, 0})};
    EXPECT_EQ(pairs_of(bonds_by_distance(crowded)), (Pairs{{0, 1}, {0, 2}}));
}

TEST(MoleculeBonds, TheGridFindsWhatBruteForceFinds) {
    std::mt19937 random(7);
    for (int round = 0; round < 30; ++round) {
        // From a dense crowd about the origin to a thin cloud far from it.
        const double half = 2.0 + round;
        const Vec3d centre = round % 3 == 0 ? Vec3d::Zero().eval() : Vec3d(999990, -999960, 3.7);
        std::uniform_real_distribution<double> place(-std::min(half, 9.0), std::min(half, 9.0));
        std::vector<Atom> atoms;
        for (int i = 0; i < 400; ++i) {
            Atom a;
            a.element = std::array{1, 6, 7, 8, 16, 26, 55, 0}[random() % (round % 2 ? 8 : 5)];
            a.position = centre + Vec3d(place(random), place(random), place(random));
            if (round == 4) a.position = a.position.array().round(); // on the borders of cells
            if (round > 20) a.altloc = std::array{"", "A", "B"}[random() % 3];
            atoms.push_back(a);
        }
        // All pairs, and then for each hydrogen its best.
        const auto distance = [&](std::size_t i, std::size_t j) {
            return (atoms[i].position - atoms[j].position).norm();
        };
        const auto is_near = [&](std::size_t i, std::size_t j) {
            const double reach = element_of(atoms[i].element).covalent_angstrom +
                                 element_of(atoms[j].element).covalent_angstrom + 0.45;
            const bool is_elsewhere = !atoms[i].altloc.empty() && !atoms[j].altloc.empty() &&
                                      atoms[i].altloc != atoms[j].altloc;
            return i != j && distance(i, j) > 0.4 && distance(i, j) <= reach && !is_elsewhere;
        };
        const auto rank = [&](std::size_t h, std::size_t j) { // smaller is better
            return std::tuple(atoms[j].element == 1, distance(h, j), j);
        };
        const auto accepts = [&](std::size_t i, std::size_t j) {
            if (atoms[i].element != 1) return true;
            for (std::size_t k = 0; k < atoms.size(); ++k)
                if (is_near(i, k) && rank(i, k) < rank(i, j)) return false;
            return true;
        };
        Pairs expected;
        for (std::size_t i = 0; i < atoms.size(); ++i)
            for (std::size_t j = i + 1; j < atoms.size(); ++j)
                if (is_near(i, j) && accepts(i, j) && accepts(j, i))
                    expected.emplace_back(int(i), int(j));
        EXPECT_EQ(pairs_of(bonds_by_distance(atoms)), expected) << round;
        EXPECT_FALSE(expected.empty());
    }
}

TEST(MoleculeBonds, ThoseOfTheFileAreKeptWithTheirOrders) {
    // Too far for a bond by distance.
    const std::vector<Atom> far{atom("C", "C1", "LIG", 1, {0, 0, 0}),
                                atom("C", "C2", "LIG", 1, {4, 0, 0}),
                                atom("ZN", "ZN", "LIG", 2, {8, 0, 0})};
    const Molecule pdb = read_text(".pdb", pdb_atoms(far) + "CONECT    1    2    2    3\n"
                                                            "CONECT    2    1    1\n"
                                                            "CONECT    3    9\nEND\n");
    ASSERT_THAT(pdb.bonds, SizeIs(2));
    EXPECT_EQ(pairs_of(pdb.bonds), (Pairs{{0, 1}, {0, 2}}));
    EXPECT_EQ(pdb.bonds[0].order, 2);
    EXPECT_EQ(pdb.bonds[1].order, 1);
    const Molecule cif = read_text(
        ".cif", mmcif_text(far) + "loop_\n_struct_conn.id\n_struct_conn.conn_type_id\n"
                                  "_struct_conn.ptnr1_auth_asym_id\n"
                                  "_struct_conn.ptnr1_auth_seq_id\n"
                                  "_struct_conn.ptnr1_label_atom_id\n"
                                  "_struct_conn.ptnr2_auth_asym_id\n"
                                  "_struct_conn.ptnr2_auth_seq_id\n"
                                  "_struct_conn.ptnr2_label_atom_id\n"
                                  "_struct_conn.ptnr2_symmetry\n_struct_conn.pdbx_value_order\n"
                                  "1 covale A 1 C1 A 1 C2 ? doub\n"
                                  "2 metalc A 2 ZN A 1 C2 ? ?\n"
                                  "3 hydrog A 2 ZN A 1 C1 ? ?\n"
                                  "4 covale A 2 ZN A 1 C1 2_655 ?\n");
    EXPECT_EQ(pairs_of(cif.bonds), (Pairs{{0, 1}, {1, 2}}));
    EXPECT_EQ(cif.bonds[0].order, 2);
}

// ------------------------------------------------------------------------------------- options

TEST(MoleculeOptionsOf, AlternativeLocationsAreChosenForEachResidue) {
    std::vector<Atom> atoms;
    const auto add = [&](const char* name, const char* residue, int number, const char* altloc,
                         double occupancy) {
        atoms.push_back(atom("C", name, residue, number, Vec3d(3.0 * double(atoms.size()), 0, 0)));
        atoms.back().altloc = altloc;
        atoms.back().occupancy = occupancy;
    };
    add("C1", "AAA", 1, "A", 0.4);
    add("C2", "AAA", 1, "B", 0.6);
    add("C3", "AAA", 1, "", 1);
    add("C4", "BBB", 2, "A", 0.5); // a tie: the first
    add("C5", "BBB", 2, "B", 0.5);
    add("C6", "SER", 3, "A", 0.3); // two residues in one place
    add("C7", "THR", 3, "C", 0.7);
    for (const auto& [extension, text] :
         {std::pair(".pdb", pdb_text(atoms)), std::pair(".cif", mmcif_text(atoms))}) {
        EXPECT_THAT(names_of(read_text(extension, text)), ElementsAre("C2", "C3", "C4", "C7"));
        EXPECT_THAT(names_of(read_text(extension, text, {.altloc = "A"})),
                    ElementsAre("C1", "C3", "C4", "C6"));
        EXPECT_THAT(names_of(read_text(extension, text, {.altloc = "B"})),
                    ElementsAre("C2", "C3", "C5", "C7"));
    }
}

TEST(MoleculeOptionsOf, TheModelIsTheFirstOrTheOneNamed) {
    std::vector<Atom> atoms;
    for (const int model : {3, 5}) {
        atoms.push_back(atom("C", "C", "LIG", 1, Vec3d(model, 0, 0)));
        atoms.back().model = model;
    }
    for (const auto& [extension, text] : {std::pair(".pdb", pdb_atoms(atoms, true) + "END\n"),
                                          std::pair(".cif", mmcif_text(atoms))}) {
        EXPECT_EQ(read_text(extension, text).atoms.at(0).position.x(), 3);
        EXPECT_EQ(read_text(extension, text, {.model = 5}).atoms.at(0).position.x(), 5);
        EXPECT_THAT(error_of(extension, text, {.model = 1}),
                    HasSubstr("there is no model 1 (known: 3, 5)"));
    }
}

TEST(MoleculeOptionsOf, SelectionsAreChainsAndRanges) {
    std::vector<Atom> atoms;
    for (const char* chain : {"A", "B"})
        for (const int number : {-5, 1, 2, 30})
            atoms.push_back(atom("C", std::string(chain) + std::to_string(number), "ALA", number,
                                 Vec3d(double(atoms.size()) * 5, 0, 0), chain));
    const auto names = [&](const std::string& selection) {
        return names_of(read_text(".cif", mmcif_text(atoms), {.selection = selection}));
    };
    EXPECT_THAT(names("A"), ElementsAre("A-5", "A1", "A2", "A30"));
    EXPECT_THAT(names("A:1-2"), ElementsAre("A1", "A2"));
    EXPECT_THAT(names(" B:-5-1 , A:30"), ElementsAre("A30", "B-5", "B1"));
    EXPECT_THAT(names("A:-5"), ElementsAre("A-5"));
    EXPECT_THAT(names("B:1,B:1-2"), ElementsAre("B1", "B2"));
    EXPECT_THAT(names(""), SizeIs(8));
    for (const char* bad : {":1", "A:", "A:x", "A:5-1", "A,,B", "A:1-2-3", ","})
        EXPECT_THAT(error_of(".cif", mmcif_text(atoms), {.selection = bad}),
                    HasSubstr("is no selection"))
            << bad;
    EXPECT_THAT(error_of(".cif", mmcif_text(atoms), {.selection = "C,A,B:99"}),
                HasSubstr("the selection C, B:99 matches no atom (chains: A, B)"));
}

TEST(MoleculeOptionsOf, WatersAreLeftOutUnlessAskedFor) {
    std::vector<Atom> atoms = benzene();
    for (Atom a : water()) {
        a.chain = "W";
        a.position.z() += 10;
        atoms.push_back(a);
    }
    EXPECT_THAT(read_text(".pdb", pdb_text(atoms)).atoms, SizeIs(12));
    EXPECT_THAT(read_text(".pdb", pdb_text(atoms), {.waters = true}).atoms, SizeIs(15));
    EXPECT_THAT(error_of(".pdb", pdb_text(water())), HasSubstr("all atoms are of waters"));
}

constexpr const char* operators =
    "loop_\n_pdbx_struct_oper_list.id\n_pdbx_struct_oper_list.matrix[1][1]\n"
    "_pdbx_struct_oper_list.matrix[1][2]\n_pdbx_struct_oper_list.matrix[1][3]\n"
    "_pdbx_struct_oper_list.vector[1]\n_pdbx_struct_oper_list.matrix[2][1]\n"
    "_pdbx_struct_oper_list.matrix[2][2]\n_pdbx_struct_oper_list.matrix[2][3]\n"
    "_pdbx_struct_oper_list.vector[2]\n_pdbx_struct_oper_list.matrix[3][1]\n"
    "_pdbx_struct_oper_list.matrix[3][2]\n_pdbx_struct_oper_list.matrix[3][3]\n"
    "_pdbx_struct_oper_list.vector[3]\n"
    "1 1 0 0 0 0 1 0 0 0 0 1 0\n"
    "2 1 0 0 0 0 1 0 0 0 0 1 100\n" // up by 100 angstrom
    "P 0 -1 0 0 1 0 0 0 0 0 1 0\n"; // a quarter turn about z

std::string assembly_table(const std::string& rows) {
    return "loop_\n_pdbx_struct_assembly_gen.assembly_id\n"
           "_pdbx_struct_assembly_gen.oper_expression\n"
           "_pdbx_struct_assembly_gen.asym_id_list\n" +
           rows;
}

TEST(MoleculeOptionsOf, AssembliesAreCopiesByTheirOperators) {
    std::vector<Atom> atoms = benzene();
    for (Atom a : benzene()) {
        a.chain = "B";
        a.position.z() += 20;
        atoms.push_back(a);
    }
    const std::string cif = mmcif_text(atoms) + operators +
                            assembly_table("1 1,2 A,B\n2 (P)(1-2) A\n3 1 A\n3 2 B\n4 9 A\n");
    const Molecule two = read_text(".cif", cif, {.assembly = "1"});
    EXPECT_THAT(two.atoms, SizeIs(48));
    EXPECT_THAT(two.bonds, SizeIs(48));
    EXPECT_THAT(chains_of(two), ElementsAre("A", "B", "A-2", "B-2"));
    EXPECT_EQ(two.atoms[24].position, Vec3d(atoms[0].position + Vec3d(0, 0, 100)));

    const Molecule products =
        read_text(".cif", mmcif_text(atoms) + operators + assembly_table("2 (P)(1-2) A\n"),
                  {.assembly = "2"});
    EXPECT_THAT(chains_of(products), ElementsAre("A", "A-2"));
    EXPECT_EQ(products.atoms[12].position, Vec3d(0, 1.39, 100)); // of (1.39, 0, 0)

    const Molecule crossed = read_text(".cif", cif, {.assembly = "3"}); // each by its own operator
    EXPECT_THAT(chains_of(crossed), ElementsAre("A", "B"));
    EXPECT_EQ(crossed.atoms[12].position, Vec3d(atoms[12].position + Vec3d(0, 0, 100)));
    // Its operator is missing, which matters to nobody else.
    EXPECT_THAT(error_of(".cif", cif, {.assembly = "4"}),
                HasSubstr("assembly '4': there is no operator '9'"));
}

TEST(MoleculeOptionsOf, AssembliesOfPdbFilesAreInTheirRemarks) {
    std::vector<Atom> atoms = benzene();
    for (Atom a : benzene()) {
        a.chain = "B";
        a.position.z() += 20;
        atoms.push_back(a);
    }
    const std::string pdb =
        "REMARK 350 BIOMOLECULE: 1\n"
        "REMARK 350 APPLY THE FOLLOWING TO CHAINS: A, B\n"
        "REMARK 350   BIOMT1   1  1.000000  0.000000  0.000000        0.00000\n"
        "REMARK 350   BIOMT2   1  0.000000  1.000000  0.000000        0.00000\n"
        "REMARK 350   BIOMT3   1  0.000000  0.000000  1.000000        0.00000\n"
        "REMARK 350   BIOMT1   2 -1.000000  0.000000  0.000000       50.00000\n"
        "REMARK 350   BIOMT2   2  0.000000 -1.000000  0.000000        0.00000\n"
        "REMARK 350   BIOMT3   2  0.000000  0.000000  1.000000        0.00000\n"
        "REMARK 350 BIOMOLECULE: 2\n"
        "REMARK 350 APPLY THE FOLLOWING TO CHAINS: B\n"
        "REMARK 350   BIOMT1   1  1.000000  0.000000  0.000000        0.00000\n"
        "REMARK 350   BIOMT2   1  0.000000  1.000000  0.000000        0.00000\n"
        "REMARK 350   BIOMT3   1  0.000000  0.000000  1.000000        0.00000\n" +
        pdb_atoms(atoms) + "END\n";
    EXPECT_THAT(chains_of(read_text(".pdb", pdb)), ElementsAre("A", "B"));
    const Molecule first = read_text(".pdb", pdb, {.assembly = "1"});
    EXPECT_THAT(chains_of(first), ElementsAre("A", "B", "A-2", "B-2"));
    EXPECT_EQ(first.atoms[24].position, Vec3d(50 - 1.39, 0, 0));
    EXPECT_THAT(chains_of(read_text(".pdb", pdb, {.assembly = "2"})), ElementsAre("B"));
    EXPECT_THAT(error_of(".pdb", pdb, {.assembly = "7"}),
                HasSubstr("there is no assembly '7' (known: 1, 2)"));
    EXPECT_THAT(error_of(".pdb", pdb, {.assembly = "2", .selection = "A"}),
                HasSubstr("assembly '2' has no atom that is kept"));
    EXPECT_THAT(error_of(".xyz", xyz_text(atoms), {.assembly = "1"}), HasSubstr("known: none"));
}

// -------------------------------------------------------------------------------------- errors

TEST(MoleculeErrors, NameTheFileTheLineAndTheCause) {
    const std::string pdb = pdb_text(alanine_dipeptide());
    const auto changed = [](std::string text, const std::string& from, const std::string& to) {
        const std::size_t at = text.find(from);
        EXPECT_NE(at, std::string::npos) << from;
        return text.replace(at, from.size(), to);
    };
    EXPECT_THAT(error_of(".pdb", changed(pdb, "   1.486", "     nan")),
                HasSubstr("a.pdb:4: the coordinate in columns 31 to 38 is no number"));
    EXPECT_THAT(error_of(".pdb", changed(pdb, "   2.454", "   2.4x4")), HasSubstr("a.pdb:4: "));
    EXPECT_THAT(error_of(".pdb", changed(pdb, "   2.454", "        ")), HasSubstr("a.pdb:4: "));
    EXPECT_THAT(error_of(".pdb", changed(pdb, "  1.00  0.00", "  1.oo  0.00")),
                HasSubstr("a.pdb:2: the occupancy"));
    EXPECT_THAT(error_of(".pdb", pdb.substr(0, pdb.size() - 50)),
                HasSubstr("a.pdb:23: an atom's line ends after"));
    EXPECT_THAT(
        error_of(".pdb", "REMARK 350 BIOMOLECULE: 1\n"
                         "REMARK 350 APPLY THE FOLLOWING TO CHAINS: A\n"
                         "REMARK 350   BIOMT1   1  1.000000  0.000000  0.0000x0  0.00000\n" +
                             pdb),
        HasSubstr("a.pdb:3: the number in columns 44 to 53 is no number"));
    std::vector<Atom> atoms = alanine_dipeptide();
    const std::string models = pdb_atoms(atoms, true);
    EXPECT_THAT(error_of(".pdb", models.substr(0, models.size() - 7)),
                HasSubstr("the file ends before the ENDMDL of the model of line 1"));
    EXPECT_THAT(error_of(".pdb", "HEADER\nEND\n"), HasSubstr("there are no atoms"));
    EXPECT_THAT(error_of(".pdb", ""), HasSubstr("the file is empty"));
    EXPECT_THAT(error_of(".pdb", std::string("ATOM\0", 5)), HasSubstr("zero byte"));

    const std::string cif = mmcif_text(atoms);
    EXPECT_THAT(
        error_of(".cif", changed(cif, "1.486", "?")),
        HasSubstr("atom 3 of the _atom_site table of line 3: the coordinate '' is no number"));
    EXPECT_THAT(error_of(".cif", changed(cif, "1.486", "nan")), HasSubstr("'nan' is no number"));
    EXPECT_THAT(error_of(".cif", changed(cif, "1.486", "1e7")), HasSubstr("beyond 1e6"));
    EXPECT_THAT(error_of(".cif", cif.substr(0, cif.size() - 12)), HasSubstr("a.cif:"));
    EXPECT_THAT(error_of(".cif", "data_x\n_cell.a 1\n"), HasSubstr("no _atom_site.Cartn_x"));
    EXPECT_THAT(error_of(".cif", cif + operators + assembly_table("1 9 A\n"), {.assembly = "1"}),
                HasSubstr("there is no operator '9'"));
    EXPECT_THAT(error_of(".cif", cif + operators + assembly_table("1 (1-2000000000) A\n"),
                         {.assembly = "1"}),
                HasSubstr("is no range of operators"));
    EXPECT_THAT(error_of(".cif", cif + operators + assembly_table("1 (1 A\n"), {.assembly = "1"}),
                HasSubstr("lacks a ')'"));

    const std::string xyz = xyz_text(atoms);
    EXPECT_THAT(error_of(".xyz", changed(xyz, "1.486000", "inf")), HasSubstr("a.xyz:5: "));
    EXPECT_THAT(error_of(".xyz", changed(xyz, "C ", "Qq")),
                HasSubstr("a.xyz:4: the line does not start with an element"));
    EXPECT_THAT(error_of(".xyz", changed(xyz, "22\n", "25\n")),
                HasSubstr("a.xyz:24: the file ends after 22 of 25 atoms"));
    EXPECT_THAT(error_of(".xyz", changed(xyz, "22\n", "-1\n")), HasSubstr("a.xyz:1: "));
    EXPECT_THAT(error_of(".xyz", "0\n\n"), HasSubstr("there are no atoms"));
    EXPECT_THAT(message_of<InputError>([] { read_molecule("/no/such.pdb"); }),
                StartsWith("/no/such.pdb: cannot open"));
}

TEST(MoleculeErrors, DamagedFilesAreReadOrRefused) {
    expect_read_or_refused(5000, 1); // of each format: some seconds with sanitizers
}

// --------------------------------------------------------------------------- files of the archive

class ArchiveFile : public ::testing::Test {
protected:
    /// Lines of atoms, counted without any reader; waters, of these, by their residue's name.
    struct Count {
        int atoms = 0, waters = 0;
    };
    static std::filesystem::path path_of(const std::string& name) {
        return std::filesystem::path(ISOCAST_SHARED_DATA) / name;
    }
    static bool is_there(const std::string& name) { return std::filesystem::exists(path_of(name)); }
    static Count count_of(const std::string& name) {
        Count count;
        std::ifstream file(path_of(name));
        for (std::string line; std::getline(file, line);) {
            if (line.starts_with("ENDMDL")) break;
            if (!line.starts_with("ATOM") && !line.starts_with("HETATM")) continue;
            ++count.atoms;
            if (line.find("HOH") != std::string::npos) ++count.waters;
        }
        return count;
    }
};

TEST_F(ArchiveFile, AToxinIsWhole) {
    if (!is_there("1tii.pdb")) GTEST_SKIP() << "1tii.pdb is not there";
    const Count count = count_of("1tii.pdb");
    EXPECT_EQ(count.atoms, 5684);
    const Molecule all = read_molecule(path_of("1tii.pdb"), {.waters = true});
    EXPECT_EQ(int(all.atoms.size()), count.atoms);
    const Molecule dry = read_molecule(path_of("1tii.pdb"));
    EXPECT_EQ(int(dry.atoms.size()), count.atoms - count.waters);
    EXPECT_EQ(std::count_if(dry.atoms.begin(), dry.atoms.end(),
                            [](const Atom& a) { return a.element == 0; }),
              0);
    // Every residue hangs together: few atoms without a bond, and about one bond for each atom.
    EXPECT_GT(dry.bonds.size(), dry.atoms.size());
    EXPECT_LT(double(dry.bonds.size()), 1.1 * double(dry.atoms.size()));
}

TEST_F(ArchiveFile, ARibosomeIsWhole) {
    if (!is_there("1xnr.cif")) GTEST_SKIP() << "1xnr.cif is not there";
    const Count count = count_of("1xnr.cif");
    EXPECT_EQ(count.atoms, 43833);
    const Molecule molecule = read_molecule(path_of("1xnr.cif"));
    EXPECT_EQ(int(molecule.atoms.size()), count.atoms - count.waters);
}

TEST_F(ArchiveFile, AnEnsembleHasItsModels) {
    if (!is_there("1l2y.pdb")) GTEST_SKIP() << "1l2y.pdb is not there";
    const int atoms = count_of("1l2y.pdb").atoms; // of the first model
    EXPECT_EQ(atoms, 304);
    const Molecule first = read_molecule(path_of("1l2y.pdb"));
    const Molecule last = read_molecule(path_of("1l2y.pdb"), {.model = 38});
    EXPECT_EQ(int(first.atoms.size()), atoms);
    EXPECT_EQ(int(last.atoms.size()), atoms);
    EXPECT_NE(first.atoms[0].position, last.atoms[0].position);
    EXPECT_THROW(read_molecule(path_of("1l2y.pdb"), {.model = 39}), InputError);
    // All hydrogens are there, and each has one bond: the same bonds in every model.
    EXPECT_EQ(pairs_of(first.bonds), pairs_of(last.bonds));
    std::vector<int> bonds_at(first.atoms.size());
    for (const Bond& bond : first.bonds) {
        ++bonds_at[std::size_t(bond.i)];
        ++bonds_at[std::size_t(bond.j)];
    }
    for (std::size_t i = 0; i < bonds_at.size(); ++i)
        if (first.atoms[i].element == 1) {
            EXPECT_EQ(bonds_at[i], 1) << i;
        }
}

} // namespace
} // namespace isocast::test
