// The double reference caster: the true first hit of a ray with a reconstructed field's isosurface,
// by brute force. It shares nothing with the certificates that it is to judge.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "filtering/bspline.h"
#include "raycaster/camera.h"
#include "volume/field_source.h"

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace isocast {

struct ReferenceOptions {
    Kernel kernel = Kernel::BSpline;
    /// Distance of the samples between which a change of sign is sought; a stretch inside the
    /// object shorter than this may be missed.
    double step_voxels = 1.0 / 64;
};

/// Casts many rays at one field, from several threads if need be.
class ReferenceCaster {
public:
    /// Copies all of `control`, whose samples are the kernel's control samples
    /// (filtering/filter.h). throws  ResourceError if the extent holds more than 2^30 samples
    ReferenceCaster(const FieldSource& control, double iso, const ReferenceOptions& options = {});

    /// Parameter t >= 0 of the first change of sign of f - iso along origin + t * direction inside
    /// the extent, from the sign where the ray enters it, or starts.
    ///
    /// returns   nothing if the sign does not change
    /// accuracy  bisection to 1e-12 voxel, or what t can hold
    std::optional<double> hit(const Ray& ray) const;

    /// f - iso at a point of the extent, by 64 products.
    double value(const Vec3d& p_index) const;

    /// Gradient at a point of the extent [world/voxel], index space. With another derivative filter
    /// than the value's: of a caster of that filter's control samples and kernel.
    Vec3d gradient(const Vec3d& p_index) const;

private:
    /// Sign of f - iso all over a cell, as far as is known.
    enum class Sign : std::int8_t { Inside = -1, Unknown = 0, Outside = 1 };
    using Support = std::array<double, 64>; // x fastest

    /// The sum over the support, derived along an axis or not.
    double sum_at(const Vec3d& p_index, std::optional<int> derived) const;
    Index3 cell_of(const Vec3d& p_index) const;
    std::size_t cell_number(const Index3& cell) const;
    Support support_of(const Index3& cell) const;
    Sign sign_over(const Index3& cell) const;

    ReferenceOptions options_;
    double iso_;
    GridSpace space_;
    IndexBox extent_;
    IndexBox stored_;
    Index3 cells_; // along each axis
    std::vector<float> samples_;
    std::vector<Sign> signs_; // of the cells
};

/// One ray at a B-spline; many are faster cast with one ReferenceCaster.
std::optional<double> reference_hit(const FieldSource& field, double iso, const Ray& ray,
                                    double step_voxels = 1.0 / 64);

} // namespace isocast
