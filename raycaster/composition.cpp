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
constexpr float tolerance_voxels = 1e-5F; // of raycast/march.glsl

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
    for (const FrameObject& object : frame.seen.objects) {
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

/// Of a root's distance by rounding, as it is written, read and added to: eight times 2^-24 of it.
double rounding_of(const Depths& depths) {
    return 0x1p-21 * depths.reach_world;
}

PlacesOnGpu tiles_of(const FrameContext& frame, std::span<const std::uint32_t> waiting,
                     std::uint32_t objects) {
    PlacesOnGpu places;
    places.set_runs(runs_of_tiles(frame.part.width, frame.part.height, [&](std::size_t tile) {
        return (waiting[tile] & objects) != 0;
    }));
    return places;
}

} // namespace

void set_operand_uniforms(const gl::Program& program, const FrameContext& frame, int number) {
    program.set("u_operand", number);
    // Behind the last root for sure; root pairs that are closer are below the guarantee.
    program.set("u_restart",
                Eigen::Vector2f(2 * tolerance_voxels,
                                2 * static_cast<float>(rounding_of(depths_of(frame)))));
}

void run_composition(FrameContext& frame) {
    const double near_world = depths_of(frame).near_world;
    start_counting_steps(frame);
    const CompositionWork work = compose_roots(
        frame, frame.targets.texture(FrameImage::Hit),
        [&](const FrameContext& object, int number) -> const gl::Program& {
            const gl::Program& program = object.shaders.program(operand_program(object));
            const RayCoefficients ray = set_search_uniforms(program, object);
            set_operand_uniforms(program, frame, number);
            program.set("u_near_share", static_cast<float>(1 - near_world / ray.depth_world));
            return program;
        });
    frame.notes.push_back(fmt::format("composition: {} objects, {} rounds, {} searches",
                                      frame.seen.objects.size(), work.rounds, work.searches));
}

CompositionWork compose_roots(FrameContext& frame, const gl::Texture& hit,
                              const OperandProgram& operand) {
    const int count = static_cast<int>(frame.seen.objects.size());
    const std::uint32_t all = (1U << count) - 1;
    const Depths depths = depths_of(frame);
    std::vector<gl::Texture> roots;
    std::vector<gl::Framebuffer> root_targets;
    const Eigen::Vector4f zero = Eigen::Vector4f::Zero();
    for (int i = 0; i < count; ++i) {
        roots.push_back(
            gl::Texture::image(gl::Format::Rgba32f, frame.part.width, frame.part.height, "roots"));
        root_targets.emplace_back(gl::Framebuffer({&roots.back()}, "roots"));
        root_targets.back().bind();
        glClearBufferfv(GL_COLOR, 0, zero.data());
        frame.scratch_bytes += roots.back().byte_count();
    }
    const gl::Texture pending = gl::Texture::image(gl::Format::R32f, frame.part.width,
                                                   frame.part.height, "pending objects");
    frame.scratch_bytes += pending.byte_count();
    const gl::Framebuffer hit_and_pending({&hit, &pending}, "hit and pending objects");
    hit_and_pending.bind();
    glClearBufferfv(GL_COLOR, 0, zero.data());
    const Eigen::Vector4f all_pending(static_cast<float>(all), 0, 0, 0);
    glClearBufferfv(GL_COLOR, 1, all_pending.data());

    const InsideTable table = inside_table(tree_of(frame.scene), count);
    const auto tile_count =
        static_cast<std::size_t>(tiles_along(frame.part.width) * tiles_along(frame.part.height));
    gl::ReadbackBuffer waiting_on_gpu(std::int64_t{4} * static_cast<std::int64_t>(tile_count),
                                      "objects that tiles wait for");
    // At first for all objects where there is one: on which side of the others a ray is must be
    // known, too.
    std::vector<std::uint32_t> waiting(tile_count);
    for (const Eigen::Vector4i& run : frame.places.tile_runs)
        std::fill_n(waiting.begin() + run[0] +
                        std::ptrdiff_t{tiles_along(frame.part.width)} * run[2],
                    run[1] - run[0], all);
    CompositionWork work;
    do {
        pending.bind_to_unit(6);
        for (int i = 0; i < count; ++i) {
            const PlacesOnGpu tiles = tiles_of(frame, waiting, 1U << i);
            if (tiles.run_count == 0) continue;
            const auto k = static_cast<std::size_t>(i);
            const FrameContext object = of_object(frame, frame.seen.objects[k]);
            const gl::Program& program = operand(object, i);
            roots[k].bind_to_unit(5);
            root_targets[k].bind();
            glTextureBarrier();
            glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
            draw_on_tiles(object, program, tiles);
            ++work.searches;
        }
        ++work.rounds;

        const gl::Program& program = frame.shaders.program(compose_program(count));
        for (int i = 0; i < count; ++i) {
            const auto k = static_cast<std::size_t>(i);
            roots[k].bind_to_unit(first_root_unit + static_cast<unsigned>(i));
            const double world_from_voxel =
                frame.seen.objects[k].object.field->space().world_from_index.linear().norm();
            program.set(
                fmt::format("u_errors[{}]", i).c_str(),
                static_cast<float>(tolerance_voxels * world_from_voxel + rounding_of(depths)));
        }
        for (int word = 0; word < std::max(1, (1 << count) / 32); ++word)
            program.set(fmt::format("u_inside[{}]", word).c_str(),
                        static_cast<int>(table.words[static_cast<std::size_t>(word)]));
        program.set("u_tile_columns", tiles_along(frame.part.width));
        waiting_on_gpu.clear();
        waiting_on_gpu.bind_to_storage(0);
        glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
        hit_and_pending.bind();
        glTextureBarrier();
        draw_on_tiles(frame, program, tiles_of(frame, waiting, all));
        gl::Fence::after_all_commands().wait();
        std::memcpy(waiting.data(), waiting_on_gpu.data(), 4 * tile_count);
    } while (std::ranges::any_of(waiting, [](std::uint32_t objects) { return objects != 0; }));
    return work;
}

std::vector<gl::ProgramKey> composition_programs() {
    std::vector<gl::ProgramKey> keys;
    for (int count = 1; count <= max_object_count; ++count) keys.push_back(compose_program(count));
    return keys;
}

} // namespace isocast
