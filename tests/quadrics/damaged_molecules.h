// Damaged copies of small files with everything in them that the readers know.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "molecule_writers.h"
#include "quadrics/molecule_parsers.h"
#include "quadrics/molecule_styles.h"
#include "volume/errors.h"

#include <gtest/gtest.h>

#include <span>

namespace isocast::test {

struct WholeFile {
    std::string extension;
    std::string text;
};

inline std::vector<WholeFile> whole_files() {
    std::vector<Atom> atoms = alanine_dipeptide();
    atoms[9].altloc = "A";
    atoms[9].occupancy = 0.4;
    std::vector<Atom> second = water();
    for (Atom& a : second) {
        a.is_hetero = true;
        a.chain = "B";
    }
    atoms.insert(atoms.end(), second.begin(), second.end());
    std::vector<Atom> models = atoms;
    for (Atom a : atoms) {
        a.model = 2;
        models.push_back(a);
    }
    return {
        {".pdb", "HEADER    TEST                                    01-JAN-20   1ABC\n"
                 "TITLE     A TEST\n"
                 "AUTHOR    A.B.SOMEBODY,C.ELSE\n"
                 "REMARK 350 BIOMOLECULE: 1\n"
                 "REMARK 350 APPLY THE FOLLOWING TO CHAINS: A, B\n"
                 "REMARK 350   BIOMT1   1  1.000000  0.000000  0.000000        0.00000\n"
                 "REMARK 350   BIOMT2   1  0.000000  1.000000  0.000000        0.00000\n"
                 "REMARK 350   BIOMT3   1  0.000000  0.000000  1.000000        0.00000\n"
                 "SEQRES   1 A    3  ACE ALA NME\n"
                 "HELIX    1   1 ALA A    2  ALA A    2  1                                   3\n"
                 "SSBOND   1 ALA A    2    ALA A    2                          1555   1555  2.03\n"
                 "LINK         C   ACE A   1                 N   ALA A   2     1555   1555  1.33\n"
                 "CRYST1   30.000   30.000   30.000  90.00  90.00  90.00 P 1           1\n" +
                     pdb_atoms(models, true) +
                     "CONECT    1    2    2\nCONECT    2    1    3    4\nEND\n"},
        {".cif", "data_test\n_entry.id 1ABC\n_struct.title\n;A\nTEST\n;\n" + mmcif_atoms(models) +
                     "loop_\n_struct_conn.id\n_struct_conn.conn_type_id\n"
                     "_struct_conn.ptnr1_auth_asym_id\n_struct_conn.ptnr1_auth_seq_id\n"
                     "_struct_conn.ptnr1_label_atom_id\n_struct_conn.ptnr2_auth_asym_id\n"
                     "_struct_conn.ptnr2_auth_seq_id\n_struct_conn.ptnr2_label_atom_id\n"
                     "c1 covale A 1 C A 2 N\n#\n"
                     "loop_\n_pdbx_struct_assembly_gen.assembly_id\n"
                     "_pdbx_struct_assembly_gen.oper_expression\n"
                     "_pdbx_struct_assembly_gen.asym_id_list\n1 (1-2)(1,2) A,B\n2 1 A\n#\n"
                     "loop_\n_pdbx_struct_oper_list.id\n_pdbx_struct_oper_list.matrix[1][1]\n"
                     "_pdbx_struct_oper_list.matrix[1][2]\n_pdbx_struct_oper_list.matrix[1][3]\n"
                     "_pdbx_struct_oper_list.vector[1]\n_pdbx_struct_oper_list.matrix[2][1]\n"
                     "_pdbx_struct_oper_list.matrix[2][2]\n_pdbx_struct_oper_list.matrix[2][3]\n"
                     "_pdbx_struct_oper_list.vector[2]\n_pdbx_struct_oper_list.matrix[3][1]\n"
                     "_pdbx_struct_oper_list.matrix[3][2]\n_pdbx_struct_oper_list.matrix[3][3]\n"
                     "_pdbx_struct_oper_list.vector[3]\n"
                     "1 1 0 0 0 0 1 0 0 0 0 1 0\n2 -1 0 0 0 0 -1 0 0 0 0 1 20\n"},
        {".xyz", xyz_text(atoms) + xyz_text(water())}};
}

/// Expects that each of `count` damaged copies of each file is read to what can be drawn, or gives
/// an InputError that names the file.
inline void expect_read_or_refused(int count, unsigned seed) {
    std::mt19937 random(seed);
    for (const WholeFile& whole : whole_files()) {
        const std::string name = "a" + whole.extension;
        int read = 0;
        for (int k = 0; k < count; ++k) {
            const std::string text = damaged(whole.text, random);
            try {
                const Molecule molecule = molecule_of_bytes(
                    text, name,
                    {.assembly = k % 2 == 1 && whole.extension != ".xyz" ? "1" : "",
                     .waters = k % 3 == 0});
                ++read;
                ASSERT_FALSE(molecule.atoms.empty());
                for (const Bond& bond : molecule.bonds) {
                    ASSERT_LE(0, bond.i);
                    ASSERT_LT(bond.i, bond.j);
                    ASSERT_LT(bond.j, static_cast<int>(molecule.atoms.size()));
                }
                const MoleculePrimitives primitives = primitives_of(molecule);
                check(std::span<const Sphere>(primitives.spheres));
                check(std::span<const Cylinder>(primitives.sticks));
            } catch (const InputError& error) {
                ASSERT_NE(std::string_view(error.what()).find(name), std::string::npos)
                    << error.what();
            } catch (const std::exception& error) {
                FAIL() << whole.extension << ", copy " << k << ": " << error.what() << "\n" << text;
            }
        }
        // Else the copies are so damaged that they test only the first lines of the readers.
        EXPECT_GT(read, count / 10) << whole.extension;
        EXPECT_LT(read, count) << whole.extension;
    }
}

} // namespace isocast::test
