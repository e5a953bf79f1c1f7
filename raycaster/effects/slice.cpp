// SPDX-License-Identifier: MPL-2.0
#include "filtering/reconstruct.h"
#include "raycaster/effects/effects.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace isocast {

namespace {

const gl::ProgramKey slice_program{{"common/tiles.vert", "shading/slice/slice.frag"}, {}};

constexpr float none = 1e30F; // where there is no value

/// A square of the plane that holds the section of the field's extent.
struct Square {
    Vec3d normal;
    Vec3d u; // unit, in the plane, across each other
    Vec3d v;
    Vec3d first_world; // the middle of the first texel
    double texel_world;
    int texels; // along each side
};

Square square_of(const Slice& slice, const FieldSource& field) {
    Square square{.normal = slice.normal.normalized()};
    square.u = square.normal.unitOrthogonal();
    square.v = square.normal.cross(square.u);
    const std::array<Vec3d, 8> corners = corners_of(field.extent(), field.space());
    const Vec3d centre = 0.5 * (corners[0] + corners[7]);
    double radius_world = 0;
    for (const Vec3d& corner : corners)
        radius_world = std::max(radius_world, (corner - centre).norm());
    // Half a voxel; 768: what takes a fifth of a second to make.
    constexpr int most_texels = 768;
    square.texel_world =
        std::max(0.5 * field.space().voxel_size_world(), 2 * radius_world / (most_texels - 1));
    square.texels = static_cast<int>(std::ceil(2 * radius_world / square.texel_world)) + 1;
    const Vec3d middle = centre + (slice.offset_world - square.normal.dot(centre)) * square.normal;
    square.first_world =
        middle - 0.5 * (square.texels - 1) * square.texel_world * (square.u + square.v);
    return square;
}

/// The field's samples by Catmull-Rom's interpolation [world]; `none` beyond the extent.
gl::Texture texture_of(const Square& square, const FieldSource& field) {
    const int n = square.texels;
    const IndexBox extent = field.extent();
    std::vector<float> values(std::size_t(n) * std::size_t(n));
    tbb::parallel_for(0, n, [&](int row) {
        for (int column = 0; column < n; ++column) {
            const Vec3d p = field.space().to_index(
                square.first_world + square.texel_world * (column * square.u + row * square.v));
            const bool is_in = (p.array() >= extent.lo.cast<double>().array()).all() &&
                               (p.array() <= extent.hi.cast<double>().array() - 1).all();
            values[std::size_t(row) * std::size_t(n) + std::size_t(column)] =
                is_in ? static_cast<float>(kernel_value(field, p, Kernel::CatmullRom)) : none;
        }
    });
    gl::Texture texture =
        gl::Texture::volume(gl::Format::R32f, n, n, 1, gl::Filter::Nearest, "slice");
    texture.upload_box(0, 0, 0, n, n, 1, std::as_bytes(std::span(values)));
    return texture;
}

/// Where a pixel's ray meets the plane: of the affine maps from the place in the picture, rows x /
/// z and y / z are the place in the texture [texels], and the ray goes along the normal by z.
///
/// Of a ray start + s way, both affine: s = (offset - n . start) / (n . way). Of an eye the starts
/// are 0, of parallel rays the ways are constant, so that numerators are affine, too.
struct Meeting {
    Mat3d texel;
    Vec3d distance; // s times z
};

Meeting meeting_of(const Square& square, const FrameContext& frame) {
    const Camera& camera = frame.camera;
    const Mat3d way = world_vector_coefficients(camera, frame.width, frame.height);
    const Mat3d start = world_start_coefficients(camera, frame.width, frame.height);
    const Vec3d first = square.first_world - camera.eye_world;
    const Vec3d one(1, 0, 0); // as a map, of all places to 1
    const Vec3d along = way.transpose() * square.normal;
    Meeting meeting;
    meeting.distance = square.normal.dot(first) * one - start.transpose() * square.normal;
    const bool is_perspective = camera.projection == Projection::Perspective;
    const auto row = [&](const Vec3d& axis) -> Vec3d {
        const Vec3d at_start = start.transpose() * axis - axis.dot(first) * one;
        const Vec3d of_way = way.transpose() * axis;
        // Each product has one constant factor.
        const Vec3d numerator = is_perspective
                                    ? Vec3d(at_start[0] * along + meeting.distance[0] * of_way)
                                    : Vec3d(along[0] * at_start + of_way[0] * meeting.distance);
        return numerator / square.texel_world;
    };
    meeting.texel << row(square.u).transpose(), row(square.v).transpose(), along.transpose();
    return meeting;
}

} // namespace

