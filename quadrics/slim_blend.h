// How the pieces of a SLIM surface become one surface along a ray, and which of its levels is drawn
// how far away.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/cut.h"
#include "quadrics/slim.h"

#include <limits>
#include <optional>
#include <span>

namespace isocast {

/// Between which its heights are over the disc of its radius, as far as they are in its sphere.
Reach height_range(const SlimPatch& patch);

/// At least the greatest d . (p - centre) of its points p; d of unit length. Of what its planes
/// keep, but not where one of two suffices.
double support(const SlimPatch& patch, const Vec3d& d);

inline Reach reach_along(const SlimPatch& patch, const Vec3d& n) {
    const double at = n.dot(patch.centre_world);
    return {at - support(patch, -n), at + support(patch, n)};
}

/// How much of a level is drawn at a depth in front of the eye: from where its error is half a
/// pixel, through twice that depth from nothing to all, while the level before it goes. So all that
/// is drawn errs by half a pixel or is of the finest level, and nothing pops.
struct SlimFade {
    static constexpr double always = 1e30; // a rise that ends at the eye; floats hold it
    double rise = always;                  // by depth; 1 where it begins, 2 where it ends
    double fall = 0;

    double at(double depth) const {
        const auto share = [&](double slope) { return std::clamp(depth * slope - 1, 0.0, 1.0); };
        return share(rise) * (1 - share(fall));
    }
    /// Whether anything is drawn between two depths.
    bool is_seen(double least_depth, double greatest_depth) const {
        return greatest_depth * rise > 1 && least_depth * fall < 2;
    }
};
/// Of the level's patches; of parallel rays for a depth of 1.
///
/// pixels_per_unit  as in SplatView
SlimFade slim_fade(const SlimSurface& surface, std::size_t level, double pixels_per_unit);

/// Moved by a similarity.
SlimSurface placed(SlimSurface surface, const Eigen::Affine3d& to_world);

/// A hit, and how far the surface may lie before or behind it along the ray.
struct SlimFragment {
    SlimHit hit; // of weight above 0
    double reach = 0;
    bool is_outside = true; // which is seen
};
/// The patch's hit that shows: the nearest that its sphere and its planes hold.
///
/// max_error_world  of its level
/// faces_front      as in intersect()
/// returns          none if its weight is 0
std::optional<SlimFragment> slim_fragment(const SlimPatch& patch, double max_error_world,
                                          const Vec3d& origin_world, const Vec3d& direction_world,
                                          bool faces_front, double t_near = 0);

/// The greatest share of the error that slanted rays see as depth: 1 / 8.
inline constexpr double least_slant = 1.0 / 8;

/// The least 1 + cosine of a normal with the axis of stereographic pictures, which ends 2.6 degrees
/// from the opposite pole: a piece of a heap that looks away by as much moves the mean as if it did
/// not yet.
inline constexpr double least_rise = 1e-3;

/// The weighted mean of distances and of normals over the pieces of the sheet that comes first: of
/// the intervals t - reach ... t + reach those that overlap the one that ends first. All pieces
/// that err by what they promise hold the surface's own place, so that none of a sheet is left out.
///
/// axis_world  unit, towards the eye: normals are blended by their stereographic pictures along it,
///             those of a sheet that shows its inside turned around
/// source      Stoll et al. 2006, 5.1.1, whose offset is one number
std::optional<SlimHit> blended(std::span<const SlimFragment> fragments, const Vec3d& axis_world);

} // namespace isocast
