// SPDX-License-Identifier: MPL-2.0
#include "raycaster/splats_on_gpu.h"

#include <algorithm>

namespace isocast {

namespace {

SplatView view_of(const Camera& camera, int width, int height, const PicturePart& part,
                  double detail_pixels, const std::vector<CutPlane>& planes,
                  const SplatStudy& study) {
    return {.space = picture_space(camera),
            .pixels_per_unit = pixels_per_unit(camera, height),
            .middle_pixels = Eigen::Vector2d(width, height) / 2 - part.first_pixel(height),
            .width = part.width,
            .height = part.height,
            .detail_pixels = detail_pixels,
            .planes = planes,
            .shape = study.shape};
}

/// The tiles that any of the boxes touches.
std::vector<Eigen::Vector4i> runs_of(const std::vector<PixelBox>& boxes, const PicturePart& part) {
    const int columns = tiles_along(part.width);
    const int rows = tiles_along(part.height);
    // How many boxes there are more than to the left, and than below: sums over both axes count.
    const auto stride = static_cast<std::size_t>(columns) + 1;
    std::vector<int> counts(stride * (static_cast<std::size_t>(rows) + 1), 0);
    const auto tile_at = [](float pixel, int tiles) {
        const float tile = std::floor(pixel / tile_pixels);
        return static_cast<int>(std::clamp(tile, 0.0F, static_cast<float>(tiles)));
    };
    for (const PixelBox& box : boxes) {
        // A rectangle's margin, and more, since boxes of spheres come without it.
        const int x_lo = tile_at(box.x_lo - 1, columns);
        const int x_hi = tile_at(box.x_hi + 1 + tile_pixels, columns);
        const int y_lo = tile_at(box.y_lo - 1, rows);
        const int y_hi = tile_at(box.y_hi + 1 + tile_pixels, rows);
        const auto at = [&](int x, int y) -> int& {
            return counts[static_cast<std::size_t>(x) + stride * static_cast<std::size_t>(y)];
        };
        ++at(x_lo, y_lo);
        --at(x_hi, y_lo);
        --at(x_lo, y_hi);
        ++at(x_hi, y_hi);
    }
    for (std::size_t y = 0; y <= static_cast<std::size_t>(rows); ++y)
        for (std::size_t x = 1; x < stride; ++x)
            counts[x + stride * y] += counts[x - 1 + stride * y];
    for (std::size_t i = stride; i < counts.size(); ++i) counts[i] += counts[i - stride];
    return runs_of_tiles(part.width, part.height, [&](std::size_t tile) {
        const auto width = static_cast<std::size_t>(columns);
        return counts[tile % width + stride * (tile / width)] > 0;
    });
}

bool have_half_colours(const Primitives& primitives) {
    return std::ranges::any_of(primitives.cylinders,
                               [](const Cylinder& stick) { return stick.colour_b.has_value(); });
}

/// By the numbers of splats_of(), and then, if any stick has two, of the halves at b of cylinders
/// and cones.
std::vector<Eigen::Vector4f> colours_of(const Primitives& primitives) {
    std::vector<Eigen::Vector4f> colours;
    const auto add = [&](const Vec3d& colour) {
        colours.emplace_back(float(colour.x()), float(colour.y()), float(colour.z()), 1.0F);
    };
    for_each_kind(primitives, [&](const auto& some) {
        for (const auto& one : some) add(one.colour);
    });
    for_each_mesh(primitives, [&](const auto& mesh) { add(mesh.colour); });
    if (!have_half_colours(primitives)) return colours;
    for (const Cylinder& stick : primitives.cylinders) add(stick.colour_b.value_or(stick.colour));
    for (const Cone& cone : primitives.cones) add(cone.colour);
    return colours;
}

/// Three a triangle; none unless a mesh has some.
std::vector<Eigen::Vector4f> normals_of(const Primitives& primitives) {
    std::vector<Eigen::Vector4f> normals;
    if (std::ranges::all_of(primitives.meshes,
                            [](const TriangleMesh& mesh) { return mesh.normals_world.empty(); }))
        return normals;
    normals.reserve(3 * primitives.triangle_count());
    for (const TriangleMesh& mesh : primitives.meshes)
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
            for (const Eigen::Vector3f& normal : corner_normals_of(mesh, i))
                normals.emplace_back(normal.x(), normal.y(), normal.z(), 0.0F);
    return normals;
}

} // namespace

RectanglesOnGpu::RectanglesOnGpu(std::size_t at_most)
    : count(static_cast<int>(std::min(at_most, std::size_t{1} << 14))) {
    std::vector<std::uint16_t> order;
    order.reserve(6 * static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i)
        for (const int corner : {0, 1, 2, 2, 1, 3})
            order.push_back(static_cast<std::uint16_t>(4 * i + corner));
    indices = {std::as_bytes(std::span(order)), "rectangles"};
    array = gl::VertexArray::indexed(indices, "rectangles");
}

PrimitivesOnGpu::PrimitivesOnGpu(const Primitives& primitives)
    : first_slim(static_cast<int>(primitives.solid_count() + primitives.mesh_count() -
                                  primitives.slims.size())),
      are_sticks(primitives.cones.empty() &&
                 std::ranges::none_of(primitives.cylinders, &Cylinder::is_capped)) {
    // Meshes of triangles have none.
    if (const std::size_t drawn = primitives.count() - primitives.triangle_count(); drawn > 0)
        rectangles = RectanglesOnGpu(drawn);
    const std::vector<Eigen::Vector4f> all_colours = colours_of(primitives);
    colours = {std::as_bytes(std::span(all_colours)), gl::Format::Rgba32f, "colours of primitives"};
    if (have_half_colours(primitives)) // those of halves follow all others, from the first stick on
        to_half_colours =
            static_cast<int>(primitives.solid_count() + primitives.mesh_count() -
                             primitives.spheres.size() - primitives.ellipsoids.size());
    if (const auto normals = normals_of(primitives); !normals.empty())
        triangle_normals = {std::as_bytes(std::span(normals)), gl::Format::Rgba32f,
                            "normals of triangles"};
}

PictureSpace picture_space(const Camera& camera) {
    return {.eye_world = camera.eye_world,
            .view_from_world = camera.view_from_world_rotation(),
            .is_perspective = camera.projection == Projection::Perspective};
}

double pixels_per_unit(const Camera& camera, int height) {
    return height / (2 * camera.half_height_at(1));
}

std::vector<CutPlane> planes_of(const Cut& cut, const Camera& viewer) {
    std::vector<CutPlane> planes = cut.planes;
    for (CutPlane& plane : planes) plane.normal.stableNormalize();
    if (cut.near_world) {
        const Vec3d back = viewer.view_from_world_rotation().row(2).transpose();
        planes.push_back({back, back.dot(viewer.eye_world) - *cut.near_world});
    }
    return planes;
}

SplatsOnGpu::SplatsOnGpu(const Primitives& primitives, std::vector<CutPlane> cut_planes,
                         const Camera& camera, int width, int height, const PicturePart& part,
                         double detail_pixels, const SplatStudy& asked)
    : planes(std::move(cut_planes)), study(asked) {
    const Splats splats =
        splats_of(primitives, view_of(camera, width, height, part, detail_pixels, planes, study));
    int slot = 0;
    for (std::size_t k = 0; k < splats.records.size(); ++k) {
        const std::vector<float>& records = splats.records[k];
        if (records.empty()) continue;
        OfKind& of_kind = kinds.emplace_back();
        of_kind.kind = static_cast<SplatKind>(k);
        of_kind.count = splats.count(of_kind.kind);
        of_kind.first_slot = slot;
        of_kind.records = {std::as_bytes(std::span(records)), gl::Format::Rgba32f, "splats"};
        of_kind.slot_count = of_kind.kind == SplatKind::Slim
                                 ? static_cast<int>(primitives.slims.size())
                                 : of_kind.count;
        slot += of_kind.slot_count;
        byte_count += of_kind.records.buffer.byte_count();
    }
    tile_runs = runs_of(splats.boxes, part);
    shows_slims_inside = splats.shows_slims_inside;
}

const SplatsOnGpu::OfKind* SplatsOnGpu::slim() const {
    const auto found = std::ranges::find(kinds, SplatKind::Slim, &OfKind::kind);
    return found == kinds.end() ? nullptr : &*found;
}

} // namespace isocast
