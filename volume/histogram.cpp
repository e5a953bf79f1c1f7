// What values a field holds, and which isosurface of it is worth seeing first.
// SPDX-License-Identifier: MPL-2.0
#include "volume/histogram.h"

#include "volume/sparse_field.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace isocast {

namespace {

// Long along x, as samples lie: a bar with its neighbours touches 36 rows for 4096 samples. Of a
// mapped file each row costs what the system reads ahead, 128 KiB as a rule, however short it is.
const Index3 bar_size(256, 4, 4);

Index3 bars_along(const IndexBox& box) {
    return ((box.size() + bar_size).array() - 1) / bar_size.array();
}

/// The bar `number` of those that cover `box`.
IndexBox bar_of(const IndexBox& box, std::int64_t number) {
    const Index3 n = bars_along(box);
    const Index3 at(static_cast<int>(number % n.x()), static_cast<int>(number / n.x() % n.y()),
                    static_cast<int>(number / n.x() / n.y()));
    const Index3 lo = box.lo + at.cwiseProduct(bar_size);
    return intersection(box, {lo, lo + bar_size});
}

/// At most `most` bars of those that cover `boxes`, evenly spread.
std::vector<IndexBox> chosen_bars(const std::vector<IndexBox>& boxes, std::int64_t most) {
    std::vector<std::int64_t> ends; // of each box's bars in the row of all
    std::int64_t all = 0;
    for (const IndexBox& box : boxes) {
        const Index3 n = bars_along(box);
        all += std::int64_t{n.x()} * n.y() * n.z();
        ends.push_back(all);
    }
    const std::int64_t count = std::min(all, most);
    std::vector<IndexBox> bars;
    bars.reserve(static_cast<std::size_t>(count));
    for (std::int64_t i = 0; i < count; ++i) {
        // One of each of `count` equal parts of the row. Where in its part follows the golden
        // ratio, so that no period of rows or layers makes the bars one column.
        const double place = std::fmod(static_cast<double>(i) * 0.6180339887498949, 1.0);
        const double part = static_cast<double>(all) / static_cast<double>(count);
        const auto number =
            std::min(static_cast<std::int64_t>((static_cast<double>(i) + place) * part), all - 1);
        const std::int64_t in_row = count == all ? i : number;
        const auto box = std::ranges::upper_bound(ends, in_row) - ends.begin();
        const std::int64_t before = box == 0 ? 0 : ends[static_cast<std::size_t>(box - 1)];
        bars.push_back(bar_of(boxes[static_cast<std::size_t>(box)], in_row - before));
    }
    return bars;
}

/// `values` with the outermost ten thousandth at each end moved to the others' range: single
/// samples far from all others must not decide how wide the bins are.
std::vector<float> without_outliers(std::span<const float> values) {
    std::vector<float> inner(values.begin(), values.end());
    const auto cut = std::ssize(inner) / 10000;
    const auto low = inner.begin() + cut;
    const auto high = inner.end() - 1 - cut;
    std::ranges::nth_element(inner, low);
    const float min = *low;
    std::ranges::nth_element(inner, high);
    const float max = *high;
    for (float& value : inner) value = std::clamp(value, min, max);
    return inner;
}

/// A histogram's greatest peak.
struct Peak {
    std::size_t bin = 0;
    double deviation_bins = 0; // standard deviation, as a normal distribution's
};

Peak peak_of(const Histogram& histogram) {
    const auto& counts = histogram.counts;
    const auto top = std::ranges::max_element(counts);
    const auto is_high = [&](std::int64_t count) { return 2 * count >= *top; };
    const auto right = std::find_if_not(top, counts.end(), is_high);
    const auto left = std::find_if_not(std::reverse_iterator(top + 1), counts.rend(), is_high);
    const std::ptrdiff_t half_width = std::max(right - top, (top + 1) - left.base());
    // A normal distribution is half as high 1.1774 deviations from its middle.
    return {static_cast<std::size_t>(top - counts.begin()),
            static_cast<double>(half_width) / 1.1774};
}

} // namespace

FieldSubset subset_of(const FieldSource& field, std::int64_t most_samples) {
    FieldSubset subset;
    const std::vector<IndexBox> boxes = field.active_boxes();
    for (const IndexBox& box : boxes) subset.samples_in_field += box.sample_count();
    const std::int64_t most_bars = subset.samples_in_field <= most_samples
                                       ? std::numeric_limits<std::int64_t>::max()
                                       : std::max<std::int64_t>(1, most_samples / bar_size.prod());
    const std::vector<IndexBox> bars = chosen_bars(boxes, most_bars);
    std::vector<std::size_t> begins; // of each bar's samples in the subset
    std::size_t count = 0;
    for (const IndexBox& bar : bars) {
        begins.push_back(count);
        count += static_cast<std::size_t>(bar.sample_count());
    }
    subset.values.resize(count);
    subset.slopes.resize(count);
    const Eigen::Matrix3f world_from_index_gradient =
        field.space().world_from_index.linear().inverse().transpose().cast<float>();
    tbb::parallel_for(std::size_t{0}, bars.size(), [&](std::size_t i) {
        const IndexBox around = dilated(bars[i], 1, 1);
        const Index3 n = around.size();
        std::vector<float> samples(static_cast<std::size_t>(around.sample_count()));
        field.copy_box(around, 0, samples);
        const std::ptrdiff_t row = n.x();
        const std::ptrdiff_t layer = row * n.y();
        std::size_t to = begins[i];
        for (int z = 1; z < n.z() - 1; ++z)
            for (int y = 1; y < n.y() - 1; ++y)
                for (int x = 1; x < n.x() - 1; ++x, ++to) {
                    const float* const at = samples.data() + z * layer + y * row + x;
                    const Eigen::Vector3f gradient =
                        0.5F *
                        Eigen::Vector3f(at[1] - at[-1], at[row] - at[-row], at[layer] - at[-layer]);
                    subset.values[to] = *at;
                    subset.slopes[to] = (world_from_index_gradient * gradient).norm();
                }
    });
    return subset;
}

