// SPDX-License-Identifier: MPL-2.0
#include "raycaster/composition.h"

#include "gl/readback.h"
#include "raycaster/field_passes.h"

#include <fmt/format.h>
#include <glad/gl.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace isocast {

namespace {

constexpr unsigned first_root_unit = 8;   // of compose.frag
constexpr double tolerance_voxels = 1e-5; // of raycast/march.glsl

gl::ProgramKey compose_program(int object_count) {
    return {{"common/tiles.vert", "raycast/compose.frag"},
            {{"OBJECTS", std::to_string(object_count)}}};
}

/// Where distances along rays start and how far they reach.
struct Depths {
    double near_world = 0;  // of a plane before all surfaces
    double reach_world = 0; // the greatest distance from it along a ray
};

/// Distances count from a plane near the objects, so that a far eye does not cost digits.
Depths depths_of(const FrameContext& frame) {
    const Vec3d back = frame.camera.view_from_world_rotation().row(2);
    double nearest = std::numeric_limits<double>::infinity();
    double farthest = 0;
    for (const FrameObject& object : frame.objects) {
        for (int i = 0; i < 8 && !object.box_world.isEmpty(); ++i) {
            const Vec3d from_eye =
                object.box_world.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i)) -
                frame.camera.eye_world;
            nearest = std::min(nearest, -back.dot(from_eye));
            farthest = std::max(farthest, from_eye.norm());
        }
    }
    const double near = std::isfinite(nearest) ? std::max(nearest, 0.0) : 0.0;
    return {near, farthest - near};
}

/// Of a distance of roots, as it is written and read [world]: a root is located to the tolerance;
/// four roundings of at most 2^-24 of the distance each, and as many of the place in the object.
double root_error(const FrameObject& object, const Depths& depths) {
    const double world_from_voxel = object.object.field->space().world_from_index.linear().norm();
    return tolerance_voxels * world_from_voxel + 0x1p-21 * depths.reach_world;
}

/// The roots of an object where rays wait for them.
void search(FrameContext& frame, int number, const Depths& depths, bool is_first,
            const gl::Texture& root, const gl::Framebuffer& target) {
    const FrameObject& object = frame.objects[static_cast<std::size_t>(number)];
    const FrameContext of_this = of_object(frame, object);
    const gl::Program& program = frame.shaders.program(operand_program(of_this));
    const RayCoefficients ray = set_search_uniforms(program, of_this);
    program.set("u_operand", number);
    program.set("u_near_share", static_cast<float>(1 - depths.near_world / ray.depth_world));
    // Behind the last root for sure; root pairs that are closer are below the guarantee.
    const double voxels_from_world =
        object.object.field->space().world_from_index.linear().inverse().norm();
    program.set("u_restart",
                static_cast<float>(2 * root_error(object, depths) * voxels_from_world));
    root.bind_to_unit(5);
    target.bind();
    glTextureBarrier();
    // On which side a ray is must be known where it meets no block of the object, too.
    draw_on_tiles(is_first ? frame : of_this, program);
}

} // namespace

void run_composition(FrameContext& frame) {
    const int count = static_cast<int>(frame.objects.size());
    const Depths depths = depths_of(frame);
    std::vector<gl::Texture> roots;
    std::vector<gl::Framebuffer> root_targets;
    const Eigen::Vector4f zero = Eigen::Vector4f::Zero();
    for (int i = 0; i < count; ++i) {
        roots.push_back(
            gl::Texture::image(gl::Format::Rgba32f, frame.width, frame.height, "roots"));
        root_targets.emplace_back(gl::Framebuffer({&roots.back()}, "roots"));
        root_targets.back().bind();
        glClearBufferfv(GL_COLOR, 0, zero.data());
        frame.scratch_bytes += roots.back().byte_count();
    }
    const gl::Texture pending =
        gl::Texture::image(gl::Format::R32f, frame.width, frame.height, "pending objects");
    frame.scratch_bytes += pending.byte_count();
    const gl::Framebuffer hit_and_pending({&frame.targets.texture(FrameImage::Hit), &pending},
                                          "hit and pending objects");
    hit_and_pending.bind();
    glClearBufferfv(GL_COLOR, 0, zero.data());
    const auto all = static_cast<float>((1 << count) - 1);
    const std::array<float, 4> all_pending{all, 0, 0, 0};
    glClearBufferfv(GL_COLOR, 1, all_pending.data());

    const InsideTable table = inside_table(tree_of(frame.scene), count);
    double tie = 0;
    for (const FrameObject& object : frame.objects)
        tie = std::max(tie, 2 * root_error(object, depths));
    gl::ReadbackBuffer waiting(std::int64_t{4} * max_object_count, "objects with waiting rays");
    std::vector<int> to_search(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) to_search[static_cast<std::size_t>(i)] = i;
    int rounds = 0;
    int searches = 0;
    while (!to_search.empty()) {
        pending.bind_to_unit(6);
        for (const int i : to_search)
            search(frame, i, depths, rounds == 0, roots[static_cast<std::size_t>(i)],
                   root_targets[static_cast<std::size_t>(i)]);
        ++rounds;
        searches += static_cast<int>(to_search.size());

        const gl::Program& program = frame.shaders.program(compose_program(count));
        for (int i = 0; i < count; ++i)
            roots[static_cast<std::size_t>(i)].bind_to_unit(first_root_unit +
                                                            static_cast<unsigned>(i));
        for (int word = 0; word < std::max(1, (1 << count) / 32); ++word)
            program.set(fmt::format("u_inside[{}]", word).c_str(),
                        static_cast<int>(table.words[static_cast<std::size_t>(word)]));
        program.set("u_tie", static_cast<float>(tie));
        waiting.clear();
        waiting.bind_to_storage(0);
        glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
        hit_and_pending.bind();
        glTextureBarrier();
        draw_on_tiles(frame, program);
        gl::Fence::after_all_commands().wait();
        std::array<std::uint32_t, max_object_count> is_waiting{};
        std::memcpy(is_waiting.data(), waiting.data(), sizeof(is_waiting));
        to_search.clear();
        for (int i = 0; i < count; ++i)
            if (is_waiting[static_cast<std::size_t>(i)] != 0) to_search.push_back(i);
    }
    frame.notes.push_back(
        fmt::format("composition: {} objects, {} rounds, {} searches", count, rounds, searches));
}

std::vector<gl::ProgramKey> composition_programs() {
    std::vector<gl::ProgramKey> keys;
    for (int count = 1; count <= max_object_count; ++count) keys.push_back(compose_program(count));
    return keys;
}

} // namespace isocast
