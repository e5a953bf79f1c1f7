// SPDX-License-Identifier: MPL-2.0
#include "raycaster/curved_points.h"

#include "filtering/curvature.h"
#include "filtering/filter.h"
#include "filtering/reconstruct.h"
#include "filtering/smoothed_field.h"
#include "quadrics/scatter.h"
#include "volume/errors.h"
#include "volume/isosurface_mesh.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <numeric>

namespace isocast {

namespace {

/// A function of index space, derived in world space.
struct Reconstructed {
    std::shared_ptr<const FieldSource> control;
    Kernel kernel;

    Jet jet(const Vec3d& p_world) const {
        const GridSpace& space = control->space();
        const Jet at = kernel_jet(*control, space.to_index(p_world), kernel);
        return {at.value, space.gradient_to_world(at.gradient), space.hessian_to_world(at.hessian)};
    }
};

double area_of(const IsosurfaceMesh& mesh) {
    return std::transform_reduce(
        mesh.triangles.begin(), mesh.triangles.end(), 0.0, std::plus<>(),
        [&](const Eigen::Vector3i& triangle) {
            const auto at = [&](int corner) {
                return mesh.vertices_world[static_cast<std::size_t>(triangle[corner])];
            };
            return (at(1) - at(0)).cross(at(2) - at(0)).norm() / 2;
        });
}

/// The isosurface's point on the way down the gradient from `p_world`, if it is near.
std::optional<Vec3d> on_surface(const Reconstructed& function, double iso_world, Vec3d p_world) {
    const double voxel = function.control->space().voxel_size_world();
    // From within a voxel where the function is nearly linear; 16 for what is not.
    for (int step = 0; step < 16; ++step) {
        const Jet jet = function.jet(p_world);
        const double slope = jet.gradient.norm();
        if (!(slope > 0)) return std::nullopt;
        const double away = (jet.value - iso_world) / slope;
        if (std::abs(away) < 1e-4 * voxel) return p_world;
        p_world -= jet.gradient / slope * std::clamp(away, -voxel, voxel);
    }
    return std::nullopt;
}

} // namespace

CurvedPoints curved_points(const FieldObject& object, std::size_t count, std::uint64_t seed,
                           double curvature_scale_voxels, const Progress& progress) {
    const auto function_of = [&](std::shared_ptr<const FieldSource> samples, Filter filter) {
        return Reconstructed{control_samples(std::move(samples), filter, progress),
                             kernel_of(filter)};
    };
    const IsosurfaceMesh mesh = isosurface_mesh(*object.field, object.iso_world);
    const std::vector<SurfacePoint> scattered =
        scatter(mesh.vertices_world, mesh.triangles, count, seed);
    if (scattered.empty())
        throw InputError(fmt::format("there is no surface at iso value {}", object.iso_world));
    const Filter derivative_filter = object.derivative_filter.value_or(object.filter);
    const Reconstructed values = function_of(object.field, object.filter);
    const Reconstructed normals =
        derivative_filter == object.filter ? values : function_of(object.field, derivative_filter);
    const Reconstructed curvatures =
        curvature_scale_voxels == 0
            ? normals
            : function_of(std::make_shared<SmoothedField>(object.field, curvature_scale_voxels),
                          derivative_filter);

    std::vector<std::optional<CurvedPoint>> found(scattered.size());
    tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t i) {
        const auto p_world = on_surface(values, object.iso_world, scattered[i].position_world);
        if (!p_world) return;
        const Jet bend = curvatures.jet(*p_world);
        const Curvatures k = principal_curvatures(bend.gradient, bend.hessian);
        found[i] = {*p_world, normals.jet(*p_world).gradient.normalized(), k.k1, k.k2,
                    k.direction1};
    });
    CurvedPoints out{.spacing_world =
                         std::sqrt(2 * area_of(mesh) / (std::sqrt(3) * double(count)))};
    for (const std::optional<CurvedPoint>& point : found)
        point ? out.points.push_back(*point) : void(++out.lost);
    return out;
}

} // namespace isocast
