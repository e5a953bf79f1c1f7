// What curvatures err, beside OpenVDB's stencil and teem's gage, and what passes of picture space
// take as the field grows.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/curvature.h"
#include "filtering/filter.h"
#include "peers/child.h"
#include "peers/peer_frame.h"
#include "peers/programs.h"
#include "raycaster/renderer.h"
#include "volume/analytic_fields.h"
#include "volume/dense_field.h"
#include "volume/files.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <openvdb/math/Stencils.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>
#include <tbb/parallel_for.h>

#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <sstream>

namespace isocast {
namespace {

const std::filesystem::path shader_folder = std::filesystem::path(ISOCAST_SOURCE_DIR) / "shaders";

/// A surface in a grid of resolution^3 voxels of size 1, off the lattice.
struct Shape {
    std::string name;
    AnalyticField field;
};

/// Exact distances, but for the saddle, a quadratic function: by its slope, which leaves its
/// surface and that one's curvatures as they are; gradient and Hessian are the function's.
std::vector<Shape> shapes_at(int resolution) {
    const double n = resolution;
    const double half = (n - 1) / 2;
    const Vec3d middle(half + 0.137, half - 0.241, half + 0.319);
    const Vec3d axis(0.3, 1, 0.5);
    const AnalyticField unit_saddle = builtin_field("saddle");
    const AnalyticField saddle{"saddle", [=](const Vec3d& p) {
                                   Jet jet = unit_saddle.jet((p - middle) / half);
                                   jet.value *= half / jet.gradient.norm();
                                   jet.hessian /= half;
                                   return jet;
                               }};
    return {{"sphere", sphere_field(middle, 0.35 * n)},
            {"torus", torus_field(middle, axis, 0.28 * n, 0.11 * n)},
            {"cylinder", cylinder_field(middle, axis, 0.25 * n)},
            {"saddle", saddle}};
}

std::shared_ptr<const DenseField> samples_of(const AnalyticField& field, int resolution,
                                             std::optional<double> half_width) {
    const IndexBox box{Index3::Zero(), Index3::Constant(resolution)};
    std::vector<float> values(static_cast<std::size_t>(box.sample_count()));
    tbb::parallel_for(0, resolution, [&](int z) {
        auto i = static_cast<std::size_t>(z) * static_cast<std::size_t>(resolution) *
                 static_cast<std::size_t>(resolution);
        for (int y = 0; y < resolution; ++y)
            for (int x = 0; x < resolution; ++x) {
                double value = field.jet(Vec3d(x, y, z)).value;
                if (half_width) value = std::clamp(value, -*half_width, *half_width);
                values[i++] = static_cast<float>(value);
            }
    });
    return std::make_shared<DenseField>(GridSpace::uniform(1), box, std::move(values), half_width);
}

Camera camera_at(int resolution) {
    const Vec3d middle = Vec3d::Constant((resolution - 1) / 2.0);
    return {.eye_world = middle + 2.2 * resolution * Vec3d(0.45, 0.35, 1).normalized(),
            .target_world = middle};
}

double degrees_between_lines(const Vec3d& a, const Vec3d& b) {
    return std::atan2(a.cross(b).norm(), std::abs(a.dot(b))) * 180 / std::numbers::pi;
}

/// Root of the mean of squares, and the greatest.
struct Errors {
    double squares = 0;
    double greatest = 0;
    int count = 0;
    void add(double error) {
        squares += error * error;
        greatest = std::max(greatest, std::abs(error));
        ++count;
    }
    double rms() const { return std::sqrt(squares / std::max(count, 1)); }
};

/// A hit with what is drawn there and what is true there.
struct Hit {
    Vec3d p_world;
    double k1, k2;
    Vec3d direction1;
    Curvatures exact;
};

/// Nearer to the grid's border control samples are made of what goes on beyond it, or of a band's
/// background there: 2 sqrt 3 and the stencil's 1 [voxels].
constexpr double border = 4.5;

std::vector<Hit> hits_of(Renderer& renderer, const Scene& scene, const AnalyticField& field,
                         int size) {
    const int resolution = scene.field->extent().hi.x();
    const Camera camera = camera_at(resolution);
    renderer.load(scene);
    renderer.draw(camera, size, size,
                  {FrameImage::Hit, FrameImage::Curvature, FrameImage::Direction});
    const Image hit = renderer.read(FrameImage::Hit);
    const Image curvature = renderer.read(FrameImage::Curvature);
    const Image direction = renderer.read(FrameImage::Direction);
    std::vector<Hit> hits;
    for (std::size_t i = 0; i < hit.rgba.size(); i += 4) {
        const auto vector = [i](const Image& image) {
            return Vec3d(image.rgba[i], image.rgba[i + 1], image.rgba[i + 2]);
        };
        if (hit.rgba[i + 3] == 0) continue;
        const Vec3d p = camera.eye_world + vector(hit);
        if (p.minCoeff() < border || p.maxCoeff() > resolution - 1 - border) continue;
        const Jet jet = field.jet(p);
        if (std::abs(jet.value) > 0.1) continue; // where a surface is cut off by the grid's faces
        hits.push_back({p, curvature.rgba[i], curvature.rgba[i + 1], vector(direction),
                        principal_curvatures(jet.gradient, jet.hessian)});
    }
    return hits;
}

double greatest_curvature(const std::vector<Hit>& hits) {
    double greatest = 0;
    for (const Hit& hit : hits)
        greatest = std::max({greatest, std::abs(hit.exact.k1), std::abs(hit.exact.k2)});
    return greatest;
}

/// k1 and k2 of OpenVDB's stencil at the voxels around a point, linear between.
std::array<double, 2> openvdb_curvatures(const openvdb::FloatGrid& grid, const Vec3d& p) {
    openvdb::math::CurvatureStencil<openvdb::FloatGrid> stencil(grid);
    const Vec3d below = p.array().floor();
    const Vec3d a = p - below;
    std::array<double, 2> k{};
    for (int i = 0; i < 8; ++i) {
        double weight = 1;
        openvdb::Coord corner;
        for (int axis = 0; axis < 3; ++axis) {
            const int side = i >> axis & 1;
            corner[axis] = static_cast<int>(below[axis]) + side;
            weight *= side == 1 ? a[axis] : 1 - a[axis];
        }
        stencil.moveTo(corner);
        const auto [least, greatest] = stencil.principalCurvatures();
        k[0] += weight * greatest;
        k[1] += weight * least;
    }
    return k;
}

void run_accuracy(Renderer& renderer, int size) {
    fmt::print("\nCurvatures at the hits of a picture of {}^2, interpolating spline: errors by the "
               "greatest |k|; order: from 64^3 to 128^3; angle of the first direction where the "
               "curvatures differ by a tenth of that. OpenVDB's stencil: RMS of both, linear "
               "between the 8 voxels around, and at the nearest one\n"
               "{:<10} {:<6} {:>5} {:>7} {:>9} {:>9} {:>9} {:>6} {:>9} {:>9} {:>10} {:>10}\n",
               size, "shape", "band", "N", "hits", "k1 RMS %", "k2 RMS %", "max %", "order",
               "angle RMS", "max", "between %", "nearest %");
    for (std::size_t shape = 0; shape < shapes_at(64).size(); ++shape)
        for (const std::optional<double> half_width : {std::optional<double>{}, {5.0}, {3.0}}) {
            double before = 0;
            for (const int resolution : {64, 128}) {
                const auto [name, field] = shapes_at(resolution)[shape];
                const auto samples = samples_of(field, resolution, half_width);
                const std::vector<Hit> hits = hits_of(renderer, {.field = samples}, field, size);
                const double greatest = greatest_curvature(hits);
                openvdb::FloatGrid grid(static_cast<float>(half_width.value_or(0)));
                openvdb::tools::Dense<const float, openvdb::tools::LayoutXYZ> dense(
                    openvdb::CoordBBox(0, 0, 0, resolution - 1, resolution - 1, resolution - 1),
                    samples->values().data());
                openvdb::tools::copyFromDense(dense, grid, 0.F);
                Errors k1, k2, angle, between, nearest;
                for (const Hit& hit : hits) {
                    k1.add((hit.k1 - hit.exact.k1) / greatest);
                    k2.add((hit.k2 - hit.exact.k2) / greatest);
                    if (hit.exact.k1 - hit.exact.k2 > 0.1 * greatest)
                        angle.add(degrees_between_lines(hit.direction1, hit.exact.direction1));
                    for (const auto& [errors, p] :
                         {std::pair{&between, hit.p_world},
                          std::pair{&nearest, Vec3d(hit.p_world.array().round())}}) {
                        const auto k = openvdb_curvatures(grid, p);
                        errors->add((k[0] - hit.exact.k1) / greatest);
                        errors->add((k[1] - hit.exact.k2) / greatest);
                    }
                }
                const double both = std::hypot(k1.rms(), k2.rms());
                fmt::print("{:<10} {:<6} {:>5} {:>7} {:>9.4f} {:>9.4f} {:>9.4f} {:>6} {:>9.4f} "
                           "{:>9.4f} {:>10.3f} {:>10.3f}\n",
                           name, half_width ? fmt::format("{}", *half_width) : "none", resolution,
                           k1.count, 100 * k1.rms(), 100 * k2.rms(),
                           100 * std::max(k1.greatest, k2.greatest),
                           before > 0 ? fmt::format("{:.2f}", std::log2(before / both)) : "",
                           angle.rms(), angle.greatest, 100 * between.rms(), 100 * nearest.rms());
                std::fflush(stdout);
                before = both;
            }
        }
}

/// A quantity of gage at points [index], from samples in a file.
std::vector<double> gage(const std::string& volume, const std::string& points,
                         const std::string& out, const char* quantity) {
    run_child(fmt::format("'{}' -i {} -k scalar -q {} -pi {} -psi true -k00 cubic:1,0 "
                          "-k11 cubicd:1,0 -k22 cubicdd:1,0 -t double -o {}",
                          gprobe_program, volume, quantity, points, out));
    run_child(fmt::format("'{0}' save -i {1} -f text -o {1}.txt", unu_program, out));
    std::ifstream text(out + ".txt");
    std::vector<double> values;
    for (double value = 0; text >> value;) values.push_back(value);
    return values;
}

void run_teem(Renderer& renderer, int size) {
    fmt::print("\nThe same beside teem's gprobe, cubic B-spline kernels, in double at our hits and "
               "of our control samples: greatest differences by the greatest |k|\n");
    if (gprobe_program.empty() || unu_program.empty()) {
        fmt::print("not built (package teem-apps)\n");
        return;
    }
    constexpr int resolution = 64;
    for (const Filter filter : {Filter::Interpolating, Filter::BSpline})
        for (const auto& [name, field] : shapes_at(resolution)) {
            const auto samples = samples_of(field, resolution, {});
            const std::vector<Hit> hits =
                hits_of(renderer, {.field = samples, .filter = filter}, field, size);
            const ScratchFolder folder;
            write_nrrd(*control_samples(samples, filter), folder / "control.nrrd");
            std::ofstream points(folder / "points.nrrd");
            points << fmt::format("NRRD0004\ntype: double\ndimension: 2\nsizes: 3 {}\n"
                                  "encoding: ascii\n\n",
                                  hits.size());
            for (const Hit& hit : hits)
                points << fmt::format("{:.17g} {:.17g} {:.17g}\n", hit.p_world.x(), hit.p_world.y(),
                                      hit.p_world.z());
            points.close();
            // For gage the inside is where values are greater: -k2 and -k1.
            const auto probe = [&](const char* quantity) {
                return gage(folder / "control.nrrd", folder / "points.nrrd",
                            folder / (std::string(quantity) + ".nrrd"), quantity);
            };
            const std::vector<double> k1 = probe("k2");
            const std::vector<double> k2 = probe("k1");
            if (k1.size() != hits.size() || k2.size() != hits.size())
                throw std::runtime_error("gprobe gave another number of values");
            const double greatest = greatest_curvature(hits);
            Errors of_k1, of_k2;
            for (std::size_t i = 0; i < hits.size(); ++i) {
                of_k1.add((hits[i].k1 + k1[i]) / greatest);
                of_k2.add((hits[i].k2 + k2[i]) / greatest);
            }
            fmt::print("{:<14} {:<10} {:>7} hits   k1 {:.1e}   k2 {:.1e}\n", filter_name(filter),
                       name, hits.size(), of_k1.greatest, of_k2.greatest);
            std::fflush(stdout);
        }
}

void run_cost(gl::Context& context, int size, int repeats, int greatest_resolution,
              const StorageOptions& storage) {
    fmt::print("\nPasses of picture space, {}^2 pixels of a torus, {} of {}, ms: median of {} "
               "turns; in brackets by the smallest field's of the same turn, median\n"
               "{:<6} {:>8} {:>9}",
               size, fetch_name(storage.fetch),
               storage.format == SampleFormat::Float16 ? "float16" : "float32", repeats, "N",
               "hits", "raycast");
    const std::array passes{"gradient", "curvature", "direction", "flow noise", "flow"};
    for (const char* pass : passes) fmt::print(" {:>16}", pass);
    fmt::print("\n");
    struct Field {
        int resolution;
        std::unique_ptr<Renderer> renderer;
        std::map<std::string, std::vector<double>> milliseconds;
        int hits = 0;
    };
    std::vector<Field> fields;
    for (int n = 64; n <= greatest_resolution; n *= 2) {
        fields.push_back({n, std::make_unique<Renderer>(context, shader_folder), {}});
        const std::shared_ptr<const FieldSource> field = sampled(builtin_field("torus"), n, 5.0);
        // Drawn blocks: gradients have a pass of their own.
        fields.back().renderer->load(
            {.field = field, .storage = storage, .quality = {.traversal = Traversal::DrawnBlocks}});
    }
    const Camera camera{.eye_world = {2.9, 2.2, 5.2}, .target_world = Vec3d::Zero()};
    for (int turn = -1; turn < repeats; ++turn)
        for (Field& field : fields) {
            // Apart: one program would draw curvatures and directions together.
            for (const ImageSet& wanted : {ImageSet{FrameImage::Gradient, FrameImage::Curvature},
                                           ImageSet{FrameImage::Flow}}) {
                const FrameReport report = field.renderer->draw(camera, size, size, wanted);
                if (turn < 0) continue; // the first one compiles
                for (const PassReport& pass : report.passes)
                    if (pass.ran) field.milliseconds[pass.name].push_back(pass.milliseconds);
            }
        }
    for (Field& field : fields) {
        field.renderer->draw(camera, size, size, {FrameImage::Hit});
        const Image hit = field.renderer->read(FrameImage::Hit);
        for (std::size_t i = 3; i < hit.rgba.size(); i += 4) field.hits += hit.rgba[i] != 0;
        fmt::print("{:<6} {:>8} {:>9.2f}", field.resolution, field.hits,
                   median(field.milliseconds["raycast"]));
        for (const char* pass : passes) {
            const std::vector<double>& own = field.milliseconds[pass];
            std::vector<double> ratios;
            for (std::size_t turn = 0; turn < own.size(); ++turn)
                ratios.push_back(own[turn] / fields[0].milliseconds[pass][turn]);
            fmt::print(" {:>8.2f} ({:.2f})", median(own), median(ratios));
        }
        fmt::print("\n");
    }
}

} // namespace
} // namespace isocast

