// What was measured at one setting, which settings no other one beats, and the files of both.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/accuracy/settings.h"

#include <nlohmann/json_fwd.hpp>

#include <filesystem>

namespace isocast {

/// Over what was compared.
struct Error {
    double rms = 0;
    double max = 0;
    std::map<std::string, int> counts = {}; // of pixels
};

struct Measurement {
    Setting setting;
    std::map<std::string, Error> errors; // by Stage::error
    /// By what took them: "field" (reading, converting), "load" (to the GPU), "frame"; one a round.
    std::map<std::string, std::vector<double>> seconds;
    std::string failed;  // why nothing was measured; else empty
    std::string picture; // file beside the results
};

double median(std::vector<double> values);
/// Sum of the medians that count [s].
double price_of(const Measurement& measurement, Price price);
/// The sums of the lower and of the upper quartiles of the rounds.
std::pair<double, double> spread_of(const Measurement& measurement, Price price);

/// The measurements that a stage is about: at settings of its knobs alone, and as usual.
std::vector<std::size_t> points_of(const Stage& stage, std::span<const Measurement> all);
/// Those of them that none beats in both rms error and price, the cheapest first.
std::vector<std::size_t> front_of(const Stage& stage, std::span<const Measurement> all);

nlohmann::ordered_json to_json(const Measurement& measurement);
Measurement measurement_from(const nlohmann::ordered_json& json);
/// Each stage with its points and its front, by their places in `all`.
nlohmann::ordered_json stages_json(std::span<const Measurement> all);

/// A row for each measurement. throws  as write_text_file
void write_csv(std::span<const Measurement> all, const std::filesystem::path& path);

} // namespace isocast
