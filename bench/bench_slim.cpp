// SLIM surfaces beside meshes simplified by edge collapse: how many primitives each takes for one
// error, and how exact its normals are.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/checked_mesh.h"
#include "distance_transform/mesh_files.h"
#include "distance_transform/point_cloud.h"
#include "quadrics/slim_cover.h"
#include "slim/edge_collapse.h"

#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/subdivision_method_3.h>
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <random>
#include <string>

namespace {

using namespace isocast;
using Kernel = CGAL::Simple_cartesian<double>;
using Surface = CollapsibleMesh;
using Tree =
    CGAL::AABB_tree<CGAL::AABB_traits<Kernel, CGAL::AABB_face_graph_triangle_primitive<Surface>>>;

constexpr double pi = std::numbers::pi;

/// A mesh and, at its vertices, the normals of the surface that it samples.
struct Shape {
    std::string name;
    TriangleMesh mesh;
    std::vector<Vec3d> normals;
    std::vector<double> mean_curvatures; // if known, per world unit
    double diagonal_world = 0;
};

/// At the shape's vertices: distances to an approximation, and angles with its normals; of SLIM
/// surfaces, what its mean curvatures are off by, by their RMS.
struct Errors {
    double rms_world = 0, greatest_world = 0;
    double rms_degrees = 0, rms_face_degrees = 0; // interpolated from vertices; of faces
    double rms_curvature = 0;
};

double degrees_between(const Vec3d& a, const Vec3d& b) {
    return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / pi;
}

struct Off {
    double world = 0, degrees = 0, face_degrees = 0, curvature = 0;
};
template<class At>
Errors errors_of(const Shape& shape, const At& at) {
    const std::size_t count = shape.mesh.vertices_world.size();
    std::vector<Off> off(count);
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) { off[i] = at(i); });
    Errors sum;
    for (const Off& one : off) {
        sum.rms_world += one.world * one.world;
        sum.greatest_world = std::max(sum.greatest_world, one.world);
        sum.rms_degrees += one.degrees * one.degrees;
        sum.rms_face_degrees += one.face_degrees * one.face_degrees;
        sum.rms_curvature += one.curvature * one.curvature;
    }
    for (double* of : {&sum.rms_world, &sum.rms_degrees, &sum.rms_face_degrees, &sum.rms_curvature})
        *of = std::sqrt(*of / static_cast<double>(count));
    if (shape.mean_curvatures.empty()) return sum;
    double squares = 0;
    for (const double h : shape.mean_curvatures) squares += h * h;
    sum.rms_curvature /= std::sqrt(squares / static_cast<double>(count));
    return sum;
}

/// Of the blend of patches within twice their errors, as pictures have it; by f / |grad f|.
Errors errors_of(const Shape& shape, const SlimLevel& level) {
    std::vector<SlimQuadric> quadrics;
    for (const SlimPatch& patch : level.patches) quadrics.push_back(slim_quadric(patch));
    return errors_of(shape, [&](std::size_t v) {
        double off = 0;
        double weight = 0;
        Vec3d normal = Vec3d::Zero();
        Mat3d bend = Mat3d::Zero();
        for (std::size_t i = 0; i < quadrics.size(); ++i) {
            const SlimPatch& patch = level.patches[i];
            const Vec3d p = shape.mesh.vertices_world[v] - patch.centre_world;
            if (p.squaredNorm() >= patch.radius_world * patch.radius_world) continue;
            const SlimQuadric& f = quadrics[i];
            const Vec3d gradient = 2 * (f.a * p + f.b);
            const double distance = (p.dot(f.a * p + 2 * f.b) + f.c) / gradient.norm();
            if (std::abs(distance) > 2 * patch.errors * level.max_error_world ||
                !is_kept(patch, p) || gradient.dot(shape.normals[v]) < 0)
                continue;
            const double w = slim_weight(p.norm() / patch.radius_world);
            off += w * distance;
            normal += w * gradient.normalized();
            bend += 2 * w / gradient.norm() * f.a;
            weight += w;
        }
        if (weight == 0) return Off{};
        const Vec3d n = normal.normalized();
        // Goldman, Curvature formulas for implicit curves and surfaces, 2005
        const double mean = (bend.trace() - n.dot(bend * n)) / (2 * weight);
        return Off{std::abs(off / weight), degrees_between(normal, shape.normals[v]), 0,
                   shape.mean_curvatures.empty() ? 0 : mean - shape.mean_curvatures[v]};
    });
}

Vec3d vec(const Kernel::Point_3& p) {
    return {p.x(), p.y(), p.z()};
}