void check_slice(const Slice& slice, std::span<const FieldObject> objects) {
    if (slice.strength == 0) return;
    if (objects.empty()) throw InputError("slice: there is no field");
    if (objects.front().field->is_adaptive()) throw InputError("slice: an octree has none");
    if (!(slice.normal.norm() > 0) || !slice.normal.allFinite())
        throw InputError("slice: its normal has no direction");
    for (const auto& [what, value] :
         {std::pair{"spacing", slice.spacing_world}, std::pair{"range", slice.range_world}})
        if (value && !(*value > 0 && std::isfinite(*value)))
            throw InputError(fmt::format("slice: its {} must be positive, not {}", what, *value));
}

double slice_spacing_world(const Slice& slice, const FieldSource& field) {
    if (slice.spacing_world) return *slice.spacing_world;
    const std::array<Vec3d, 8> corners = corners_of(field.extent(), field.space());
    // A third of the band: so that it has two lines on each side.
    const double about = std::min((corners[7] - corners[0]).norm() / 50,
                                  field.half_width_world().value_or(1e30) / 3);
    const double decade = std::pow(10, std::floor(std::log10(about)));
    return about < 2 * decade ? decade : about < 5 * decade ? 2 * decade : 5 * decade;
}

double slice_range_world(const Slice& slice, const FieldSource& field) {
    return slice.range_world.value_or(
        field.half_width_world().value_or(10 * slice_spacing_world(slice, field)));
}

void run_slice(FrameContext& frame) {
    const Slice& slice = frame.scene.look.effects.slice;
    if (frame.seen.objects.empty()) throw InputError("slice: there is no field");
    const FieldObject& object = frame.seen.objects.front().object;
    const Square square = square_of(slice, *object.field);
    const gl::Program& program = frame.shaders.program(slice_program);
    frame.targets.texture(FrameImage::Hit).bind_to_unit(0);
    frame.look_textures.texture("slice", [&] { return texture_of(square, *object.field); })
        .bind_to_unit(1);
    const Meeting meeting = meeting_of(square, frame);
    // So that they are near 1 in the middle of the picture: their quotients alone count.
    const Vec3d middle(1, 0.5 * frame.width, 0.5 * frame.height);
    const double size = std::max(std::abs(meeting.texel.row(2).dot(middle)), 1e-30);
    program.set("u_texel_from_pixel", Eigen::Matrix3f((meeting.texel / size).cast<float>()));
    program.set("u_distance", Eigen::Vector3f((meeting.distance / size).cast<float>()));
    const double offset = square.normal.dot(square.first_world - frame.camera.eye_world);
    program.set("u_plane", Eigen::Vector4f(float(square.normal.x()), float(square.normal.y()),
                                           float(square.normal.z()), float(offset)));
    // Of float's roundings of places, and of what a cut in the same plane is found to.
    program.set("u_tie", static_cast<float>(1e-5 * square.texels * square.texel_world +
                                            0x1p-20 * std::abs(offset)));
    program.set("u_iso", static_cast<float>(object.iso_world));
    program.set("u_spacing", static_cast<float>(slice_spacing_world(slice, *object.field)));
    program.set("u_range", static_cast<float>(slice_range_world(slice, *object.field)));
    program.set("u_paper", Eigen::Vector3f(slice_paper().cast<float>()));
    program.set("u_inside", Eigen::Vector3f(slice.inside.cast<float>()));
    program.set("u_outside", Eigen::Vector3f(slice.outside.cast<float>()));
    program.set("u_line", Eigen::Vector3f(slice.line.cast<float>()));
    draw_everywhere(frame, FrameImage::Slice, program);
}

std::vector<gl::ProgramKey> slice_programs() {
    return {slice_program};
}

} // namespace isocast
