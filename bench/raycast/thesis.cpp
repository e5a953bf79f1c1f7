// The tables and figures of section 6.3 of the thesis, with our own fields.
// SPDX-License-Identifier: MPL-2.0
#include "raycast/raycast_bench.h"
#include "raycast/silhouette.h"
#include "raycaster/image_files.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstdio>

namespace isocast {

namespace {

std::vector<double> frames_per_second(Renderer& renderer, const std::vector<DrawCase>& cases,
                                      const Camera& camera, int size, int repeats) {
    std::vector<double> fps;
    for (const DrawResult& result : draw_in_turns(renderer, cases, camera, size, repeats))
        fps.push_back(1 / result.frame.median);
    return fps;
}

/// Edges of boxes drawn over a picture, behind what it shows.
class Wireframe {
public:
    Wireframe(Image& picture, const Image& hits, const Camera& camera)
        : picture_(picture), hits_(hits), camera_(camera),
          view_from_world_(camera.view_from_world_rotation()),
          pixels_per_unit_(picture.height / 2.0 / camera.half_height_at(1)) {}

    void draw_box(const GridSpace& space, const Vec3d& lo_index, double edge, const Vec3d& colour) {
        for (int axis = 0; axis < 3; ++axis) {
            for (int corner = 0; corner < 4; ++corner) {
                Vec3d from = lo_index;
                from[(axis + 1) % 3] += edge * (corner & 1);
                from[(axis + 2) % 3] += edge * (corner >> 1);
                draw_edge(space.to_world(from), space.to_world(from + edge * Vec3d::Unit(axis)),
                          colour);
            }
        }
    }

private:
    void draw_edge(const Vec3d& a_world, const Vec3d& b_world, const Vec3d& colour) {
        constexpr int steps = 64;
        for (int i = 0; i <= steps; ++i) {
            const Vec3d from_eye =
                a_world + (b_world - a_world) * i / double(steps) - camera_.eye_world;
            const Vec3d view = view_from_world_ * from_eye;
            const int x =
                int(std::floor(picture_.width / 2.0 - pixels_per_unit_ * view.x() / view.z()));
            const int y =
                int(std::floor(picture_.height / 2.0 + pixels_per_unit_ * view.y() / view.z()));
            if (view.z() >= 0 || x < 0 || y < 0 || x >= picture_.width || y >= picture_.height)
                continue;
            const float* hit = hits_.pixel(x, y);
            const double hit_distance = Vec3d(hit[0], hit[1], hit[2]).norm();
            if (hit[3] != 0 && hit_distance < from_eye.norm()) continue;
            float* pixel = picture_.rgba.data() +
                           4 * (std::size_t(y) * std::size_t(picture_.width) + std::size_t(x));
            for (int c = 0; c < 3; ++c) pixel[c] = static_cast<float>(colour[c]);
        }
    }

