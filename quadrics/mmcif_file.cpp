// mmCIF: cif_tables reads the syntax, this file the categories that matter here.
// SPDX-License-Identifier: MPL-2.0
#include "quadrics/cif_tables.h"
#include "quadrics/elements.h"
#include "quadrics/molecule_parsers.h"
#include "volume/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

namespace isocast {

namespace {

using Row = std::vector<std::string>;

// An icosahedral capsid has 60 operators, a helical one some hundreds.
constexpr std::size_t most_operators = 100'000;

/// The first of these columns that says something; else empty.
const std::string& text_of(const Row& row, std::initializer_list<int> columns) {
    static const std::string nothing;
    for (const int column : columns)
        if (const std::string& cell = row[static_cast<std::size_t>(column)]; !cell.empty())
            return cell;
    return nothing;
}

/// CIF numbers may end in their uncertainty: 1.234(5).
double number_of(const std::string& text) {
    const std::size_t open = text.find('(');
    const bool is_closed = open != std::string::npos && text.ends_with(')');
    return number_or_nan(is_closed ? std::string_view(text).substr(0, open) : text);
}

class MmcifFile {
public:
    MmcifFile(const CifDocument& document, const std::string& name)
        : document_(document), name_(name) {}

    MoleculeFile parse() {
        read_atoms();
        read_connections();
        read_operators();
        read_assemblies();
        for (const std::string& title : {document_.value("_struct.title"),
                                         document_.value("_entry.id"), document_.block_name()})
            if (file_.title.empty()) file_.title = title;
        return std::move(file_);
    }

private:
    [[noreturn]] void fail(const std::string& where, const std::string& cause) const {
        throw InputError(fmt::format("{}: {}: {}", name_, where, cause));
    }

    [[noreturn]] static void fail_assembly(const std::string& cause) { throw InputError(cause); }

    void read_atoms() {
        enum {
            X,
            Y,
            Z,
            Group,
            Symbol,
            Name,
            Name2,
            Alt,
            Residue,
            Residue2,
            Asym,
            Chain,
            Sequence,
            Sequence2,
            Insertion,
            Occupancy,
            B,
            Model
        };
        const CifTable table = document_.table(
            "_atom_site.",
            {"Cartn_x", "Cartn_y", "Cartn_z", "?group_PDB", "?type_symbol", "?label_atom_id",
             "?auth_atom_id", "?label_alt_id", "?label_comp_id", "?auth_comp_id", "?label_asym_id",
             "?auth_asym_id", "?auth_seq_id", "?label_seq_id", "?pdbx_PDB_ins_code", "?occupancy",
             "?B_iso_or_equiv", "?pdbx_PDB_model_num"});
        if (!table.is_there) fail("_atom_site", "Cartn_x, Cartn_y or Cartn_z is missing");
        const int line = table.line;
        int count = 0;
        for (const Row& row : table.rows) {
            ++count;
            const auto fail_here = [&](const std::string& cause) {
                fail(fmt::format("atom {} of the _atom_site table of line {}", count, line), cause);
            };
            const auto optional_number = [&](int column, double otherwise) {
                const std::string text = text_of(row, {column});
                if (text.empty()) return otherwise;
                const double value = number_of(text);
                if (!std::isfinite(value)) fail_here(fmt::format("'{}' is no number", text));
                return value;
            };
            const auto optional_integer = [&](const std::string& text, int otherwise) {
                if (text.empty()) return otherwise;
                const std::optional<int> value = whole_number(text);
                if (!value) fail_here(fmt::format("'{}' is no integer", text));
                return *value;
            };
            Atom atom;
            for (const int k : {X, Y, Z}) {
                const std::string text = text_of(row, {k});
                atom.position[k] = number_of(text);
                if (!std::isfinite(atom.position[k]))
                    fail_here(fmt::format("the coordinate '{}' is no number", text));
                if (std::abs(atom.position[k]) > largest_coordinate_angstrom)
                    fail_here("a coordinate is beyond 1e6 angstrom");
            }
            atom.element = atomic_number_of(text_of(row, {Symbol}));
            atom.name = text_of(row, {Name, Name2});
            atom.altloc = text_of(row, {Alt});
            atom.residue_name = text_of(row, {Residue, Residue2});
            atom.chain = text_of(row, {Chain, Asym});
            atom.insertion_code = text_of(row, {Insertion});
            std::string sequence = text_of(row, {Sequence, Sequence2});
            if (!sequence.empty() && std::isalpha(static_cast<unsigned char>(sequence.back()))) {
                // Old files write the insertion code after the number.
                if (atom.insertion_code.empty()) atom.insertion_code = sequence.back();
                sequence.pop_back();
            }
            atom.residue_number = optional_integer(sequence, 0);
            atom.model = optional_integer(text_of(row, {Model}), 1);
            atom.occupancy = optional_number(Occupancy, 1);
            atom.b_factor = optional_number(B, 0);
            atom.is_hetero = text_of(row, {Group}) == "HETATM";
            atom.is_water = is_water_name(atom.residue_name);
            file_.atoms.push_back(std::move(atom));
            file_.assembly_chains.push_back(text_of(row, {Asym, Chain}));
        }
    }

