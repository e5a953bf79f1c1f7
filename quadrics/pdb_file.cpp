// PDB as the library gemmi reads it. What gemmi passes over is done here: fields that are no
// numbers (it takes them for 0), CONECT, models without an end.
// SPDX-License-Identifier: MPL-2.0
#include "quadrics/molecule_parsers.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <gemmi/pdb.hpp>

#include <cmath>
#include <map>
#include <unordered_map>

namespace isocast {

namespace {

struct Link {
    int from_serial, to_serial;
};

struct CheckedLines {
    std::vector<Link> links; // CONECT, in the file's order
    std::size_t atom_count = 0;
};

/// Fields by their columns in the format's description, from 1, both included.
std::string_view columns(std::string_view line, std::size_t first, std::size_t last) {
    if (line.size() < first) return {};
    return line.substr(first - 1, last - first + 1);
}

/// As gemmi tells records apart: by four letters of either case.
bool is_record(std::string_view line, const char* record) {
    std::string start(line.substr(0, 4));
    start.resize(4, ' ');
    return gemmi::pdb_impl::is_record_type(start.c_str(), record);
}

CheckedLines check_lines(std::string_view bytes, const std::string& name) {
    CheckedLines checked;
    int line_number = 0;
    int model_line = 0; // of the MODEL that has not ended
    const auto fail = [&](const std::string& cause) {
        throw InputError(fmt::format("{}:{}: {}", name, line_number, cause));
    };
    while (!bytes.empty()) {
        ++line_number;
        const std::size_t end = bytes.find('\n');
        std::string_view line = bytes.substr(0, end);
        bytes.remove_prefix(end == std::string_view::npos ? bytes.size() : end + 1);
        if (line.ends_with('\r')) line.remove_suffix(1);
        if (is_record(line, "ATOM") || is_record(line, "HETATM")) {
            ++checked.atom_count;
            if (line.size() < 54)
                fail(fmt::format("an atom's line ends after {} of at least 54 columns",
                                 line.size()));
            for (const std::size_t first : {31, 39, 47}) {
                const double x = number_or_nan(columns(line, first, first + 7));
                if (!std::isfinite(x))
                    fail(fmt::format("the coordinate in columns {} to {} is no number", first,
                                     first + 7));
                if (std::abs(x) > largest_coordinate_angstrom)
                    fail("a coordinate is beyond 1e6 angstrom");
            }
            for (const std::size_t first : {55, 61}) {
                const std::string_view field = trimmed(columns(line, first, first + 5));
                if (!field.empty() && !std::isfinite(number_or_nan(field)))
                    fail(fmt::format("the {} in columns {} to {} is no number",
                                     first == 55 ? "occupancy" : "B-factor", first, first + 5));
            }
        } else if (is_record(line, "MODEL")) {
            if (model_line != 0)
                fail(fmt::format("the model of line {} has no ENDMDL", model_line));
            model_line = line_number;
        } else if (is_record(line, "ENDMDL")) {
            model_line = 0;
        } else if (is_record(line, "CONECT")) {
            std::string padded(line);
            padded.resize(32, ' ');
            const int from = gemmi::pdb_impl::read_serial(padded.data() + 6);
            for (const std::size_t at : {11, 16, 21, 26}) // beyond these stood hydrogen bonds
                if (!trimmed(std::string_view(padded).substr(at, 5)).empty())
                    checked.links.push_back({from, gemmi::pdb_impl::read_serial(&padded[at])});
        } else if (is_record(line, "END ")) {
            break;
        }
    }
    if (model_line != 0)
        throw InputError(fmt::format("{}: the file ends before the ENDMDL of the model of line {}",
                                     name, model_line));
    return checked;
}

Eigen::Affine3d map_of(const gemmi::Transform& transform) {
    Eigen::Affine3d map;
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) map(row, column) = transform.mat[row][column];
        map(row, 3) = transform.vec.at(row);
    }
    map.makeAffine();
    return map;
}

std::vector<Assembly> assemblies_of(const gemmi::Structure& structure) {
    std::vector<Assembly> assemblies;
    for (const gemmi::Assembly& theirs : structure.assemblies) {
        Assembly& ours = assemblies.emplace_back(Assembly{theirs.name, {}, {}});
        for (const gemmi::Assembly::Gen& generator : theirs.generators) {
            AssemblyPart& part = ours.parts.emplace_back();
            part.chains = generator.chains;
            for (const gemmi::Assembly::Operator& op : generator.operators)
                part.operators.push_back({op.name, map_of(op.transform)});
        }
    }
    return assemblies;
}

/// A bond listed k times from one of its atoms has order k: how double bonds are written.
void append_links(MoleculeFile& file, const std::vector<Link>& links,
                  const std::vector<int>& serials) {
    std::map<int, std::unordered_map<int, int>> atom_of; // by model and serial number
    for (std::size_t i = 0; i < file.atoms.size(); ++i)
        atom_of[file.atoms[i].model].emplace(serials[i], static_cast<int>(i));
    std::map<std::pair<int, int>, int> count_of;
    for (const Link& link : links) ++count_of[{link.from_serial, link.to_serial}];
    for (const auto& [model, atoms] : atom_of)
        for (const auto& [serials_of_link, count] : count_of) {
            const auto from = atoms.find(serials_of_link.first);
            const auto to = atoms.find(serials_of_link.second);
            if (from != atoms.end() && to != atoms.end())
                file.bonds.push_back({from->second, to->second, count});
        }
}

} // namespace

MoleculeFile parse_pdb(std::string_view bytes, const std::string& name) {
    const CheckedLines checked = check_lines(bytes, name);
    gemmi::Structure structure;
    try {
        structure = gemmi::read_pdb_from_memory(bytes.data(), bytes.size(), name);
    } catch (const std::exception& error) {
        throw InputError(fmt::format("{}: {}", name, error.what()));
    }
    MoleculeFile file;
    file.title = trimmed(structure.get_info("_struct.title"));
    if (file.title.empty()) file.title = structure.get_info("_entry.id");
    std::vector<int> serials;
    for (const gemmi::Model& model : structure.models) {
        const std::optional<int> number = whole_number(model.name);
        for (const gemmi::Chain& chain : model.chains)
            for (const gemmi::Residue& residue : chain.residues)
                for (const gemmi::Atom& theirs : residue.atoms) {
                    Atom atom;
                    atom.element = theirs.element.atomic_number();
                    atom.name = theirs.name;
                    atom.residue_name = residue.name;
                    atom.residue_number = residue.seqid.num ? *residue.seqid.num : 0;
                    if (residue.seqid.has_icode()) atom.insertion_code = residue.seqid.icode;
                    atom.chain = chain.name;
                    atom.model = number.value_or(1);
                    if (theirs.has_altloc()) atom.altloc = theirs.altloc;
                    atom.occupancy = theirs.occ;
                    atom.b_factor = theirs.b_iso;
                    atom.position = Vec3d(theirs.pos.x, theirs.pos.y, theirs.pos.z);
                    atom.is_water = residue.is_water();
                    atom.is_hetero = residue.het_flag == 'H';
                    file.atoms.push_back(std::move(atom));
                    file.assembly_chains.push_back(chain.name);
                    serials.push_back(theirs.serial);
                }
    }
    if (file.atoms.size() != checked.atom_count)
        throw InputError(fmt::format("{}: {} of {} lines of atoms can be read", name,
                                     file.atoms.size(), checked.atom_count));
    file.assemblies = assemblies_of(structure);
    append_links(file, checked.links, serials);
    return file;
}

} // namespace isocast
