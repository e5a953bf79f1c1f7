// SPDX-License-Identifier: MPL-2.0
#include "raycaster/passes.h"

#include "gl/readback.h"

#include <Eigen/Eigenvalues>
#include <glad/gl.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

namespace isocast {

namespace {

const gl::ProgramKey blinn_phong_program{
    {"common/tiles.vert", "shading/blinn_phong/blinn_phong.frag"}, {}};

gl::ProgramKey field_program(const char* fragment_shader, const BrickPool& pool) {
    return {{"common/tiles.vert", fragment_shader}, pool.defines()};
}

/// Columns (constant, d/dx, d/dy) of the affine map from gl_FragCoord to view space at `depth` in
/// front of the eye; gl_FragCoord has its origin at the bottom left.
Mat3d view_point_coefficients(const Camera& camera, int width, int height, double depth) {
    const double half_height = camera.projection == Projection::Perspective
                                   ? depth * std::tan(camera.fov_y_degrees * std::numbers::pi / 360)
                                   : camera.height_world / 2;
    const double half_width = half_height * width / height;
    Mat3d columns;
    columns.col(0) = Vec3d(-half_width, -half_height, -depth);
    columns.col(1) = Vec3d(2 * half_width / width, 0, 0);
    columns.col(2) = Vec3d(0, 2 * half_height / height, 0);
    return columns;
}

/// The same for the vectors that lead from the rays' starts to those points.
Mat3d view_vector_coefficients(const Camera& camera, int width, int height, double depth) {
    Mat3d columns = view_point_coefficients(camera, width, height, depth);
    if (camera.projection == Projection::Orthographic) {
        columns.setZero();
        columns(2, 0) = -depth;
    }
    return columns;
}

RayCoefficients set_ray_uniforms(const gl::Program& program, const FrameContext& frame) {
    const RayCoefficients ray =
        ray_coefficients(frame.camera, frame.width, frame.height, frame.scene.field->space(),
                         frame.field.local_origin_index());
    program.set("u_ray_point", Eigen::Matrix3f(ray.point.cast<float>()));
    program.set("u_ray_vector", Eigen::Matrix3f(ray.vector.cast<float>()));
    return ray;
}

void set_fixed_state() {
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_CULL_FACE);
    glDisable(GL_BLEND);
}

/// Runs the program on every pixel that can show something, into the bound framebuffer.
void draw_on_tiles(const FrameContext& frame, const gl::Program& program) {
    set_fixed_state();
    frame.no_vertices.bind();
    frame.tiles.runs_texture.bind_to_unit(7);
    program.set("u_clip_from_tile",
                Eigen::Vector2f(2.0F * tile_pixels / static_cast<float>(frame.width),
                                2.0F * tile_pixels / static_cast<float>(frame.height)));
    program.use();
    glDrawArrays(GL_TRIANGLES, 0, 6 * frame.tiles.run_count);
}

/// The same into an image whose other pixels become `empty`.
void draw_tiles(const FrameContext& frame, FrameImage image, const gl::Program& program,
                const Eigen::Vector4f& empty) {
    frame.targets.framebuffer(image).bind();
    glClearBufferfv(GL_COLOR, 0, empty.data());
    draw_on_tiles(frame, program);
}

/// draw_tiles again and again, with the bricks loaded that pixels wait for, until none waits.
///
/// Every pass ends with the bricks in the pool that the first waiting pixels need, so each of them
/// gets at least one block further.
void draw_streamed(FrameContext& frame, FrameImage image, const gl::Program& program) {
    BrickPool& pool = frame.field.pool();
    gl::Texture progress =
        gl::Texture::image(gl::Format::R32i, frame.width, frame.height, "pixels' progress");
    progress.clear(-1); // shaders/raycast/stream.glsl: not_started
    const int block_count = frame.field.block_count();
    gl::ReadbackBuffer visits(std::int64_t{block_count} * 4, "visited blocks");
    frame.targets.framebuffer(image).bind();
    const Eigen::Vector4f empty = Eigen::Vector4f::Zero();
    glClearBufferfv(GL_COLOR, 0, empty.data());
    std::vector<int> used;
    std::vector<int> missing;
    do {
        visits.clear();
        visits.bind_to_storage(0);
        progress.bind_as_image(0);
        glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
        draw_on_tiles(frame, program);
        gl::Fence::after_all_commands().wait();
        used.clear();
        missing.clear();
        for (int block = 0; block < block_count; ++block) {
            std::uint32_t visit = 0;
            std::memcpy(&visit, visits.data() + std::size_t{4} * static_cast<std::size_t>(block),
                        sizeof(visit));
            if (visit == 1) missing.push_back(block);
            if (visit == 2) used.push_back(block);
        }
        if (!missing.empty()) pool.load(used, missing);
    } while (!missing.empty());
}

/// The pass of a program that reads the field.
void draw_field(FrameContext& frame, FrameImage image, const gl::Program& program) {
    if (frame.field.pool().holds_all())
        draw_tiles(frame, image, program, Eigen::Vector4f::Zero());
    else
        draw_streamed(frame, image, program);
}

void run_raycast(FrameContext& frame) {
    const Quality& quality = frame.scene.quality;
    gl::ProgramKey key = field_program("raycast/raycast.frag", frame.field.pool());
    key.defines.emplace("SEARCH", std::to_string(quality.rate ? 1 : 0));
    const gl::Program& program = frame.shaders.program(key);
    const FieldSource& field = *frame.scene.field;
    const RayCoefficients ray = set_ray_uniforms(program, frame);
    frame.field.bind(program);
    program.set("u_ray_from_eye", Eigen::Matrix3f(ray.from_eye.cast<float>()));
    // A field with a band goes on beyond its extent as background; one without ends there.
    constexpr float nowhere = 1e9F; // beyond any table
    const auto local = [&](const Index3& index) {
        return Eigen::Vector3f((index - frame.field.local_origin_index()).cast<float>());
    };
    const bool has_band = field.half_width_world().has_value();
    program.set("u_extent_lo", has_band ? Eigen::Vector3f(Eigen::Vector3f::Constant(-nowhere))
                                        : local(field.extent().lo));
    program.set("u_extent_hi", has_band ? Eigen::Vector3f(Eigen::Vector3f::Constant(nowhere))
                                        : local((field.extent().hi.array() - 1).matrix()));
    frame.tiles.lists_texture.bind_to_unit(3);
    frame.tiles.blocks_texture.bind_to_unit(4);
    program.set("u_tile_columns", frame.tiles.columns);
    const float stored_from_world = 1 / frame.field.pool().world_from_stored();
    if (quality.rate) {
        program.set("u_fine_step", static_cast<float>(1 / (*quality.rate * quality.rate_factor)));
        program.set("u_fine_per_coarse", quality.rate_factor);
        program.set("u_near",
                    static_cast<float>(quality.near_voxels * field.space().voxel_size_world()) *
                        stored_from_world);
    } else {
        program.set("u_guarantee", static_cast<float>(quality.guarantee_voxels));
        // 2^-19: 32 roundings of a sum of 64 products, each of at most the greatest sample; 24 are
        // the longest way through it.
        program.set("u_value_error", 0x1p-19F * frame.field.pool().greatest_stored());
    }
    program.set("u_world_from_index",
                Eigen::Matrix3f(field.space().world_from_index.linear().cast<float>()));
    draw_field(frame, FrameImage::Hit, program);
}

void run_gradient(FrameContext& frame) {
    const gl::Program& program =
        frame.shaders.program(field_program("raycast/gradient.frag", frame.field.pool()));
    frame.field.bind(program);
    frame.targets.texture(FrameImage::Hit).bind_to_unit(3);
    const GridSpace& space = frame.scene.field->space();
    const Vec3d eye_local =
        space.to_index(frame.camera.eye_world) - frame.field.local_origin_index().cast<double>();
    program.set("u_index_from_world",
                Eigen::Matrix3f(space.world_from_index.linear().inverse().cast<float>()));
    program.set("u_world_from_stored", frame.field.pool().world_from_stored());
    program.set("u_eye_local", Eigen::Vector3f(eye_local.cast<float>()));
    draw_field(frame, FrameImage::Gradient, program);
}

void run_shading(FrameContext& frame) {
    const gl::Program& program = frame.shaders.program(blinn_phong_program);
    frame.targets.texture(FrameImage::Hit).bind_to_unit(0);
    frame.targets.texture(FrameImage::Gradient).bind_to_unit(1);
    const Mat3d world_from_view = frame.camera.view_from_world_rotation().transpose();
    const Material& material = frame.scene.material;
    program.set("u_ray_vector",
                Eigen::Matrix3f((world_from_view * view_vector_coefficients(
                                                       frame.camera, frame.width, frame.height, 1))
                                    .cast<float>()));
    program.set(
        "u_light_direction",
        Eigen::Vector3f(
            (world_from_view * frame.scene.light.direction_view).normalized().cast<float>()));
    program.set("u_light_colour", Eigen::Vector3f(frame.scene.light.colour.cast<float>()));
    program.set("u_colour", Eigen::Vector3f(material.colour.cast<float>()));
    program.set("u_material", Eigen::Vector4f(float(material.ambient), float(material.diffuse),
                                              float(material.specular), float(material.shininess)));
    program.set("u_background", Eigen::Vector3f(frame.scene.background.cast<float>()));
    Eigen::Vector4f background = Eigen::Vector4f::Zero();
    background.head<3>() = frame.scene.background.cast<float>();
    draw_tiles(frame, FrameImage::Beauty, program, background);
}

} // namespace

