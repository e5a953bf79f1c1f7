// What covers of meshes and of points share: least squares, which patches stay, and levels.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/slim.h"

#include <algorithm>
#include <array>
#include <functional>
#include <vector>

namespace isocast {

/// Of a radius: beyond it weights are small, so that what is covered lies within.
inline constexpr double slim_covered_share = 0.93;
/// Of the error, the radius of a plane where nothing keeps the error.
inline constexpr double slim_fall_back_errors = 3;
/// Of the box's diagonal, the greatest radius.
inline constexpr double slim_greatest_radius_share = 0.25;

/// Faces that turn more from a patch's normal are no graph over its plane that would do: heights
/// are then three times the distance.
inline constexpr double slim_least_cosine = 1.0 / 3;
/// By so much the search for a radius ends: an eighth of an octave.
inline constexpr double slim_radius_precision = 1.0906;
/// The patches to choose from are those of so many covers.
inline constexpr int slim_rounds = 3;

/// Of a level.
struct SlimReport {
    std::size_t with_planes = 0;     // of the patches
    std::size_t over_bound = 0;      // of the least size, which do not keep the error
    double greatest_error_world = 0; // bounded, of all patches
    double seconds = 0;
};

/// What a patch may be off by: so little of the radius at most that it stays in its sphere.
inline double spare_of(double radius_world, double max_error_world) {
    return std::min(max_error_world, radius_world / slim_fall_back_errors);
}

/// A patch's function at a place in its plane, from the centre.
inline double height_at(const SlimPatch& patch, double u, double v) {
    const auto& h = patch.height;
    return h[0] + u * (h[1] + u * h[3] + v * h[4]) + v * (h[2] + v * h[5]);
}

/// The function of least squares over places in a patch's frame, by its radius.
class HeightFit {
public:
    using Vector6 = Eigen::Matrix<double, 6, 1>;
    static Vector6 basis_of(const Vec3d& q); // heights are h . basis
    void add(const Vec3d& q, double weight);
    Vector6 solved() const;
    /// As patches have it.
    static std::array<double, 6> height_of(const Vector6& h, double radius_world);

private:
    using Matrix6 = Eigen::Matrix<double, 6, 6>;
    Matrix6 sum_ = Matrix6::Zero();
    Vector6 right_ = Vector6::Zero();
};

/// Which patches suffice: again and again the one that covers most of what is left, then those go
/// that others made needless, the least first.
///
/// covering  of each thing to be covered, which patches do
/// count     of patches
std::vector<bool> needed_patches(const std::vector<std::vector<int>>& covering, std::size_t count);

/// Covers anew with four times the error, and so on, while that leaves less than two thirds of the
/// patches, of which one of fifty at most does not keep its error; the last has fewer than 200
/// patches, if errors become that great.
///
/// cover    makes a level for an error and fills its report
/// reports  of each level
SlimSurface
with_levels(double max_error_world, int max_levels, double diagonal_world,
            std::vector<SlimReport>& reports,
            const std::function<SlimLevel(double max_error_world, SlimReport& report)>& cover);

} // namespace isocast
