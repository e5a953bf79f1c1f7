// From one field to another (thesis section 6.4.3, "Morphing").
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "filtering/filter.h"
#include "volume/dense_field.h"

#include <array>
#include <optional>
#include <string>

namespace isocast {

/// A field's function, sampled on another lattice.
///
/// samples  beyond its extent a field without a band continues its border
/// filter   what makes a function of the samples; its values keep to the band, if there is one
/// extent   of the lattice `space`; a band is a whole one only in an extent that holds it all
/// throws   ResourceError if the extent does not fit the memory that is available
/// accuracy the filter's order; computed in double on all threads
std::shared_ptr<const DenseField> resampled(const std::shared_ptr<const FieldSource>& samples,
                                            Filter filter, const GridSpace& space,
                                            const IndexBox& extent, const Progress& progress = {});

/// Two fields with their samples at the same places.
///
/// On two lattices, the coarser field is resampled on the lattice of the finer one, by the filter,
/// all over the extent of both. Beyond its own extent a field without a band continues its border
/// and is no distance any more: extents should hold both surfaces.
/// throws   as resampled
std::array<std::shared_ptr<const FieldSource>, 2>
on_one_lattice(const std::shared_ptr<const FieldSource>& a,
               const std::shared_ptr<const FieldSource>& b, Filter filter,
               const Progress& progress = {});

struct Morph {
    std::shared_ptr<const FieldSource> field;
    /// What the user should know: bands that do not meet.
    std::optional<std::string> warning;
};

/// (1 - t) a + t b on one lattice; at 0 and 1 it is `a` and `b` themselves.
///
/// throws  InputError unless 0 <= t <= 1; as on_one_lattice
Morph morph(const std::shared_ptr<const FieldSource>& a,
            const std::shared_ptr<const FieldSource>& b, double t,
            Filter filter = Filter::Interpolating, const Progress& progress = {});

} // namespace isocast