Histogram histogram_of(std::span<const float> values, int most_bins) {
    Histogram histogram;
    if (values.empty()) return histogram;
    const auto [min, max] = std::ranges::minmax(values);
    const double extent = static_cast<double>(max) - static_cast<double>(min);
    // 2^24: up to there float32 holds every integer.
    const bool is_integer = std::max(std::abs(min), std::abs(max)) <= 0x1p24F &&
                            std::ranges::all_of(values, [](float v) { return v == std::floor(v); });
    std::size_t bins = 1;
    if (is_integer) {
        histogram.bin_width = std::ceil((extent + 1) / most_bins);
        histogram.first_edge = static_cast<double>(min) - 0.5;
        bins = static_cast<std::size_t>(std::ceil((extent + 1) / histogram.bin_width));
    } else {
        histogram.first_edge = min;
        bins = extent > 0 ? static_cast<std::size_t>(most_bins) : 1;
        if (extent > 0) histogram.bin_width = extent / most_bins;
    }
    histogram.counts.resize(bins);
    for (const float value : values) {
        const double place =
            (static_cast<double>(value) - histogram.first_edge) / histogram.bin_width;
        ++histogram.counts[std::min(static_cast<std::size_t>(place), bins - 1)];
    }
    return histogram;
}

double iso_beside_background(std::span<const float> values) {
    if (values.empty()) return 0;
    const Histogram histogram = histogram_of(without_outliers(values), 256);
    const auto bins = static_cast<int>(histogram.counts.size());
    const Peak peak = peak_of(histogram);
    const auto background = static_cast<int>(peak.bin);
    const auto count_of = [&](int bin) {
        return static_cast<double>(histogram.counts[static_cast<std::size_t>(bin)]);
    };
    // What lies farther than `least` from the background on one side: distances in bins.
    struct Beyond {
        double count = 0;
        double sum = 0;
    };
    const auto beyond = [&](int side, double least) {
        Beyond all;
        for (int bin = background; bin >= 0 && bin < bins; bin += side) {
            const int distance = std::abs(bin - background);
            if (distance <= least) continue;
            all.count += count_of(bin);
            all.sum += count_of(bin) * distance;
        }
        return all;
    };
    const double noise = 4 * peak.deviation_bins; // 6e-5 of normal noise lie beyond, at both ends
    const int side = beyond(1, noise).sum >= beyond(-1, noise).sum ? 1 : -1;
    double threshold = noise;
    // The mean beyond a threshold grows with it, so that both come to rest.
    for (int i = 0; i < bins; ++i) {
        const Beyond object = beyond(side, threshold);
        if (object.count == 0) break;
        const double next = std::max(noise, 0.5 * object.sum / object.count);
        if (next <= threshold) break;
        threshold = next;
    }
    const bool has_object = beyond(side, noise).count > 0;
    const double place = background + 0.5 + (has_object ? side * threshold : 0);
    return histogram.edge(0) + histogram.bin_width * place;
}

SuggestedIso suggested_iso(const FieldSource& field, const FieldSubset& subset) {
    if (field.half_width_world()) return {0, "a field with a band: its surface"};
    if (subset.values.empty()) return {0, "no samples"};
    const auto [min, max] = std::ranges::minmax(subset.values);
    const auto* const sparse = dynamic_cast<const SparseField*>(&field);
    if (sparse != nullptr && sparse->background_world() > 0 && min >= 0 &&
        max <= static_cast<float>(sparse->background_world()))
        return {field.space().voxel_size_world(), "unsigned distances: one voxel"};
    const auto sloped = std::ranges::count_if(subset.slopes, [](float s) { return s > 0; });
    const auto of_one =
        std::ranges::count_if(subset.slopes, [](float s) { return s > 0.9F && s < 1.1F; });
    if (min < 0 && max > 0 && 5 * of_one > 2 * sloped)
        return {0, "signed distances, by their slopes: their surface"};
    if (sloped == 0) return {min, "a constant field"};
    return {iso_beside_background(subset.values),
            "midway between the background and what stands out of it"};
}

SuggestedIso suggested_iso(const FieldSource& field) {
    return suggested_iso(field, subset_of(field));
}

} // namespace isocast