    static std::string key_of(int model, const std::string& chain, const std::string& sequence,
                              const std::string& insertion, const std::string& atom) {
        return fmt::format("{} {} {} {} {}", model, chain, sequence, insertion, atom);
    }

    void read_connections() {
        enum {
            Type,
            Asym,
            Asym2,
            LabelAsym,
            LabelAsym2,
            Atom1,
            Atom2,
            Alt,
            Alt2,
            Sequence,
            Sequence2,
            Insertion,
            Insertion2,
            Symmetry,
            Symmetry2,
            Order
        };
        const CifTable table = document_.table(
            "_struct_conn.",
            {"conn_type_id", "?ptnr1_auth_asym_id", "?ptnr2_auth_asym_id", "?ptnr1_label_asym_id",
             "?ptnr2_label_asym_id", "ptnr1_label_atom_id", "ptnr2_label_atom_id",
             "?pdbx_ptnr1_label_alt_id", "?pdbx_ptnr2_label_alt_id", "?ptnr1_auth_seq_id",
             "?ptnr2_auth_seq_id", "?pdbx_ptnr1_PDB_ins_code", "?pdbx_ptnr2_PDB_ins_code",
             "?ptnr1_symmetry", "?ptnr2_symmetry", "?pdbx_value_order"});
        if (table.rows.empty()) return;
        std::unordered_map<std::string, std::vector<int>> atoms_of;
        std::vector<int> models;
        for (std::size_t i = 0; i < file_.atoms.size(); ++i) {
            const Atom& a = file_.atoms[i];
            if (models.empty() || models.back() != a.model) models.push_back(a.model);
            atoms_of[key_of(a.model, a.chain, std::to_string(a.residue_number), a.insertion_code,
                            a.name)]
                .push_back(static_cast<int>(i));
        }
        std::sort(models.begin(), models.end());
        models.erase(std::unique(models.begin(), models.end()), models.end());
        int count = 0;
        for (const Row& row : table.rows) {
            ++count;
            const std::string type = text_of(row, {Type});
            if (type.starts_with("hydrog") || type.starts_with("salt") || type.starts_with("mism"))
                continue;
            if (text_of(row, {Symmetry}) != text_of(row, {Symmetry2})) continue; // to another copy
            const std::string order_text = text_of(row, {Order});
            const int order = order_text == "doub" ? 2 : order_text == "trip" ? 3 : 1;
            for (const int model : models) {
                std::array<const std::vector<int>*, 2> ends{};
                for (const int k : {0, 1}) {
                    const auto found = atoms_of.find(
                        key_of(model, text_of(row, {Asym + k, LabelAsym + k}),
                               text_of(row, {Sequence + k}), text_of(row, {Insertion + k}),
                               text_of(row, {Atom1 + k})));
                    if (found != atoms_of.end()) ends[static_cast<std::size_t>(k)] = &found->second;
                }
                if (!ends[0] || !ends[1]) continue; // not modelled, or of another model
                // 100: more alternative locations than there are letters for.
                if (ends[0]->size() > 100 || ends[1]->size() > 100)
                    fail(fmt::format("row {} of the _struct_conn table of line {}", count,
                                     table.line),
                         "it names an atom that is there more than 100 times");
                for (const int i : *ends[0])
                    for (const int j : *ends[1])
                        if (fits(i, text_of(row, {Alt})) && fits(j, text_of(row, {Alt2})))
                            file_.bonds.push_back({i, j, order});
            }
        }
    }

    bool fits(int atom, const std::string& altloc) const {
        return altloc.empty() || file_.atoms[static_cast<std::size_t>(atom)].altloc == altloc;
    }

    void read_operators() {
        std::vector<std::string> tags{"id"};
        for (const int row : {1, 2, 3}) {
            for (const int column : {1, 2, 3})
                tags.push_back(fmt::format("matrix[{}][{}]", row, column));
            tags.push_back(fmt::format("vector[{}]", row));
        }
        const CifTable table = document_.table("_pdbx_struct_oper_list.", tags);
        for (const Row& row : table.rows) {
            Eigen::Affine3d map;
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 4; ++j) map(i, j) = number_of(text_of(row, {1 + 4 * i + j}));
            map.makeAffine();
            operators_[text_of(row, {0})] = map;
        }
    }

