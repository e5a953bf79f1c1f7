// The exact signed distance to a mesh, cube by cube.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/box_tree.h"
#include "distance_transform/exact_distance.h"
#include "distance_transform/point_triangle.h"
#include "distance_transform/pseudonormals.h"
#include "distance_transform/winding_number.h"

namespace isocast {

/// By a tree of boxes, from the triangle on that was nearest last.
class MeshDistance final : public ExactDistance {
public:
    /// mesh      in finest cells; must outlive this, as must `winding`
    /// topology  of `mesh`
    /// winding   tells inside from outside; null leaves it to the normal of the closest feature
    MeshDistance(const Mesh& mesh, const MeshTopology& topology, const WindingNumber* winding);

    Sample at(const Vec3d& p, Hint& hint) const override;
    bool is_to_nearest() const override { return true; }
    SurfaceInCube surface_in(const Cube& cube, const CellFunction& g,
                             double tolerance) const override;

private:
    /// A triangle in its own plane: corner `first` at 0, the longest edge along x, y upwards.
    struct Frame {
        Vec3d origin, x, y, normal;
        double length;                      // of the longest edge
        double top_x, top_y;                // the third corner; top_y is 0 for slivers
        double inverse_right, inverse_left; // of the other edges' squared lengths
        int first;
    };
    struct Closest {
        Vec3d offset; // to p from the closest point
        Feature feature;
    };
    using Floats = Eigen::Array4f;
    /// Signed distances to planes, one of each of four triangles.
    struct Planes {
        Floats x = Floats::Zero(), y = Floats::Zero(), z = Floats::Zero(), offset = Floats::Zero();

        Floats at(const Eigen::Vector3f& p) const {
            return x * p.x() + y * p.y() + z * p.z() - offset;
        }
        /// How far a cube reaches from its centre along the normals.
        Floats reach(float half_edge) const { return half_edge * (x.abs() + y.abs() + z.abs()); }
    };
    /// Bounds on the distances to four triangles: from their planes, and beyond their edges, in
    /// the same order as the longest edge's, the right and the left one. All 0 for slivers.
    using Slabs = std::array<Planes, 4>;
    void add_slabs();
    static Frame frame_of(const std::array<Vec3d, 3>& corners);
    /// closest_point by the frame.
    Closest closest_on(std::int32_t triangle, const Vec3d& p) const;
    std::vector<std::array<Vec3d, 3>> corners_;
    BoxTree tree_;
    Pseudonormals normals_;
    const WindingNumber* winding_;
    std::vector<Frame> frames_;
    Vec3d slab_origin_;        // the middle of the mesh
    double slab_radius_;       // of a ball around it that holds the mesh
    std::vector<Slabs> slabs_; // by the places of the tree's leaves
};

} // namespace isocast
