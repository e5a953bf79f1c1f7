// Molecules of PDB, mmCIF and XYZ files: atoms, and the bonds between them.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/grid_space.h"

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace isocast {

/// What an XYZ file does not say keeps its default.
struct Atom {
    int element = 0;            // atomic number; 0 if unknown
    std::string name;           // within its residue: "CA"
    std::string residue_name;   // "ALA"
    int residue_number = 0;     // the author's
    std::string insertion_code; // tells residues of one number apart; mostly empty
    std::string chain;          // the author's; copies of an assembly are "A-2", "A-3", …
    int model = 1;
    std::string altloc; // which alternative location; empty if it has only one
    double occupancy = 1;
    double b_factor = 0;            // angstrom^2
    Vec3d position = Vec3d::Zero(); // angstrom
    bool is_water = false;
    bool is_hetero = false; // a HETATM: no residue of a polymer
};

struct Bond {
    int i = 0; // indices of atoms, i < j
    int j = 1;
    int order = 1; // 1 to 3; 1 where the file does not say
};

struct Molecule {
    std::vector<Atom> atoms; // in the file's order
    std::vector<Bond> bonds; // ascending by i, then j; each once
    std::string title;
};

struct MoleculeOptions {
    /// Its number in the file; in XYZ files frames count from 1. The file's first if not given.
    std::optional<int> model;
    /// The alternative location to keep where a residue has it. Elsewhere, and if empty, the one
    /// with the highest mean occupancy in the residue, the first of equals.
    std::string altloc;
    /// Which biological assembly to build; the asymmetric unit as in the file if empty.
    std::string assembly;
    bool waters = false;
    /// Chains and ranges of residues, "A,B:10-50,C:7", by the names in the file; all if empty.
    std::string selection;

    bool operator==(const MoleculeOptions&) const = default;
};

/// The molecule in a .pdb, .ent, .cif, .mmcif or .xyz file.
///
/// Bonds are those that the file lists (CONECT; _struct_conn without hydrogen bonds and salt
/// bridges) and those of bonds_by_distance().
///
/// throws  InputError that names the file, the line or atom where it is known, and the cause: text
///         that is not of its format or ends early, a coordinate that is no number or beyond 1e6
///         angstrom, an unknown model or assembly (with a list of those there), a selection of
///         which a part matches nothing, no atoms
Molecule read_molecule(const std::filesystem::path& path, const MoleculeOptions& options = {});

bool is_molecule_file(const std::filesystem::path& path);
std::string molecule_file_extensions(); // ".pdb, .ent, …"

/// Pairs of atoms that are as close as a bond.
///
/// A pair is bonded if 0.4 angstrom < distance <= r(i) + r(j) + 0.45 angstrom with covalent radii;
/// a hydrogen is bonded only to the nearest of its candidates (the first of equals), to another
/// hydrogen only if there is no other kind. Atoms of two different alternative locations are not
/// bonded.
///
/// atoms    positions finite and within 1e6 angstrom; O(n log n) at the densities of chemistry
/// returns  ascending, order 1
/// source   both limits: RDKit's ConnectTheDots (ProximityBonds.cpp); the radii: element_of()
std::vector<Bond> bonds_by_distance(std::span<const Atom> atoms);

} // namespace isocast
