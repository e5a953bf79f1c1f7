// Batches of tiles: sections on the CPU, two passes on the GL, exact distances on the CPU.
// SPDX-License-Identifier: MPL-2.0
//
//     CPU   sections 0 | sections 1         exact 0 | sections 2         exact 1 | ...
//     GL               | bound 0  candidates 0      | bound 1  candidates 1      | ...
#include "distance_transform/gl/scan_on_gpu.h"

#include "distance_transform/gl/exact_block.h"
#include "distance_transform/gl/site_sections.h"
#include "distance_transform/progress_meter.h"
#include "distance_transform/tile_transform.h"
#include "gl/readback.h"
#include "gl/timer.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <glad/gl.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <chrono>
#include <cstring>

namespace isocast {

namespace {

gl::ProgramKey program_key(const std::string& fragment_shader, int kind) {
    return {{"distance/section.vert", fragment_shader}, {{"SITE_KIND", std::to_string(kind)}}};
}
gl::ProgramKey nearest_program(int kind) {
    return program_key("distance/nearest.frag", kind);
}
gl::ProgramKey candidates_program(int kind) {
    return program_key("distance/candidates.frag", kind);
}

/// Adds what passes in its scope.
class Stopwatch {
public:
    explicit Stopwatch(double& seconds) : seconds_(seconds) {}
    ~Stopwatch() { seconds_ += std::chrono::duration<double>(Clock::now() - start_).count(); }
    Stopwatch(const Stopwatch&) = delete;
    Stopwatch& operator=(const Stopwatch&) = delete;

private:
    using Clock = std::chrono::steady_clock;
    double& seconds_;
    Clock::time_point start_ = Clock::now();
};

/// The image that a batch is drawn to: tiles as slots, each with its slices one above the other.
struct Target {
    int columns;
    int rows;

    explicit Target(int most_pixels)
        : columns(std::max(1, most_pixels / slot_width)),
          rows(std::max(1, most_pixels / slot_height)) {}
    int slots() const { return columns * rows; }
    int width() const { return slot_width * columns; }
    int height() const { return slot_height * rows; }

private:
    static constexpr int slot_width = tile_size;
    static constexpr int slot_height = tile_size * tile_size;
};

/// Instances of one kind with the same number of slices.
struct Draw {
    int kind;
    int slice_count;
    std::uint32_t first;
    std::uint32_t count;
};

/// What one batch of tiles gives the GL to draw.
struct BatchSections {
    std::vector<SeenTile> tiles;
    std::vector<GpuSite> sites; // draw by draw
    std::vector<Draw> draws;
};

/// A batch on its way through the GL, with all that it needs to be drawn again.
struct Stage {
    std::vector<SeenTile> tiles;
    std::vector<Draw> draws;
    gl::Buffer sites;
    gl::VertexArray instances;
    gl::Texture bound;
    gl::Framebuffer framebuffer;
    gl::Buffer counter;
    gl::ReadbackBuffer count;
    gl::ReadbackBuffer candidates;
    gl::Fence drawn;
    gl::Timer timer;
};

/// What section.vert reads of a GpuSite.
constexpr std::array attributes = {gl::AttributeType::Int4,   gl::AttributeType::Float4,
                                   gl::AttributeType::Float4, gl::AttributeType::Float4,
                                   gl::AttributeType::Float4, gl::AttributeType::Float4,
                                   gl::AttributeType::Float4, gl::AttributeType::Float4,
                                   gl::AttributeType::Float4, gl::AttributeType::Int4};
static_assert(sizeof(GpuSite) == 16 * attributes.size());

/// Of all tiles of a batch: each takes 288 bytes for its exact distances and 160 or more for the
/// GL, so that the two batches at work stay below some hundred MB.
constexpr std::size_t most_sites = 500'000;

/// Two triangles for each slice, of its four corners.
constexpr int indices_per_slice = 6;
gl::Buffer corner_indices() {
    std::vector<std::uint16_t> indices;
    for (int slice = 0; slice < tile_size; ++slice)
        for (const int corner : {0, 1, 2, 2, 1, 3})
            indices.push_back(static_cast<std::uint16_t>(4 * slice + corner));
    return {std::as_bytes(std::span(indices)), "corners of sections"};
}

class GpuScanner {
public:
    GpuScanner(gl::Context& context, gl::ShaderLibrary& shaders, const Sites& sites,
               const BandTiles& band, const WindingNumber* winding, double voxel_size_world,
               const GpuScanOptions& options, const Progress& progress)
        : context_(context), shaders_(shaders), sites_(sites), band_(band),
          transform_(sites, {.winding = winding}, voxel_size_world, band.block_count),
          voxel_size_(voxel_size_world),
          target_(std::min(options.target_extent, gl::max_image_extent())),
          most_bytes_(gl::max_storage_bytes()),
          no_attachments_(gl::Framebuffer::without_attachments(target_.width(), target_.height(),
                                                               "candidates")),
          corners_(corner_indices()),
          meter_(progress, "transform", static_cast<double>(band.tiles.size()), 16) {}

