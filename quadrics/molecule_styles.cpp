// SPDX-License-Identifier: MPL-2.0
#include "quadrics/molecule_styles.h"

#include "quadrics/elements.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <unordered_map>

namespace isocast {

namespace {

struct ResidueColour {
    std::string_view residue;
    std::uint32_t colour;
};

// Jmol's "amino".
constexpr std::array amino_colours = {
    ResidueColour{"ALA", 0xC8C8C8}, ResidueColour{"ARG", 0x145AFF}, ResidueColour{"ASN", 0x00DCDC},
    ResidueColour{"ASP", 0xE60A0A}, ResidueColour{"CYS", 0xE6E600}, ResidueColour{"GLN", 0x00DCDC},
    ResidueColour{"GLU", 0xE60A0A}, ResidueColour{"GLY", 0xEBEBEB}, ResidueColour{"HIS", 0x8282D2},
    ResidueColour{"ILE", 0x0F820F}, ResidueColour{"LEU", 0x0F820F}, ResidueColour{"LYS", 0x145AFF},
    ResidueColour{"MET", 0xE6E600}, ResidueColour{"PHE", 0x3232AA}, ResidueColour{"PRO", 0xDC9682},
    ResidueColour{"SER", 0xFA9600}, ResidueColour{"THR", 0xFA9600}, ResidueColour{"TRP", 0xB45AB4},
    ResidueColour{"TYR", 0x3232AA}, ResidueColour{"VAL", 0x0F820F}, ResidueColour{"ASX", 0xFF69B4},
    ResidueColour{"GLX", 0xFF69B4}};
constexpr std::uint32_t other_residue = 0xBEA06E;

// Okabe and Ito: told apart with any colour vision.
constexpr std::array<std::uint32_t, 7> chain_colours = {0x0072B2, 0xE69F00, 0x009E73, 0xCC79A7,
                                                        0x56B4E9, 0xD55E00, 0xF0E442};

std::uint32_t amino_colour(std::string_view residue) {
    const auto found = std::find_if(amino_colours.begin(), amino_colours.end(),
                                    [&](const ResidueColour& c) { return c.residue == residue; });
    return found == amino_colours.end() ? other_residue : found->colour;
}

/// The value that a fraction of `sorted` lies below, linear between neighbours.
double quantile(const std::vector<double>& sorted, double fraction) {
    const double at = fraction * static_cast<double>(sorted.size() - 1);
    const auto below = static_cast<std::size_t>(at);
    const std::size_t above = std::min(below + 1, sorted.size() - 1);
    return std::lerp(sorted[below], sorted[above], at - static_cast<double>(below));
}

std::vector<Vec3d> b_factor_colours(const std::vector<Atom>& atoms) {
    std::vector<double> sorted;
    for (const Atom& atom : atoms) sorted.push_back(atom.b_factor);
    std::sort(sorted.begin(), sorted.end());
    const double low = quantile(sorted, 0.05), high = quantile(sorted, 0.95);
    std::vector<Vec3d> colours;
    for (const Atom& atom : atoms) {
        const double t =
            high > low ? std::clamp((atom.b_factor - low) / (high - low), 0.0, 1.0) : 0.5;
        const double fade = 1 - std::abs(2 * t - 1); // 0 at both ends, 1 at white
        colours.push_back(t < 0.5 ? Vec3d(fade, fade, 1) : Vec3d(1, fade, fade));
    }
    return colours;
}

} // namespace

double linear_light(double srgb) {
    return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

Vec3d linear_colour(std::uint32_t colour) {
    Vec3d linear;
    for (int k = 0; k < 3; ++k)
        linear[k] = linear_light(double((colour >> (16 - 8 * k)) & 0xff) / 255);
    return linear;
}

std::vector<Vec3d> colours_of(const Molecule& molecule, MoleculeColours colours) {
    if (molecule.atoms.empty()) return {};
    if (colours == MoleculeColours::BFactor) return b_factor_colours(molecule.atoms);
    std::unordered_map<std::string, std::size_t> chains;
    std::vector<Vec3d> all;
    for (const Atom& atom : molecule.atoms) {
        std::uint32_t colour = 0;
        if (colours == MoleculeColours::Element) {
            colour = element_of(atom.element).jmol_colour;
        } else if (colours == MoleculeColours::Residue) {
            colour = amino_colour(atom.residue_name);
        } else {
            const std::size_t chain = chains.emplace(atom.chain, chains.size()).first->second;
            colour = chain_colours[chain % chain_colours.size()];
        }
        all.push_back(linear_colour(colour));
    }
    return all;
}

MoleculePrimitives primitives_of(const Molecule& molecule, const MoleculeLook& look) {
    const std::vector<Vec3d> colours = colours_of(molecule, look.colours);
    MoleculePrimitives primitives;
    for (std::size_t i = 0; i < molecule.atoms.size(); ++i) {
        const Atom& atom = molecule.atoms[i];
        double radius = element_of(atom.element).van_der_waals_angstrom;
        if (look.style == MoleculeStyle::BallsAndSticks) radius *= look.ball_scale;
        if (look.style == MoleculeStyle::Licorice) radius = look.licorice_radius_angstrom;
        primitives.spheres.push_back({atom.position, radius, colours[i]});
    }
    if (look.style == MoleculeStyle::SpaceFilling) return primitives;
    const double radius = look.style == MoleculeStyle::Licorice ? look.licorice_radius_angstrom
                                                                : look.stick_radius_angstrom;
    for (const Bond& bond : molecule.bonds) {
        const auto i = static_cast<std::size_t>(bond.i), j = static_cast<std::size_t>(bond.j);
        const Vec3d &a = molecule.atoms[i].position, &b = molecule.atoms[j].position;
        if (a == b) continue;
        // Where its side comes out of the smaller ball, and 1 % of that before; at both ends the
        // same, so that its middle stays where the colours meet.
        const double ball =
            std::min(primitives.spheres[i].radius_world, primitives.spheres[j].radius_world);
        const double hidden = std::sqrt(std::max(ball * ball - radius * radius, 0.0)) - 0.01 * ball;
        // Of balls that meet nothing of it shows: 0.49 leaves a stick of some length all the same.
        const Vec3d end = look.ends_sticks_in_balls
                              ? Vec3d(std::clamp(hidden / (b - a).norm(), 0.0, 0.49) * (b - a))
                              : Vec3d::Zero();
        primitives.sticks.push_back({a + end, b - end, radius, false, colours[i]});
        if (colours[j] != colours[i]) primitives.sticks.back().colour_b = colours[j];
    }
    return primitives;
}

} // namespace isocast
