// SPDX-License-Identifier: MPL-2.0
#include "apps/accuracy/measurement.h"

#include "volume/atomic_file.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <fstream>
#include <numeric>
#include <set>

namespace isocast {

using Json = nlohmann::ordered_json;

namespace {

std::vector<std::string_view> parts_of(Price price) {
    switch (price) {
    case Price::Field:
        return {"field"};
    case Price::LoadAndFrame:
        return {"load", "frame"};
    case Price::Frame:
        return {"frame"};
    case Price::All:
        break;
    }
    return {"field", "load", "frame"};
}

const char* price_name(Price price) {
    switch (price) {
    case Price::Field:
        return "seconds to make the field";
    case Price::LoadAndFrame:
        return "seconds to load and draw";
    case Price::Frame:
        return "seconds a picture";
    case Price::All:
        break;
    }
    return "seconds to make the field, load and draw";
}

} // namespace

double median(std::vector<double> values) {
    std::ranges::sort(values);
    const std::size_t n = values.size();
    return n == 0 ? 0 : (values[(n - 1) / 2] + values[n / 2]) / 2;
}

double price_of(const Measurement& measurement, Price price) {
    double sum = 0;
    for (const std::string_view part : parts_of(price))
        if (const auto found = measurement.seconds.find(std::string(part));
            found != measurement.seconds.end())
            sum += median(found->second);
    return sum;
}

std::pair<double, double> spread_of(const Measurement& measurement, Price price) {
    double lower = 0;
    double upper = 0;
    for (const std::string_view part : parts_of(price))
        if (const auto found = measurement.seconds.find(std::string(part));
            found != measurement.seconds.end() && !found->second.empty()) {
            std::vector<double> rounds = found->second;
            std::ranges::sort(rounds);
            const std::size_t quarter = rounds.size() / 4;
            lower += rounds[quarter];
            upper += rounds[rounds.size() - 1 - quarter];
        }
    return {lower, upper};
}

std::vector<std::size_t> points_of(const Stage& stage, std::span<const Measurement> all) {
    const auto is_about = [&](const auto& value_of_knob) {
        return std::ranges::find(stage.knobs, value_of_knob.first) != stage.knobs.end();
    };
    std::vector<std::size_t> points;
    for (std::size_t i = 0; i < all.size(); ++i)
        if (all[i].errors.contains(std::string(stage.error)) &&
            std::ranges::all_of(all[i].setting, is_about))
            points.push_back(i);
    return points;
}

std::vector<std::size_t> front_of(const Stage& stage, std::span<const Measurement> all) {
    std::vector<std::size_t> points = points_of(stage, all);
    const auto error = [&](std::size_t i) {
        return all[i].errors.at(std::string(stage.error)).rms;
    };
    std::ranges::stable_sort(points, {}, [&](std::size_t i) {
        return std::pair(price_of(all[i], stage.price), error(i));
    });
    std::vector<std::size_t> front;
    for (const std::size_t i : points)
        if (front.empty() || error(i) < error(front.back())) front.push_back(i);
    return front;
}

Json to_json(const Measurement& measurement) {
    Json json{{"setting", measurement.setting}, {"text", text_of(measurement.setting)}};
    Json& errors = json["errors"] = Json::object();
    for (const auto& [name, error] : measurement.errors) {
        errors[name] = {{"rms", error.rms}, {"max", error.max}};
        if (!error.counts.empty()) errors[name]["pixels"] = error.counts;
    }
    json["seconds"] = measurement.seconds;
    if (!measurement.failed.empty()) json["failed"] = measurement.failed;
    if (!measurement.picture.empty()) json["picture"] = measurement.picture;
    return json;
}

Measurement measurement_from(const Json& json) {
    Measurement out{.setting = json.at("setting").get<Setting>(),
                    .failed = json.value("failed", ""),
                    .picture = json.value("picture", "")};
    for (const auto& [name, error] : json.at("errors").items())
        out.errors[name] = {error.at("rms"), error.at("max"),
                            error.value("pixels", std::map<std::string, int>())};
    for (const auto& [name, rounds] : json.at("seconds").items())
        out.seconds[name] = rounds.get<std::vector<double>>();
    return out;
}

Json stages_json(std::span<const Measurement> all) {
    Json out = Json::array();
    for (const Stage& stage : stages()) {
        const std::vector<std::size_t> points = points_of(stage, all);
        if (points.size() < 2) continue; // nothing to choose between
        Json prices = Json::array();
        for (const std::size_t i : points) {
            const auto [least, greatest] = spread_of(all[i], stage.price);
            prices.push_back({price_of(all[i], stage.price), least, greatest});
        }
        out.push_back({{"name", stage.name},
                       {"error", stage.error},
                       {"unit", stage.unit},
                       {"what", stage.what},
                       {"price", price_name(stage.price)},
                       {"knobs", stage.knobs},
                       {"points", points},
                       {"prices", prices},
                       {"front", front_of(stage, all)}});
    }
    return out;
}

void write_csv(std::span<const Measurement> all, const std::filesystem::path& path) {
    std::set<std::string> knobs;
    std::set<std::string> errors;
    for (const Measurement& m : all) {
        for (const auto& [knob, value] : m.setting) knobs.insert(knob);
        for (const auto& [name, error] : m.errors) errors.insert(name);
    }
    std::string text;
    for (const std::string& knob : knobs) text += knob + ",";
    for (const std::string& error : errors) text += fmt::format("{0}_rms,{0}_max,", error);
    text += "field_seconds,load_seconds,frame_seconds,failed\n";
    for (const Measurement& m : all) {
        for (const std::string& knob : knobs)
            text += (m.setting.contains(knob) ? m.setting.at(knob) : "") + ",";
        for (const std::string& error : errors)
            text += m.errors.contains(error)
                        ? fmt::format("{},{},", m.errors.at(error).rms, m.errors.at(error).max)
                        : ",,";
        for (const char* part : {"field", "load", "frame"})
            text += m.seconds.contains(part) ? fmt::format("{},", median(m.seconds.at(part))) : ",";
        std::string why = m.failed;
        std::ranges::replace_if(
            why, [](char c) { return c == '"' || c == '\n'; }, ' ');
        text += why.empty() ? "\n" : fmt::format("\"{}\"\n", why);
    }
    write_text_file(text, path);
}

} // namespace isocast