int main(int argc, char** argv) {
    using namespace isocast;
    CLI::App app{"Curvatures: accuracy, teem, cost"};
    std::string only;
    std::string backend = "auto";
    int size = 512;
    int repeats = 5;
    int greatest_resolution = 512;
    app.add_option("--only", only, "A section: accuracy, teem, cost");
    app.add_option("--backend", backend, "auto, egl, osmesa");
    app.add_option("--size", size, "Pixels along an edge");
    app.add_option("--repeats", repeats, "Turns of cost");
    app.add_option("--greatest", greatest_resolution, "The largest field of cost");
    CLI11_PARSE(app, argc, argv);
    const auto context = gl::make_context({.backend = gl::backend_from_name(backend)});
    Renderer renderer(*context, shader_folder);
    fmt::print("{}\n", context->driver().renderer);
    if (only.empty() || only == "accuracy") {
        openvdb::initialize();
        run_accuracy(renderer, size);
    }
    if (only.empty() || only == "teem") run_teem(renderer, size);
    if (only.empty() || only == "cost")
        // The default, half of its memory, and a quarter of it by more fetches.
        for (const StorageOptions& storage :
             {StorageOptions{.fetch = Fetch::Rows},
              StorageOptions{.fetch = Fetch::Rows, .format = SampleFormat::Float16},
              StorageOptions{.fetch = Fetch::Samples}})
            run_cost(*context, size, repeats, greatest_resolution, storage);
}
