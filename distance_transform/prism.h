// The thesis's bounding polyhedra: one frustum per triangle between bisector planes (4.2.3).
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/convex_scan.h"
#include "distance_transform/one_rings.h"

#include <array>

namespace isocast {

/// A row of thesis table 4.1: vertices, saddle vertices, vertices with incomplete covering.
struct CoveringCounts {
    int vertices = 0;
    int saddles = 0;
    int gaps = 0;
    bool operator==(const CoveringCounts&) const = default;
};

enum class Gaps { Leave, Close };

/// The printed prisms of a mesh: each triangle's is bounded by the bisector planes to its three
/// neighbours and by two planes parallel to it at distance half width.
///
/// At a boundary the plane through the edge perpendicular to the face stands for the bisector.
/// source    Sigg 2006, section 4.2.3 and appendix A
/// accuracy  not conservative: a sample's closest triangle need not be one whose prism holds it;
///           bench_prisms shows what that costs
class Prisms {
public:
    /// mesh        must outlive this; edges as one_rings() needs them
    /// half_width  in the mesh's unit
    /// throws      InputError as one_rings
    Prisms(const Mesh& mesh, double half_width, Gaps gaps);

    /// Three lateral half-spaces, by half-edge, then the one above and the one below the face.
    std::array<HalfSpace, 5> half_spaces(int triangle) const;
    const OneRings& rings() const { return rings_; }
    /// Before any gap was closed.
    const CoveringCounts& counts() const { return counts_; }
    /// True if the unshifted prisms around the vertex leave a gap; never at a boundary.
    bool has_gap(std::size_t ring) const { return !failing_test_points(ring).empty(); }

private:
    /// Normals of the bisector planes A_0 … A_n-1 around a vertex; A_i points to the right of
    /// figure 4.6, into P_i.
    std::vector<Vec3d> bisectors(std::size_t ring) const;
    std::vector<Vec3d> failing_test_points(std::size_t ring) const;
    void close_gap(std::size_t ring, const std::vector<Vec3d>& test_points);

    const Mesh& mesh_;
    double half_width_;
    OneRings rings_;
    std::vector<Vec3d> lateral_normals_; // per half-edge, unit, out of its triangle's prism
    std::vector<double> shifts_;         // per half-edge, outward
    CoveringCounts counts_;
};

/// The prisms of `triangles` as closed surfaces, to be drawn (figures 4.4 and 4.5).
Mesh prism_mesh(const Mesh& mesh, const Prisms& prisms, std::span<const int> triangles);

} // namespace isocast
