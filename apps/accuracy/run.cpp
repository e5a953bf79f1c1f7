// SPDX-License-Identifier: MPL-2.0
#include "apps/accuracy/run.h"

#include "raycaster/image_files.h"
#include "volume/atomic_file.h"
#include "volume/errors.h"
#include "volume/stopwatch.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/utsname.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <ctime>
#include <fstream>
#include <set>
#include <thread>

namespace isocast {

using Json = nlohmann::ordered_json;

namespace {

std::string processor_name() {
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("model name"))
            if (const auto colon = line.find(": "); colon != std::string::npos)
                return line.substr(colon + 2);
    return "unknown";
}

/// As usual first, then every setting of the sweeps, each once.
std::vector<Setting> settings_of(const std::vector<Sweep>& sweeps) {
    std::vector<Setting> all{{}};
    for (const Sweep& sweep : sweeps)
        for (const Setting& setting : isocast::settings_of(sweep))
            if (std::ranges::find(all, setting) == all.end()) all.push_back(setting);
    return all;
}

/// What the folder holds of the same run; nothing if it holds another, or none.
std::vector<Measurement> kept_in(const std::filesystem::path& path, const Json& description) {
    std::ifstream file(path);
    if (!file) return {};
    const Json json = Json::parse(file, nullptr, false);
    if (json.is_discarded() || json.value("run", Json()) != description) return {};
    std::vector<Measurement> kept;
    for (const Json& measurement : json.at("settings"))
        kept.push_back(measurement_from(measurement));
    return kept;
}

std::size_t rounds_of(const Measurement& measurement) {
    const auto frame = measurement.seconds.find("frame");
    return frame == measurement.seconds.end() ? 0 : frame->second.size();
}

} // namespace

Json machine_json(const gl::DriverInfo& driver) {
    utsname system{};
    uname(&system);
    std::array<char, 32> date{};
    const std::time_t now = std::time(nullptr);
    std::tm utc{};
    std::strftime(date.data(), date.size(), "%F %H:%M UTC", gmtime_r(&now, &utc));
    return {{"processor", processor_name()},
            {"cores", std::thread::hardware_concurrency()},
            {"system", fmt::format("{} {}", system.sysname, system.release)},
            {"gl_renderer", driver.renderer},
            {"gl_version", driver.version},
            {"isocast", ISOCAST_VERSION},
            {"date", date.data()}};
}

Json description_of(const Study& study, const StudyOptions& options, const RunOptions& run,
                    const gl::DriverInfo& driver) {
    Json sweeps = Json::array();
    for (const Sweep& sweep : run.sweeps) sweeps.push_back(sweep);
    Json out{{"input", options.input},
             {"set", options.settings},
             {"size", {options.width, options.height}},
             {"vary", sweeps},
             {"gl_renderer", driver.renderer},
             {"threads",
              tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism)},
             {"isocast", ISOCAST_VERSION}};
    if (std::filesystem::exists(study.input().name)) {
        out["bytes"] = std::filesystem::file_size(study.input().name);
        out["changed"] =
            std::filesystem::last_write_time(study.input().name).time_since_epoch().count();
    }
    return out;
}

std::vector<Measurement> measure(Study& study, const Json& description, const Json& machine,
                                 const RunOptions& options, const Progress& progress) {
    const std::filesystem::path results = options.folder / "results.json";
    const std::filesystem::path pictures = options.folder / "report" / "pictures";
    std::filesystem::create_directories(pictures);
    std::vector<Measurement> all;
    if (!options.is_fresh) all = kept_in(results, description);
    if (all.empty())
        for (const Setting& setting : settings_of(options.sweeps))
            all.push_back({.setting = setting});
    const auto save = [&] {
        Json json{{"run", description},
                  {"truth", study.truth_source()},
                  {"diagonal_world", study.diagonal_world()},
                  {"voxel_world", study.voxel_size_world()},
                  {"machine", machine}};
        for (const Measurement& measurement : all) json["settings"].push_back(to_json(measurement));
        json["stages"] = stages_json(all);
        write_text_file(json.dump(1) + "\n", results);
        write_csv(all, options.folder / "results.csv");
    };
    Stopwatch since_saved;
    const auto save_now_and_then = [&] {
        if (since_saved.seconds() < 5) return;
        save();
        since_saved.lap();
    };
    const std::size_t steps = all.size() * static_cast<std::size_t>(options.rounds + 1);
    std::size_t done = 0;
    const auto tell = [&](const Measurement& measurement) {
        if (progress) progress(text_of(measurement.setting), double(done++) / double(steps));
    };
    std::set<std::string> drawn; // whose programs are compiled, and still kept by the driver
    try {
        for (std::size_t i = 0; i < all.size(); ++i) {
            Measurement& measurement = all[i];
            tell(measurement);
            if (!measurement.errors.empty() || !measurement.failed.empty()) continue;
            try {
                auto errors = study.errors_at(measurement.setting);
                measurement.picture = fmt::format("report/pictures/{:03}.png", i);
                write_png(study.picture(), options.folder / measurement.picture);
                measurement.errors = std::move(errors);
            } catch (const InputError& error) {
                measurement.failed = error.what();
            } catch (const ResourceError& error) {
                measurement.failed = error.what();
            }
            save_now_and_then();
        }
        for (int round = 1; round <= options.rounds; ++round) {
            study.new_round();
            for (Measurement& measurement : all) {
                tell(measurement);
                if (!measurement.failed.empty() ||
                    rounds_of(measurement) >= static_cast<std::size_t>(round))
                    continue;
                if (drawn.insert(text_of(measurement.setting)).second)
                    study.seconds_at(measurement.setting);
                for (const auto& [part, seconds] : study.seconds_at(measurement.setting))
                    measurement.seconds[part].push_back(seconds);
                save_now_and_then();
            }
        }
    } catch (const Interrupted&) {
        save();
        throw;
    }
    save();
    return all;
}

} // namespace isocast