Errors errors_of(const Shape& shape, const Surface& mesh) {
    std::vector<Vec3d> face_normals(mesh.num_faces());
    std::vector<Vec3d> vertex_normals(mesh.num_vertices(), Vec3d::Zero());
    std::vector<std::array<std::size_t, 3>> corners(mesh.num_faces());
    for (const auto face : mesh.faces()) {
        std::size_t k = 0;
        for (const auto v : mesh.vertices_around_face(mesh.halfedge(face)))
            corners[face][k++] = static_cast<std::size_t>(v);
        const auto at = [&](std::size_t corner) {
            return vec(mesh.point(
                Surface::Vertex_index(static_cast<Surface::size_type>(corners[face][corner % 3]))));
        };
        const Vec3d n = (at(1) - at(0)).cross(at(2) - at(0));
        face_normals[face] = n;
        for (k = 0; k < 3; ++k) {
            const Vec3d a = at(k + 1) - at(k);
            const Vec3d b = at(k + 2) - at(k);
            vertex_normals[corners[face][k]] +=
                std::atan2(a.cross(b).norm(), a.dot(b)) * n.normalized();
        }
    }
    for (Vec3d& n : vertex_normals) n.normalize();
    Tree tree(faces(mesh).begin(), faces(mesh).end(), mesh);
    tree.accelerate_distance_queries();
    return errors_of(shape, [&](std::size_t v) {
        const Vec3d& p = shape.mesh.vertices_world[v];
        const auto [closest, face] = tree.closest_point_and_primitive({p.x(), p.y(), p.z()});
        const Vec3d q = vec(closest);
        Vec3d interpolated = Vec3d::Zero();
        for (std::size_t k = 0; k < 3; ++k) {
            const auto at = [&](std::size_t corner) {
                return vec(mesh.point(Surface::Vertex_index(
                    static_cast<Surface::size_type>(corners[face][(k + corner) % 3]))));
            };
            const double share = (at(1) - q).cross(at(2) - q).dot(face_normals[face]);
            interpolated += share * vertex_normals[corners[face][k]];
        }
        return Off{(p - q).norm(), degrees_between(interpolated, shape.normals[v]),
                   degrees_between(face_normals[face], shape.normals[v])};
    });
}

struct Simplified {
    double triangles = 0;
    Errors errors;
};
/// Edges collapsed by Lindstrom and Turk's cost and placement, on and on.
std::vector<Simplified> simplified(const Shape& shape) {
    Surface mesh = collapsible(shape.mesh);
    if (const std::size_t lost = shape.mesh.triangles.size() - mesh.num_faces(); lost > 0)
        fmt::print("  {} triangles are not manifold\n", lost);
    std::vector<Simplified> all;
    for (double share = 0.71; mesh.num_faces() > 150; share *= 0.71) {
        const auto edges = static_cast<std::size_t>(
            1.5 * share * static_cast<double>(shape.mesh.triangles.size()));
        collapse_edges(mesh, edges);
        all.push_back({static_cast<double>(mesh.num_faces()), errors_of(shape, mesh)});
        if (static_cast<double>(mesh.num_edges()) > 1.1 * static_cast<double>(edges)) break;
    }
    return all;
}

/// Between the two with errors on either side, by powers; nothing beyond all.
template<class Error>
std::optional<Simplified> at_error(const std::vector<Simplified>& all, double error_world,
                                   const Error& error) {
    for (std::size_t i = 1; i < all.size(); ++i) {
        const double a = error(all[i - 1].errors);
        const double b = error(all[i].errors);
        if (!(a <= error_world && error_world < b)) continue;
        const double s = std::log(error_world / a) / std::log(b / a);
        const auto between = [&](double from, double to) { return from * std::pow(to / from, s); };
        Simplified out{between(all[i - 1].triangles, all[i].triangles), all[i].errors};
        const Errors& one = all[i - 1].errors;
        out.errors.rms_degrees = between(one.rms_degrees, out.errors.rms_degrees);
        out.errors.rms_face_degrees = between(one.rms_face_degrees, out.errors.rms_face_degrees);
        return out;
    }
    return std::nullopt;
}