    Image& picture_;
    const Image& hits_;
    Camera camera_;
    Mat3d view_from_world_;
    double pixels_per_unit_;
};

Image cropped(const Image& image, int x_lo, int y_lo, int width, int height) {
    Image out{width, height, {}};
    for (int y = 0; y < height; ++y) {
        const float* row = image.pixel(x_lo, y_lo + y);
        out.rgba.insert(out.rgba.end(), row, row + std::size_t{4} * std::size_t(width));
    }
    return out;
}

} // namespace

void run_table_6_1(Renderer& renderer, const std::vector<TableField>& fields, int size,
                   int repeats) {
    fmt::print("\nThesis table 6.1: frames a second at {0} x {0}, full picture\n{1:<24} {2:>16} "
               "{3:>12} {4:>12}\n",
               size, "field", "grid", "certified", "rate 1");
    for (const TableField& field : fields) {
        const std::vector<double> fps =
            frames_per_second(renderer,
                              {{"certified", {.field = field.field}},
                               {"rate", {.field = field.field, .quality = {.rate = 1.0}}}},
                              field.camera, size, repeats);
        const Index3 n = field.field->extent().size();
        fmt::print("{:<24} {:>16} {:>12.1f} {:>12.1f}\n", field.name,
                   fmt::format("{}x{}x{}", n.x(), n.y(), n.z()), fps[0], fps[1]);
        std::fflush(stdout);
    }
}

void run_table_6_2(Renderer& renderer, const std::shared_ptr<const FieldSource>& field,
                   const Camera& camera, int size, int repeats) {
    constexpr std::array rates{0.25, 0.5, 1.0, 2.0, 4.0, 8.0};
    struct Row {
        const char* traversal;
        int factor;
        const char* bricks;
    };
    constexpr std::array rows{
        Row{"bounds", 1, "none"}, Row{"bounds", 1, "32"}, Row{"bounds", 8, "none"},
        Row{"bounds", 8, "32"},   Row{"drawn", 1, "32"},  Row{"drawn", 8, "32"},
        Row{"walk", 1, "32"},     Row{"walk", 8, "32"},   Row{"lists", 1, "none"},
        Row{"lists", 1, "32"},    Row{"lists", 1, "8"},   Row{"lists", 8, "8"}};
    fmt::print("\nThesis table 6.2: frames a second at {0} x {0}, full picture, by the greatest "
               "rate [samples a voxel]\n{1:<10} {2:<12} {3:<8}",
               size, "blocks by", "adaptive", "bricks");
    for (const double rate : rates) fmt::print(" {:>7}", rate);
    fmt::print("\n");
    for (const Row& row : rows) {
        std::vector<DrawCase> cases;
        for (const double rate : rates) {
            if (row.factor > 1 && rate < 1) continue; // as in the thesis: r0 of 1/8 and more
            cases.push_back({"",
                             {.field = field,
                              .storage = {.brick_size = brick_size_from_name(row.bricks)},
                              .quality = {.traversal = traversal_from_name(row.traversal),
                                          .rate = rate / row.factor,
                                          .rate_factor = row.factor}}});
        }
        const std::vector<double> fps = frames_per_second(renderer, cases, camera, size, repeats);
        fmt::print("{:<10} {:<12} {:<8}", row.traversal, row.factor > 1 ? "r1 = 8 r0" : "no",
                   row.bricks);
        for (std::size_t i = fps.size(); i < rates.size(); ++i) fmt::print(" {:>7}", "");
        for (const double value : fps) fmt::print(" {:>7.2f}", value);
        fmt::print("\n");
        std::fflush(stdout);
    }
    std::vector<DrawCase> certified;
    for (const char* traversal : {"bounds", "drawn", "walk", "lists"})
        certified.push_back(
            {traversal,
             {.field = field, .quality = {.traversal = traversal_from_name(traversal)}}});
    const std::vector<double> fps = frames_per_second(renderer, certified, camera, size, repeats);
    fmt::print("certified to 0.01 voxel, bricks of 8:");
    for (std::size_t i = 0; i < fps.size(); ++i)
        fmt::print("  {} {:.2f}", certified[i].name, fps[i]);
    fmt::print("\n");
    std::fflush(stdout);
}

void run_silhouettes(Renderer& renderer) {
    constexpr int size = 512;
    constexpr int phases = 8;
    fmt::print(
        "\nThesis figure 6.7: spheres of R voxels under {0} x {0} parallel rays; depth of the "
        "deepest ray that samples miss against its bound; distance of the certified hits from "
        "the sphere [voxels]\n"
        "{1:>6} {2:>8} {3:>10} {4:>10} {5:>10} {6:>8} {7:>8} {8:>8} {9:>10}\n",
        size, "R", "rate", "adaptive", "bound h", "measured", "rays", "missed", "false", "surface");
    for (const double radius : {5.0, 20.0}) {
        for (const int factor : {1, 8}) {
            for (const double rate : {0.25, 0.5, 1.0, 2.0, 4.0, 8.0}) {
                if (factor > 1 && rate < 1) continue;
                const SilhouetteError e =
                    silhouette_error(renderer, radius, rate, factor, size, phases);
                fmt::print("{:>6} {:>8} {:>10} {:>10.5f} {:>10.5f} {:>8} {:>8} {:>8} {:>10.5f}\n",
                           radius, rate, factor > 1 ? "r1 = 8 r0" : "no", e.bound_voxels,
                           e.deepest_voxels, e.rays, e.missed, e.false_hits,
                           e.surface_error_voxels);
                std::fflush(stdout);
            }
        }
    }
}

void write_figures(Renderer& renderer, const std::shared_ptr<const FieldSource>& field,
                   const Camera& camera, const std::filesystem::path& folder) {
    constexpr int size = 768;
    const Scene scene{.field = field};
    renderer.load(scene);
    renderer.draw(camera, size, size, {FrameImage::Beauty, FrameImage::Hit});
    const Image hits = renderer.read(FrameImage::Hit);
    Image picture = renderer.read(FrameImage::Beauty);
    const auto control = control_samples(field, scene.filter);
    const BlockRanges ranges = find_block_ranges(*control, kernel_of(scene.filter));
    Wireframe wireframe(picture, hits, camera);
    for (const ActivePage& page : active_pages(ranges, 0)) {
        const Vec3d lo = (page_size * ranges.pages[page.page].coordinate).cast<double>();
        for (std::uint64_t rest = page.blocks; rest != 0; rest &= rest - 1)
            wireframe.draw_box(
                field->space(),
                lo + (block_size * block_in_page(std::countr_zero(rest))).cast<double>(),
                block_size, {0.05, 0.12, 0.55});
    }
    // The larger ones last, so that they stay visible where edges coincide.
    for (const ActivePage& page : active_pages(ranges, 0))
        wireframe.draw_box(field->space(),
                           (page_size * ranges.pages[page.page].coordinate).cast<double>(),
                           page_size, {0.05, 0.45, 0.08});
    write_png(picture, folder / "figure_6_3.png");

    // The upper left corner of a picture three times as large, on both sides of a silhouette.
    const auto detail = [&](const Quality& quality) {
        renderer.load({.field = field, .quality = quality});
        renderer.draw(camera, 3 * size, 3 * size, {FrameImage::Beauty});
        return cropped(renderer.read(FrameImage::Beauty), size * 3 / 4, size * 3 / 8, size, size);
    };
    write_png(detail({.rate = 0.5}), folder / "figure_6_8_rate_half.png");
    write_png(detail({.rate = 0.5, .rate_factor = 8}), folder / "figure_6_8_adaptive.png");
    write_png(detail({}), folder / "figure_6_8_certified.png");
    fmt::print("\nfigures 6.3 and 6.8 in {}\n", folder.string());
}

} // namespace isocast
