// SPDX-License-Identifier: MPL-2.0
#include "raycaster/field_passes.h"

#include "gl/readback.h"
#include "raycaster/composition.h"
#include "raycaster/slim_passes.h"
#include "raycaster/splat_passes.h"

#include <Eigen/Eigenvalues>
#include <glad/gl.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace isocast {

namespace {

/// What raycast/raycast.frag is made for.
struct RaycastKind {
    bool is_sampled = false; // at a rate, for comparison
    Traversal traversal = Traversal::TileLists;
    bool has_gradient = false;
    bool is_operand = false;
    bool is_to_sky = false;
    bool counts_steps = false;
};

gl::ProgramKey raycast_program(std::map<std::string, std::string> defines,
                               const RaycastKind& kind) {
    const auto define = [&](const char* name, int value) {
        defines.emplace(name, std::to_string(value));
    };
    define("SEARCH", kind.is_sampled ? 1 : 0);
    define("TRAVERSAL", static_cast<int>(kind.traversal));
    define("HAS_GRADIENT", kind.has_gradient ? 1 : 0);
    define("IS_OPERAND", kind.is_operand ? 1 : 0);
    define("IS_TO_SKY", kind.is_to_sky ? 1 : 0);
    define("COUNTS_STEPS", kind.counts_steps ? 1 : 0);
    return {{kind.traversal == Traversal::DrawnBlocks ? "raycast/drawn_block.vert"
                                                      : "common/tiles.vert",
             "raycast/raycast.frag"},
            std::move(defines)};
}

gl::ProgramKey bounds_program(const BrickPool& pool) {
    return {{"raycast/bounds.vert", "raycast/bounds.frag"}, pool.defines()};
}

/// What follows from the Hessian, and where raycast/derivatives.frag writes it.
struct SecondOrder {
    FrameImage image;
    const char* attachment_define;
};
constexpr std::array second_order{
    SecondOrder{FrameImage::Curvature, "CURVATURE_AT"},
    SecondOrder{FrameImage::Direction, "DIRECTION_AT"},
    SecondOrder{FrameImage::ViewCurvature, "VIEW_CURVATURE_AT"},
    SecondOrder{FrameImage::FlowLineCurvature, "FLOW_LINE_CURVATURE_AT"}};

gl::ProgramKey gradient_program(std::map<std::string, std::string> defines, bool is_operand) {
    defines.emplace("IS_OPERAND", is_operand ? "1" : "0");
    defines.emplace("ORDER", "1");
    return {{"common/tiles.vert", "raycast/derivatives.frag"}, std::move(defines)};
}

} // namespace

void add_second_order_defines(std::map<std::string, std::string>& defines, const ImageSet& images) {
    int attachment = 0;
    for (const auto& [image, define] : second_order)
        defines.emplace(define, std::to_string(images.contains(image) ? attachment++ : -1));
}