    GpuScan run() {
        std::array<Stage, 2> stages;
        for (Stage& stage : stages) {
            stage.bound = gl::Texture::image(gl::Format::R32f, target_.width(), target_.height(),
                                             "bound above the distance");
            stage.framebuffer = gl::Framebuffer({&stage.bound}, "bound above the distance");
            stage.count = gl::ReadbackBuffer(sizeof(std::uint32_t), "number of candidates");
            // Mostly one for each sample, of which the band seldom fills half; else it grows.
            reserve_candidates(stage, std::int64_t{target_.width()} * target_.height() / 2);
        }
        std::span<const BandTile> rest = band_.tiles;
        Stage* drawing = nullptr;
        while (!rest.empty()) {
            BatchSections batch = next_batch(rest);
            rest = rest.subspan(batch.tiles.size());
            Stage& stage = stages[result_.batches % 2];
            start(stage, std::move(batch));
            if (drawing) finish(*drawing);
            drawing = &stage;
            ++result_.batches;
        }
        if (drawing) finish(*drawing);
        result_.blocks = transform_.take().blocks;
        return std::move(result_);
    }

private:
    /// The first of `rest`, as many as have slots and as memory should be taken for.
    BatchSections next_batch(std::span<const BandTile> rest) {
        const Stopwatch watch(result_.time.sections_seconds);
        std::size_t count = 0;
        for (std::size_t site_count = 0;
             count < std::min(rest.size(), static_cast<std::size_t>(target_.slots())); ++count) {
            site_count += rest[count].count;
            if (count > 0 && site_count > most_sites) break;
        }
        BatchSections batch{.tiles = std::vector<SeenTile>(count)};
        std::vector<std::vector<SiteSections>> of_tile(count);
        tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
            batch.tiles[i] = see_tile(sites_, band_, rest[i]);
            of_tile[i] = sections_of_tile(batch.tiles[i], static_cast<int>(i));
        });

        const auto bin_of = [](const SiteSections& s) {
            return static_cast<std::size_t>(s.kind * tile_size + s.slice_count - 1);
        };
        constexpr std::size_t bins = site_kinds * tile_size;
        std::vector<std::uint32_t> begin(bins + 1);
        for (const auto& tile : of_tile)
            for (const SiteSections& site : tile) ++begin[bin_of(site) + 1];
        for (std::size_t i = 0; i < bins; ++i) {
            const std::uint32_t in_bin = begin[i + 1];
            begin[i + 1] += begin[i];
            if (in_bin == 0) continue;
            const int slices = static_cast<int>(i) % tile_size + 1;
            batch.draws.push_back({.kind = static_cast<int>(i) / tile_size,
                                   .slice_count = slices,
                                   .first = begin[i],
                                   .count = in_bin});
            result_.sections += std::int64_t{in_bin} * slices;
        }
        batch.sites.resize(begin.back());
        for (const auto& tile : of_tile)
            for (const SiteSections& site : tile) batch.sites[begin[bin_of(site)]++] = site.site;
        return batch;
    }

    static void reserve_candidates(Stage& stage, std::int64_t count) {
        stage.candidates =
            gl::ReadbackBuffer(count * std::int64_t{sizeof(Candidate)}, "candidates");
    }

    /// Gives the GL all of a batch's work.
    void start(Stage& stage, BatchSections batch) {
        stage.tiles = std::move(batch.tiles);
        stage.draws = std::move(batch.draws);
        stage.sites = gl::Buffer(std::as_bytes(std::span(batch.sites)), "sites");
        stage.instances = gl::VertexArray::instanced(stage.sites, attributes, corners_, "sites");
        stage.timer.start();
        draw_bounds(stage);
        draw_candidates(stage);
        stage.timer.stop();
        stage.drawn = gl::Fence::after_all_commands();
        context_.throw_pending_error();
    }

    void draw_bounds(const Stage& stage) {
        const gl::DebugGroup group("bounds above the distances");
        stage.framebuffer.bind();
        set_state();
        constexpr float none[4] = {1e30f, 0, 0, 0}; // nearest.frag has the same number
        glClearBufferfv(GL_COLOR, 0, none);
        glEnable(GL_BLEND);
        glBlendEquation(GL_MIN);
        for (const Draw& draw : stage.draws)
            draw_sections(stage, shaders_.program(nearest_program(draw.kind)), draw);
    }

