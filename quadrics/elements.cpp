// SPDX-License-Identifier: MPL-2.0
#include "quadrics/elements.h"

#include <array>

namespace isocast {

namespace {

// Gaps: beyond Cm the covalent radius is 1.5 angstrom; where neither paper has a van der Waals
// radius (Po to Ra, beyond Es) it is 2 angstrom; beyond Mt the colour is that of the unknown
// element. The unknown element has carbon's radii.
// clang-format off
constexpr std::array<Element, last_atomic_number + 1> elements = {{
    {"X", 0.76, 1.70, 0xFF1493}, {"H", 0.31, 1.20, 0xFFFFFF}, {"He", 0.28, 1.40, 0xD9FFFF},
    {"Li", 1.28, 1.82, 0xCC80FF}, {"Be", 0.96, 1.98, 0xC2FF00}, {"B", 0.84, 1.91, 0xFFB5B5},
    {"C", 0.76, 1.70, 0x909090}, {"N", 0.71, 1.55, 0x3050F8}, {"O", 0.66, 1.52, 0xFF0D0D},
    {"F", 0.57, 1.47, 0x90E050}, {"Ne", 0.58, 1.54, 0xB3E3F5}, {"Na", 1.66, 2.27, 0xAB5CF2},
    {"Mg", 1.41, 1.73, 0x8AFF00}, {"Al", 1.21, 2.25, 0xBFA6A6}, {"Si", 1.11, 2.10, 0xF0C8A0},
    {"P", 1.07, 1.80, 0xFF8000}, {"S", 1.05, 1.80, 0xFFFF30}, {"Cl", 1.02, 1.75, 0x1FF01F},
    {"Ar", 1.06, 1.88, 0x80D1E3}, {"K", 2.03, 2.75, 0x8F40D4}, {"Ca", 1.76, 2.62, 0x3DFF00},
    {"Sc", 1.70, 2.58, 0xE6E6E6}, {"Ti", 1.60, 2.46, 0xBFC2C7}, {"V", 1.53, 2.42, 0xA6A6AB},
    {"Cr", 1.39, 2.45, 0x8A99C7}, {"Mn", 1.39, 2.45, 0x9C7AC7}, {"Fe", 1.32, 2.44, 0xE06633},
    {"Co", 1.26, 2.40, 0xF090A0}, {"Ni", 1.24, 1.63, 0x50D050}, {"Cu", 1.32, 1.40, 0xC88033},
    {"Zn", 1.22, 1.39, 0x7D80B0}, {"Ga", 1.22, 1.87, 0xC28F8F}, {"Ge", 1.20, 2.29, 0x668F8F},
    {"As", 1.19, 1.85, 0xBD80E3}, {"Se", 1.20, 1.90, 0xFFA100}, {"Br", 1.20, 1.85, 0xA62929},
    {"Kr", 1.16, 2.02, 0x5CB8D1}, {"Rb", 2.20, 3.21, 0x702EB0}, {"Sr", 1.95, 2.84, 0x00FF00},
    {"Y", 1.90, 2.75, 0x94FFFF}, {"Zr", 1.75, 2.52, 0x94E0E0}, {"Nb", 1.64, 2.56, 0x73C2C9},
    {"Mo", 1.54, 2.45, 0x54B5B5}, {"Tc", 1.47, 2.44, 0x3B9E9E}, {"Ru", 1.46, 2.46, 0x248F8F},
    {"Rh", 1.42, 2.44, 0x0A7D8C}, {"Pd", 1.39, 1.63, 0x006985}, {"Ag", 1.45, 1.72, 0xC0C0C0},
    {"Cd", 1.44, 1.58, 0xFFD98F}, {"In", 1.42, 1.93, 0xA67573}, {"Sn", 1.39, 2.17, 0x668080},
    {"Sb", 1.39, 2.47, 0x9E63B5}, {"Te", 1.38, 2.06, 0xD47A00}, {"I", 1.39, 1.98, 0x940094},
    {"Xe", 1.40, 2.16, 0x429EB0}, {"Cs", 2.44, 3.48, 0x57178F}, {"Ba", 2.15, 3.03, 0x00C900},
    {"La", 2.07, 2.98, 0x70D4FF}, {"Ce", 2.04, 2.88, 0xFFFFC7}, {"Pr", 2.03, 2.92, 0xD9FFC7},
    {"Nd", 2.01, 2.95, 0xC7FFC7}, {"Pm", 1.99, 2.00, 0xA3FFC7}, {"Sm", 1.98, 2.90, 0x8FFFC7},
    {"Eu", 1.98, 2.87, 0x61FFC7}, {"Gd", 1.96, 2.83, 0x45FFC7}, {"Tb", 1.94, 2.79, 0x30FFC7},
    {"Dy", 1.92, 2.87, 0x1FFFC7}, {"Ho", 1.92, 2.81, 0x00FF9C}, {"Er", 1.89, 2.83, 0x00E675},
    {"Tm", 1.90, 2.79, 0x00D452}, {"Yb", 1.87, 2.80, 0x00BF38}, {"Lu", 1.87, 2.74, 0x00AB24},
    {"Hf", 1.75, 2.63, 0x4DC2FF}, {"Ta", 1.70, 2.53, 0x4DA6FF}, {"W", 1.62, 2.57, 0x2194D6},
    {"Re", 1.51, 2.49, 0x267DAB}, {"Os", 1.44, 2.48, 0x266696}, {"Ir", 1.41, 2.41, 0x175487},
    {"Pt", 1.36, 1.75, 0xD0D0E0}, {"Au", 1.36, 1.66, 0xFFD123}, {"Hg", 1.32, 1.55, 0xB8B8D0},
    {"Tl", 1.45, 1.96, 0xA6544D}, {"Pb", 1.46, 2.02, 0x575961}, {"Bi", 1.48, 2.54, 0x9E4FB5},
    {"Po", 1.40, 2.00, 0xAB5C00}, {"At", 1.50, 2.00, 0x754F45}, {"Rn", 1.50, 2.00, 0x428296},
    {"Fr", 2.60, 2.00, 0x420066}, {"Ra", 2.21, 2.00, 0x007D00}, {"Ac", 2.15, 2.80, 0x70ABFA},
    {"Th", 2.06, 2.93, 0x00BAFF}, {"Pa", 2.00, 2.88, 0x00A1FF}, {"U", 1.96, 1.86, 0x008FFF},
    {"Np", 1.90, 2.82, 0x0080FF}, {"Pu", 1.87, 2.81, 0x006BFF}, {"Am", 1.80, 2.83, 0x545CF2},
    {"Cm", 1.69, 3.05, 0x785CE3}, {"Bk", 1.50, 3.40, 0x8A4FE3}, {"Cf", 1.50, 3.05, 0xA136D4},
    {"Es", 1.50, 2.70, 0xB31FD4}, {"Fm", 1.50, 2.00, 0xB31FBA}, {"Md", 1.50, 2.00, 0xB30DA6},
    {"No", 1.50, 2.00, 0xBD0D87}, {"Lr", 1.50, 2.00, 0xC70066}, {"Rf", 1.50, 2.00, 0xCC0059},
    {"Db", 1.50, 2.00, 0xD1004F}, {"Sg", 1.50, 2.00, 0xD90045}, {"Bh", 1.50, 2.00, 0xE00038},
    {"Hs", 1.50, 2.00, 0xE6002E}, {"Mt", 1.50, 2.00, 0xEB0026}, {"Ds", 1.50, 2.00, 0xFF1493},
    {"Rg", 1.50, 2.00, 0xFF1493}, {"Cn", 1.50, 2.00, 0xFF1493}, {"Nh", 1.50, 2.00, 0xFF1493},
    {"Fl", 1.50, 2.00, 0xFF1493}, {"Mc", 1.50, 2.00, 0xFF1493}, {"Lv", 1.50, 2.00, 0xFF1493},
    {"Ts", 1.50, 2.00, 0xFF1493}, {"Og", 1.50, 2.00, 0xFF1493},
}};
// clang-format on

char upper(char c) {
    return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
}

bool is_same(std::string_view a, std::string_view b) {
    if (a.size() != b.size()) return false;
    for (std::size_t i = 0; i < a.size(); ++i)
        if (upper(a[i]) != upper(b[i])) return false;
    return true;
}

} // namespace

const Element& element_of(int atomic_number) {
    const bool is_known = atomic_number >= 0 && atomic_number <= last_atomic_number;
    return elements[is_known ? static_cast<std::size_t>(atomic_number) : 0];
}

int atomic_number_of(std::string_view symbol) {
    if (is_same(symbol, "D") || is_same(symbol, "T")) return 1;
    for (std::size_t z = 1; z < elements.size(); ++z)
        if (is_same(symbol, elements[z].symbol)) return static_cast<int>(z);
    return 0;
}

} // namespace isocast
