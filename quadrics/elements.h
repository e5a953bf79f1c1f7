// The chemical elements as molecules are drawn: radii and colours by atomic number.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <cstdint>
#include <string_view>

namespace isocast {

struct Element {
    const char* symbol;       // "Fe"
    double covalent_angstrom; // single bond
    double van_der_waals_angstrom;
    std::uint32_t jmol_colour; // sRGB, 0xRRGGBB
};

inline constexpr int last_atomic_number = 118;

/// atomic_number  1 (H) to 118 (Og); 0 and all others are the unknown element, symbol "X"
/// source         covalent: Cordero et al. 2008, Dalton Trans. 2832, table 2, carbon as sp3, Mn, Fe
///                and Co with low spin; van der Waals: Bondi 1964, J. Phys. Chem. 68, 441, else
///                Alvarez 2013, Dalton Trans. 42, 8617; colours: Jmol's table by element
///                (jmol.sourceforge.net/jscolors). All by way of ASE's tables (ase.data), which
///                cite the same papers.
const Element& element_of(int atomic_number);

/// symbol   in any case ("FE", "Fe"); D and T are hydrogen
/// returns  the atomic number; 0 if there is no such element
int atomic_number_of(std::string_view symbol);

} // namespace isocast