void compare(const Shape& shape) {
    fmt::print("{}: {} triangles; lengths by the box's diagonal, normals RMS in degrees\n",
               shape.name, shape.mesh.triangles.size());
    const std::vector<Simplified> meshes = simplified(shape);
    for (const double share : {1e-3, 3e-4, 1e-4}) {
        std::vector<SlimReport> reports;
        const SlimSurface surface =
            slim_of(shape.mesh, {.max_error_world = share * shape.diagonal_world, .max_levels = 1},
                    reports);
        const Errors slim = errors_of(shape, surface.levels.front());
        const auto patches = static_cast<double>(surface.patch_count());
        fmt::print("  SLIM for {:.0e}: {} patches, {:.1f} s; RMS {:.2g}, greatest {:.2g}, "
                   "normals {:.3f}",
                   share, patches, reports.front().seconds, slim.rms_world / shape.diagonal_world,
                   slim.greatest_world / shape.diagonal_world, slim.rms_degrees);
        if (!shape.mean_curvatures.empty())
            fmt::print(", mean curvatures {:.2g}", slim.rms_curvature);
        fmt::print("\n");
        for (const bool is_rms : {true, false}) {
            const auto error = [&](const Errors& e) {
                return is_rms ? e.rms_world : e.greatest_world;
            };
            const auto mesh = at_error(meshes, error(slim), error);
            if (!mesh)
                fmt::print("    no simplified mesh has its {}\n", is_rms ? "RMS" : "greatest");
            else
                fmt::print("    a mesh of its {}: {:.0f} triangles, {:.2f} a patch; normals {:.3f} "
                           "interpolated, {:.3f} of faces\n",
                           is_rms ? "RMS" : "greatest", mesh->triangles, mesh->triangles / patches,
                           mesh->errors.rms_degrees, mesh->errors.rms_face_degrees);
        }
    }
}

Shape finished(Shape shape) {
    Eigen::AlignedBox3d box;
    for (const Vec3d& p : shape.mesh.vertices_world) box.extend(p);
    shape.diagonal_world = box.diagonal().norm();
    return shape;
}

/// How far places of the pieces are off the flat triangles, by the error.
std::vector<double> off_pieces(const SlimLevel& level, const Tree& tree) {
    const std::size_t places = std::max<std::size_t>(1, 100000 / level.patches.size());
    std::vector<std::vector<double>> off(level.patches.size());
    tbb::parallel_for(std::size_t{0}, off.size(), [&](std::size_t i) {
        const SlimPatch& patch = level.patches[i];
        std::mt19937_64 random(i);
        std::uniform_real_distribution<> within(-patch.radius_world, patch.radius_world);
        for (std::size_t k = 0; k < places; ++k) {
            const double u = within(random);
            const double v = within(random);
            const Vec3d d = slim_axes(patch.normal) * Vec3d(u, v, height_at(patch, u, v));
            if (d.norm() >= patch.radius_world || !is_kept(patch, d)) continue;
            const Vec3d p = patch.centre_world + d;
            off[i].push_back(std::sqrt(tree.squared_distance({p.x(), p.y(), p.z()})) /
                             level.max_error_world);
        }
    });
    std::vector<double> all;
    for (const std::vector<double>& one : off) all.insert(all.end(), one.begin(), one.end());
    std::ranges::sort(all);
    return all;
}

/// Rays against the normals of random points of the flat triangles: whether any passes between
/// pieces, and how far all hits are off these triangles.
void cast_rays(const Shape& shape) {
    const Surface mesh = collapsible(shape.mesh);
    Tree tree(faces(mesh).begin(), faces(mesh).end(), mesh);
    tree.accelerate_distance_queries();
    fmt::print(
        "{}: error, patches, cut by planes, off by more; s; rays missed, hits; off, by the "
        "error: median, 99 %, greatest, above 1; of places of the pieces: 99 %, 99.9 %, greatest\n",
        shape.name);
    for (const double share : {1e-3, 1e-4}) {
        const double error = share * shape.diagonal_world;
        std::vector<SlimReport> reports;
        const SlimSurface surface = slim_of(shape.mesh, {.max_error_world = error}, reports);
        double seconds = 0;
        for (const SlimReport& report : reports) seconds += report.seconds;
        constexpr std::size_t count = 1000;
        const double reach = 20 * error; // triangles bow by up to ten at fine errors
        std::vector<std::vector<double>> off(count);
        tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
            std::mt19937_64 random(i);
            const auto some = [&] { return std::uniform_real_distribution<>(0, 1)(random); };
            const auto& corners = shape.mesh.triangles[random() % shape.mesh.triangles.size()];
            const auto at = [&](std::size_t k) -> const Vec3d& {
                return shape.mesh.vertices_world[static_cast<std::size_t>(corners[k])];
            };
            const double u = std::sqrt(some());
            const double v = some();
            const Vec3d p = (1 - u) * at(0) + u * ((1 - v) * at(1) + v * at(2));
            const Vec3d n = (at(1) - at(0)).cross(at(2) - at(0)).normalized();
            for (const SlimPatch& patch : surface.levels.front().patches)
                for (const SlimHit& hit : intersect(patch, p + reach * n, -n, true)) {
                    if (hit.t > 2 * reach) continue;
                    const Vec3d q = p + (reach - hit.t) * n;
                    off[i].push_back(std::sqrt(tree.squared_distance({q.x(), q.y(), q.z()})) /
                                     error);
                }
        });
        std::vector<double> all;
        for (const std::vector<double>& one : off) all.insert(all.end(), one.begin(), one.end());
        std::ranges::sort(all);
        const std::vector<double> back = off_pieces(surface.levels.front(), tree);
        fmt::print("{:.0e} {} {} {} {:.1f} {} {} {:.3f} {:.1f} {:.1f} {}; {:.1f} {:.1f} {:.1f}\n",
                   share, surface.levels.front().patches.size(), reports.front().with_planes,
                   reports.front().over_bound, seconds,
                   std::ranges::count_if(off, &std::vector<double>::empty), all.size(),
                   all[all.size() / 2], all[all.size() * 99 / 100], all.back(),
                   std::ranges::count_if(all, [](double d) { return d > 1; }),
                   back[back.size() * 99 / 100], back[back.size() * 999 / 1000], back.back());
    }
}