TilesOnGpu::TilesOnGpu(const TileLists& tiles)
    : columns(tiles.width), lists(std::as_bytes(std::span(tiles.lists)), "tiles"),
      lists_texture(lists, gl::Format::Rg32i, "tiles"),
      blocks(std::as_bytes(std::span(tiles.blocks)), "blocks of tiles"),
      blocks_texture(blocks, gl::Format::R32i, "blocks of tiles") {
    const std::vector<Eigen::Vector4i> tile_runs = tiles.runs();
    run_count = static_cast<int>(tile_runs.size());
    runs = gl::Buffer(std::as_bytes(std::span(tile_runs)), "tile runs");
    runs_texture = gl::BufferTexture(runs, gl::Format::Rgba32i, "tile runs");
}

FieldOnGpu::FieldOnGpu(const FieldSource& samples, const FieldSource& control, Kernel kernel,
                       const BlockRanges& ranges, const std::vector<ActivePage>& active, float iso,
                       const StorageOptions& storage, const Progress& progress,
                       const CoarseBricks* coarse) {
    const BlockTable table = make_block_table(samples, ranges, active, iso);
    local_origin_index_ = page_size * (table.first_page + table.pages / 2);
    table_lo_ = table.lo_index() - local_origin_index_;
    table_pages_ = table.pages;
    block_count_ = table.block_count;
    table_ = gl::Buffer(std::as_bytes(std::span(table.words)), "block table");
    table_texture_ = gl::BufferTexture(table_, gl::Format::R32ui, "block table");
    pool_ = coarse != nullptr
                ? BrickPool(*coarse, ranges, active, table, iso, storage)
                : BrickPool(control, kernel, ranges, active, table, iso, storage, progress);
}

