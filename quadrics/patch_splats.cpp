// SPDX-License-Identifier: MPL-2.0
#include "quadrics/patch_splats.h"

#include "quadrics/hull_cover.h"

#include <algorithm>
#include <cmath>

namespace isocast {

namespace {

/// Where the segment p + s k, s from 0 to 1, is nearest to the origin.
double nearest_on(const Vec3d& p, const Vec3d& k) {
    const double length2 = k.squaredNorm();
    return length2 > 0 ? std::clamp(-p.dot(k) / length2, 0.0, 1.0) : 0.5;
}

void put_patch(const PatchFrame& frame, double number, Record& record) {
    record.put(frame.c, frame.base_u);
    record.put(frame.h, frame.base_v);
    record.put(frame.e, number);
    record.put(frame.d, 0);
}

/// Coefficients below 2, whose products keep within floats: by a power of 2, so that signs stay the
/// same on both sides of a face.
Eigen::Matrix4d scaled(const Eigen::Matrix4d& coefficients) {
    const double greatest = coefficients.cwiseAbs().maxCoeff();
    return greatest > 0 ? coefficients * std::exp2(-std::ilogb(greatest)) : coefficients;
}

std::array<Vec3d, 4> in_view(const Tetrahedron& tetrahedron, const PictureSpace& space) {
    std::array<Vec3d, 4> out;
    for (std::size_t k = 0; k < 4; ++k)
        out[k] = space.view_from_world * (tetrahedron.corners_world[k] - space.eye_world);
    return out;
}

/// Whether only the outside of a closed surface shows: it is in front of the eye, and nothing is
/// cut away.
bool shows_outside_only(const TetrahedralMesh& mesh, const SplatView& view) {
    const Vec3d axis = view.space.view_from_world.row(2);
    return mesh.is_closed && view.planes.empty() &&
           std::ranges::all_of(mesh.vertices_world, [&](const Vec3d& p) {
               return axis.dot(p - view.space.eye_world) < 0;
           });
}

/// Whether the function grows all along every ray, which then leaves what is inside and never
/// enters it. Along the ray to p the slope is g . p, a quadratic function of p since the gradient g
/// is linear, and positive if its Bernstein-Bézier coefficients are; along parallel rays it is
/// linear.
///
/// source  Stoll, Gumhold, Seidel 2007, 5.1.2: conservative culling; but by the polar form
bool faces_away(const Tetrahedron& tetrahedron, const PictureSpace& space) {
    const std::array<Vec3d, 4> p = in_view(tetrahedron, space);
    const Eigen::Matrix<double, 3, 4> g = space.view_from_world *
                                          tetrahedron.barycentric_gradients() *
                                          tetrahedron.coefficients; // half gradients at corners
    for (int k = 0; k < 4; ++k) {
        if (!space.is_perspective) {
            if (!(g(2, k) < 0)) return false;
            continue;
        }
        for (int l = k; l < 4; ++l)
            if (!(g.col(k).dot(p[static_cast<std::size_t>(l)]) +
                      g.col(l).dot(p[static_cast<std::size_t>(k)]) >
                  0))
                return false;
    }
    return true;
}

} // namespace

PatchFrame frame_of(const Patch& patch, const PictureSpace& space) {
    Patch seen = patch;
    for (Vec3d& corner : seen.corners_world)
        corner = space.view_from_world * (corner - space.eye_world);
    Patch flat = seen;
    if (!space.is_perspective)
        for (Vec3d& corner : flat.corners_world) corner.z() = 0;
    PatchFrame frame{.base_u = 0.5, .base_v = 0.5};
    for (int round = 0; round < 4; ++round) { // about the nearest will do
        frame.base_v = nearest_on(flat.point(frame.base_u, 0), flat.along_v(frame.base_u));
        frame.base_u = nearest_on(flat.point(0, frame.base_v), flat.along_u(frame.base_v));
    }
    // As floats have it, so that edges lie where they belong.
    frame.base_u = static_cast<double>(static_cast<float>(frame.base_u));
    frame.base_v = static_cast<double>(static_cast<float>(frame.base_v));
    frame.c = seen.point(frame.base_u, frame.base_v);
    frame.h = seen.along_u(frame.base_v);
    frame.e = seen.along_v(frame.base_u);
    frame.d = seen.along_v(1) - seen.along_v(0);
    return frame;
}

void append_splats(const PatchMesh& mesh, std::size_t number, const SplatView& view,
                   Splats& splats) {
    append_hulls(
        SplatKind::Patch, mesh.quads.size(), number, view, splats,
        [&](std::size_t i) { return patch_of(mesh, i); }, is_without_area,
        [&](const Patch& patch, Record& record) {
            put_patch(frame_of(patch, view.space), 0, record);
        });
}

void append_splats(const TetrahedralMesh& mesh, std::size_t number, const SplatView& view,
                   Splats& splats) {
    const bool is_culled = shows_outside_only(mesh, view);
    append_hulls(
        SplatKind::Tetrahedron, mesh.tetrahedra.size(), number, view, splats,
        [&](std::size_t i) { return tetrahedron_of(mesh, i); },
        [&](const Tetrahedron& tetrahedron) {
            return is_without_volume(tetrahedron) ||
                   (is_culled && faces_away(tetrahedron, view.space));
        },
        [&](const Tetrahedron& tetrahedron, Record& record) {
            const std::array<Vec3d, 4> corners = in_view(tetrahedron, view.space);
            std::array<Vec3d, 4> seen = corners;
            if (!view.space.is_perspective)
                for (Vec3d& corner : seen) corner.z() = -1;
            const auto edge = [&](std::size_t k, std::size_t l) {
                // By their difference: far away corners alone are nearly parallel.
                return Vec3d(seen[k].cross(seen[l] - seen[k]));
            };
            const Eigen::Matrix4d c = scaled(tetrahedron.coefficients);
            const Eigen::Matrix<double, 3, 4> gradients =
                view.space.view_from_world * tetrahedron.barycentric_gradients();
            record.put(edge(0, 1), -corners[0].z());
            record.put(edge(0, 2), -corners[1].z());
            record.put(edge(0, 3), 0);
            record.put(edge(1, 2), -corners[2].z());
            record.put(edge(1, 3), -corners[3].z());
            record.put(edge(2, 3), c(0, 0));
            record.put({c(0, 1), c(0, 2), c(0, 3), c(1, 1)});
            record.put({c(1, 2), c(1, 3), c(2, 2), c(2, 3)});
            record.put(gradients.col(1), c(3, 3));
            record.put(gradients.col(2), 0);
            record.put(gradients.col(3), 0);
        });
}

void put_body(const Patch& patch, const PictureSpace& space, float* to) {
    Record record(to);
    put_patch(frame_of(patch, space), 0, record);
}

void put_body(const Tetrahedron& tetrahedron, const PictureSpace& space, float* to) {
    const std::array<Vec3d, 4> corners = in_view(tetrahedron, space);
    const Eigen::Matrix4d c = scaled(tetrahedron.coefficients);
    Record record(to);
    record.put(corners[0], c(0, 0));
    record.put(corners[1], c(1, 1));
    record.put(corners[2], c(2, 2));
    record.put(corners[3], c(3, 3));
    record.put({c(0, 1), c(0, 2), c(0, 3), c(1, 2)});
    record.put({c(1, 3), c(2, 3), 0, 0});
}

} // namespace isocast
