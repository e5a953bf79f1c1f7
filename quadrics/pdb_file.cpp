// PDB as the library gemmi reads it, of lines that are checked first: gemmi takes fields that are
// no numbers for 0, passes over CONECT, and reads past the end of short SSBOND and LINK records.
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
    std::string text; // for gemmi: lines of 80 columns, blank ones for records that are not needed
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

constexpr std::size_t last_needed_column = 78; // the element; then the charge, which may be garbage

class LineChecker {
public:
    explicit LineChecker(const std::string& name) : name_(name) {}

    CheckedLines check(std::string_view bytes) {
        while (!bytes.empty() && !is_at_end_) {
            ++line_number_;
            const std::size_t end = bytes.find('\n');
            std::string_view line = bytes.substr(0, end);
            bytes.remove_prefix(end == std::string_view::npos ? bytes.size() : end + 1);
            if (line.ends_with('\r')) line.remove_suffix(1);
            std::string kept =
                check_line(line) ? std::string(line.substr(0, last_needed_column)) : "";
            kept.resize(80, ' ');
            // gemmi would take blanks for an occupancy of 0.
            if (is_atom(kept) && trimmed(columns(kept, 55, 60)).empty())
                kept.replace(54, 6, "  1.00");
            checked_.text += kept;
            checked_.text += '\n';
        }
        if (model_line_ != 0)
            throw InputError(fmt::format(
                "{}: the file ends before the ENDMDL of the model of line {}", name_, model_line_));
        return std::move(checked_);
    }

private:
    [[noreturn]] void fail(const std::string& cause) const {
        throw InputError(fmt::format("{}:{}: {}", name_, line_number_, cause));
    }

    static bool is_atom(std::string_view line) {
        return is_record(line, "ATOM") || is_record(line, "HETATM");
    }

    double number_in(std::string_view line, std::size_t first, std::size_t last,
                     const char* what) const {
        const double value = number_or_nan(columns(line, first, last));
        if (!std::isfinite(value))
            fail(fmt::format("the {} in columns {} to {} is no number", what, first, last));
        return value;
    }

    /// Whether gemmi is to read it.
    bool check_line(std::string_view line) {
        if (is_atom(line)) {
            ++checked_.atom_count;
            check_atom(line);
            return true;
        }
        if (is_record(line, "MODEL")) {
            if (model_line_ != 0)
                fail(fmt::format("the model of line {} has no ENDMDL", model_line_));
            model_line_ = line_number_;
            if (!whole_number(columns(line, 11, 14))) fail("the model has no number");
            return true;
        }
        if (is_record(line, "ENDMDL")) {
            model_line_ = 0;
            return true;
        }
        if (is_record(line, "CONECT")) {
            append_links(line);
            return false;
        }
        if (is_record(line, "REMARK")) {
            if (whole_number(columns(line, 8, 10)) != 350) return false;
            if (columns(line, 14, 18) == "BIOMT") // a row of an operator of an assembly
                for (const std::size_t first : {24, 34, 44, 59})
                    number_in(line, first, first + 9, "number");
            return true;
        }
        if (is_record(line, "END ")) is_at_end_ = true;
        return is_record(line, "TER ") || is_record(line, "TITLE") || is_record(line, "HEADER");
    }

    void check_atom(std::string_view line) const {
        if (line.size() < 54)
            fail(fmt::format("an atom's line ends after {} of at least 54 columns", line.size()));
        for (const std::size_t first : {31, 39, 47})
            if (std::abs(number_in(line, first, first + 7, "coordinate")) >
                largest_coordinate_angstrom)
                fail("a coordinate is beyond 1e6 angstrom");
        for (const std::size_t first : {55, 61})
            if (!trimmed(columns(line, first, first + 5)).empty())
                number_in(line, first, first + 5, first == 55 ? "occupancy" : "B-factor");
    }

    void append_links(std::string_view line) {
        std::string padded(line);
        padded.resize(32, ' ');
        const int from = gemmi::pdb_impl::read_serial(&padded[6]);
        for (const std::size_t at : {11, 16, 21, 26}) // beyond these stood hydrogen bonds
            if (!trimmed(std::string_view(padded).substr(at, 5)).empty())
                checked_.links.push_back({from, gemmi::pdb_impl::read_serial(&padded[at])});
    }

    const std::string& name_;
    CheckedLines checked_;
    int line_number_ = 0;
    int model_line_ = 0; // of the MODEL that has not ended
    bool is_at_end_ = false;
};

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
    const CheckedLines checked = LineChecker(name).check(bytes);
    gemmi::Structure structure;
    try {
        structure = gemmi::read_pdb_from_memory(checked.text.data(), checked.text.size(), name);
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
