// The filters: which control samples are made of a field's samples, and which kernel reads them.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "filtering/bspline.h"
#include "volume/field_source.h"
#include "volume/progress.h"

#include <memory>
#include <string_view>

namespace isocast {

/// How a field's samples become a function.
enum class Filter {
    Linear,        // through the samples; second order, no curvature
    BSpline,       // cubic B-spline of the samples: smooths; second order
    Interpolating, // cubic B-spline of c = f - (Laplacian of f by 7 points)/6: fourth order, local
    Exact,         // cubic B-spline through the samples: fourth order; needs the whole field dense
    CatmullRom,    // cubic through the samples, one continuous derivative; third order
};

/// "linear", "bspline", "interpolating", "exact" or "catmull-rom".
/// throws  InputError that lists these
Filter filter_from_name(std::string_view name);
std::string_view filter_name(Filter filter);

Kernel kernel_of(Filter filter);

/// Whether the control samples of two filters are the same.
bool share_control_samples(Filter a, Filter b);

/// Bytes that the dense coefficients of Filter::Exact may take: 4 GiB, 1024^3 samples.
inline constexpr double default_control_bytes = 0x1p32;

/// The field whose samples are the control samples of the filter's kernel.
///
/// Linear, BSpline, CatmullRom: `samples` itself.
///
/// Interpolating: a view of `samples` that computes c = f - ((sum of the 6 neighbours) - 6 f)/6
/// when asked, in float; where f is constant c = f exactly, and c does not change when an axis is
/// mirrored. At level l the neighbours are the level's own, 2^l samples away, so that every level
/// reconstructs to fourth order on its own lattice. The extent stays: beyond it f continues, and c
/// follows from that, so that one sample beyond the border c is not yet constant.
///
/// Exact: coefficients c with (c[i-1] + 4 c[i] + c[i+1])/6 = f[i] along each axis in turn, and
/// c[-1] = c[0], c[n] = c[n-1] at the border, as a dense field continues: the spline then passes
/// through every sample of the extent. Computed at once, on all threads.
///
/// memory_bytes  limit for the coefficients of Exact, which are stored, beside what is available
/// throws  InputError if the filter is Exact and the field has a band: its coefficients would ring
///         off the band's edge; ResourceError if they do not fit
/// source  the quasi-interpolant: FORMULAS.md, Cubic B-spline; Exact: the recursive filter of Unser
///         1993, whose pole 1/(2 + sqrt 3) is the limit of the pivots here
std::shared_ptr<const FieldSource> control_samples(std::shared_ptr<const FieldSource> samples,
                                                   Filter filter, const Progress& progress = {},
                                                   double memory_bytes = default_control_bytes);

} // namespace isocast
