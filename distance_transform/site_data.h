// The faces, edges and vertices of a mesh as the scan kernels read them.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <cstdint>

namespace isocast {

// Plain numbers only: the kernels that read these are compiled once per instruction set, where no
// inline function of a library may be (the linker would keep any one of its copies). Positions are
// in voxels from the lattice's anchor.

/// Where a site can hold the nearest point of the mesh: a convex bound of the tower of a face, the
/// wedge of an edge or the cone of a vertex (thesis figure 4.3), cut off at the half width.
///
///     point = base + height * direction + offset across it
///
///     low <= height <= high, |offset| <= lateral + lateral_slope * |height|
///
/// In float: the bound is widened by what that rounds.
struct alignas(64) SiteRegion {
    float base_min[3]; // box of the triangle, segment or point
    float base_max[3];
    float direction[3]; // unit, and positive along `axis`
    float low;
    float high;
    float lateral;
    float lateral_slope;
    std::int32_t axis; // of the greatest component of `direction`
    std::int32_t strip_count;
    // So far a line of the processor's caches.
    float lateral_factor[3]; // how much of the offset can lie along each axis
    /// Two parallel planes along `axis` between which the region's projection lies:
    /// low <= across[0] * x_u + across[1] * x_v <= high for the base, u and v the axes after
    /// `axis`.
    struct Strip {
        float across[2];
        float low;
        float high;
        float lean;   // how much a height adds
        float factor; // how much of the offset adds
    };
    Strip strips[4];
};

/// A face: the orthonormal frame of the thesis's figure 4.9. r runs along the longest side, s to
/// the apex, t along the normal; the corners are (-b, 0), (a, 0) and (0, h), all of a, b, h >= 0.
struct FaceSite {
    double origin[3]; // foot of the apex on the longest side
    double r[3];
    double s[3];
    double t[3];
    /// Of the side from (base, 0) to the apex: the distance outwards is
    /// sine * (|r| - base) + cosine * s.
    struct Side {
        double base;
        double cosine;
        double sine;
    };
    Side right;
    Side left;
};

/// An edge: e along it, x and y across.
struct EdgeSite {
    double origin[3];
    double e[3];
    double x[3];
    double y[3];
    double length;
    double normal_x; // of the pseudonormal
    double normal_y;
};

/// A vertex, once for each fan of triangles around it.
struct VertexSite {
    double origin[3];
    double normal[3];    // of the fan
    std::int32_t number; // of the vertex
};

} // namespace isocast
