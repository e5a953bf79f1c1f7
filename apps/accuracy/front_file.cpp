// The file of a front: what `isocast accuracy --calibrate` measured.
// SPDX-License-Identifier: MPL-2.0
#include "apps/accuracy/promise.h"
#include "volume/atomic_file.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <fstream>

namespace isocast {

using Json = nlohmann::ordered_json;

namespace {

Json to_json(const std::vector<FrontPoint>& points) {
    Json json = Json::array();
    for (const FrontPoint& point : points)
        json.push_back({{"filter", filter_name(point.filter)},
                        {"resolution", point.resolution},
                        {"seconds", point.seconds},
                        {"ratio", point.ratio}});
    return json;
}

std::vector<FrontPoint> points_from(const Json& json) {
    std::vector<FrontPoint> points;
    for (const Json& point : json)
        points.push_back({filter_from_name(point.at("filter").get<std::string>()),
                          point.at("resolution"), point.at("seconds"), point.at("ratio")});
    return points;
}

} // namespace

std::filesystem::path own_front_path() {
    const std::filesystem::path folder = config_folder();
    return folder.empty() ? folder : folder / "front.json";
}

Front read_front(const std::vector<std::filesystem::path>& data_folders) {
    std::filesystem::path path = own_front_path();
    if (path.empty() || !std::filesystem::exists(path))
        path = first_folder_of(data_folders) / "front.json";
    std::ifstream file(path);
    try {
        const Json json = Json::parse(file);
        return {path, points_from(json.at("meshes")), points_from(json.at("fields"))};
    } catch (const Json::exception& error) {
        throw InputError(fmt::format("{}: no front of `isocast accuracy --calibrate`: {}",
                                     path.string(), error.what()));
    }
}

void write_front(const Front& front, const Json& machine) {
    std::filesystem::create_directories(front.path.parent_path());
    const Json json{
        {"machine", machine}, {"meshes", to_json(front.meshes)}, {"fields", to_json(front.fields)}};
    write_text_file(json.dump(1) + "\n", front.path);
}

} // namespace isocast
