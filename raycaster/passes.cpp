// SPDX-License-Identifier: MPL-2.0
#include "raycaster/passes.h"

#include "gl/readback.h"

#include <glad/gl.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

namespace isocast {

namespace {

const gl::ProgramKey blinn_phong_program{
    {"common/tiles.vert", "shading/blinn_phong/blinn_phong.frag"}, {}};

gl::ProgramKey raycast_program(std::map<std::string, std::string> defines, int search,
                               Traversal traversal, bool has_gradient) {
    defines.emplace("SEARCH", std::to_string(search));
    defines.emplace("HAS_GRADIENT", has_gradient ? "1" : "0");
    defines.emplace("TRAVERSAL", std::to_string(static_cast<int>(traversal)));
    return {{traversal == Traversal::DrawnBlocks ? "raycast/drawn_block.vert" : "common/tiles.vert",
             "raycast/raycast.frag"},
            std::move(defines)};
}

gl::ProgramKey bounds_program(const BrickPool& pool) {
    return {{"raycast/bounds.vert", "raycast/bounds.frag"}, pool.defines()};
}

gl::ProgramKey derivatives_program(std::map<std::string, std::string> defines, int order) {
    defines.emplace("ORDER", std::to_string(order));
    return {{"common/tiles.vert", "raycast/derivatives.frag"}, std::move(defines)};
}

Vec3d eye_local(const Camera& camera, const GridSpace& space, const Index3& local_origin_index) {
    return space.to_index(camera.eye_world) - local_origin_index.cast<double>();
}

/// Columns (constant, d/dx, d/dy) of the affine map from gl_FragCoord to view space at `depth` in
/// front of the eye; gl_FragCoord has its origin at the bottom left.
Mat3d view_point_coefficients(const Camera& camera, int width, int height, double depth) {
    const double half_height = camera.half_height_at(depth);
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

/// Of shaders/raycast/faces.glsl.
void set_face_uniforms(const gl::Program& program, const FrameContext& frame) {
    const Camera& camera = frame.camera;
    const GridSpace& space = frame.scene.field->space();
    const bool is_perspective = camera.projection == Projection::Perspective;
    const double half_height = camera.half_height_at(1);
    const Mat3d rotation = camera.view_from_world_rotation();
    const Mat3d view_from_index = rotation * space.world_from_index.linear();
    const Vec3d offset_view =
        rotation *
        (space.to_world(frame.field.local_origin_index().cast<double>()) - camera.eye_world);
    Eigen::Matrix4d clip_from_view = Eigen::Matrix4d::Zero();
    clip_from_view(0, 0) = frame.height / (half_height * frame.width);
    clip_from_view(1, 1) = 1 / half_height;
    // Depth is not looked at: faces are clipped where they reach behind the eye alone.
    (is_perspective ? clip_from_view(3, 2) : clip_from_view(3, 3)) = is_perspective ? -1 : 1;
    Eigen::Matrix4d view_from_local = Eigen::Matrix4d::Identity();
    view_from_local.topLeftCorner<3, 3>() = view_from_index;
    view_from_local.topRightCorner<3, 1>() = offset_view;
    program.set("u_clip_from_local",
                Eigen::Matrix4f((clip_from_view * view_from_local).cast<float>()));
    // A 64th of a pixel at least; rasterisers keep a 256th.
    const double voxels_per_world = space.world_from_index.linear().inverse().norm();
    program.set("u_margin",
                static_cast<float>(2 * half_height / frame.height / 64 * voxels_per_world));
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
    frame.places.runs.texture.bind_to_unit(7);
    program.set("u_clip_from_tile",
                Eigen::Vector2f(2.0F * tile_pixels / static_cast<float>(frame.width),
                                2.0F * tile_pixels / static_cast<float>(frame.height)));
    program.use();
    glDrawArrays(GL_TRIANGLES, 0, 6 * frame.places.run_count);
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
void draw_streamed(FrameContext& frame, FieldOnGpu& field, FrameImage image,
                   const gl::Program& program) {
    BrickPool& pool = field.pool();
    gl::Texture progress =
        gl::Texture::image(gl::Format::R32i, frame.width, frame.height, "pixels' progress");
    progress.clear(-1); // shaders/raycast/stream.glsl: not_started
    const int block_count = field.block_count();
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

/// Draws blocks layer by layer; shaders read the hits of the layers before.
void draw_blocks(const FrameContext& frame, FrameImage image, const gl::Program& program) {
    frame.targets.framebuffer(image).bind();
    const Eigen::Vector4f empty = Eigen::Vector4f::Zero();
    glClearBufferfv(GL_COLOR, 0, empty.data());
    set_fixed_state();
    set_face_uniforms(program, frame);
    const Vec3d forward = frame.camera.view_from_world_rotation().transpose() * Vec3d(0, 0, -1);
    const GridSpace& space = frame.scene.field->space();
    Eigen::Vector4d eye;
    if (frame.camera.projection == Projection::Perspective)
        eye << eye_local(frame.camera, space, frame.field.local_origin_index()), 1;
    else
        eye << -(space.world_from_index.linear().inverse() * forward).normalized(), 0;
    program.set("u_eye", Eigen::Vector4f(eye.cast<float>()));
    frame.places.order.texture.bind_to_unit(3);
    frame.targets.texture(image).bind_to_unit(5);
    frame.no_vertices.bind();
    program.use();
    constexpr int vertices = 36;
    const std::vector<std::int32_t>& layers = frame.places.layers;
    for (std::size_t i = 0; i + 1 < layers.size(); ++i) {
        glTextureBarrier();
        glDrawArrays(GL_TRIANGLES, vertices * layers[i], vertices * (layers[i + 1] - layers[i]));
    }
}

/// The pass of a program that reads the field, or that of derivatives.
void draw_field(FrameContext& frame, FieldOnGpu& field, FrameImage image,
                const gl::Program& program) {
    if (field.pool().holds_all())
        draw_tiles(frame, image, program, Eigen::Vector4f::Zero());
    else
        draw_streamed(frame, field, image, program);
}

/// Of shaders that go from hits to the field.
void set_hit_uniforms(const gl::Program& program, const FrameContext& frame,
                      const FieldOnGpu& field) {
    const GridSpace& space = frame.scene.field->space();
    program.set("u_index_from_world",
                Eigen::Matrix3f(space.world_from_index.linear().inverse().cast<float>()));
    program.set(
        "u_eye_local",
        Eigen::Vector3f(eye_local(frame.camera, space, field.local_origin_index()).cast<float>()));
}

void run_bounds(FrameContext& frame) {
    const gl::Program& program = frame.shaders.program(bounds_program(frame.field.pool()));
    set_ray_uniforms(program, frame);
    frame.field.bind_blocks(program);
    set_face_uniforms(program, frame);
    frame.field.bind_faces(3);
    frame.targets.framebuffer(FrameImage::Bounds).bind();
    constexpr float nowhere = 1e30F;
    const std::array<float, 4> empty{nowhere, nowhere, 0, 0};
    glClearBufferfv(GL_COLOR, 0, empty.data());
    set_fixed_state();
    glEnable(GL_BLEND);
    glBlendEquation(GL_MIN);
    frame.no_vertices.bind();
    program.use();
    glDrawArrays(GL_TRIANGLES, 0, 6 * frame.field.face_count());
    glDisable(GL_BLEND);
}

void run_raycast(FrameContext& frame) {
    const Quality& quality = frame.scene.quality;
    const gl::ProgramKey key = raycast_program(frame.field.pool().defines(), quality.rate ? 1 : 0,
                                               quality.traversal, frame.has_fused_gradient);
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
    if (quality.traversal == Traversal::TileLists) {
        frame.places.lists.texture.bind_to_unit(3);
        frame.places.blocks.texture.bind_to_unit(4);
        program.set("u_tile_columns", frame.places.columns);
    } else if (quality.traversal == Traversal::BoundingFaces) {
        frame.targets.texture(FrameImage::Bounds).bind_to_unit(5);
    }
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
    if (frame.has_fused_gradient) {
        set_hit_uniforms(program, frame, frame.field);
        program.set("u_world_from_stored", frame.field.pool().world_from_stored());
        frame.targets.hit_and_gradient.bind();
        const Eigen::Vector4f empty = Eigen::Vector4f::Zero();
        for (const int attachment : {0, 1}) glClearBufferfv(GL_COLOR, attachment, empty.data());
        draw_on_tiles(frame, program);
    } else if (quality.traversal == Traversal::DrawnBlocks)
        draw_blocks(frame, FrameImage::Hit, program);
    else
        draw_field(frame, frame.field, FrameImage::Hit, program);
}

/// Of raycast/derivatives.frag: 1 for the gradient, 2 for curvatures.
void run_derivatives(FrameContext& frame, FrameImage image, int order) {
    FieldOnGpu& field = frame.derivative_field;
    gl::ProgramKey key = derivatives_program(field.pool().defines(), order);
    const Kernel kernel = kernel_of(frame.scene.derivative_filter.value_or(frame.scene.filter));
    key.defines["KERNEL"] = std::to_string(static_cast<int>(kernel));
    const gl::Program& program = frame.shaders.program(key);
    field.bind(program);
    frame.targets.texture(FrameImage::Hit).bind_to_unit(3);
    set_hit_uniforms(program, frame, field);
    // Curvatures do not depend on the unit of values.
    if (order == 1) program.set("u_world_from_stored", field.pool().world_from_stored());
    draw_field(frame, field, image, program);
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

PlacesOnGpu::PlacesOnGpu(Traversal traversal, const BlockRanges& ranges,
                         const std::vector<ActivePage>& active, const GridSpace& space,
                         const Camera& camera, int width, int height) {
    std::vector<Eigen::Vector4i> tile_runs;
    if (traversal == Traversal::TileLists) {
        const TileLists tiles = list_blocks(ranges, active, space, camera, width, height);
        columns = tiles.width;
        lists = {std::as_bytes(std::span(tiles.lists)), gl::Format::Rg32i, "tiles"};
        blocks = {std::as_bytes(std::span(tiles.blocks)), gl::Format::R32i, "blocks of tiles"};
        tile_runs = tiles.runs();
    } else {
        tile_runs = whole_picture(width, height);
    }
    run_count = static_cast<int>(tile_runs.size());
    runs = {std::as_bytes(std::span(tile_runs)), gl::Format::Rgba32i, "tile runs"};
    if (traversal == Traversal::DrawnBlocks) {
        BlockOrder nearest_first = order_blocks(ranges, active, space, camera);
        order = {std::as_bytes(std::span(nearest_first.blocks)), gl::Format::R32i, "block order"};
        layers = std::move(nearest_first.layers);
    }
}

FieldOnGpu::FieldOnGpu(const FieldSource& samples, const FieldSource& control, Kernel kernel,
                       const BlockRanges& ranges, const std::vector<ActivePage>& active, float iso,
                       const StorageOptions& storage, const Progress& progress, Traversal traversal,
                       const CoarseBricks* coarse) {
    const BlockTable table = make_block_table(samples, ranges, active, iso);
    local_origin_index_ = page_size * (table.first_page + table.pages / 2);
    table_lo_ = table.lo_index() - local_origin_index_;
    table_pages_ = table.pages;
    block_count_ = table.block_count;
    table_ = gl::Buffer(std::as_bytes(std::span(table.words)), "block table");
    table_texture_ = gl::BufferTexture(table_, gl::Format::R32ui, "block table");
    if (traversal == Traversal::BoundingFaces) {
        const std::vector<Eigen::Vector2i> faces = bounding_faces(table);
        faces_ = gl::Buffer(std::as_bytes(std::span(faces)), "bounding faces");
        faces_texture_ = gl::BufferTexture(faces_, gl::Format::Rg32i, "bounding faces");
    }
    pool_ = coarse != nullptr
                ? BrickPool(*coarse, ranges, active, table, iso, storage)
                : BrickPool(control, kernel, ranges, active, table, iso, storage, progress);
}

void FieldOnGpu::bind(const gl::Program& program) const {
    table_texture_.bind_to_unit(0);
    program.set("u_table_pages", Eigen::Vector3i(table_pages_));
    bind_blocks(program);
}

void FieldOnGpu::bind_blocks(const gl::Program& program) const {
    program.set("u_table_lo", Eigen::Vector3f(table_lo_.cast<float>()));
    pool_.bind();
}

RayCoefficients ray_coefficients(const Camera& camera, int width, int height,
                                 const GridSpace& space, const Index3& local_origin_index) {
    const Mat3d rotation = camera.view_from_world_rotation();
    const Mat3d index_from_view = space.world_from_index.linear().inverse() * rotation.transpose();
    // The plane passes through the object's middle; if that lies behind the eye or at it, a plane
    // one voxel away serves, since the eye is then inside the object and coordinates are small.
    const double depth = std::max(
        -(rotation * (space.to_world(local_origin_index.cast<double>()) - camera.eye_world)).z(),
        space.voxel_size_world());
    RayCoefficients ray;
    ray.from_eye = index_from_view * view_point_coefficients(camera, width, height, depth);
    ray.point = ray.from_eye;
    ray.point.col(0) += eye_local(camera, space, local_origin_index);
    ray.vector = index_from_view * view_vector_coefficients(camera, width, height, depth);
    return ray;
}

bool FrameContext::can_fuse_gradient() const {
    return &derivative_field == &field && field.pool().holds_all() &&
           field.pool().fetch() != Fetch::Linear && // whose gradient may be another sum
           scene.quality.traversal != Traversal::DrawnBlocks &&
           kernel_of(scene.derivative_filter.value_or(scene.filter)) == kernel_of(scene.filter);
}

std::vector<Pass> declare_passes(FrameContext& frame) {
    const ImageSet bounds = frame.scene.quality.traversal == Traversal::BoundingFaces
                                ? ImageSet{FrameImage::Bounds}
                                : ImageSet{};
    return {
        {"bounds", {}, FrameImage::Bounds, [&frame] { run_bounds(frame); }},
        {"raycast", bounds, FrameImage::Hit, [&frame] { run_raycast(frame); }},
        {"gradient",
         {FrameImage::Hit},
         FrameImage::Gradient,
         [&frame] {
             if (!frame.has_fused_gradient) run_derivatives(frame, FrameImage::Gradient, 1);
         }},
        {"curvature",
         {FrameImage::Hit},
         FrameImage::Curvature,
         [&frame] { run_derivatives(frame, FrameImage::Curvature, 2); }},
        {"shading",
         {FrameImage::Hit, FrameImage::Gradient},
         FrameImage::Beauty,
         [&frame] { run_shading(frame); }},
    };
}

std::vector<gl::ProgramKey> all_programs() {
    std::vector<gl::ProgramKey> keys{blinn_phong_program, bounds_program({})};
    std::vector<StorageOptions> storages{{.fetch = Fetch::Rows}, {.fetch = Fetch::Samples}};
    for (const int fraction_bits : {0, 8})
        for (const bool is_refined_exactly : {true, false})
            storages.push_back({.fetch = Fetch::Linear,
                                .fraction_bits = fraction_bits,
                                .is_refined_exactly = is_refined_exactly});
    for (const StorageOptions& storage : storages) {
        for (const Kernel kernel : {Kernel::Linear, Kernel::BSpline, Kernel::CatmullRom}) {
            // Strides and the zero of the samples are numbers, which no #if looks at: those of the
            // default storage stand for all.
            std::map<std::string, std::string> defines = fetch_defines(storage);
            defines["KERNEL"] = std::to_string(static_cast<int>(kernel));
            defines.merge(BrickPool().defines());
            for (const int is_streamed : {0, 1}) {
                defines["IS_STREAMED"] = std::to_string(is_streamed);
                for (const int order : {1, 2}) keys.push_back(derivatives_program(defines, order));
                for (const int search : {0, 1}) {
                    for (const Traversal traversal : {Traversal::TileLists, Traversal::DrawnBlocks,
                                                      Traversal::BoundingFaces, Traversal::Walk}) {
                        // Renderer::load refuses the others.
                        const bool is_default = search == 0 && traversal == Traversal::TileLists;
                        if (is_streamed == 0 || is_default)
                            keys.push_back(raycast_program(defines, search, traversal, false));
                        if (is_streamed == 0 && traversal != Traversal::DrawnBlocks &&
                            storage.fetch != Fetch::Linear)
                            keys.push_back(raycast_program(defines, search, traversal, true));
                    }
                }
            }
        }
    }
    return keys;
}

gl::Format format_of(FrameImage image) {
    switch (image) {
    case FrameImage::Beauty:
        return gl::Format::Rgba16f;
    case FrameImage::Bounds:
        return gl::Format::Rg32f;
    default:
        return gl::Format::Rgba32f;
    }
}

} // namespace isocast
