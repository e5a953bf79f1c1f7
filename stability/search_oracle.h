// What the search of a ray must find, by the double reference caster, and how far float32 may be
// off.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "filtering/filter.h"
#include "raycaster/ray_span.h"
#include "raycaster/reference.h"

#include <memory>
#include <optional>
#include <vector>

namespace isocast::stability {

/// Of unit length, at a pixel's middle: in a world of unit voxels it is an index-space ray.
Ray unit_ray(const Camera& camera, int width, int height, int x, int y);

/// Where such a ray is in the extent.
RaySpan span_in(const Ray& ray, const IndexBox& extent);

/// The truth about the surface f = iso of samples with unit voxels, world space being index space.
class SearchOracle {
public:
    /// storage_error  of the samples that are drawn [world]
    SearchOracle(const std::shared_ptr<const FieldSource>& samples, Filter filter, double iso,
                 double guarantee_voxels, double storage_error);

    /// By slopes at a few of the reference's hits, or by their greatest; before anything is judged.
    void prepare(const std::vector<Camera>& cameras, int width, int height);
    void prepare(double greatest_slope);

    /// How far an evaluated value may lie from f at a hit's place in double: 2^-20 of the samples,
    /// sixteen roundings of a sum of 64 products (twice that for Catmull-Rom, whose weights' sizes
    /// add up to 1.25 along each axis, 1.95 in all), what the storage says, and a displacement of
    /// 3e-5 voxel: coordinates of up to 200 voxels before the middle is taken off round by 1e-5
    /// along each axis, and the search ends within 1e-5.
    double value_error() const;

    /// Where a unit ray is sure to be stopped at the latest: it enters a stretch longer than the
    /// guarantee in which the value has the other sign by more than its error.
    ///
    /// t_end  where the ray leaves the extent
    std::optional<double> first_certain(const Ray& ray, bool starts_inside, double t_end) const;

    const FieldSource& control() const { return *control_; }
    const ReferenceCaster& exact() const { return exact_; }

    static constexpr double place_error_voxels = 1e-4; // of float32

private:
    std::shared_ptr<const FieldSource> control_;
    Filter filter_;
    double iso_;
    double guarantee_voxels_;
    double storage_error_;
    ReferenceOptions options_; // steps of half the guarantee, so that it sees what must be seen
    ReferenceCaster exact_;
    std::vector<ReferenceCaster> deep_; // of the surfaces value_error() inside and outside
    double magnitude_ = 0;              // greatest |sample - iso| that a point of the surface reads
    double slope_ = 0;
};

} // namespace isocast::stability
