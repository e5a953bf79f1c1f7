// One parser per molecule format, from bytes in memory; read_molecule chooses by the extension.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/molecule.h"
#include "volume/volume_file.h" // trimmed

#include <limits>
#include <string_view>

namespace isocast {

/// Copies of the atoms of some chains: one for each map.
struct AssemblyPart {
    struct Operator {
        std::string name; // parts that share it belong to one copy
        Eigen::Affine3d map = Eigen::Affine3d::Identity();
    };
    std::vector<std::string> chains; // values of MoleculeFile::assembly_chains
    std::vector<Operator> operators;
};

struct Assembly {
    std::string name;
    std::vector<AssemblyPart> parts;
    std::string problem; // why it cannot be built, if it cannot
};

/// All that a file says: every model, water and alternative location.
struct MoleculeFile {
    std::vector<Atom> atoms;
    std::vector<std::string> assembly_chains; // of each atom; empty if there are no assemblies
    std::vector<Bond> bonds;                  // as listed; perhaps twice, and i > j
    std::vector<Assembly> assemblies;
    std::string title;
};

/// read_molecule() for the bytes of a file, whose name's extension says its format.
Molecule molecule_of_bytes(std::string_view bytes, const std::filesystem::path& name,
                           const MoleculeOptions& options = {});

/// Each parser takes the bytes of a whole file and the name that messages give it.
/// throws  InputError that names the line or atom and the cause
MoleculeFile parse_pdb(std::string_view bytes, const std::string& name);
MoleculeFile parse_mmcif(std::string_view bytes, const std::string& name);
MoleculeFile parse_xyz(std::string_view bytes, const std::string& name);

// 0.1 mm: larger than any molecule, and the grid of bonds_by_distance can number its cells.
inline constexpr double largest_coordinate_angstrom = 1e6;

/// `text` without blanks about it as a number; NaN if it is none. "+1.5" is one, "1.5x" is not.
double number_or_nan(std::string_view text);
std::optional<int> whole_number(std::string_view text);

} // namespace isocast
