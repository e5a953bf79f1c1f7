// docs_point_pictures FOLDER: thesis figures 4.11 and 4.12 for distance_transform.md.
// SPDX-License-Identifier: MPL-2.0
#include "docs/program.h"
#include "docs/slice.h"

#include "distance_transform/meshless.h"

#include <fmt/format.h>

#include <filesystem>
#include <functional>
#include <numbers>
#include <random>
#include <string_view>

namespace {

using namespace isocast;

/// A square picture of places (x, y).
class Canvas {
public:
    Canvas(int width, const Vec3d& lo, const Vec3d& hi)
        : lo_(lo), scale_((width / (hi - lo).array()).matrix()),
          slice_({Index3::Zero(), {width, width, 1}}) {}
    void fill(const std::function<Colour(const Vec3d&)>& colour_at) {
        const int width = slice_.box().hi.x();
        for (int y = 0; y < width; ++y)
            for (int x = 0; x < width; ++x)
                slice_.set({x, y, 0}, colour_at({lo_.x() + (x + 0.5) / scale_.x(),
                                                 lo_.y() + (y + 0.5) / scale_.y(), 0}));
    }
    Index3 pixel_of(double x, double y) const {
        return {static_cast<int>(std::lround((x - lo_.x()) * scale_.x())),
                static_cast<int>(std::lround((y - lo_.y()) * scale_.y())), 0};
    }
    /// A disc of `radius` pixels.
    void dot(const Index3& middle, double radius, const Colour& colour) {
        const int reach = static_cast<int>(radius);
        for (int v = -reach; v <= reach; ++v)
            for (int u = -reach; u <= reach; ++u)
                if (u * u + v * v <= radius * radius) set(middle + Index3(u, v, 0), colour);
    }
    void curve(const std::function<double(double)>& y_of, double x_end, const Colour& colour) {
        for (double x = 0; x <= x_end; x += 0.1 / scale_.x())
            dot(pixel_of(x, y_of(x)), 1.5, colour);
    }
    void line(const Index3& from, const Index3& to, const Colour& colour) {
        const int steps = (to - from).cwiseAbs().maxCoeff();
        for (int i = 0; i <= steps; ++i) set(from + ((to - from) * i) / std::max(steps, 1), colour);
    }
    /// Digits and points, four pixels wide and twice as large as that, from their lower left end.
    void number(Index3 at, std::string_view text) {
        // Rows of three pixels from the top.
        static constexpr std::array<int, 10> digits = {075557, 026227, 071747, 071717, 055711,
                                                       074717, 074757, 071111, 075757, 075717};
        for (const char c : text) {
            const int rows = c == '.' ? 000002 : digits[static_cast<std::size_t>(c - '0')];
            for (int i = 0; i < 15; ++i) {
                if (!(rows >> i & 1)) continue;
                const Index3 corner = at + 3 * Index3(2 - i % 3, i / 3, 0);
                for (int k = 0; k < 9; ++k) set(corner + Index3(k % 3, k / 3, 0), Colour::Zero());
            }
            at.x() += 12;
        }
    }
    const Image& image() const { return slice_.image(); }

private:
    void set(const Index3& pixel, const Colour& colour) {
        if (slice_.box().contains(pixel)) slice_.set(pixel, colour);
    }
    Vec3d lo_;
    Vec3d scale_; // pixels per unit
    SliceCanvas slice_;
};

/// Thesis figure 4.11: what each method makes of five points of a circle with their normals.
Image five_samples(PointMethod method) {
    std::vector<Vec3d> points;
    for (int i = 0; i < 5; ++i) {
        const double angle = (0.25 + i / 5.0) * 2 * std::numbers::pi;
        points.emplace_back(std::cos(angle), std::sin(angle), 0);
    }
    const Meshless field(points, points, {.method = method, .neighbours = 4, .same_side = false});
    constexpr int width = 320;
    constexpr double reach = 2;
    Canvas canvas(width, Vec3d(-reach, -reach, 0), Vec3d(reach, reach, 1));
    canvas.fill([&](const Vec3d& p) {
        return distance_colour(field.at(p).near * width / (2 * reach) / 2); // a stripe: 10 pixels
    });
    for (const Vec3d& p : points) {
        canvas.line(canvas.pixel_of(p.x(), p.y()), canvas.pixel_of(1.3 * p.x(), 1.3 * p.y()),
                    Colour::Zero());
        canvas.dot(canvas.pixel_of(p.x(), p.y()), 4, Colour(0.8f, 0, 0));
    }
    return canvas.image();
}

/// (4.13), d in radii of the disc of the neighbours
double exact_deviation(double d) {
    const double cubes = std::pow(1 + d * d, 1.5) - d * d * d;
    return std::sqrt(std::max(9 + 18 * d * d - 8 * cubes * cubes, 0.0) / 8) / cubes;
}

/// Deviations at places above planes of points, against their height.
void draw_sampled(Canvas& canvas, std::span<const Vec3d> points, const Colour& colour,
                  unsigned seed) {
    constexpr int neighbours = 20;
    const double disc_radius = std::sqrt(neighbours / std::numbers::pi); // at a point per unit area
    const PointTree tree(points);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(0, 1);
    std::vector<Neighbour> seen;
    for (int i = 0; i < 500; ++i) {
        const double d = 3 * any(random);
        const Vec3d p(8 * any(random) - 4, 8 * any(random) - 4, d * disc_radius);
        tree.nearest(p, neighbours, seen);
        std::vector<double> distances;
        for (const Neighbour& n : seen) distances.push_back(std::sqrt(n.squared_distance));
        canvas.dot(canvas.pixel_of(d, relative_deviation(distances)), 2.5, colour);
    }
}

/// Thesis figure 4.12.
Image deviation_plot() {
    Canvas canvas(640, Vec3d(-0.25, -0.04, 0), Vec3d(3.05, 0.52, 1));
    const Colour grid = Colour::Constant(0.85f);
    for (int i = 0; i <= 6; ++i) {
        canvas.line(canvas.pixel_of(i / 2.0, 0), canvas.pixel_of(i / 2.0, 0.5), grid);
        canvas.number(canvas.pixel_of(i / 2.0, 0) - Index3(i % 2 * 15 + 4, 26, 0),
                      i % 2 ? fmt::format("{:.1f}", i / 2.0) : fmt::format("{}", i / 2));
    }
    for (int i = 0; i <= 5; ++i) {
        canvas.line(canvas.pixel_of(0, i / 10.0), canvas.pixel_of(3, i / 10.0), grid);
        if (i > 0)
            canvas.number(canvas.pixel_of(0, i / 10.0) - Index3(44, 7, 0),
                          fmt::format("{:.1f}", i / 10.0));
    }
    std::mt19937 random(1);
    std::uniform_real_distribution<double> any(-20, 20);
    std::vector<Vec3d> scattered;
    for (int i = 0; i < 1600; ++i) scattered.emplace_back(any(random), any(random), 0);
    std::vector<Vec3d> lattice;
    for (int i = 0; i < 1600; ++i) lattice.emplace_back(i % 40 - 20, i / 40 - 20, 0);
    draw_sampled(canvas, scattered, Colour(0.65f, 0.76f, 0.90f), 2);
    draw_sampled(canvas, lattice, Colour(0.10f, 0.38f, 0.75f), 3);
    canvas.curve([](double d) { return 1 / (std::sqrt(8.0) + 6.93 * d * d); }, 3,
                 Colour(0.95f, 0.50f, 0.10f));
    canvas.curve(exact_deviation, 3, Colour::Zero());
    return canvas.image();
}

} // namespace

int main(int argc, char** argv) {
    return run_program(argc, "docs_point_pictures FOLDER", [&] {
        const std::filesystem::path folder = argv[1];
        write_png(
            above(beside(five_samples(PointMethod::Shepard),
                         five_samples(PointMethod::ModifiedShepard)),
                  beside(five_samples(PointMethod::Rbf), five_samples(PointMethod::Partition))),
            folder / "points_five.png");
        write_png(deviation_plot(), folder / "points_deviation.png");
    });
}
