// SPDX-License-Identifier: MPL-2.0
#include "apps/view/trace.h"

#include "volume/errors.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace isocast::view {

namespace {

using Json = nlohmann::ordered_json;

} // namespace

Trace::Trace(const std::filesystem::path& path) {
    if (path.empty()) return;
    file_.open(path);
    if (!file_) throw InputError(fmt::format("{}: cannot be written", path.string()));
}

void Trace::step(const Step& step) {
    if (!file_.is_open()) return;
    Json passes = Json::object();
    for (const PassReport& pass : step.report.passes)
        if (pass.ran) passes[pass.name] = pass.milliseconds;
    file_ << Json{{"step", step.is_coarse ? "coarse" : "part"},
                  {"size", {step.width, step.height}},
                  {"part", {step.part.x, step.part.y, step.part.width, step.part.height}},
                  {"round", step.round},
                  {"ends_round", step.ends_round},
                  {"milliseconds", step.milliseconds},
                  {"passes", passes}}
          << std::endl;
}

void Trace::screen(double milliseconds) {
    if (file_.is_open())
        file_ << Json{{"screen", ++screens_}, {"milliseconds", milliseconds}} << std::endl;
}

void Trace::places(const std::map<std::string, std::array<float, 4>>& places) {
    if (!file_.is_open() || places == places_) return;
    places_ = places;
    file_ << Json{{"places", places}} << std::endl;
}

void Trace::event(const std::string& what, const std::string& text) {
    if (file_.is_open()) file_ << Json{{what, text}} << std::endl;
}

} // namespace isocast::view