namespace {

/// images  of second order, at least one
gl::ProgramKey second_order_program(std::map<std::string, std::string> defines, bool is_operand,
                                    const ImageSet& images) {
    defines.emplace("IS_OPERAND", is_operand ? "1" : "0");
    defines.emplace("ORDER", "2");
    add_second_order_defines(defines, images);
    return {{"common/tiles.vert", "raycast/derivatives.frag"}, std::move(defines)};
}

RayCoefficients set_ray_uniforms(const gl::Program& program, const FrameContext& frame) {
    const RayCoefficients ray =
        ray_coefficients(frame.camera, frame.width, frame.height, frame.object().field->space(),
                         frame.field().local_origin_index());
    program.set("u_ray_point", Eigen::Matrix3f(ray.point.cast<float>()));
    program.set("u_ray_vector", Eigen::Matrix3f(ray.vector.cast<float>()));
    set_first_pixel(frame, program);
    return ray;
}

/// Of shaders/raycast/faces.glsl.
void set_face_uniforms(const gl::Program& program, const FrameContext& frame) {
    const Camera& camera = frame.camera;
    const GridSpace& space = frame.object().field->space();
    const bool is_perspective = camera.projection == Projection::Perspective;
    const double half_height = camera.half_height_at(1);
    const Mat3d rotation = camera.view_from_world_rotation();
    const Mat3d view_from_index = rotation * space.world_from_index.linear();
    const Vec3d offset_view =
        rotation *
        (space.to_world(frame.field().local_origin_index().cast<double>()) - camera.eye_world);
    Eigen::Matrix4d clip_from_view = Eigen::Matrix4d::Zero();
    clip_from_view(0, 0) = frame.height / (half_height * frame.width);
    clip_from_view(1, 1) = 1 / half_height;
    // Depth is not looked at: faces are clipped where they reach behind the eye alone.
    (is_perspective ? clip_from_view(3, 2) : clip_from_view(3, 3)) = is_perspective ? -1 : 1;
    // From the whole picture to the part that is drawn.
    const Eigen::Array2d picture(frame.width, frame.height);
    const Eigen::Array2d part(frame.part.width, frame.part.height);
    const Eigen::Array2d first = frame.part.first_pixel(frame.height).array();
    for (int axis = 0; axis < 2; ++axis)
        clip_from_view.row(axis) =
            picture[axis] / part[axis] * clip_from_view.row(axis) +
            ((picture[axis] - 2 * first[axis]) / part[axis] - 1) * clip_from_view.row(3);
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

/// draw_on_tiles again and again, with the bricks loaded that pixels wait for, until none waits.
///
/// Every pass ends with the bricks in the pool that the first waiting pixels need, so each of them
/// gets at least one block further.
void draw_streamed(FrameContext& frame, FieldOnGpu& field, const gl::Program& program) {
    BrickPool& pool = field.pool();
    gl::Texture progress = gl::Texture::image(gl::Format::R32i, frame.part.width, frame.part.height,
                                              "pixels' progress");
    progress.clear(-1); // shaders/raycast/stream.glsl: not_started
    const int block_count = field.block_count();
    gl::ReadbackBuffer visits(std::int64_t{block_count} * 4, "visited blocks");
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
    const GridSpace& space = frame.object().field->space();
    Eigen::Vector4d eye;
    if (frame.camera.projection == Projection::Perspective)
        eye << eye_local(frame.camera, space, frame.field().local_origin_index()), 1;
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
        glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
        glDrawArrays(GL_TRIANGLES, vertices * layers[i], vertices * (layers[i + 1] - layers[i]));
    }
}

/// The pass of a program that reads the field, or that of derivatives: zero where it draws nothing.
void draw_field(FrameContext& frame, FieldOnGpu& field, const gl::Framebuffer& target,
                int attachment_count, const gl::Program& program) {
    target.bind();
    const Eigen::Vector4f empty = Eigen::Vector4f::Zero();
    for (int i = 0; i < attachment_count; ++i) glClearBufferfv(GL_COLOR, i, empty.data());
    if (field.pool().holds_all())
        draw_on_tiles(frame, program);
    else
        draw_streamed(frame, field, program);
}

} // namespace

void set_hit_uniforms(const gl::Program& program, const FrameContext& frame,
                      const FieldOnGpu& field) {
    const GridSpace& space = frame.object().field->space();
    program.set("u_index_from_world",
                Eigen::Matrix3f(space.world_from_index.linear().inverse().cast<float>()));
    program.set(
        "u_eye_local",
        Eigen::Vector3f(eye_local(frame.camera, space, field.local_origin_index()).cast<float>()));
}

