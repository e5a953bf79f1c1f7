// What values a field holds, and which isosurface of it is worth seeing first.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/field_source.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace isocast {

/// Samples of a field and how steep it is there, enough of them for statistics.
struct FieldSubset {
    std::vector<float> values;
    /// |gradient| by central differences [value / world].
    std::vector<float> slopes;
    /// Number of samples in the field's active boxes; the subset is all of them if it has as many.
    std::int64_t samples_in_field = 0;

    bool is_whole() const { return std::ssize(values) == samples_in_field; }
};

/// All samples of the active boxes, or, of larger fields, those of some bars of 256 x 4 x 4 that
/// are spread evenly over them: of a file that is mapped little is read.
///
/// most_samples  about so many; 2^20 are enough for thresholds, and read in a tenth of a second
/// throws        InputError if the field finds a sample that is no number
FieldSubset subset_of(const FieldSource& field, std::int64_t most_samples = std::int64_t{1} << 20);

/// Counts in bins of equal width.
struct Histogram {
    double first_edge = 0;
    double bin_width = 1;
    std::vector<std::int64_t> counts;

    double edge(std::size_t i) const { return first_edge + bin_width * static_cast<double>(i); }
};

/// Bins over the range of `values`. Those of integers hold equally many integers each, between
/// edges at halves.
///
/// values  finite
Histogram histogram_of(std::span<const float> values, int most_bins = 64);

/// The value midway between a volume's background and what stands out of it: skin in a head, a
/// part in its noisy surroundings.
///
/// The background is the greatest peak of the histogram, as wide as its noise; the object is what
/// lies more than four standard deviations above it, or below, whichever differs by more in sum.
/// Then, until nothing changes, the threshold is the middle between the background and the mean of
/// all values beyond the threshold, so that samples blurred between the two count less and less.
/// The share of the object in the volume does not matter, unlike in Otsu's method, which splits the
/// noise where an object is small.
///
/// values    finite; the value itself if all are equal, 0 if there are none
/// accuracy  a blurred step's middle within an eighth of its height, lower where objects of a few
///           voxels are mostly blur (Histogram.SuggestsTheMiddleOfABlurredStep)
/// source    after Ridler & Calvard 1978, whose threshold lies midway between the means of both
///           classes; that the background is a peak and stays is ours
double iso_beside_background(std::span<const float> values);

struct SuggestedIso {
    double iso = 0;
    std::string reason;
};

/// A first iso value for a field of which nothing is known.
///
/// 0 for a field with a band, and for one of both signs whose slope is 1 in two of five samples
/// that have one: distances. (In a band three voxels wide that was cut off, the slope is 1 in half
/// of them.) One voxel for unsigned distances: a sparse field of no band, a background above 0 and
/// no value that is negative or above it. Else iso_beside_background.
SuggestedIso suggested_iso(const FieldSource& field, const FieldSubset& subset);
SuggestedIso suggested_iso(const FieldSource& field);

} // namespace isocast
