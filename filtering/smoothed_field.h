// A field smoothed by a Gaussian, for derivatives at a scale.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/field_source.h"

#include <array>
#include <memory>

namespace isocast {

/// The largest scale: pages of 32^3 samples then read 190^3.
inline constexpr double greatest_scale_voxels = 16;

/// Weights w[0], w[1] = w[-1], ... that smooth samples by a Gaussian of the given variance.
///
/// returns  as many as leave out 1e-6 of the sum, then scaled to a sum of 1
/// source   Lindeberg 1990, "Scale-space for discrete signals": e^-t I_n(t). Their variance is t
///          for any t, where samples of exp(-n^2 / 2t) have another below a voxel; and smoothing by
///          s and then by t is smoothing by s + t
std::vector<double> gaussian_weights(double variance_voxels2);

/// A view of a field, convolved with a Gaussian. Quadratic functions f become f + (s^2/2) times
/// their Laplacian, with s the scale in world units: but for a constant they are the same.
///
/// As every sample, those of a band count as what they hold: farther than the half width from the
/// surface all are ± half width. Level sets of a sphere, a cylinder or a plane keep their shape all
/// the same, as they do under any smoothing of a function of the distance; of other surfaces,
/// pieces farther from a point than the half width count less. Beyond the extent fields go on as
/// copy_box says.
class SmoothedField final : public FieldSource {
public:
    /// scale_voxels  standard deviation [shortest edges of a voxel]; along each axis the number of
    ///               voxels that is as long in world space
    /// throws        InputError unless it lies between 0 and greatest_scale_voxels
    SmoothedField(std::shared_ptr<const FieldSource> samples, double scale_voxels);

    const GridSpace& space() const override { return samples_->space(); }
    IndexBox extent() const override { return samples_->extent(); }
    std::optional<double> half_width_world() const override { return samples_->half_width_world(); }
    std::vector<IndexBox> active_boxes() const override;
    int finest_level(const IndexBox& box) const override;
    ValueRange value_range(const IndexBox& box) const override;
    /// At higher levels every second sample of level 0 and so on.
    void copy_box(const IndexBox& box, int level, std::span<float> out) const override;

private:
    IndexBox with_reach(const IndexBox& box) const;

    std::shared_ptr<const FieldSource> samples_;
    std::array<std::vector<double>, 3> weights_; // along each axis
};

} // namespace isocast