void FieldOnGpu::bind(const gl::Program& program) const {
    table_texture_.bind_to_unit(0);
    program.set("u_table_pages", Eigen::Vector3i(table_pages_));
    program.set("u_table_lo", Eigen::Vector3f(table_lo_.cast<float>()));
    pool_.bind();
}

RayCoefficients ray_coefficients(const Camera& camera, int width, int height,
                                 const GridSpace& space, const Index3& local_origin_index) {
    const Mat3d rotation = camera.view_from_world_rotation();
    const Mat3d index_from_view = space.world_from_index.linear().inverse() * rotation.transpose();
    const Vec3d eye_local = space.to_index(camera.eye_world) - local_origin_index.cast<double>();
    // The plane passes through the object's middle; if that lies behind the eye or at it, a plane
    // one voxel away serves, since the eye is then inside the object and coordinates are small.
    const double depth = std::max(
        -(rotation * (space.to_world(local_origin_index.cast<double>()) - camera.eye_world)).z(),
        space.voxel_size_world());
    RayCoefficients ray;
    ray.from_eye = index_from_view * view_point_coefficients(camera, width, height, depth);
    ray.point = ray.from_eye;
    ray.point.col(0) += eye_local;
    ray.vector = index_from_view * view_vector_coefficients(camera, width, height, depth);
    return ray;
}

std::vector<Pass> declare_passes(FrameContext& frame) {
    return {
        {"raycast", {}, FrameImage::Hit, [&frame] { run_raycast(frame); }},
        {"gradient", {FrameImage::Hit}, FrameImage::Gradient, [&frame] { run_gradient(frame); }},
        {"shading",
         {FrameImage::Hit, FrameImage::Gradient},
         FrameImage::Beauty,
         [&frame] { run_shading(frame); }},
    };
}

std::vector<gl::ProgramKey> all_programs() {
    std::vector<gl::ProgramKey> keys{blinn_phong_program};
    for (const Fetch fetch : {Fetch::Rows, Fetch::Samples}) {
        for (const Kernel kernel : {Kernel::Linear, Kernel::BSpline, Kernel::CatmullRom}) {
            // Strides and the zero of the samples are numbers, which no #if looks at: those of the
            // default storage stand for all.
            std::map<std::string, std::string> defines = BrickPool().defines();
            defines["FETCH"] = std::to_string(static_cast<int>(fetch));
            defines["KERNEL"] = std::to_string(static_cast<int>(kernel));
            for (const int is_streamed : {0, 1}) {
                defines["IS_STREAMED"] = std::to_string(is_streamed);
                keys.push_back({{"common/tiles.vert", "raycast/gradient.frag"}, defines});
                for (const int search : {0, 1}) {
                    if (search == 1 && is_streamed == 1) continue; // Renderer::load refuses
                    std::map<std::string, std::string> with_search = defines;
                    with_search["SEARCH"] = std::to_string(search);
                    keys.push_back({{"common/tiles.vert", "raycast/raycast.frag"}, with_search});
                }
            }
        }
    }
    return keys;
}

gl::Format format_of(FrameImage image) {
    return image == FrameImage::Beauty ? gl::Format::Rgba16f : gl::Format::Rgba32f;
}

} // namespace isocast