namespace {

/// Of shaders/raycast/derivatives.frag: how roundings and stored samples err in curvatures.
void set_error_uniforms(const gl::Program& program, const GridSpace& space, const BrickPool& pool,
                        Kernel kernel) {
    // The greatest sum of |weights| of a second derivative, which is at a sample. Mixed ones have
    // less than 4, but those of Catmull-Rom 9.
    double hull = 0;
    for (const double weight : kernel_weights_d2(kernel, 0)) hull += std::abs(weight);
    hull = std::max(hull, 4.0);
    // 2^-19: 32 roundings of what is summed; 24 are the longest way through a sum of 64 products.
    program.set("u_entry_error",
                Eigen::Vector2f(float(hull * 0x1p-19),
                                float(hull * pool.storage_error() / pool.world_from_stored())));
    // Symmetric matrices of entries up to e have eigenvalues up to 3 e, and two of them differ.
    const double stretch = space.world_from_index.linear().inverse().operatorNorm();
    program.set("u_difference_error", static_cast<float>(6 * stretch * stretch));
}

/// Runs raycast/derivatives.frag: of several owners of hits each one's, on the pixels that it owns.
///
/// order     1 or 2, of the same derivatives of primitives
/// field_of  the field that is derived
/// key_of    (its pool's defines, is_operand) -> its program, but for the kernel
/// set_more  (program, object, field, kernel): its uniforms beside those of all programs
template<class KeyOf, class SetMore>
void draw_derivatives(FrameContext& frame, int order, FieldOnGpu& (*field_of)(const FrameContext&),
                      const gl::Framebuffer& target, int attachment_count, KeyOf key_of,
                      SetMore set_more) {
    const bool is_operand = has_owners(frame);
    const auto prepared = [&](const FrameContext& object) -> const gl::Program& {
        FieldOnGpu& field = field_of(object);
        gl::ProgramKey key = key_of(field.pool().defines(), is_operand);
        const Kernel kernel =
            kernel_of(object.object().derivative_filter.value_or(object.object().filter));
        key.defines["KERNEL"] = std::to_string(static_cast<int>(kernel));
        const gl::Program& program = object.shaders.program(key);
        field.bind(program);
        object.targets.texture(FrameImage::Hit).bind_to_unit(3);
        set_hit_uniforms(program, object, field);
        set_more(program, object, field, kernel);
        return program;
    };
    if (!is_operand) {
        draw_field(frame, field_of(frame), target, attachment_count, prepared(frame));
        return;
    }
    target.bind();
    const Eigen::Vector4f empty = Eigen::Vector4f::Zero();
    for (int i = 0; i < attachment_count; ++i) glClearBufferfv(GL_COLOR, i, empty.data());
    for (int i = 0; i < std::ssize(frame.seen.objects); ++i) {
        const FrameContext object =
            of_object(frame, frame.seen.objects[static_cast<std::size_t>(i)]);
        const gl::Program& program = prepared(object);
        program.set("u_object", i + 1);
        draw_on_tiles(object, program);
    }
    if (frame.seen.splats) draw_splat_derivatives(frame, order, target);
}

} // namespace

void set_extent_uniforms(const gl::Program& program, const FrameContext& frame) {
    const FieldSource& field = *frame.object().field;
    // A field with a band goes on beyond its extent as background; one without ends there.
    constexpr float nowhere = 1e9F; // beyond any table
    const auto local = [&](const Index3& index) {
        return Eigen::Vector3f((index - frame.field().local_origin_index()).cast<float>());
    };
    const bool has_band = field.half_width_world().has_value();
    program.set("u_extent_lo", has_band ? Eigen::Vector3f(Eigen::Vector3f::Constant(-nowhere))
                                        : local(field.extent().lo));
    program.set("u_extent_hi", has_band ? Eigen::Vector3f(Eigen::Vector3f::Constant(nowhere))
                                        : local((field.extent().hi.array() - 1).matrix()));
}

void set_accuracy_uniforms(const gl::Program& program, const FrameContext& frame) {
    program.set("u_guarantee", static_cast<float>(frame.scene.quality.guarantee_voxels));
    // 2^-19: 32 roundings of a sum of 64 products, each of at most the greatest sample; 24 are
    // the longest way through it.
    program.set("u_value_error", 0x1p-19F * frame.field().pool().greatest_stored());
}

bool can_fuse_gradient(const FrameContext& frame) {
    if (frame.one == nullptr) return true; // primitives know their normals
    return &frame.derivative_field() == &frame.field() && frame.field().pool().holds_all() &&
           frame.field().pool().fetch() != Fetch::Linear && // whose gradient may be another sum
           frame.scene.quality.traversal != Traversal::DrawnBlocks && !is_composed(frame.scene) &&
           kernel_of(frame.object().derivative_filter.value_or(frame.object().filter)) ==
               kernel_of(frame.object().filter);
}

