// A mesh as samples of a smooth surface with creases.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/triangles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace isocast {

/// The smooth surface that a mesh samples, and how its triangles meet.
///
/// Over each triangle it is quadratic, through the corners and a point beside the middle of each
/// edge: as far off as the arc that both ends' normals ask for, (n_b - n_a) . (b - a) / 8 along
/// their mean; of a crease, as far as each of both faces asks for. So it has no gaps, circles
/// through vertices are met to the fourth order of the edges' length, and what is flat stays flat.
///
/// source  as Nagata, Simple local interpolation of surfaces using normal vectors, 2005, and
///         Vlachos et al., Curved PN triangles, 2001, with one term
class SlimMesh {
public:
    /// crease_degrees  between faces; more is a crease
    /// throws          InputError as check() of meshes, or if no triangle has an area
    SlimMesh(const TriangleMesh& mesh, double crease_degrees);

    struct Side {
        int neighbour = -1; // triangle across the edge from corner k to k + 1; -1: none, or several
        bool is_crease = false;
    };
    std::size_t size() const { return triangles_.size(); }
    const std::array<int, 3>& corners_of(std::size_t i) const { return triangles_[i]; }
    const Vec3d& vertex(int i) const { return vertices_world_[static_cast<std::size_t>(i)]; }
    /// Of the edge from corner k to k + 1: how far the surface passes from its middle.
    const Vec3d& bow(std::size_t i, std::size_t k) const { return bows_[i][k]; }
    /// Twice as far as any edge of the triangle bows: how little is known of it.
    double spare_world(std::size_t i) const {
        const auto& [a, b, c] = bows_[i];
        return 2 * std::sqrt(std::max({a.squaredNorm(), b.squaredNorm(), c.squaredNorm()}));
    }
    double longest_world(std::size_t i) const { return longest_world_[i]; } // edge
    double area_of_vertex(int i) const { return vertex_areas_[static_cast<std::size_t>(i)]; }
    std::size_t vertex_count() const { return vertices_world_.size(); }
    /// Of the surface.
    Vec3d point(std::size_t i, const Vec3d& barycentric) const;
    const Vec3d& normal(std::size_t i) const { return normals_[i]; }
    const Side& side(std::size_t i, std::size_t k) const { return sides_[i][k]; }
    double diagonal_world() const { return diagonal_world_; }
    bool is_closed() const { return is_closed_; }

private:
    void meet(double crease_degrees);
    /// Of the corner, by the angles of the faces around it that no crease divides from it.
    Vec3d corner_normal(std::size_t i, std::size_t k) const;
    void bend();

    std::vector<Vec3d> vertices_world_;
    std::vector<std::array<int, 3>> triangles_;
    std::vector<Vec3d> normals_; // of the flat triangles, unit
    std::vector<std::array<Side, 3>> sides_;
    std::vector<std::array<Vec3d, 3>> bows_;
    std::vector<double> longest_world_;
    std::vector<double> vertex_areas_; // a third of those of its triangles
    double diagonal_world_ = 0;
    bool is_closed_ = true;
};

} // namespace isocast
