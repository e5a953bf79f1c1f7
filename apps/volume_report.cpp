// SPDX-License-Identifier: MPL-2.0
#include "apps/volume_report.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace isocast {

namespace {

constexpr int json_bins = 64;
constexpr int text_bins = 16; // one line each
constexpr int bar_length = 40;

} // namespace

FieldStatistics statistics_of(const FieldSource& field) {
    // Read whole for their exact range: 2^26 samples are a second of a slow disk.
    constexpr std::int64_t most_read = std::int64_t{1} << 26;
    FieldSubset subset = subset_of(field);
    FieldStatistics statistics;
    statistics.suggested = suggested_iso(field, subset);
    statistics.samples_in_field = subset.samples_in_field;
    statistics.values = std::move(subset.values);
    if (statistics.values.empty()) return statistics;
    if (field.extent().sample_count() <= most_read) {
        statistics.range = field.value_range(field.extent());
    } else {
        const auto [min, max] = std::ranges::minmax(statistics.values);
        statistics.range = {min, max};
        statistics.range_is_exact = std::ssize(statistics.values) == statistics.samples_in_field;
    }
    return statistics;
}

void add_statistics(nlohmann::ordered_json& json, const FieldStatistics& statistics) {
    const Histogram histogram = histogram_of(statistics.values, json_bins);
    std::vector<double> edges;
    if (!histogram.counts.empty())
        for (std::size_t i = 0; i <= histogram.counts.size(); ++i)
            edges.push_back(histogram.edge(i));
    json["value_range"] = {statistics.range.min, statistics.range.max};
    json["value_range_is_exact"] = statistics.range_is_exact;
    json["histogram"] = {{"edges", edges},
                         {"counts", histogram.counts},
                         {"samples", statistics.values.size()},
                         {"samples_in_field", statistics.samples_in_field}};
    json["suggested_iso"] = statistics.suggested.iso;
    json["suggested_iso_reason"] = statistics.suggested.reason;
}

void print_statistics(const FieldStatistics& statistics) {
    fmt::print("    values {:.6g} ... {:.6g}{}\n", statistics.range.min, statistics.range.max,
               statistics.range_is_exact ? "" : " in those looked at");
    const Histogram histogram = histogram_of(statistics.values, text_bins);
    const bool is_whole = std::ssize(statistics.values) == statistics.samples_in_field;
    if (is_whole)
        fmt::print("    all {} samples (bars: logarithm of the count)\n",
                   statistics.samples_in_field);
    else
        fmt::print("    {} of {} samples, spread over all (bars: logarithm of the count)\n",
                   statistics.values.size(), statistics.samples_in_field);
    const auto length_of = [](std::int64_t count) {
        return std::log1p(static_cast<double>(count));
    };
    const double longest =
        histogram.counts.empty() ? 1 : length_of(std::ranges::max(histogram.counts));
    for (std::size_t i = 0; i < histogram.counts.size(); ++i) {
        const std::int64_t count = histogram.counts[i];
        const auto length = static_cast<std::size_t>(
            std::lround(bar_length * length_of(count) / std::max(longest, 1.0)));
        fmt::print("    {:>12.6g} ... {:<12.6g} {:<{}} {}\n", histogram.edge(i),
                   histogram.edge(i + 1), std::string(length, '#'), bar_length, count);
    }
    fmt::print("    suggested iso {:.6g}: {}\n", statistics.suggested.iso,
               statistics.suggested.reason);
}

} // namespace isocast
