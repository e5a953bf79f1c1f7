// What `isocast info` says of a field's values.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/histogram.h"

#include <nlohmann/json_fwd.hpp>

namespace isocast {

struct FieldStatistics {
    ValueRange range{};
    /// Whether `range` is that of all samples, and not only of those looked at.
    bool range_is_exact = true;
    std::vector<float> values; // of the samples looked at
    std::int64_t samples_in_field = 0;
    SuggestedIso suggested;
};

/// Looks at all samples, or at a subset where they are many.
/// throws  InputError if a sample is no number
FieldStatistics statistics_of(const FieldSource& field);

/// Adds value_range, value_range_is_exact, histogram:{edges, counts, samples, samples_in_field},
/// suggested_iso and suggested_iso_reason. At most 64 bins.
void add_statistics(nlohmann::ordered_json& json, const FieldStatistics& statistics);
/// The same for people, with bars.
void print_statistics(const FieldStatistics& statistics);

} // namespace isocast
