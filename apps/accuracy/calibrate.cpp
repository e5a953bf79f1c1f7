// SPDX-License-Identifier: MPL-2.0
#include "apps/accuracy/calibrate.h"

#include "distance_transform/convert.h"

#include <fmt/format.h>

namespace isocast {

namespace {

/// As promise_for() probes it.
double probed(const Input& input, Filter filter, int resolution, double& voxel_world) {
    if (!input.is_mesh()) {
        const AnalyticField field = builtin_field(input.name);
        const auto samples = sampled(field, resolution);
        voxel_world = samples->space().voxel_size_world();
        return probe(*samples, 0, filter, surface_points(field, probe_point_count));
    }
    const CheckedMesh mesh = read_checked_mesh(input);
    voxel_world = voxel_size_for_resolution(bounding_box(mesh.mesh), resolution);
    const ConvertResult result = convert(mesh, {.voxel_size_world = voxel_world});
    return probe(result.field, 0, filter, surface_points(mesh.mesh, probe_point_count));
}

std::vector<FrontPoint> measured(const std::vector<std::string>& inputs,
                                 const std::vector<int>& resolutions, StudyOptions options,
                                 gl::Context& context, Renderer& renderer, int rounds,
                                 const Progress& progress) {
    std::vector<FrontPoint> points;
    for (const Filter filter : front_filters)
        for (const int resolution : resolutions) points.push_back({filter, resolution});
    std::vector<std::vector<double>> seconds(points.size());
    for (std::size_t i = 0; i < inputs.size(); ++i) {
        options.input = inputs[i];
        Study study(options, context, renderer, progress);
        for (int round = 0; round <= rounds; ++round) {
            study.new_round();
            for (std::size_t p = 0; p < points.size(); ++p) {
                progress(inputs[i],
                         (double(i) + double(round) / (rounds + 1)) / double(inputs.size()));
                FrontPoint& point = points[p];
                const Setting setting{{"filter", std::string(filter_name(point.filter))},
                                      {"resolution", std::to_string(point.resolution)}};
                if (round > 0) {
                    double sum = 0;
                    for (const auto& [part, taken] : study.seconds_at(setting)) sum += taken;
                    seconds[p].push_back(sum);
                    continue;
                }
                // The first one compiles programs: it is not timed.
                double voxel_world = 0;
                const double error =
                    probed(study.input(), point.filter, point.resolution, voxel_world);
                const double off = study.errors_at(setting).at("surface").max -
                                   hit_error_voxels(point.resolution) * voxel_world;
                if (error > 0) point.ratio = std::max(point.ratio, off / error);
            }
        }
    }
    for (std::size_t p = 0; p < points.size(); ++p) points[p].seconds = median(seconds[p]);
    return points;
}

} // namespace

Front calibrated(const StudyOptions& options, gl::Context& context, Renderer& renderer, int rounds,
                 const Progress& progress) {
    const auto measure = [&](const std::vector<std::string>& inputs,
                             const std::vector<int>& resolutions) {
        return measured(inputs, resolutions, options, context, renderer, rounds, progress);
    };
    return {own_front_path(),
            measure({"mesh:knot", "mesh:seashell", "mesh:torus"}, {16, 32, 64, 128, 256}),
            measure({"field:sphere@32", "field:torus@32", "field:gyroid@32", "field:saddle@32",
                     "field:cube@32"},
                    {16, 32, 64, 128})};
}

} // namespace isocast
