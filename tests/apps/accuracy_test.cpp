// `isocast accuracy` and `--max-error`: errors against closed forms, runs that go on, promises
// kept.
// SPDX-License-Identifier: MPL-2.0
#include "../renderer_test_base.h"
#include "../volume/temporary_folder.h"
#include "apps/accuracy/promise.h"
#include "distance_transform/brute_force.h"
#include "distance_transform/mesh_files.h"
#include "program.h"
#include "stability/shapes.h"
#include "volume/files.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <random>

namespace isocast::test {
namespace {

using Json = nlohmann::json;

std::vector<std::string> accuracy(const std::string& folder) {
    return {"accuracy", "field:sphere@32", "-o",
            folder,     "--vary",          "filter=bspline,interpolating",
            "--size",   "64x64",           "--repeats",
            "1",        "--backend",       "osmesa",
            "--json"};
}

TEST(Accuracy, ErrorsAreThoseOfTheClosedForm) {
    const TemporaryFolder folder;
    const Json json = Json::parse(checked_output(isocast(accuracy(folder / "run"))));
    ASSERT_EQ(json["settings"].size(), 3u);
    const auto rms = [&](std::size_t i, const char* error) {
        return json["settings"][i]["errors"][error]["rms"].get<double>();
    };
    // The smoothing spline moves a sphere by the Laplacian's sixth, h^2 (2/r)/6, to leading order;
    // what it leaves out is h^2 of that.
    const double h = 3.0 / 31;
    EXPECT_NEAR(rms(1, "surface"), h * h / 3, 0.05 * h * h / 3);
    EXPECT_LT(rms(2, "surface"), 0.1 * rms(1, "surface"));
    // Rays find the roots of their own function, whatever that is (docs/raycasting.md: 1e-5).
    for (const std::size_t i : {1, 2}) EXPECT_LT(rms(i, "position"), 1e-5);
    EXPECT_EQ(rms(2, "search"), 0);
    // As usual is interpolating.
    EXPECT_EQ(json["settings"][0]["errors"], json["settings"][2]["errors"]);
}

TEST(Accuracy, GoesOnWhereItWas) {
    const TemporaryFolder folder;
    const std::string run = folder / "run";
    checked_output(isocast(accuracy(run)));
    auto kept = nlohmann::ordered_json::parse(contents_of(run + "/results.json"));
    // As if it had been interrupted: one setting has no time yet, and the others a mark.
    kept["settings"][1]["seconds"] = Json::object();
    kept["settings"][2]["seconds"]["frame"] = {123.0};
    write_text(run + "/results.json", kept.dump());
    checked_output(isocast(accuracy(run)));
    const Json now = Json::parse(contents_of(run + "/results.json"));
    EXPECT_EQ(now["settings"][2]["seconds"]["frame"], Json({123.0}));
    EXPECT_EQ(now["settings"][1]["seconds"]["frame"].size(), 1u);
    for (const char* file : {"/results.csv", "/report/index.html", "/report/surface.png"})
        EXPECT_GT(contents_of(run + file).size(), 100u) << file;
}

TEST(Accuracy, KnobsThatThereAreNotAreUsageErrors) {
    const Outcome outcome =
        isocast({"accuracy", "field:sphere@16", "-o", "unused", "--vary", "method=csc"});
    EXPECT_EQ(outcome.code, 2);
    EXPECT_NE(outcome.err.find("'method' is no knob of this input"), std::string::npos)
        << outcome.err;
}

struct MaxError : RendererTest {
    /// Of what a picture sees of a surface [world].
    std::vector<double> errors_of_hits(const Scene& scene,
                                       const std::function<double(const Vec3d&)>& off_world) {
        renderer.load(scene);
        const Camera camera = frame_box(renderer.surface_points_world(), Vec3d(0.5, 0.3, 1), 1, 30);
        renderer.draw(camera, 128, 128, {FrameImage::Hit});
        const Image hits = renderer.read(FrameImage::Hit);
        std::vector<double> errors;
        for (std::size_t p = 0; p < hits.rgba.size(); p += 4)
            if (hits.rgba[p + 3] != 0)
                errors.push_back(off_world(
                    camera.eye_world + Vec3d(hits.rgba[p], hits.rgba[p + 1], hits.rgba[p + 2])));
        return errors;
    }
};

/// The same, turned, grown and moved: no longer what was calibrated with.
AnalyticField placed(const AnalyticField& field, const Mat3d& rotation, double scale,
                     const Vec3d& shift_world) {
    const auto jet = [inner = field.jet, rotation, scale, shift_world](const Vec3d& p_world) {
        const Jet at = inner(rotation.transpose() * (p_world - shift_world) / scale);
        return Jet{at.value * scale, rotation * at.gradient,
                   rotation * at.hessian * rotation.transpose() / scale};
    };
    return {field.name, jet, scale * field.half_extent_world};
}

/// From the zero set, by Newton's method along the gradient [world].
double off_surface(const AnalyticField& field, const Vec3d& p_world) {
    Vec3d p = p_world;
    for (int i = 0; i < 4; ++i) {
        const Jet jet = field.jet(p);
        p -= jet.value / jet.gradient.squaredNorm() * jet.gradient;
    }
    return (p - p_world).norm();
}

/// Twenty built-in fields of random size, place and axis: none was calibrated with.
TEST_F(MaxError, IsKeptOnFieldsThatWereNotInTheCalibration) {
    const Front front = read_front({std::filesystem::path(ISOCAST_SOURCE_DIR) / "apps/data"});
    std::mt19937_64 random(7);
    const auto any = [&](double lo, double hi) {
        return std::uniform_real_distribution<double>(lo, hi)(random);
    };
    const auto any_field = [&](int i) {
        const Vec3d centre(any(-0.2, 0.2), any(-0.2, 0.2), any(-0.2, 0.2));
        const Vec3d axis(any(-1, 1), any(-1, 1), any(0.2, 1));
        const double radius = any(0.4, 2);
        const Mat3d rotation = Eigen::AngleAxisd(any(0, 3), axis.normalized()).toRotationMatrix();
        switch (i % 7) {
        case 0:
            return sphere_field(centre, radius);
        case 1:
            return torus_field(centre, axis, radius, any(0.2, 0.5) * radius);
        case 2:
            return cylinder_field(centre, axis, radius);
        case 3:
            return placed(builtin_field("gyroid"), rotation, radius, centre);
        case 4:
            return placed(builtin_field("saddle"), rotation, radius, centre);
        case 5:
            return placed(builtin_field("cube"), rotation, radius, centre);
        default:
            return placed(builtin_field("marschner-lobb"), rotation, radius, centre);
        }
    };
    std::vector<double> shares;
    for (int i = 0; i < 20; ++i) {
        const AnalyticField field = any_field(i);
        // To 1e-4 of the size: finer than that cylinders, which leave their cube, would need more
        // samples than there are. The waves of Marschner and Lobb are half a sample at 32: coarser.
        const double max_error =
            field.half_extent_world * std::pow(10, i % 7 == 6 ? any(-3, -2) : any(-4, -2));
        const Promise promise = promise_for(field, max_error, front);
        ASSERT_TRUE(promise.resolution);
        EXPECT_LE(promise.error_world, max_error);
        const std::shared_ptr<const FieldSource> samples = sampled(field, *promise.resolution);
        const double greatest = std::ranges::max(
            errors_of_hits({.field = samples, .filter = promise.filter},
                           [&](const Vec3d& p_world) { return off_surface(field, p_world); }));
        EXPECT_GT(greatest, 0);
        EXPECT_LE(greatest, max_error)
            << field.name << " " << filter_name(promise.filter) << "@" << *promise.resolution;
        fmt::print("{} {}@{}: {:.2g} of {:.2g}\n", field.name, filter_name(promise.filter),
                   *promise.resolution, greatest, max_error);
        shares.push_back(greatest / max_error);
    }
    std::ranges::sort(shares);
    fmt::print("error by what was allowed: median {:.2f}, from {:.2f} to {:.2f}; {} of {} below a "
               "half\n",
               shares[10], shares.front(), shares.back(),
               std::ranges::count_if(shares, [](double share) { return share < 0.5; }),
               shares.size());
}

/// As files, drawn as `isocast render` does without options, and linearly. None was calibrated
/// with.
TEST_F(MaxError, IsKeptByConvertedMeshes) {
    const TemporaryFolder folder;
    const std::array meshes{stability::tilted(stability::cube()), stability::noisy_sphere(3, 4),
                            stability::tilted(stability::tetrahedron())};
    for (const Mesh& mesh : meshes) {
        write_mesh(mesh, folder / "mesh.obj");
        for (const auto& [word, filter] :
             {std::pair{"cubic", Filter::Interpolating}, std::pair{"linear", Filter::Linear}}) {
            const Json json = Json::parse(checked_output(
                isocast({"convert", folder / "mesh.obj", "-o", folder / "field.vdb", "--max-error",
                         "0.02", "--interpolation", word, "--json"})));
            EXPECT_EQ(json["promise"]["filter"], filter_name(filter));
            EXPECT_LE(json["promise"]["error"], 0.02);
            const std::vector<double> off = errors_of_hits(
                {.field = read_field(folder / "field.vdb"), .filter = filter},
                [&](const Vec3d& p_world) { return brute_force_distance(mesh, p_world); });
            const double greatest = std::ranges::max(off);
            EXPECT_GT(greatest, 0);
            EXPECT_LE(greatest, 0.02) << word << " at " << json["promise"]["resolution"];
            fmt::print("{} voxels, {}: {:.2g} of 0.02\n", json["promise"]["resolution"].dump(),
                       word, greatest);
        }
    }
}

TEST(MaxErrorOfConvert, ChoosesTheResolutionAlone) {
    const TemporaryFolder folder;
    const auto convert = [&](const std::vector<std::string>& more) {
        return isocast(joined({"convert", "mesh:knot", "-o", folder / "a.vdb"}, more));
    };
    for (const std::vector<std::string>& more :
         {std::vector<std::string>{"--max-error", "0.1", "--resolution", "64"},
          {"--max-error", "0.1", "--voxel-size", "0.1"},
          {"--max-error", "0.1", "--method", "points"},
          {"--max-error", "0.1", "--prism", "printed"},
          {"--max-error", "0"},
          {"--interpolation", "linear"}})
        EXPECT_EQ(convert(more).code, 2) << more.back();
    const Outcome finer = convert({"--max-error", "1e-9"});
    EXPECT_EQ(finer.code, 3);
    EXPECT_NE(finer.err.find("1024 voxels would err by"), std::string::npos) << finer.err;
    EXPECT_EQ(folder.entry_count(), 0);
}

} // namespace
} // namespace isocast::test