void run_bounds(FrameContext& frame) {
    const gl::Program& program = frame.shaders.program(bounds_program(frame.field().pool()));
    set_ray_uniforms(program, frame);
    frame.field().bind_blocks(program);
    set_face_uniforms(program, frame);
    frame.field().bind_faces(3);
    frame.targets.framebuffer(FrameImage::Bounds).bind();
    constexpr float nowhere = 1e30F;
    const std::array<float, 4> empty{nowhere, nowhere, 0, 0};
    glClearBufferfv(GL_COLOR, 0, empty.data());
    set_fixed_state();
    glEnable(GL_BLEND);
    glBlendEquation(GL_MIN);
    frame.no_vertices.bind();
    program.use();
    glDrawArrays(GL_TRIANGLES, 0, 6 * frame.field().face_count());
    glDisable(GL_BLEND);
}

RayCoefficients set_search_uniforms(const gl::Program& program, const FrameContext& frame) {
    const Quality& quality = frame.scene.quality;
    const FieldSource& field = *frame.object().field;
    const RayCoefficients ray = set_ray_uniforms(program, frame);
    frame.field().bind(program);
    program.set("u_ray_from_eye", Eigen::Matrix3f(ray.from_eye.cast<float>()));
    set_extent_uniforms(program, frame);
    if (quality.traversal == Traversal::TileLists) {
        frame.places.lists.texture.bind_to_unit(3);
        frame.places.blocks.texture.bind_to_unit(4);
        program.set("u_tile_columns", frame.places.columns);
    } else if (quality.traversal == Traversal::BoundingFaces) {
        frame.targets.texture(FrameImage::Bounds).bind_to_unit(5);
    }
    const float stored_from_world = 1 / frame.field().pool().world_from_stored();
    if (quality.rate) {
        program.set("u_fine_step", static_cast<float>(1 / (*quality.rate * quality.rate_factor)));
        program.set("u_fine_per_coarse", quality.rate_factor);
        program.set("u_near",
                    static_cast<float>(quality.near_voxels * field.space().voxel_size_world()) *
                        stored_from_world);
        program.set("u_refine_steps", quality.refine_steps);
    } else {
        set_accuracy_uniforms(program, frame);
    }
    program.set("u_world_from_index",
                Eigen::Matrix3f(field.space().world_from_index.linear().cast<float>()));
    return ray;
}

gl::ProgramKey operand_program(const FrameContext& frame) {
    return raycast_program(
        frame.field().pool().defines(),
        {.is_operand = true, .counts_steps = frame.live.contains(FrameImage::Steps)});
}

void start_counting_steps(const FrameContext& frame) {
    if (!frame.live.contains(FrameImage::Steps)) return;
    const Eigen::Vector4f zero = Eigen::Vector4f::Zero();
    frame.targets.framebuffer(FrameImage::Steps).bind();
    glClearBufferfv(GL_COLOR, 0, zero.data());
    frame.targets.texture(FrameImage::Steps).bind_as_image(1);
}

gl::ProgramKey sky_operand_program(std::map<std::string, std::string> pool_defines) {
    return raycast_program(std::move(pool_defines),
                           {.traversal = Traversal::Walk, .is_operand = true, .is_to_sky = true});
}

namespace {

/// Of the frame's one field.
void run_raycast(FrameContext& frame) {
    const Quality& quality = frame.scene.quality;
    const gl::ProgramKey key = raycast_program(
        frame.field().pool().defines(), {.is_sampled = quality.rate.has_value(),
                                         .traversal = quality.traversal,
                                         .has_gradient = frame.has_fused_gradient,
                                         .counts_steps = frame.live.contains(FrameImage::Steps)});
    const gl::Program& program = frame.shaders.program(key);
    start_counting_steps(frame);
    set_search_uniforms(program, frame);
    if (frame.has_fused_gradient) {
        set_hit_uniforms(program, frame, frame.field());
        program.set("u_world_from_stored", frame.field().pool().world_from_stored());
        const gl::Framebuffer both(
            {&frame.targets.texture(FrameImage::Hit), &frame.targets.texture(FrameImage::Gradient)},
            "hit and gradient");
        draw_field(frame, frame.field(), both, 2, program);
    } else if (quality.traversal == Traversal::DrawnBlocks)
        draw_blocks(frame, FrameImage::Hit, program);
    else
        draw_field(frame, frame.field(), frame.targets.framebuffer(FrameImage::Hit), 1, program);
}

} // namespace