    const Eigen::Affine3d& operator_of(const std::string& operator_name) const {
        const auto found = operators_.find(operator_name);
        if (found == operators_.end())
            fail_assembly(fmt::format("there is no operator '{}'", operator_name));
        if (!found->second.matrix().allFinite())
            fail_assembly(fmt::format("a number of operator '{}' is none", operator_name));
        return found->second;
    }

    /// One pair of parentheses, or a text without any: "1", "1,3", "1-60", "P,X0".
    std::vector<std::string> names_of_group(std::string_view group) const {
        std::vector<std::string> names;
        while (true) {
            const std::size_t comma = group.find(',');
            const std::string_view item = trimmed(group.substr(0, comma));
            const std::size_t dash = item.find('-');
            const std::optional<int> first = whole_number(item.substr(0, dash));
            const std::optional<int> last =
                dash == std::string_view::npos ? std::nullopt : whole_number(item.substr(dash + 1));
            if (first && last) {
                if (*last < *first ||
                    static_cast<std::size_t>(std::int64_t{*last} - *first) >= most_operators)
                    fail_assembly(fmt::format("'{}' is no range of operators", item));
                for (int k = *first; k <= *last; ++k) names.push_back(std::to_string(k));
            } else {
                names.emplace_back(item);
            }
            if (comma == std::string_view::npos) return names;
            group.remove_prefix(comma + 1);
        }
    }

    /// "(P)(1-60)" is each of the first group after each of the second.
    std::vector<AssemblyPart::Operator> operators_of(const std::string& expression) const {
        std::vector<AssemblyPart::Operator> all{{}};
        std::string_view rest = trimmed(expression);
        while (!rest.empty()) {
            std::string_view group = rest;
            if (rest.front() == '(') {
                const std::size_t close = rest.find(')');
                if (close == std::string_view::npos)
                    fail_assembly(fmt::format("'{}' lacks a ')'", expression));
                group = rest.substr(1, close - 1);
                rest = trimmed(rest.substr(close + 1));
            } else {
                rest = {};
            }
            const std::vector<std::string> names = names_of_group(group);
            if (all.size() * names.size() > most_operators)
                fail_assembly("more than 100,000 operators");
            std::vector<AssemblyPart::Operator> products;
            for (const AssemblyPart::Operator& left : all)
                for (const std::string& right : names)
                    products.push_back({left.name.empty() ? right : left.name + "x" + right,
                                        left.map * operator_of(right)});
            all = std::move(products);
        }
        return all;
    }

    void read_assemblies() {
        const CifTable table = document_.table("_pdbx_struct_assembly_gen.",
                                               {"assembly_id", "oper_expression", "asym_id_list"});
        for (const Row& row : table.rows) {
            const std::string assembly_name = text_of(row, {0});
            const auto same =
                std::find_if(file_.assemblies.begin(), file_.assemblies.end(),
                             [&](const Assembly& other) { return other.name == assembly_name; });
            Assembly& assembly =
                same == file_.assemblies.end()
                    ? file_.assemblies.emplace_back(Assembly{assembly_name, {}, {}})
                    : *same;
            AssemblyPart part;
            try {
                part.operators = operators_of(text_of(row, {1}));
            } catch (const InputError& error) { // matters only to who asks for this assembly
                assembly.problem = error.what();
            }
            const std::string list = text_of(row, {2});
            for (std::string_view rest = list; !rest.empty();) {
                const std::size_t comma = rest.find(',');
                part.chains.emplace_back(trimmed(rest.substr(0, comma)));
                rest.remove_prefix(comma == std::string_view::npos ? rest.size() : comma + 1);
            }
            assembly.parts.push_back(std::move(part));
        }
    }

    static bool is_water_name(std::string_view residue) { // as gemmi names them for PDB
        return residue == "HOH" || residue == "DOD" || residue == "WAT" || residue == "H2O";
    }

    const CifDocument& document_;
    const std::string& name_;
    std::unordered_map<std::string, Eigen::Affine3d> operators_;
    MoleculeFile file_;
};

} // namespace

MoleculeFile parse_mmcif(std::string_view bytes, const std::string& name) {
    std::optional<CifDocument> document;
    try {
        document.emplace(bytes.data(), bytes.size(), name);
    } catch (const std::exception& error) { // its message starts with the file and the line
        throw InputError(error.what());
    }
    if (document->choose_block("_atom_site.Cartn_x")) return MmcifFile(*document, name).parse();
    throw InputError(
        fmt::format("{}: no _atom_site.Cartn_x (small-molecule CIF is another format)", name));
}

} // namespace isocast
