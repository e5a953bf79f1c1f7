// SPDX-License-Identifier: MPL-2.0
#include "apps/points_input.h"

#include "apps/parsed_option.h"
#include "distance_transform/sample_meshes.h"
#include "volume/errors.h"

#include <fmt/format.h>

namespace isocast {

void add_point_options(CLI::App& app, MeshlessOptions& options) {
    add_parsed(app, "--neighbours", options.neighbours, integer_from,
               "Of --method points: how many points a place looks at (default 20)")
        ->type_name("K");
    add_parsed(app, "--point-method", options.method, point_method_from_name,
               "Of --method points: partition (default), printed (as in the thesis), shepard, "
               "modified-shepard, rbf, mls")
        ->type_name("METHOD");
    add_parsed(app, "--approximation", options.approximation, number_from,
               "Of --method points: 0 (default) passes through the points, more evens noise out")
        ->type_name("A");
}

CheckedPoints read_checked_points(const Input& input, int neighbours) {
    const PointCloud cloud = input.kind == Input::Kind::SampleMesh
                                 ? vertices_of(check(sample_mesh(input.name)))
                                 : read_cloud(input.name);
    try {
        return check(cloud, neighbours);
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", input.text, error.what()));
    }
}

ConvertReport::Points report_of(const CheckedPoints& points, const MeshlessOptions& options) {
    return {.count = points.cloud.points_world.size(),
            .normals_given = points.normals_given,
            .median_spacing_world = points.median_spacing_world,
            .meshless = options};
}

} // namespace isocast