    void draw_candidates(Stage& stage) {
        const gl::DebugGroup group("candidates");
        constexpr std::uint32_t zero = 0;
        stage.counter = gl::Buffer(std::as_bytes(std::span(&zero, 1)), "counter");
        no_attachments_.bind();
        set_state();
        glDisable(GL_BLEND);
        stage.bound.bind_to_unit(0);
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, stage.counter.id());
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, stage.candidates.id());
        for (const Draw& draw : stage.draws) {
            const gl::Program& program = shaders_.program(candidates_program(draw.kind));
            program.set("u_half_width", static_cast<float>(sites_.arrays().half_width));
            draw_sections(stage, program, draw);
        }
        glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
        glCopyNamedBufferSubData(stage.counter.id(), stage.count.id(), 0, 0, sizeof zero);
    }

    static void set_state() {
        glDisable(GL_DEPTH_TEST);
        glDisable(GL_CULL_FACE);
        glDisable(GL_SCISSOR_TEST);
        glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    }

    void draw_sections(const Stage& stage, const gl::Program& program, const Draw& draw) {
        program.set("u_slot_columns", target_.columns);
        program.set("u_target_size",
                    Eigen::Vector2i(target_.width(), target_.height()).cast<float>().eval());
        stage.instances.bind();
        program.use();
        glDrawElementsInstancedBaseInstance(GL_TRIANGLES, indices_per_slice * draw.slice_count,
                                            GL_UNSIGNED_SHORT, nullptr,
                                            static_cast<GLsizei>(draw.count), draw.first);
    }

    std::uint32_t wait(const Stage& stage) {
        const Stopwatch watch(result_.time.wait_seconds);
        stage.drawn.wait();
        std::uint32_t count = 0;
        std::memcpy(&count, stage.count.data(), sizeof count);
        return count;
    }

    /// Turns what the GL found into blocks.
    void finish(Stage& stage) {
        std::uint32_t count = wait(stage);
        result_.time.draw_seconds += stage.timer.milliseconds() / 1000;
        if (const std::int64_t bytes = std::int64_t{count} * std::int64_t{sizeof(Candidate)};
            bytes > stage.candidates.byte_count()) {
            if (bytes > most_bytes_)
                throw ResourceError(fmt::format(
                    "{} sites may be nearest to the samples of one batch, more than the GL's "
                    "buffers of {} MiB hold; use the CPU",
                    count, most_bytes_ >> 20));
            reserve_candidates(stage, count);
            stage.timer.start();
            draw_candidates(stage);
            stage.timer.stop();
            stage.drawn = gl::Fence::after_all_commands();
            count = wait(stage);
            result_.time.draw_seconds += stage.timer.milliseconds() / 1000;
            ++result_.repeated_batches;
        }
        const Stopwatch watch(result_.time.exact_seconds);
        result_.candidates += count;
        const std::span candidates(reinterpret_cast<const Candidate*>(stage.candidates.data()),
                                   count);
        write_blocks(stage.tiles, candidates);
    }

    void write_blocks(const std::vector<SeenTile>& tiles, std::span<const Candidate> candidates) {
        const auto block_of = [](const Candidate& c) { return c.sample / samples_per_block; };
        std::vector<std::uint32_t> begin(tiles.size() * blocks_per_tile + 1);
        for (const Candidate& candidate : candidates) ++begin[block_of(candidate) + 1];
        for (std::size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
        std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
        std::vector<Candidate> by_block(candidates.size());
        for (const Candidate& candidate : candidates)
            by_block[next[block_of(candidate)]++] = candidate;

        tbb::parallel_for(std::size_t{0}, tiles.size(), [&](std::size_t slot) {
            const SeenTile& tile = tiles[slot];
            transform_.add_blocks(tile.of_band, [&](int b, const Index3& at,
                                                    ScannedBlock& scanned) {
                const std::size_t number = slot * blocks_per_tile + static_cast<std::size_t>(b);
                return finish_block(
                    tile, at,
                    std::span(by_block).subspan(begin[number], begin[number + 1] - begin[number]),
                    sites_.arrays().half_width, voxel_size_, scanned);
            });
            meter_.add(1);
        });
    }

    gl::Context& context_;
    gl::ShaderLibrary& shaders_;
    const Sites& sites_;
    const BandTiles& band_;
    TileTransform transform_;
    double voxel_size_;
    Target target_;
    std::int64_t most_bytes_; // of the candidates of one batch
    gl::Framebuffer no_attachments_;
    gl::Buffer corners_;
    ProgressMeter meter_;
    GpuScan result_;
};

} // namespace

GpuScan scan_on_gpu(gl::Context& context, gl::ShaderLibrary& shaders, const Sites& sites,
                    const BandTiles& band, const WindingNumber* winding, double voxel_size_world,
                    const GpuScanOptions& options, const Progress& progress) {
    return GpuScanner(context, shaders, sites, band, winding, voxel_size_world, options, progress)
        .run();
}

std::vector<gl::ProgramKey> scan_programs() {
    std::vector<gl::ProgramKey> keys;
    for (int kind = 0; kind < site_kinds; ++kind) {
        keys.push_back(nearest_program(kind));
        keys.push_back(candidates_program(kind));
    }
    return keys;
}

} // namespace isocast
