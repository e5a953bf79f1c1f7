// Bonds by distance, through a grid whose cells are as large as the longest bond.
// SPDX-License-Identifier: MPL-2.0
#include "quadrics/elements.h"
#include "quadrics/molecule.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace isocast {

namespace {

constexpr double tolerance_angstrom = 0.45;
// Nearer atoms are two records of one; the shortest bond, that of H2, is 0.74 angstrom.
constexpr double least_angstrom = 0.4;

struct Place {
    std::int64_t cell;
    int atom;
    bool operator<(const Place& other) const {
        return cell != other.cell ? cell < other.cell : atom < other.atom;
    }
};

// 21 bits for each axis: 2e6 angstrom in cells of at least 2 * 0.28 + 0.45 angstrom, the margin and
// neighbours included, are fewer than 2^21.
std::int64_t cell_number(const std::array<std::int64_t, 3>& cell) {
    constexpr std::int64_t offset = std::int64_t{1} << 20;
    return ((cell[2] + offset) << 42) + ((cell[1] + offset) << 21) + (cell[0] + offset);
}

bool is_hydrogen(const Atom& atom) {
    return atom.element == 1;
}

/// Which of its neighbours each hydrogen is bonded to; -1 for none and for other atoms.
/// candidates  ascending, so that the first of equals is the one with the lowest index
std::vector<int> partners_of_hydrogens(std::span<const Atom> atoms,
                                       const std::vector<Bond>& candidates) {
    std::vector<int> partner(atoms.size(), -1);
    const auto is_better = [&](std::size_t h, std::size_t than, std::size_t candidate) {
        const bool is_h = is_hydrogen(atoms[candidate]), was_h = is_hydrogen(atoms[than]);
        if (is_h != was_h) return was_h;
        return (atoms[candidate].position - atoms[h].position).squaredNorm() <
               (atoms[than].position - atoms[h].position).squaredNorm();
    };
    for (const Bond& bond : candidates)
        for (const auto& [from, to] : {std::pair(bond.i, bond.j), std::pair(bond.j, bond.i)}) {
            const auto h = static_cast<std::size_t>(from);
            if (!is_hydrogen(atoms[h])) continue;
            if (partner[h] < 0 ||
                is_better(h, static_cast<std::size_t>(partner[h]), static_cast<std::size_t>(to)))
                partner[h] = to;
        }
    return partner;
}

} // namespace

std::vector<Bond> bonds_by_distance(std::span<const Atom> atoms) {
    double largest_radius = 0;
    for (const Atom& atom : atoms)
        largest_radius = std::max(largest_radius, element_of(atom.element).covalent_angstrom);
    const double cell_size = 2 * largest_radius + tolerance_angstrom;
    const auto cell_of = [&](const Vec3d& p) {
        std::array<std::int64_t, 3> cell;
        for (std::size_t k = 0; k < 3; ++k)
            cell[k] =
                static_cast<std::int64_t>(std::floor(p[static_cast<Eigen::Index>(k)] / cell_size));
        return cell;
    };
    std::vector<Place> places(atoms.size());
    for (std::size_t i = 0; i < atoms.size(); ++i)
        places[i] = {cell_number(cell_of(atoms[i].position)), static_cast<int>(i)};
    std::sort(places.begin(), places.end());

    std::vector<Bond> candidates;
    const auto consider = [&](std::size_t i, std::size_t j) {
        const Atom &a = atoms[i], &b = atoms[j];
        if (!a.altloc.empty() && !b.altloc.empty() && a.altloc != b.altloc) return;
        const double longest = element_of(a.element).covalent_angstrom +
                               element_of(b.element).covalent_angstrom + tolerance_angstrom;
        const double squared = (a.position - b.position).squaredNorm();
        if (squared > least_angstrom * least_angstrom && squared <= longest * longest)
            candidates.push_back({static_cast<int>(i), static_cast<int>(j), 1});
    };
    for (std::size_t i = 0; i < atoms.size(); ++i) {
        const std::array<std::int64_t, 3> cell = cell_of(atoms[i].position);
        for (const int dz : {-1, 0, 1})
            for (const int dy : {-1, 0, 1}) {
                // The three cells along x are one run of numbers.
                const std::int64_t first = cell_number({cell[0] - 1, cell[1] + dy, cell[2] + dz});
                for (auto at = std::lower_bound(places.begin(), places.end(), Place{first, 0});
                     at != places.end() && at->cell <= first + 2; ++at)
                    if (static_cast<std::size_t>(at->atom) > i)
                        consider(i, static_cast<std::size_t>(at->atom));
            }
    }
    std::sort(candidates.begin(), candidates.end(), [](const Bond& a, const Bond& b) {
        return std::pair(a.i, a.j) < std::pair(b.i, b.j);
    });
    const std::vector<int> partner = partners_of_hydrogens(atoms, candidates);
    std::erase_if(candidates, [&](const Bond& bond) {
        return (is_hydrogen(atoms[static_cast<std::size_t>(bond.i)]) &&
                partner[static_cast<std::size_t>(bond.i)] != bond.j) ||
               (is_hydrogen(atoms[static_cast<std::size_t>(bond.j)]) &&
                partner[static_cast<std::size_t>(bond.j)] != bond.i);
    });
    return candidates;
}

} // namespace isocast
