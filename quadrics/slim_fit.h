// One piece of a quadric for what a sphere holds of a mesh.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/slim_choice.h"
#include "quadrics/slim_mesh.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

namespace isocast {

/// What a sphere holds of a mesh, connected within it.
struct SlimPiece {
    SlimPatch patch;
    double residual_world = 0;  // greatest height over samples in the sphere, or as fit() has it
    std::vector<int> triangles; // of the mesh, all or in part
};

/// Fits patches, one at a time.
class SlimFitter {
public:
    explicit SlimFitter(const SlimMesh& mesh);

    /// The patch for the part of the mesh that is connected with a point of a triangle in a sphere
    /// about it. Edges of the mesh end the part, and so do creases unless the patch rounds them
    /// within the error; where it ends, planes clip the patch: half as far off as others at most,
    /// so that neighbours across a crease, each half an error longer than it is, meet.
    ///
    /// returns   nothing if no patch keeps the error: the part bends too much, or back, or has more
    ///           than two ends, or any in a sphere of less than three errors, or one where no plane
    ///           ends it
    /// accuracy  heights over the samples, the mesh's vertices, are no greater than spare_of();
    ///           over the surface between them, at corners and middles of edges of its parts of 0.7
    ///           of the radius, than that and twice as far as the triangle bows (flat ones do not),
    ///           two errors at most; where these edges leave the sphere, than three errors;
    ///           heights are no less than distances
    /// source    Ohtake, Belyaev, Alexa 2005 and Stoll et al. 2006 fig. 8; least squares by area
    std::optional<SlimPiece> fit(int triangle, const Vec3d& centre_world, double radius_world,
                                 double max_error_world);
    /// A plane in a sphere of slim_fall_back_errors without a bound, for where nothing keeps one.
    SlimPiece fall_back(int triangle, const Vec3d& centre_world, double max_error_world);
    /// How many errors the patch may be off by, 1 at least.
    ///
    /// accuracy  by the places that fit() looks at, and a tenth more
    double errors_of(const SlimPiece& piece, double max_error_world);

private:
    struct End { // a piece of an edge of the part, within the sphere
        Vec3d a, b;
        int from, to;                  // vertices
        Vec3d inwards, normal, beyond; // unit: normals of both faces; 0 if there is none beyond
        int chain = -1;
    };
    struct Leaf { // of the surface, from the centre
        std::array<Vec3d, 3> corners;
        std::array<Vec3d, 3> middles; // of the edges from corner k to k + 1
        double spare_world = 0;       // how little is known between the samples
    };
    struct Sample { // a vertex, from the centre
        Vec3d p;
        double weight;
    };
    void collect(int triangle, const Vec3d& centre_world, double radius_world,
                 bool crosses_creases);
    void add_triangle(std::size_t triangle, const std::array<Vec3d, 3>& corners,
                      const Vec3d& centre_world, double radius_world);
    /// corners    where they lie, from the centre
    /// bow_world  no less than how far this part of the triangle leaves the plane of its corners
    void add_leaves(std::size_t triangle, const Mat3d& corners_barycentric,
                    const std::array<Vec3d, 3>& corners, double bow_world,
                    const Vec3d& centre_world, double radius_world);
    bool is_graph(const Vec3d& normal, double least_cosine) const;
    /// Heights by least squares; as they come without enough leaves.
    SlimPatch fitted(const Vec3d& centre_world, double radius_world) const;
    /// most_spare_world  how much of what is little known between the samples is forgiven
    double residual(const SlimPatch& patch, double most_spare_world) const;
    /// Towards the fit with the least greatest height, until that keeps the bound: samples count by
    /// how far they are off, again and again.
    ///
    /// source  Lawson, Contributions to the theory of linear least maximum approximation, 1961
    void even_out(SlimPiece& piece, double bound_world, double most_spare_world);
    int group_ends();
    bool clip(SlimPatch& patch, double max_error_world);
    bool ends_with_part(const SlimPatch& patch, double max_error_world) const;
    std::optional<SlimPiece> fit_collected(const Vec3d& centre_world, double radius_world,
                                           double max_error_world);
    double rim_residual(const SlimPatch& patch) const;

    const SlimMesh& mesh_;
    std::vector<std::uint32_t> visits_; // by triangle: the last that came by
    std::vector<std::uint32_t> vertex_visits_;
    std::uint32_t visit_ = 0;
    std::vector<int> part_;
    std::vector<End> ends_;
    std::vector<Leaf> leaves_;
    std::vector<Sample> samples_;
    bool has_creases_ = false;
};

} // namespace isocast
