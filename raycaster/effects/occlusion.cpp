// SPDX-License-Identifier: MPL-2.0
#include "raycaster/effects/occlusion.h"

#include "quadrics/primitive_tree.h"
#include "raycaster/composition.h"
#include "raycaster/field_passes.h"
#include "raycaster/splat_passes.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <glad/gl.h>

#include <algorithm>

namespace isocast {

namespace {

using Defines = std::map<std::string, std::string>;

gl::ProgramKey occlusion_program(Defines defines) {
    defines["TRAVERSAL"] = std::to_string(static_cast<int>(Traversal::Walk));
    return {{"common/tiles.vert", "shading/occlusion/occlusion.frag"}, std::move(defines)};
}

/// Of shaders/quadrics/tree.glsl.
///
/// kinds  by bits
Defines tree_defines(unsigned kinds, const CutKind& cut) {
    Defines defines{{"IS_PERSPECTIVE", "0"}}; // rays start anywhere
    add_kind_defines(defines, kinds);
    add_cut_defines(defines, cut);
    return defines;
}

gl::ProgramKey primitives_program(unsigned kinds, const CutKind& cut) {
    return {{"common/tiles.vert", "shading/occlusion/primitives.frag"}, tree_defines(kinds, cut)};
}

/// kinds  of primitives, if there are some
gl::ProgramKey count_program(const std::optional<unsigned>& kinds, const CutKind& cut) {
    Defines defines = kinds ? tree_defines(*kinds, cut) : Defines{};
    defines.emplace("HAS_PRIMITIVES", kinds ? "1" : "0");
    return {{"common/tiles.vert", "shading/occlusion/count.frag"}, std::move(defines)};
}

/// Made for one frame: the eye moves, and the tree takes less time than its rays.
struct TreeOnGpu {
    explicit TreeOnGpu(const PrimitiveTree& tree)
        : node_count(static_cast<int>(tree.nodes.size() / 2)), kinds(tree.kinds),
          nodes(std::as_bytes(std::span(tree.nodes)), gl::Format::Rgba32i, "tree of primitives"),
          bodies(std::as_bytes(std::span(tree.bodies)), gl::Format::Rgba32f,
                 "bodies of primitives") {}
    int node_count;
    unsigned kinds;
    NumbersOnGpu nodes;
    NumbersOnGpu bodies;
};

/// Of shaders/shading/occlusion/sky.glsl.
void set_sky_uniforms(const gl::Program& program, const FrameContext& frame,
                      double distance_world) {
    frame.targets.texture(FrameImage::Hit).bind_to_unit(3);
    frame.targets.texture(FrameImage::Gradient).bind_to_unit(4);
    program.set(
        "u_view_vector",
        Eigen::Matrix3f(
            world_vector_coefficients(frame.camera, frame.width, frame.height).cast<float>()));
    program.set("u_rays", frame.scene.look.effects.occlusion.rays);
    program.set("u_distance_world", static_cast<float>(distance_world));
}

/// The same, and of the rays' way through an object's field.
void set_field_uniforms(const gl::Program& program, const FrameContext& frame,
                        double distance_world, double lift_world) {
    set_sky_uniforms(program, frame, distance_world);
    frame.field().bind(program);
    set_hit_uniforms(program, frame, frame.field());
    set_extent_uniforms(program, frame);
    set_accuracy_uniforms(program, frame);
    program.set("u_lift_world", static_cast<float>(lift_world));
}

/// The same of the primitives.
void set_tree_uniforms(const gl::Program& program, const FrameContext& frame, const TreeOnGpu& tree,
                       double distance_world) {
    set_sky_uniforms(program, frame, distance_world);
    tree.nodes.texture.bind_to_unit(6);
    tree.bodies.texture.bind_to_unit(7);
    program.set("u_nodes", tree.node_count);
    set_cut_planes(program, frame, Mat3d::Identity());
    if (!program.has("u_coarse")) return;
    const bool has_levels = std::ranges::any_of(
        frame.primitives->slims, [](const SlimSurface& s) { return s.levels.size() > 1; });
    const auto half_pixel =
        static_cast<float>(has_levels ? 0.5 / pixels_per_unit(frame.camera, frame.height) : 0.0);
    program.set("u_coarse", is_perspective(frame) ? Eigen::Vector2f(half_pixel, 0)
                                                  : Eigen::Vector2f(0, half_pixel));
}

/// Of rays' starts off the surface. 1/64 voxel: hits are known to 1e-5, and coordinates of a
/// thousand voxels to 6e-5.
double lift_world(const FrameObject& object) {
    return object.object.field->space().voxel_size_world() / 64;
}

/// Ray by ray, each through all objects, and among the primitives.
void run_composed(FrameContext& frame, const std::optional<TreeOnGpu>& tree,
                  double distance_world) {
    const Occlusion& occlusion = frame.scene.look.effects.occlusion;
    double lift = 0;
    for (const FrameObject& object : frame.seen.objects) lift = std::max(lift, lift_world(object));
    const gl::Texture met = gl::Texture::image(gl::Format::Rgba32f, frame.part.width,
                                               frame.part.height, "what rays to the sky meet");
    frame.scratch_bytes += met.byte_count();
    const gl::Texture& seen = frame.targets.texture(FrameImage::Occlusion);
    frame.targets.framebuffer(FrameImage::Occlusion).bind();
    const Eigen::Vector4f all = Eigen::Vector4f::UnitX();
    glClearBufferfv(GL_COLOR, 0, all.data());
    const std::int64_t scratch_bytes = frame.scratch_bytes;
    for (int ray = 0; ray < occlusion.rays; ++ray) {
        frame.scratch_bytes = scratch_bytes; // what the ray before took is gone
        compose_roots(
            frame, met, [&](const FrameContext& object, int number) -> const gl::Program& {
                const gl::Program& program =
                    object.shaders.program(sky_operand_program(object.field().pool().defines()));
                set_field_uniforms(program, object, distance_world, lift);
                set_operand_uniforms(program, frame, number);
                const Mat3d& axes = object.object().field->space().world_from_index.linear();
                program.set("u_world_from_index", Eigen::Matrix3f(axes.cast<float>()));
                program.set("u_ray", ray);
                return program;
            });
        const gl::Program& program = frame.shaders.program(
            tree ? count_program(tree->kinds, cut_kind_of(frame)) : count_program({}, {}));
        met.bind_to_unit(0);
        seen.bind_to_unit(1);
        if (tree) {
            set_tree_uniforms(program, frame, *tree, distance_world);
            program.set("u_ray", ray);
        } else {
            program.set("u_rays", occlusion.rays);
        }
        frame.targets.framebuffer(FrameImage::Occlusion).bind();
        glTextureBarrier();
        draw_on_tiles(frame, program);
    }
}

} // namespace

void run_occlusion(FrameContext& frame) {
    if (frame.one != nullptr && !frame.field().pool().holds_all())
        throw ResourceError("all bricks must fit the texture budget for ambient occlusion");
    const std::optional<double>& asked = frame.scene.look.effects.occlusion.distance_world;
    double distance = asked.value_or(0);
    if (!asked) {
        const std::array<Vec3d, 8> box = frame.surface_box_world();
        distance = (box.back() - box.front()).norm() / 10;
        frame.notes.push_back(
            fmt::format("ambient occlusion: occluders within {:.3g} world units", distance));
    }
    std::optional<TreeOnGpu> tree;
    if (frame.primitives != nullptr) {
        const PrimitiveTree on_cpu =
            tree_of(*frame.primitives, frame.camera.eye_world, frame.seen.splats->planes);
        if (!on_cpu.nodes.empty()) tree.emplace(on_cpu); // not all is cut away
    }
    if (tree)
        frame.scratch_bytes += tree->nodes.buffer.byte_count() + tree->bodies.buffer.byte_count();
    if (frame.one == nullptr && !tree) {
        const Eigen::Vector4f all = Eigen::Vector4f::UnitX();
        frame.targets.framebuffer(FrameImage::Occlusion).bind();
        glClearBufferfv(GL_COLOR, 0, all.data());
    } else if (frame.one == nullptr) {
        const gl::Program& program =
            frame.shaders.program(primitives_program(tree->kinds, cut_kind_of(frame)));
        set_tree_uniforms(program, frame, *tree, distance);
        draw_tiles(frame, FrameImage::Occlusion, program, {1, 0, 0, 0});
    } else if (is_composed(frame.scene) || tree) {
        run_composed(frame, tree, distance);
    } else {
        const gl::Program& program =
            frame.shaders.program(occlusion_program(frame.field().pool().defines()));
        set_field_uniforms(program, frame, distance, lift_world(frame.seen.objects.front()));
        draw_tiles(frame, FrameImage::Occlusion, program, {1, 0, 0, 0});
    }
}

std::vector<gl::ProgramKey> occlusion_programs() {
    std::vector<gl::ProgramKey> keys;
    for (const Defines& defines : all_pool_defines())
        for (const gl::ProgramKey& key : {occlusion_program(defines), sky_operand_program(defines)})
            keys.push_back(key);
    keys.push_back(count_program({}, {}));
    for (unsigned k = 0; k < splat_kind_count; ++k) keys.push_back(primitives_program(1U << k, {}));
    keys.push_back(primitives_program(all_splat_kinds, {}));
    keys.push_back(count_program(all_splat_kinds, {}));
    for (const CutLook look : {CutLook::Inside, CutLook::Flat, CutLook::Capped}) {
        keys.push_back(primitives_program(all_splat_kinds, {2, look}));
        keys.push_back(count_program(all_splat_kinds, {2, look}));
    }
    return keys;
}

} // namespace isocast