/// A grid that wraps around in i, and in j unless it has poles.
Shape torus() {
    Shape shape{.name = "torus"};
    const int n = 400;
    const int m = 140;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < m; ++j) {
            const double a = 2 * pi * i / n;
            const double b = 2 * pi * (j + 0.5 * (i % 2)) / m;
            const Vec3d out(std::cos(a), std::sin(a), 0);
            shape.normals.push_back(std::cos(b) * out + std::sin(b) * Vec3d::UnitZ());
            shape.mesh.vertices_world.push_back(out + 0.4 * shape.normals.back());
            shape.mean_curvatures.push_back((1 + 0.8 * std::cos(b)) /
                                            (0.8 * (1 + 0.4 * std::cos(b))));
            const auto at = [&](int x, int y) { return (x % n) * m + (y + m) % m; };
            const int skew = i % 2;
            shape.mesh.triangles.push_back({at(i, j), at(i + 1, j + skew), at(i, j + 1)});
            shape.mesh.triangles.push_back(
                {at(i, j + 1), at(i + 1, j + skew), at(i + 1, j + 1 + skew)});
        }
    return finished(std::move(shape));
}

Shape sphere() { // an octahedron's faces in 112^2 triangles
    Shape shape{.name = "sphere"};
    const int n = 112;
    std::map<std::array<int, 3>, int> numbers;
    const auto vertex = [&](int x, int y, int z) {
        const auto [at, is_new] =
            numbers.try_emplace({x, y, z}, static_cast<int>(shape.normals.size()));
        if (is_new) {
            shape.normals.push_back(Vec3d(x, y, z).normalized());
            shape.mean_curvatures.push_back(1);
            shape.mesh.vertices_world.push_back(shape.normals.back());
        }
        return at->second;
    };
    for (int face = 0; face < 8; ++face) {
        const int sx = face & 1 ? -1 : 1;
        const int sy = face & 2 ? -1 : 1;
        const int sz = face & 4 ? -1 : 1;
        const auto at = [&](int x, int y) { return vertex(sx * x, sy * y, sz * (n - x - y)); };
        const auto add = [&](int a, int b, int c) {
            if (sx * sy * sz < 0) std::swap(b, c);
            shape.mesh.triangles.push_back({a, b, c});
        };
        for (int x = 0; x < n; ++x)
            for (int y = 0; x + y < n; ++y) {
                add(at(x, y), at(x + 1, y), at(x, y + 1));
                if (x + y + 1 < n) add(at(x + 1, y), at(x + 1, y + 1), at(x, y + 1));
            }
    }
    return finished(std::move(shape));
}

/// By the angles of the faces at each vertex.
Shape with_normals(std::string name, const Mesh& mesh) {
    const CheckedMesh read = check(mesh);
    return finished(
        {.name = std::move(name),
         .mesh = {.vertices_world = read.mesh.vertices_world, .triangles = read.mesh.triangles},
         .normals = vertices_of(read).normals});
}

Shape scan(const std::string& path) {
    return with_normals(path, read_mesh(path));
}

/// What a scan would be without its noise: few of its triangles, rounded off again by Loop's
/// subdivision, which has curvatures everywhere but at a few vertices.
Shape rounded(const Shape& shape) {
    constexpr std::size_t triangles = 4000;
    Surface mesh = collapsible(shape.mesh);
    collapse_edges(mesh, 3 * triangles / 2);
    CGAL::Subdivision_method_3::Loop_subdivision(mesh, CGAL::parameters::number_of_iterations(3));
    return with_normals(shape.name + ", rounded", mesh_of(mesh));
}

} // namespace

/// bench_slim [MESH...]; bench_slim rays MESH...
int main(int argc, char** argv) {
    const bool casts = argc > 1 && std::string(argv[1]) == "rays";
    if (!casts) {
        compare(sphere());
        compare(torus());
    }
    for (int i = casts ? 2 : 1; i < argc; ++i)
        if (const Shape shape = scan(argv[i]); casts) {
            cast_rays(shape);
        } else {
            compare(shape);
            compare(rounded(shape));
        }
}
