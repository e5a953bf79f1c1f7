// Coefficients with which the cubic B-spline passes through the samples.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/dense_field.h"
#include "volume/progress.h"

#include <memory>

namespace isocast {

/// The coefficients c of the cubic B-spline through every sample of the field's extent, which
/// continue beyond its border as a DenseField does: c[-1] = c[0].
///
/// memory_bytes  limit for the coefficients
/// throws  InputError if the field has a band, ResourceError above memory_bytes
/// source  Unser 1993 (recursive prefilter); here as the elimination of the tridiagonal system,
///         whose pivots tend to that filter's 2 + sqrt 3 and which is exact at the border too
std::shared_ptr<const DenseField>
spline_coefficients(const FieldSource& field, const Progress& progress, double memory_bytes);

} // namespace isocast
