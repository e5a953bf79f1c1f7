// A mesh as the scan kernels read it: its faces, edges and fans, the Voronoi sites.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <cstdint>

namespace isocast {

// Plain numbers only: the kernels that read these are compiled once per instruction set, where no
// inline function of a library may be (the linker would keep any one of its copies). Positions are
// in voxels from the lattice's anchor.

/// What a face's neighbours need of it.
struct FaceNormal {
    double normal[3];
    double noise; // how far it may be off, from rounding of the corners [radians]
};

/// An edge of one triangle or more.
struct EdgeData {
    std::int32_t ends[2];
    std::int32_t faces[2]; // of two triangles at most: see `kind`
    enum : std::int32_t {
        Border,   // of faces[0] alone
        Opposed,  // of two that run along it in opposite directions, faces[0] from ends[0]
        Parallel, // of two that both run from ends[0] to ends[1]
        Junction  // of more; faces[0] is the number of the sum of their normals
    } kind;
};

/// A vertex, once for each fan of triangles around it.
struct FanData {
    double normal[3]; // angle-weighted; its length means nothing
    /// With h along the normal: an offset h n + l leads along no edge only if |l| <= slope_above h,
    /// or |l| <= - slope_below h. Negative where there is no bound.
    double slope_above;
    double slope_below;
    std::int32_t vertex;
};

/// A mesh with all its sites: faces first, then edges, then fans.
struct SiteArrays {
    const double (*vertices)[3];
    const std::int32_t (*triangles)[3];
    const FaceNormal* faces;
    const EdgeData* edges;
    const double (*junctions)[3];
    const FanData* fans;
    std::int32_t face_count;
    std::int32_t edge_count;
    std::int32_t fan_count;
    double half_width;
};

/// Where a site can hold the nearest point of the mesh: a convex bound of the tower of a face, the
/// wedge of an edge or the cone of a vertex (thesis figure 4.3), cut off at the half width.
///
///     point = base + height * direction + offset across it
///
///     low <= height <= high, |offset| <= lateral + lateral_slope * |height|
struct SiteRegion {
    double base_min[3]; // box of the triangle, segment or point
    double base_max[3];
    double direction[3]; // unit, and positive along `axis`
    double low;          // > high if the region is empty
    double high;
    double lateral;
    double lateral_slope;
    double lateral_factor[3]; // how much of the offset can lie along each axis
    std::int32_t axis;        // of the greatest component of `direction`
};

/// Samples, first and last; empty if any first > last.
struct SampleBox {
    std::int32_t first[3];
    std::int32_t last[3];
};

/// A linear function of a tile's samples, by steps along the column's axis k and along the two
/// after it. All that evaluate it do so as k * along_k + ((first + v * along_v) + u * along_u), so
/// that they get the same bits.
struct SampleFunction {
    double first; // at the tile's first sample
    double along_k;
    double along_u;
    double along_v;
};

/// A site as a tile's samples see it.
///
/// A face: its signed height, and the distances outwards over its three sides. An edge: two
/// coordinates across it, and one along it. A vertex: the function of which the side is the sign,
/// and the offsets along k, u and v.
struct TileSite {
    SiteRegion region; // from the tile's first sample
    SampleFunction functions[4];
    double length;   // of an edge
    double normal_x; // of an edge's pseudonormal, along the two coordinates across
    double normal_y;
};

} // namespace isocast