void run_hits(FrameContext& frame) {
    if (is_composed(frame.scene))
        run_composition(frame);
    else if (frame.one != nullptr) {
        FrameContext one = of_object(frame, *frame.one);
        run_raycast(one);
    } else
        start_counting_steps(frame);
    if (frame.seen.splats) resolve_splats(frame);
}

bool is_of_second_order(FrameImage image) {
    return std::ranges::find(second_order, image, &SecondOrder::image) != second_order.end();
}

FrameImage drawn_with(const FrameContext& frame, FrameImage image) {
    if (image == FrameImage::Steps || image == FrameImage::SplatColour ||
        (image == FrameImage::Gradient && frame.has_fused_gradient))
        return FrameImage::Hit;
    if (!is_of_second_order(image)) return image;
    return std::ranges::find_if(second_order,
                                [&](const SecondOrder& other) {
                                    return other.image == image || frame.live.contains(other.image);
                                })
        ->image;
}

void run_gradient(FrameContext& frame) {
    if (drawn_with(frame, FrameImage::Gradient) != FrameImage::Gradient) return;
    draw_derivatives(
        frame, 1,
        [](const FrameContext& object) -> FieldOnGpu& { return object.derivative_field(); },
        frame.targets.framebuffer(FrameImage::Gradient), 1, gradient_program,
        [](const gl::Program& program, const FrameContext&, const FieldOnGpu& field, Kernel) {
            program.set("u_world_from_stored", field.pool().world_from_stored());
        });
}

void run_second_order(FrameContext& frame, FrameImage image) {
    if (drawn_with(frame, image) != image) return;
    std::vector<const gl::Texture*> textures;
    for (const SecondOrder& other : second_order)
        if (frame.live.contains(other.image))
            textures.push_back(&frame.targets.texture(other.image));
    draw_derivatives(
        frame, 2,
        [](const FrameContext& object) -> FieldOnGpu& { return object.curvature_field(); },
        gl::Framebuffer(textures, "of second order"), static_cast<int>(textures.size()),
        [&](std::map<std::string, std::string> defines, bool is_operand) {
            return second_order_program(std::move(defines), is_operand, frame.live);
        },
        [&](const gl::Program& program, const FrameContext& object, const FieldOnGpu& field,
            Kernel kernel) {
            if (frame.live.contains(FrameImage::Curvature) ||
                frame.live.contains(FrameImage::Direction))
                set_error_uniforms(program, object.object().field->space(), field.pool(), kernel);
            if (frame.live.contains(FrameImage::ViewCurvature))
                program.set("u_ray_vector_world",
                            Eigen::Matrix3f(
                                world_vector_coefficients(frame.camera, frame.width, frame.height)
                                    .cast<float>()));
        });
}

void cast_rays(FrameContext& frame, const ImageSet& derived) {
    const bool has_gradient = derived.contains(FrameImage::Gradient);
    frame.has_fused_gradient = has_gradient && can_fuse_gradient(frame);
    for (int i = 0; i < frame_image_count; ++i) {
        const auto image = static_cast<FrameImage>(i);
        if (image == FrameImage::Hit || (image == FrameImage::Gradient && has_gradient) ||
            (is_of_second_order(image) && derived.contains(image))) {
            frame.targets.make(image, frame.width, frame.height);
            frame.live.insert(image); // and nothing else: steps are the frame's rays'
        }
    }
    if (frame.one != nullptr && frame.scene.quality.traversal == Traversal::BoundingFaces) {
        frame.targets.make(FrameImage::Bounds, frame.width, frame.height);
        run_bounds(frame);
    }
    if (frame.seen.splats) {
        if (has_slims(frame)) {
            for (const FrameImage image : {FrameImage::SlimNearest, FrameImage::SlimHit})
                frame.targets.make(image, frame.width, frame.height);
            run_slim_nearest(frame);
            run_slim_hits(frame);
        }
        frame.targets.make(FrameImage::Splat, frame.width, frame.height);
        run_splats(frame);
    }
    run_hits(frame);
    if (has_gradient) run_gradient(frame);
    for (const SecondOrder& one : second_order)
        if (derived.contains(one.image)) run_second_order(frame, one.image);
}

