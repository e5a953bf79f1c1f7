// From the bytes of a file to one molecule: model, alternative locations, waters, selection,
// assembly, bonds, in this order.
// SPDX-License-Identifier: MPL-2.0
#include "quadrics/molecule.h"

#include "quadrics/molecule_parsers.h"
#include "volume/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <system_error>
#include <unordered_map>

namespace isocast {

namespace {

struct MoleculeFormat {
    std::string_view extension;
    MoleculeFile (*parse)(std::string_view bytes, const std::string& name);
};

constexpr std::array formats = {
    MoleculeFormat{".pdb", parse_pdb}, MoleculeFormat{".ent", parse_pdb},
    MoleculeFormat{".cif", parse_mmcif}, MoleculeFormat{".mmcif", parse_mmcif},
    MoleculeFormat{".xyz", parse_xyz}};

// 50 million: some 10 GB; a capsid has 5 million. More is a mistake in the list of operators.
constexpr std::size_t most_atoms = 50'000'000;

const MoleculeFormat* find_format(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    for (char& c : extension)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    const auto found = std::find_if(formats.begin(), formats.end(), [&](const auto& format) {
        return format.extension == extension;
    });
    return found == formats.end() ? nullptr : &*found;
}

const MoleculeFormat& format_of(const std::filesystem::path& path) {
    if (const MoleculeFormat* format = find_format(path)) return *format;
    throw InputError(fmt::format("{}: unknown molecule format '{}' (known: {})", path.string(),
                                 path.extension().string(), molecule_file_extensions()));
}

std::string read_whole(const std::filesystem::path& path) {
    if (std::filesystem::is_directory(path))
        throw InputError(fmt::format("{}: is a directory", path.string()));
    std::ifstream file(path, std::ios::binary);
    if (!file)
        throw InputError(fmt::format("{}: cannot open: {}", path.string(),
                                     std::generic_category().message(errno)));
    std::ostringstream bytes;
    bytes << file.rdbuf(); // fails if there is nothing
    if (file.bad()) throw InputError(fmt::format("{}: cannot read", path.string()));
    return std::move(bytes).str();
}

template<class Names>
std::string list_of(const Names& names) {
    return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

/// The names in the order of their first appearance.
template<class Items, class NameOf>
auto distinct(const Items& items, NameOf name_of) {
    std::vector<std::decay_t<decltype(name_of(*items.begin()))>> names;
    for (const auto& item : items)
        if (std::find(names.begin(), names.end(), name_of(item)) == names.end())
            names.push_back(name_of(item));
    return names;
}

// ------------------------------------------------------------------------------ what is kept

using Kept = std::vector<char>; // of each atom of the file, whether it stays

void keep_model(Kept& kept, const MoleculeFile& file, std::optional<int> wanted) {
    const int model = wanted.value_or(file.atoms.front().model);
    bool is_there = false;
    for (std::size_t i = 0; i < kept.size(); ++i) {
        kept[i] = file.atoms[i].model == model;
        is_there = is_there || kept[i];
    }
    if (is_there) return;
    throw InputError(
        fmt::format("there is no model {} (known: {})", model,
                    list_of(distinct(file.atoms, [](const Atom& a) { return a.model; }))));
}

/// One alternative location for each residue, whose parts have the same chain, number and insertion
/// code; with microheterogeneity they differ in name.
void keep_altlocs(Kept& kept, const MoleculeFile& file, const std::string& wanted) {
    struct Alternative {
        std::string altloc;
        double sum = 0;
        int count = 0;
    };
    std::unordered_map<std::string, std::vector<Alternative>> residues;
    const auto key_of = [](const Atom& a) {
        return fmt::format("{} {} {}", a.chain, a.residue_number, a.insertion_code);
    };
    for (std::size_t i = 0; i < kept.size(); ++i) {
        const Atom& atom = file.atoms[i];
        if (!kept[i] || atom.altloc.empty()) continue;
        std::vector<Alternative>& all = residues[key_of(atom)];
        auto found = std::find_if(all.begin(), all.end(), [&](const Alternative& alternative) {
            return alternative.altloc == atom.altloc;
        });
        if (found == all.end()) found = all.insert(all.end(), {atom.altloc});
        found->sum += atom.occupancy;
        ++found->count;
    }
    std::unordered_map<std::string, std::string> chosen;
    for (const auto& [residue, all] : residues) {
        const Alternative* best = &all.front();
        for (const Alternative& alternative : all) {
            if (alternative.altloc == wanted) {
                best = &alternative;
                break;
            }
            // 1e-6: occupancies are read as floats.
            if (alternative.sum / alternative.count > best->sum / best->count + 1e-6)
                best = &alternative;
        }
        chosen[residue] = best->altloc;
    }
    for (std::size_t i = 0; i < kept.size(); ++i)
        if (kept[i] && !file.atoms[i].altloc.empty())
            kept[i] = chosen.at(key_of(file.atoms[i])) == file.atoms[i].altloc;
}

struct SelectionItem {
    std::string text;
    std::string chain;
    int first = std::numeric_limits<int>::min();
    int last = std::numeric_limits<int>::max();
};

std::vector<SelectionItem> parse_selection(std::string_view selection) {
    std::vector<SelectionItem> items;
    while (true) {
        const std::size_t comma = selection.find(',');
        const std::string_view text = trimmed(selection.substr(0, comma));
        const std::size_t colon = text.find(':');
        SelectionItem item{.text = std::string(text), .chain = std::string(text.substr(0, colon))};
        bool is_good = !item.chain.empty();
        if (colon != std::string_view::npos) {
            const std::string_view range = text.substr(colon + 1);
            const std::size_t dash = range.find('-', 1); // the first may be the sign
            const std::optional<int> first = whole_number(range.substr(0, dash));
            const std::optional<int> last =
                dash == std::string_view::npos ? first : whole_number(range.substr(dash + 1));
            is_good = is_good && first && last && *first <= *last;
            if (is_good) {
                item.first = *first;
                item.last = *last;
            }
        }
        if (!is_good)
            throw InputError(fmt::format(
                "'{}' is no selection: a chain (A) or a range of its residues (A:10-50)", text));
        items.push_back(std::move(item));
        if (comma == std::string_view::npos) return items;
        selection.remove_prefix(comma + 1);
    }
}

void keep_selected(Kept& kept, const MoleculeFile& file, const std::string& selection) {
    if (trimmed(selection).empty()) return;
    const std::vector<SelectionItem> items = parse_selection(selection);
    std::vector<char> has_matched(items.size(), 0);
    Kept selected(kept.size(), 0);
    for (std::size_t i = 0; i < kept.size(); ++i)
        for (std::size_t k = 0; kept[i] && k < items.size(); ++k) {
            const Atom& atom = file.atoms[i];
            if (atom.chain == items[k].chain && atom.residue_number >= items[k].first &&
                atom.residue_number <= items[k].last)
                has_matched[k] = selected[i] = 1;
        }
    std::vector<std::string> unmatched;
    for (std::size_t k = 0; k < items.size(); ++k)
        if (!has_matched[k]) unmatched.push_back(items[k].text);
    if (!unmatched.empty()) {
        std::vector<std::string> chains;
        for (std::size_t i = 0; i < kept.size(); ++i)
            if (const std::string& chain = file.atoms[i].chain;
                kept[i] && std::find(chains.begin(), chains.end(), chain) == chains.end())
                chains.push_back(chain);
        throw InputError(fmt::format("the selection {} matches no atom (chains: {})",
                                     list_of(unmatched), list_of(chains)));
    }
    kept = std::move(selected);
}

// ----------------------------------------------------------------------- from file to molecule

/// The kept atoms and the bonds listed between them.
Molecule kept_part(const MoleculeFile& file, const Kept& kept, std::vector<std::string>& chains) {
    Molecule molecule{.title = file.title};
    std::vector<int> index_of(kept.size(), -1);
    for (std::size_t i = 0; i < kept.size(); ++i) {
        if (!kept[i]) continue;
        index_of[i] = static_cast<int>(molecule.atoms.size());
        molecule.atoms.push_back(file.atoms[i]);
        if (!file.assembly_chains.empty()) chains.push_back(file.assembly_chains[i]);
    }
    for (const Bond& bond : file.bonds) {
        const int i = index_of[static_cast<std::size_t>(bond.i)];
        const int j = index_of[static_cast<std::size_t>(bond.j)];
        if (i >= 0 && j >= 0) molecule.bonds.push_back({i, j, bond.order});
    }
    return molecule;
}

/// Copies of the atoms by the operators; a listed bond is copied where one operator has both ends.
Molecule assembled(const Molecule& unit, const std::vector<std::string>& chains,
                   const std::vector<Assembly>& assemblies, const std::string& name) {
    const auto found = std::find_if(assemblies.begin(), assemblies.end(),
                                    [&](const Assembly& a) { return a.name == name; });
    if (found == assemblies.end())
        throw InputError(
            fmt::format("there is no assembly '{}' (known: {})", name,
                        list_of(distinct(assemblies, [](const Assembly& a) { return a.name; }))));
    if (!found->problem.empty())
        throw InputError(fmt::format("assembly '{}': {}", name, found->problem));
    std::unordered_map<std::string, std::vector<int>> atoms_of;
    for (std::size_t i = 0; i < chains.size(); ++i)
        atoms_of[chains[i]].push_back(static_cast<int>(i));

    Molecule molecule{.title = unit.title};
    std::map<std::string, std::unordered_map<int, int>> copies; // by operator, then by atom
    std::unordered_map<std::string, std::map<std::string, int>> copy_numbers; // by chain, operator
    for (const AssemblyPart& part : found->parts)
        for (const AssemblyPart::Operator& op : part.operators)
            for (const std::string& chain : part.chains) {
                const auto of_chain = atoms_of.find(chain);
                if (of_chain == atoms_of.end()) continue; // waters, or not selected
                if (molecule.atoms.size() + of_chain->second.size() > most_atoms)
                    throw InputError(
                        fmt::format("assembly '{}' has more than {} atoms", name, most_atoms));
                for (const int i : of_chain->second) {
                    Atom atom = unit.atoms[static_cast<std::size_t>(i)];
                    auto& numbers = copy_numbers[atom.chain];
                    const int number =
                        numbers.emplace(op.name, static_cast<int>(numbers.size()) + 1)
                            .first->second;
                    if (number > 1) atom.chain += fmt::format("-{}", number);
                    atom.position = op.map * atom.position;
                    if (!(atom.position.cwiseAbs().maxCoeff() <= largest_coordinate_angstrom))
                        throw InputError(fmt::format(
                            "operator '{}' of assembly '{}' moves an atom beyond 1e6 angstrom",
                            op.name, name));
                    copies[op.name].emplace(i, static_cast<int>(molecule.atoms.size()));
                    molecule.atoms.push_back(std::move(atom));
                }
            }
    for (const auto& [op, copy_of] : copies)
        for (const Bond& bond : unit.bonds) {
            const auto i = copy_of.find(bond.i), j = copy_of.find(bond.j);
            if (i != copy_of.end() && j != copy_of.end())
                molecule.bonds.push_back({i->second, j->second, bond.order});
        }
    return molecule;
}

/// Each pair once, ascending, with the highest order that it came with; no atom with itself.
std::vector<Bond> merged(std::vector<Bond> bonds) {
    for (Bond& bond : bonds) {
        if (bond.i > bond.j) std::swap(bond.i, bond.j);
        bond.order = std::clamp(bond.order, 1, 3);
    }
    std::erase_if(bonds, [](const Bond& bond) { return bond.i == bond.j; });
    std::sort(bonds.begin(), bonds.end(), [](const Bond& a, const Bond& b) {
        return std::tuple(a.i, a.j, -a.order) < std::tuple(b.i, b.j, -b.order);
    });
    const auto end = std::unique(bonds.begin(), bonds.end(), [](const Bond& a, const Bond& b) {
        return a.i == b.i && a.j == b.j;
    });
    bonds.erase(end, bonds.end());
    return bonds;
}

Molecule molecule_of(const MoleculeFile& file, const MoleculeOptions& options) {
    if (file.atoms.empty()) throw InputError("there are no atoms");
    Kept kept(file.atoms.size(), 1);
    keep_model(kept, file, options.model);
    keep_altlocs(kept, file, options.altloc);
    if (!options.waters)
        for (std::size_t i = 0; i < kept.size(); ++i) kept[i] = kept[i] && !file.atoms[i].is_water;
    if (std::find(kept.begin(), kept.end(), 1) == kept.end())
        throw InputError("all atoms are of waters, which are left out");
    keep_selected(kept, file, options.selection);
    std::vector<std::string> chains;
    Molecule molecule = kept_part(file, kept, chains);
    if (!options.assembly.empty())
        molecule = assembled(molecule, chains, file.assemblies, options.assembly);
    if (molecule.atoms.empty())
        throw InputError(fmt::format("assembly '{}' has no atom that is kept", options.assembly));
    const std::vector<Bond> near = bonds_by_distance(molecule.atoms);
    molecule.bonds.insert(molecule.bonds.end(), near.begin(), near.end());
    molecule.bonds = merged(std::move(molecule.bonds));
    return molecule;
}

} // namespace

double number_or_nan(std::string_view text) {
    text = trimmed(text);
    if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool is_number = error == std::errc() && end == text.data() + text.size();
    return is_number ? value : std::numeric_limits<double>::quiet_NaN();
}

std::optional<int> whole_number(std::string_view text) {
    text = trimmed(text);
    if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
    int value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return value;
}

Molecule molecule_of_bytes(std::string_view bytes, const std::filesystem::path& name,
                           const MoleculeOptions& options) {
    const MoleculeFormat& format = format_of(name);
    if (bytes.empty()) throw InputError(fmt::format("{}: the file is empty", name.string()));
    if (bytes.find('\0') != std::string_view::npos)
        throw InputError(fmt::format("{}: it holds a zero byte, so it is no text", name.string()));
    const MoleculeFile file = format.parse(bytes, name.string());
    try {
        return molecule_of(file, options);
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", name.string(), error.what()));
    }
}

Molecule read_molecule(const std::filesystem::path& path, const MoleculeOptions& options) {
    format_of(path); // before all of a large file is read
    return molecule_of_bytes(read_whole(path), path, options);
}

bool is_molecule_file(const std::filesystem::path& path) {
    return find_format(path) != nullptr;
}

std::string molecule_file_extensions() {
    std::vector<std::string_view> extensions;
    for (const MoleculeFormat& format : formats) extensions.push_back(format.extension);
    return list_of(extensions);
}

} // namespace isocast
