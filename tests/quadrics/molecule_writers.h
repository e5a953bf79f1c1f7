// Small known molecules, and files of them as other programs write them.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "../volume/temporary_folder.h"
#include "quadrics/elements.h"
#include "quadrics/molecule.h"

#include <cstdio>
#include <fstream>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

namespace isocast::test {

template<class... Values>
std::string formatted(const char* format, Values... values) {
    char buffer[256];
    const int length = std::snprintf(buffer, sizeof buffer, format, values...);
    return {buffer, static_cast<std::size_t>(length)};
}

inline Atom atom(const std::string& symbol, const std::string& name, const std::string& residue,
                 int number, const Vec3d& position, const std::string& chain = "A") {
    return {.element = atomic_number_of(symbol),
            .name = name,
            .residue_name = residue,
            .residue_number = number,
            .chain = chain,
            .position = position};
}

inline std::vector<Atom> water() {
    return {atom("O", "O", "HOH", 1, {0, 0, 0}), atom("H", "H1", "HOH", 1, {0.757, 0.586, 0}),
            atom("H", "H2", "HOH", 1, {-0.757, 0.586, 0})};
}

inline std::vector<Atom> benzene() { // C-C 1.39 angstrom, C-H 1.09 angstrom
    std::vector<Atom> atoms;
    for (const auto& [symbol, radius] : {std::pair("C", 1.39), std::pair("H", 2.48)})
        for (int k = 0; k < 6; ++k) {
            const double angle = k * std::numbers::pi / 3;
            // Three decimals, so that every format can say it.
            const Vec3d p(std::round(1e3 * radius * std::cos(angle)) / 1e3,
                          std::round(1e3 * radius * std::sin(angle)) / 1e3, 0);
            atoms.push_back(atom(symbol, symbol + std::to_string(k + 1), "BNZ", 1, p));
        }
    return atoms;
}

inline std::vector<Atom> alanine_dipeptide() { // ACE-ALA-NME, stretched
    return {atom("H", "H1", "ACE", 1, {2.000, 1.000, 0}),
            atom("C", "CH3", "ACE", 1, {2.000, 2.090, 0}),
            atom("H", "H2", "ACE", 1, {1.486, 2.454, 0.890}),
            atom("H", "H3", "ACE", 1, {1.486, 2.454, -0.890}),
            atom("C", "C", "ACE", 1, {3.427, 2.641, 0}),
            atom("O", "O", "ACE", 1, {4.391, 1.877, 0}),
            atom("N", "N", "ALA", 2, {3.555, 3.970, 0}),
            atom("H", "H", "ALA", 2, {2.733, 4.556, 0}),
            atom("C", "CA", "ALA", 2, {4.853, 4.614, 0}),
            atom("H", "HA", "ALA", 2, {5.408, 4.316, 0.890}),
            atom("C", "CB", "ALA", 2, {5.661, 4.221, -1.232}),
            atom("H", "HB1", "ALA", 2, {5.123, 4.521, -2.131}),
            atom("H", "HB2", "ALA", 2, {6.630, 4.719, -1.206}),
            atom("H", "HB3", "ALA", 2, {5.809, 3.141, -1.241}),
            atom("C", "C", "ALA", 2, {4.713, 6.129, 0}),
            atom("O", "O", "ALA", 2, {3.601, 6.653, 0}),
            atom("N", "N", "NME", 3, {5.846, 6.835, 0}),
            atom("H", "H", "NME", 3, {6.737, 6.359, 0}),
            atom("C", "C", "NME", 3, {5.846, 8.284, 0}),
            atom("H", "H1", "NME", 3, {4.819, 8.648, 0}),
            atom("H", "H2", "NME", 3, {6.360, 8.648, 0.890}),
            atom("H", "H3", "NME", 3, {6.360, 8.648, -0.890})};
}

inline const std::vector<std::pair<int, int>> alanine_dipeptide_bonds{
    {0, 1},   {1, 2},   {1, 3},   {1, 4},   {4, 5},   {4, 6},   {6, 7},
    {6, 8},   {8, 9},   {8, 10},  {8, 14},  {10, 11}, {10, 12}, {10, 13},
    {14, 15}, {14, 16}, {16, 17}, {16, 18}, {18, 19}, {18, 20}, {18, 21}};

// ------------------------------------------------------------------------ writers of the formats

/// The lines of the atoms alone; MODEL and ENDMDL about each model if `with_models`.
inline std::string pdb_atoms(const std::vector<Atom>& atoms, bool with_models = false) {
    std::string text;
    for (std::size_t i = 0; i < atoms.size(); ++i) {
        const Atom& a = atoms[i];
        if (with_models && (i == 0 || atoms[i - 1].model != a.model)) {
            if (i != 0) text += "ENDMDL\n";
            text += formatted("MODEL     %4d\n", a.model);
        }
        // A name starts in the second of its columns if the element has one letter.
        const std::string name = a.name.size() < 4 ? " " + a.name : a.name;
        text +=
            formatted("%-6s%5d %-4s%1s%3s %1s%4d%1s   %8.3f%8.3f%8.3f%6.2f%6.2f          %2s\n",
                      a.is_hetero ? "HETATM" : "ATOM", int(i) + 1, name.c_str(), a.altloc.c_str(),
                      a.residue_name.c_str(), a.chain.c_str(), a.residue_number,
                      a.insertion_code.c_str(), a.position.x(), a.position.y(), a.position.z(),
                      a.occupancy, a.b_factor, element_of(a.element).symbol);
    }
    if (with_models) text += "ENDMDL\n";
    return text;
}

inline std::string mmcif_atoms(const std::vector<Atom>& atoms) {
    std::string text = "loop_\n";
    for (const char* tag :
         {"group_PDB", "id", "type_symbol", "label_atom_id", "label_alt_id", "label_comp_id",
          "label_asym_id", "label_seq_id", "pdbx_PDB_ins_code", "Cartn_x", "Cartn_y", "Cartn_z",
          "occupancy", "B_iso_or_equiv", "auth_seq_id", "auth_asym_id", "pdbx_PDB_model_num"})
        text += std::string("_atom_site.") + tag + "\n";
    const auto or_dot = [](const std::string& s) { return s.empty() ? std::string(".") : s; };
    for (std::size_t i = 0; i < atoms.size(); ++i) {
        const Atom& a = atoms[i];
        text += formatted("%s %d %s \"%s\" %s %s %s . %s %.3f %.3f %.3f %.2f %.2f %d %s %d\n",
                          a.is_hetero ? "HETATM" : "ATOM", int(i) + 1, element_of(a.element).symbol,
                          a.name.c_str(), or_dot(a.altloc).c_str(), a.residue_name.c_str(),
                          a.chain.c_str(), or_dot(a.insertion_code).c_str(), a.position.x(),
                          a.position.y(), a.position.z(), a.occupancy, a.b_factor, a.residue_number,
                          a.chain.c_str(), a.model);
    }
    return text + "#\n";
}

inline std::string pdb_text(const std::vector<Atom>& atoms) {
    return "TITLE     A TEST\n" + pdb_atoms(atoms) + "END\n";
}

inline std::string mmcif_text(const std::vector<Atom>& atoms) {
    return "data_test\n_struct.title 'A TEST'\n" + mmcif_atoms(atoms);
}

inline std::string xyz_text(const std::vector<Atom>& atoms) {
    std::string text = std::to_string(atoms.size()) + "\nA TEST\n";
    for (const Atom& a : atoms)
        text += formatted("%-2s %12.6f %12.6f %12.6f\n", element_of(a.element).symbol,
                          a.position.x(), a.position.y(), a.position.z());
    return text;
}

/// The molecule in a file of this text.
inline Molecule read_text(const std::string& extension, const std::string& text,
                          const MoleculeOptions& options = {}) {
    const TemporaryFolder folder;
    const std::filesystem::path path = folder / ("a" + extension);
    std::ofstream(path, std::ios::binary) << text;
    return read_molecule(path, options);
}

inline std::vector<std::pair<int, int>> pairs_of(const std::vector<Bond>& bonds) {
    std::vector<std::pair<int, int>> pairs;
    for (const Bond& bond : bonds) pairs.emplace_back(bond.i, bond.j);
    return pairs;
}

// ------------------------------------------------------------------------------- damaged copies

/// `text` with bytes changed, lines swapped, repeated or removed, or its end missing.
inline std::string damaged(std::string text, std::mt19937& random) {
    const auto below = [&](std::size_t n) {
        return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
    };
    const int damages = 1 + static_cast<int>(below(4));
    for (int k = 0; k < damages && !text.empty(); ++k) {
        switch (below(5)) {
        case 0: // a byte becomes any byte
            text[below(text.size())] = static_cast<char>(below(256));
            break;
        case 1: { // a byte becomes one that means something somewhere
            constexpr std::string_view bytes = " \n\r\t0123456789-+.eE()',;_#\"NIAn*";
            text[below(text.size())] = bytes[below(bytes.size())];
            break;
        }
        case 2: // the end is missing
            if (below(4) == 0) text.resize(below(text.size()));
            break;
        case 3: { // two lines change places
            std::vector<std::string> lines;
            std::istringstream stream(text);
            for (std::string line; std::getline(stream, line);) lines.push_back(line + "\n");
            std::swap(lines[below(lines.size())], lines[below(lines.size())]);
            text.clear();
            for (const std::string& line : lines) text += line;
            break;
        }
        default: { // some bytes are there twice, or not at all
            const std::size_t at = below(text.size());
            const std::size_t length = std::min(text.size() - at, 1 + below(20));
            if (below(2) == 0)
                text.insert(at, text.substr(at, length));
            else
                text.erase(at, length);
        }
        }
    }
    return text;
}

} // namespace isocast::test
