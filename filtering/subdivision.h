// Cubic B-splines of lower resolution: their control samples, and the same functions' control
// samples at half the spacing.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/field_source.h"

#include <vector>

namespace isocast {

// Level l has its control samples 2^l voxels apart: sample i lies at index 2^l i. Boxes are in
// samples of their level, arrays x fastest.

/// The samples of level l + 1 that make those of `box` at level l.
IndexBox coarse_support(const IndexBox& box);

/// Control samples of the same spline at half the spacing: along each axis (c[i-1] + 6 c[i] +
/// c[i+1])/8 at 2i and (c[i] + c[i+1])/2 at 2i + 1. The weights are positive and their sum is one.
///
/// coarse    samples of coarse_support(box)
/// returns   samples of `box`
/// source    knot insertion; FORMULAS.md, Two resolutions side by side
std::vector<double> subdivided(std::vector<double> coarse, const IndexBox& box);

/// Control samples of a spline of level l that is near the one of `control`.
///
/// c - (1 - 4^-l)/6 ((sum of the 6 neighbours) - 6 c), the neighbours 2^l voxels away: the spline
/// of samples H apart is c + H^2/6 times their Laplacian, to fourth order, and this turns the H
/// of level l into that of level 0. It reads seven samples, which in a clamped band matters more
/// than the order: of the filters that were tried (docs/raycasting.md) it errs least there.
///
/// level  at least 1
std::vector<double> coarse_samples(const FieldSource& control, const IndexBox& box, int level);

} // namespace isocast