std::vector<std::map<std::string, std::string>> all_pool_defines() {
    std::vector<StorageOptions> storages{{.fetch = Fetch::Rows}, {.fetch = Fetch::Samples}};
    for (const int fraction_bits : {0, 8})
        for (const bool is_refined_exactly : {true, false})
            storages.push_back({.fetch = Fetch::Linear,
                                .fraction_bits = fraction_bits,
                                .is_refined_exactly = is_refined_exactly});
    std::vector<std::map<std::string, std::string>> all;
    for (const StorageOptions& storage : storages) {
        for (const Kernel kernel : {Kernel::Linear, Kernel::BSpline, Kernel::CatmullRom}) {
            // Strides and the zero of the samples are numbers, which no #if looks at: those of the
            // default storage stand for all.
            std::map<std::string, std::string>& defines = all.emplace_back(fetch_defines(storage));
            defines["KERNEL"] = std::to_string(static_cast<int>(kernel));
            defines.merge(BrickPool().defines());
        }
    }
    return all;
}

std::vector<gl::ProgramKey> field_programs() {
    std::vector<gl::ProgramKey> keys{bounds_program({})};
    for (std::map<std::string, std::string> defines : all_pool_defines()) {
        const bool is_linear =
            defines.at("FETCH") == std::to_string(static_cast<int>(Fetch::Linear));
        for (const int is_streamed : {0, 1}) {
            defines["IS_STREAMED"] = std::to_string(is_streamed);
            for (const bool is_operand : {false, true}) {
                if (is_streamed != 0 && is_operand) continue;
                keys.push_back(gradient_program(defines, is_operand));
                keys.push_back(second_order_program(defines, is_operand, {FrameImage::Curvature}));
            }
            if (is_streamed == 0)
                for (const bool counts_steps : {false, true})
                    keys.push_back(raycast_program(
                        defines, {.is_operand = true, .counts_steps = counts_steps}));
            for (const bool is_sampled : {false, true}) {
                for (const Traversal traversal : {Traversal::TileLists, Traversal::DrawnBlocks,
                                                  Traversal::BoundingFaces, Traversal::Walk}) {
                    // Renderer::load refuses the others.
                    const bool is_default = !is_sampled && traversal == Traversal::TileLists;
                    if (is_streamed == 0 || is_default)
                        keys.push_back(raycast_program(
                            defines, {.is_sampled = is_sampled, .traversal = traversal}));
                    if (is_streamed == 0 && traversal != Traversal::DrawnBlocks && !is_linear)
                        keys.push_back(raycast_program(defines, {.is_sampled = is_sampled,
                                                                 .traversal = traversal,
                                                                 .has_gradient = true}));
                }
            }
        }
    }
    // What is written does not depend on how the field is read: the default storage stands for all.
    std::map<std::string, std::string> defines = BrickPool().defines();
    defines.emplace("KERNEL", std::to_string(static_cast<int>(Kernel::BSpline)));
    defines.emplace("IS_STREAMED", "0");
    for (const bool is_sampled : {false, true})
        for (const Traversal traversal : {Traversal::TileLists, Traversal::DrawnBlocks,
                                          Traversal::BoundingFaces, Traversal::Walk})
            keys.push_back(raycast_program(
                defines, {.is_sampled = is_sampled, .traversal = traversal, .counts_steps = true}));
    for (unsigned set = 2; set < 1U << second_order.size(); ++set) {
        ImageSet images;
        for (std::size_t i = 0; i < second_order.size(); ++i)
            if (set & 1U << i) images.insert(second_order[i].image);
        for (const bool is_operand : {false, true})
            keys.push_back(second_order_program(defines, is_operand, images));
    }
    return keys;
}

} // namespace isocast
