// How a molecule is drawn: which spheres and cylinders, in which colours.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/molecule.h"
#include "quadrics/primitives.h"

#include <vector>

namespace isocast {

enum class MoleculeStyle {
    SpaceFilling,   // each atom its van der Waals sphere
    BallsAndSticks, // a quarter of that, and a stick for each bond
    Licorice,       // sticks alone, with spheres as thick in their joints
};

enum class MoleculeColours {
    Element, // Jmol's table
    Chain,   // by the order of the chains' first atoms, from Okabe and Ito's palette
    Residue, // the kind of amino acid, Jmol's "amino" table
    BFactor, // blue to white to red, from the 5th to the 95th percentile
};

struct MoleculeLook {
    MoleculeStyle style = MoleculeStyle::BallsAndSticks;
    MoleculeColours colours = MoleculeColours::Element;
    double ball_scale = 0.25; // of the van der Waals radius
    double stick_radius_angstrom = 0.15;
    double licorice_radius_angstrom = 0.25;
    /// Sticks end just inside the balls that hide the rest: they are about half as long. Not for
    /// pictures in which balls are cut open.
    bool ends_sticks_in_balls = true;
};

/// World units are angstrom.
struct MoleculePrimitives {
    std::vector<Sphere> spheres;  // one for each atom, in its order
    std::vector<Cylinder> sticks; // open; one for each bond
};

/// Each half of a stick has the colour of its atom; a bond of two atoms in
/// one place has none.
///
/// source  radii and element colours: element_of()
MoleculePrimitives primitives_of(const Molecule& molecule, const MoleculeLook& look = {});

/// The colour of each atom, linear.
///
/// source  amino: RasMol's manual, which Jmol follows (jmol.sourceforge.net/jscolors); chains:
/// Okabe
///         and Ito 2008, "Color Universal Design", without black, repeated after seven; B-factors:
///         blue (0, 0, 1), white and red (1, 0, 0), between them linear in light, and white if all
///         are the same
std::vector<Vec3d> colours_of(const Molecule& molecule, MoleculeColours colours);

/// From sRGB to linear, both 0 to 1.
///
/// source  IEC 61966-2-1
double linear_light(double srgb);
/// The same of all three parts of 0xRRGGBB.
Vec3d linear_colour(std::uint32_t colour);

} // namespace isocast
