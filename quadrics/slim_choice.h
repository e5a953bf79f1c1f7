// What covers of meshes and of points share: the order of centres, which patches stay, and levels.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/slim.h"

#include <cstdint>
#include <functional>

namespace isocast {

/// Of a radius: beyond it weights are small, so that what is covered lies within.
inline constexpr double slim_covered_share = 0.93;
/// Of the error, the radius of a plane where nothing keeps the error.
inline constexpr double slim_fall_back_errors = 3;
/// Of the box's diagonal, the greatest radius.
inline constexpr double slim_greatest_radius_share = 0.25;

/// Of a level.
struct SlimReport {
    std::size_t with_planes = 0;     // of the patches
    std::size_t over_bound = 0;      // of the least size, which do not keep the error
    double greatest_error_world = 0; // bounded, of all patches
    double seconds = 0;
};

/// source  splitmix64's finaliser, Steele, Lea and Flood 2014
std::uint64_t scrambled(std::uint64_t number);

/// Which patches are still needed once the others go that are not, the smallest first.
///
/// covering      of each thing to be covered, which patches do
/// radius_world  of each patch
std::vector<bool> needed_patches(const std::vector<std::vector<int>>& covering,
                                 const std::vector<double>& radius_world);

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
