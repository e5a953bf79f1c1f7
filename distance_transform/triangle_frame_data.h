// The numbers of a triangle in its own orthonormal frame, as the block kernels read them.
// SPDX-License-Identifier: MPL-2.0
#pragma once

namespace isocast {

/// The frame of the thesis's figure 4.9: r runs along the longest side, s to the opposite corner
/// (the apex), t along the normal. The corners are (-b, 0), (a, 0) and (0, h), all of a, b, h >= 0.
///
///            (0, h)                 Plain doubles only: the kernels that read this are compiled
///            / |  \                 once per instruction set, where no inline function of a
///     left  /  |s   \ right         library may be (the linker would keep any one of its copies).
///     (-b,0)---o----(a, 0)  r
///
/// Stable for slivers: a triangle without height keeps its longest side exactly, and whatever
/// rounding does to the direction of s moves no corner by more than rounding.
struct TriangleFrame {
    double origin[3]; // foot of the apex on the longest side
    double r[3];
    double s[3];
    double t[3];
    double h;
    /// Of the side from (base, 0) to the apex: its length, and the cosine and sine of the angle
    /// between it and the longest side.
    struct Side {
        double base; // a or b
        double cosine;
        double sine;
        double length;
    };
    Side right;
    Side left;
    /// Corner of the triangle at (-b, 0); those at (a, 0) and at the apex follow in its order.
    int first_corner;
};

} // namespace isocast
