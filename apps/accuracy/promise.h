// Which setting is the cheapest that keeps an error: `--max-error`.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/inputs.h"
#include "apps/scene_file.h"
#include "distance_transform/checked_mesh.h"
#include "filtering/filter.h"
#include "volume/analytic_fields.h"
#include "volume/progress.h"

#include <nlohmann/json_fwd.hpp>

#include <array>
#include <functional>
#include <span>

namespace isocast {

/// What is measured and chosen from.
inline constexpr std::array front_filters{Filter::Linear, Filter::BSpline, Filter::Interpolating};
/// A picture of 256^2 pixels shows ten times as many points, which the ratio makes up for.
inline constexpr int probe_point_count = 4000;

/// What `isocast accuracy --calibrate` measured, of meshes or of fields: at a filter and a
/// resolution, what a picture takes in all, and how many times as large as the probe's its greatest
/// error was at most.
struct FrontPoint {
    Filter filter = Filter::Interpolating;
    int resolution = 0;
    double seconds = 0;
    double ratio = 0;
};
struct Front {
    std::filesystem::path path;
    std::vector<FrontPoint> meshes;
    std::vector<FrontPoint> fields;
};

/// front.json in the user's config_folder().
std::filesystem::path own_front_path();
/// The one that was measured on this machine, or else the one that comes with the program.
/// throws  InputError that names the file and the cause
Front read_front(const std::vector<std::filesystem::path>& data_folders);
/// throws  as write_text_file
void write_front(const Front& front, const nlohmann::ordered_json& machine);

/// The greatest ratio that was measured for a filter, and a quarter: the worst of a few fields is
/// not the worst of all.
double ratio_of(std::span<const FrontPoint> points, Filter filter);
/// What a picture takes, between resolutions by powers of both.
double seconds_of(std::span<const FrontPoint> points, Filter filter, int resolution);

/// Points of a surface, seeded: of a function's zero set within its cube, by Newton's method; of a
/// mesh half of them spread evenly, half on edges and corners, where fields err most.
std::vector<Vec3d> surface_points(const AnalyticField& field, int count);
std::vector<Vec3d> surface_points(const Mesh& mesh, int count);

/// What hits are off by at most beside that [voxels]: rays find roots to 1e-5, floats at the far
/// end of a field are 1e-7 of its size apart; the greatest measured is half of this.
inline double hit_error_voxels(int resolution) {
    return 4e-5 + 4e-7 * resolution;
}

/// How far the surface of a field, as the filter makes it, is from points of the true one: the
/// greatest |f - iso| / |gradient| there [world]. Points without 4^3 samples around them do not
/// count.
double probe(const FieldSource& field, double iso_world, Filter filter,
             std::span<const Vec3d> points_world);

struct Promise {
    Filter filter = Filter::Interpolating;
    std::optional<int> resolution; // of a mesh, or a built-in field
    double error_world = 0;        // that is promised
    double seconds = 0;            // that the front says
};

/// The cheapest filter and resolution with which points that are drawn lie within `max_error_world`
/// of the true surface: for each filter the least resolution, of steps of a factor of sqrt(2),
/// whose probed error times the front's ratio is small enough.
///
/// filters  to choose from, of the front's
///
/// throws  InputError if none does up to 1024 voxels, that says what can be had
Promise promise_for(const AnalyticField& field, double max_error_world, const Front& front);
Promise promise_for(const CheckedMesh& mesh, double max_error_world, const Front& front,
                    const Progress& progress, std::span<const Filter> filters = front_filters);
/// Of a field whose samples are what they are, the filters alone. The truth is not known: that of
/// the interpolating spline is estimated by how far Catmull-Rom's cubic, of third order, is from
/// it, and that of the others by how far they are from it, and by that.
Promise promise_for(const std::shared_ptr<const FieldSource>& field, double iso_world,
                    double max_error_world, const Front& front);

/// Sets what was chosen in a scene of one mesh or field.
void apply(const Promise& promise, SceneFile& scene);
/// By what the scene's one object is.
/// throws  UsageError if it has several, or none of a field
Promise promise_for(const SceneFile& scene, double max_error_world, const Front& front,
                    const Progress& progress);

} // namespace isocast
