// Signed distance to oriented points that no triangles connect.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/point_tree.h"

#include <Eigen/Core>

#include <string_view>
#include <vector>

namespace isocast {

/// How the distance near the points is put together from them.
enum class PointMethod {
    Partition,       // planes blended by Wendland's weights, with constants solved for
    Printed,         // the same with the thesis's weights (4.10), whose system is near singular
    Shepard,         // planes blended by 1 / r^2
    ModifiedShepard, // planes blended by Nielson's weights of compact support (4.9)
    Rbf,             // Wendland's compact radial functions on the points and two offsets of each
    Mls              // distance to the fixed point of projecting onto local planes
};

/// throws  InputError that lists the known names: partition, printed, shepard, modified-shepard,
/// rbf, mls
PointMethod point_method_from_name(std::string_view name);
std::string_view name_of(PointMethod method);

struct MeshlessOptions {
    PointMethod method = PointMethod::Partition;
    /// The k nearest points that a place looks at; below 20 the blend to the far field wavers.
    int neighbours = 20;
    /// 0 interpolates the points; larger lets the surface pass by them and evens noise out.
    /// Partition, Printed and Rbf only.
    double approximation = 0;
    /// Points whose normals turn away from the nearest one's do not count: they lie beyond an edge
    /// or on the other side of a thin part. Not for Rbf.
    bool same_side = true;

    bool operator==(const MeshlessOptions&) const = default;
};

/// The distance field of a cloud, at any place.
///
/// f = w f_near + (1 - w) f_far with f_far = ± the distance to the nearest point.
///
/// source    Sigg 2006 (thesis), 4.3: 4.8, 4.11, 4.12, and 4.15 as corrected. Instead of 4.10,
/// whose
///           transform changes its sign, so that interpolating has no stable solution where 10 or
///           20 planes overlap, Wendland's function of smoothness C2, of nearly the same shape and
///           positive definite (Wendland 1995). Planes of points that face away from the nearest
///           one are left out, which the thesis does not
/// accuracy  |f_near| <= 1e-10 spacings at the points for Partition without approximation
///           (Meshless.InterpolatesThePoints)
class Meshless {
public:
    /// points   any unit of length, distinct, more than options.neighbours
    /// normals  unit length, outward
    /// throws   InputError if there are too few points, an option is out of range, or the system of
    ///          equations has no solution
    Meshless(std::vector<Vec3d> points, std::vector<Vec3d> normals, const MeshlessOptions& options);

    struct Value {
        double near;        // f_near
        double far;         // distance to the nearest point, >= 0
        double near_weight; // w of 4.15
        std::int32_t nearest;
        bool all_agree; // the normals of all points seen are within 60 degrees of the nearest one's

        /// negative  the sign of the far field
        double blended(bool negative) const;
    };
    Value at(const Vec3d& p) const;
    /// seen  the seen_points() nearest points, the nearest first and the farthest last
    Value at(const Vec3d& p, std::span<const Neighbour> seen) const;
    std::size_t seen_points() const { return static_cast<std::size_t>(options_.neighbours) + 1; }

    const PointTree& tree() const { return tree_; }
    std::span<const Vec3d> points() const { return points_; }
    std::span<const Vec3d> normals() const { return normals_; }

    /// What the planes of `seen` weigh, together 1; 0 for points of no influence.
    /// returns  whether all agree, see Value
    bool weights(std::span<const Neighbour> seen, std::span<const double> distances,
                 std::span<double> out) const;

private:
    double plane(std::int32_t i, const Vec3d& p) const {
        return normals_[i].dot(p - points_[i]) + constants_[i];
    }
    double projected(const Vec3d& p, std::span<const Neighbour> seen) const;
    double radial(const Vec3d& p) const;
    void solve_constants();
    void solve_radial();

    MeshlessOptions options_;
    std::vector<Vec3d> points_;
    std::vector<Vec3d> normals_;
    PointTree tree_;
    std::vector<double> constants_; // of the planes
    // Rbf only: the centres are the points, then those outside, then those inside.
    PointTree centres_;
    std::vector<double> centre_weights_;
    double radius_ = 0;
};

/// w of 4.15 from the distances to the nearest points.
double near_weight(std::span<const double> distances);
/// The relative standard deviation of 4.12.
double relative_deviation(std::span<const double> distances);

} // namespace isocast
