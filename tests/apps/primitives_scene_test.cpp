// Molecules and points in scenes, and runs of the program that draws them.
// SPDX-License-Identifier: MPL-2.0
#include "apps/scene_objects.h"

#include "../volume/temporary_folder.h"
#include "program.h"
#include "volume/errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace isocast::test {
namespace {

struct PrimitiveScenes : testing::Test {
    TemporaryFolder folder;

    PrimitiveScenes() {
        write_text(folder / "water.xyz", "3\nwater\nO 0 0 0\nH 0.96 0 0\nH -0.24 0.93 0\n");
        write_text(folder / "cloud.csv", "x,y,z,radius,r,g,b\n1,2,3,0.5,1,0,0\n-1,0,0,0,0,1,0\n");
        write_text(folder / "tensors.csv",
                   "x,y,z,txx,tyy,tzz,txy,txz,tyz\n0,0,1,0.5,0.25,0.125,0,0,0\n");
    }
    SceneFile read(const std::string& text) const {
        write_text(folder / "scene.toml", text);
        SceneFile scene = read_scene_file(folder / "scene.toml");
        check_scene(scene);
        return scene;
    }
    Scene compose(const std::string& text, std::vector<std::string>* warnings = nullptr) const {
        const SceneFile scene = read(text);
        SceneObjects objects;
        objects.open(scene);
        return objects.compose(scene, {}, [&](const std::string& warning) {
            if (warnings) warnings->push_back(warning);
        });
    }
};

TEST_F(PrimitiveScenes, MoleculesAreSpheresAndSticksWhereTheyArePlaced) {
    const Scene scene =
        compose("[[object]]\nmolecule = \"water.xyz\"\nscale = 2\ntranslate = [10, 0, 0]\n");
    EXPECT_TRUE(scene.objects.empty());
    ASSERT_EQ(scene.primitives->spheres.size(), 3);
    EXPECT_EQ(scene.primitives->cylinders.size(), 2);
    EXPECT_EQ(scene.primitives->spheres[1].centre_world, Vec3d(10 + 2 * 0.96, 0, 0));
    EXPECT_DOUBLE_EQ(scene.primitives->cylinders[0].radius_world, 0.3);
    const Scene filled =
        compose("[[object]]\nmolecule = \"water.xyz\"\nstyle = \"space-filling\"\n");
    EXPECT_TRUE(filled.primitives->cylinders.empty());
}

TEST_F(PrimitiveScenes, SurfacesOfMoleculesAreFields) {
    const Scene scene = compose("[[object]]\nmolecule = \"water.xyz\"\nsurface = \"accessible\"\n"
                                "probe = 1.4\nvoxel = 0.25\n");
    EXPECT_EQ(scene.primitives, nullptr);
    ASSERT_EQ(scene.objects.size(), 1);
    const FieldSource& field = *scene.objects[0].field;
    EXPECT_EQ(scene.objects[0].iso_world, 0);
    EXPECT_EQ(field.space().voxel_size_world(), 0.25);
    // Oxygen's 1.52 and the probe below the origin, away from both hydrogens.
    const Vec3d below(0, -2.5, 0);
    const Index3 at = field.space().to_index(below).array().round().cast<int>();
    std::array<float, 1> value{};
    field.copy_box({at, at + Index3::Ones()}, 0, value);
    EXPECT_NEAR(value[0], 2.5 - 1.52 - 1.4, 1e-6);
}

TEST_F(PrimitiveScenes, PointsAreSpheresAndTensorsEllipsoids) {
    std::vector<std::string> warnings;
    const Scene scene = compose("[[object]]\nname = \"cloud\"\npoints = \"cloud.csv\"\n"
                                "[[object]]\npoints = \"tensors.csv\"\ntensor_scale = 4\n",
                                &warnings);
    ASSERT_EQ(scene.primitives->spheres.size(), 1);
    EXPECT_EQ(scene.primitives->spheres[0].centre_world, Vec3d(1, 2, 3));
    EXPECT_EQ(scene.primitives->spheres[0].colour, Vec3d(1, 0, 0));
    ASSERT_EQ(scene.primitives->ellipsoids.size(), 1);
    EXPECT_NEAR(scene.primitives->ellipsoids[0].axes_world.determinant(), 2 * 1 * 0.5, 1e-12);
    ASSERT_EQ(warnings.size(), 1);
    EXPECT_EQ(warnings[0], "cloud: 1 points of no size are not drawn");
}

TEST_F(PrimitiveScenes, MeshesAreTrianglesWhereTheyArePlaced) {
    const std::string knot = "[[object]]\nmesh = \"mesh:knot\"\nas = \"triangles\"\n";
    const Scene scene = compose(knot +
                                "scale = 2\nrotate = [0, 0, 90]\ntranslate = [10, 0, 0]\n"
                                "colour = [1, 0, 0]\n" +
                                knot + "crease = 0\n");
    EXPECT_TRUE(scene.objects.empty());
    ASSERT_EQ(scene.primitives->meshes.size(), 2);
    const TriangleMesh& placed = scene.primitives->meshes[0];
    const TriangleMesh& flat = scene.primitives->meshes[1];
    EXPECT_EQ(placed.colour, Vec3d(1, 0, 0));
    EXPECT_EQ(flat.triangles, placed.triangles);
    EXPECT_TRUE(flat.normals_world.empty());
    ASSERT_EQ(placed.normals_world.size(), 3 * placed.triangles.size());
    for (std::size_t i = 0; i < flat.vertices_world.size(); ++i) {
        const Vec3d& v = flat.vertices_world[i];
        EXPECT_LT((placed.vertices_world[i] - Vec3d(10 - 2 * v.y(), 2 * v.x(), 2 * v.z())).norm(),
                  1e-12);
    }
    // The tube's twelve sides bend by 30 degrees: normals are those of a smooth one.
    const Vec3d face = area_normal(triangle_of(placed, 0)).normalized();
    for (const std::size_t corner : {0, 1, 2}) {
        EXPECT_NEAR(placed.normals_world[corner].norm(), 1, 1e-6);
        EXPECT_GT(placed.normals_world[corner].cast<double>().dot(face), std::cos(0.4));
        EXPECT_LT(placed.normals_world[corner].cast<double>().dot(face), std::cos(0.02));
    }
}

TEST_F(PrimitiveScenes, TensorsAreSuperquadricsAndPointsDotsIfAskedFor) {
    const Scene scene = compose("[[object]]\npoints = \"tensors.csv\"\nglyph = \"superquadric\"\n"
                                "sharpness = 2\ntensor_scale = 4\nscale = 3\n"
                                "[[object]]\npoints = \"cloud.csv\"\nradius_pixels = 7\n"
                                "scale = 3\n");
    EXPECT_TRUE(scene.primitives->ellipsoids.empty());
    EXPECT_TRUE(scene.primitives->spheres.empty());
    ASSERT_EQ(scene.primitives->superquadrics.size(), 1);
    const Superquadric& glyph = scene.primitives->superquadrics[0];
    EXPECT_NEAR(std::abs(glyph.axes_world.determinant()), 27 * 2 * 1 * 0.5, 1e-12);
    EXPECT_EQ(glyph.centre_world, Vec3d(0, 0, 3));
    // l = 4, 2, 1 sevenths: c_l = c_p = 2/7, linear.
    EXPECT_NEAR(glyph.beta, std::pow(5 / 7.0, 2), 1e-12);
    ASSERT_EQ(scene.primitives->dots.size(), 2); // that of radius 0, too
    EXPECT_EQ(scene.primitives->dots[0].centre_world, Vec3d(3, 6, 9));
    EXPECT_EQ(scene.primitives->dots[0].radius_pixels, 7);
    EXPECT_EQ(scene.primitives->dots[0].colour, Vec3d(1, 0, 0));
}

TEST_F(PrimitiveScenes, KeysThatThePointsHaveNoUseForAreNamedWithTheirLine) {
    const auto message = [&](const std::string& text) {
        return message_of<InputError>([&] { compose(text); });
    };
    EXPECT_THAT(message("[[object]]\npoints = \"cloud.csv\"\nglyph = \"superquadric\"\n"),
                testing::AllOf(testing::HasSubstr("scene.toml:3:9: object.0.glyph: "),
                               testing::HasSubstr("cloud.csv have no tensors")));
    EXPECT_THAT(message("[[object]]\npoints = \"tensors.csv\"\nradius_pixels = 2\n"),
                testing::HasSubstr("scene.toml:3:17: object.0.radius_pixels: "));
    EXPECT_THAT(message("[[object]]\npoints = \"cloud.csv\"\nglyphs = 5\n"),
                testing::HasSubstr("scene.toml:3:10: object.0.glyphs: these stand on a field"));
    EXPECT_THAT(
        message("[[object]]\nfield = \"field:torus@8\"\nglyphs = 0\n"),
        testing::HasSubstr("scene.toml:3:10: object.0.glyphs: expected a number between 1"));
    EXPECT_THAT(message("[[object]]\nfield = \"field:torus@8\"\nglyphs = 9\n"
                        "colour = [1, 0, 0]\n"),
                testing::HasSubstr("scene.toml:4:10: object.0.colour: "));
    EXPECT_THAT(message("[[object]]\nfield = \"field:torus@16\"\nglyphs = 9\niso = 99\n"),
                testing::HasSubstr("scene.toml:3:10: object.0.glyphs: there is no surface at"));
}

TEST_F(PrimitiveScenes, GlyphsStandOnTheFieldWhereItIsPlaced) {
    const std::string torus =
        "[[object]]\nfield = \"field:torus@48\"\nscale = 2\ntranslate = [5, 0, 0]\n";
    const Scene scene = compose(torus + "glyphs = 300\nglyph_size = 0.05\n" + torus);
    ASSERT_EQ(scene.objects.size(), 1); // the surface beneath
    ASSERT_EQ(scene.primitives->ellipsoids.size(), 300);
    for (const Ellipsoid& glyph : scene.primitives->ellipsoids) {
        const Vec3d p = glyph.centre_world - Vec3d(5, 0, 0);
        const double from_circle = std::hypot(p.head<2>().norm() - 2, p.z());
        // On the tube, or lifted off its hollow side by half a semi-axis squared times 1 / 1.2.
        EXPECT_GT(from_circle, 0.8 - 1e-3);
        EXPECT_LT(from_circle, 0.8 + 0.05 * 0.05 / 2 / 1.2 + 1e-3);
        EXPECT_NEAR(glyph.axes_world.colwise().norm().maxCoeff(), 0.05, 0.05 * 0.8);
    }
    const Scene other = compose(torus + "glyphs = 300\nglyph_seed = 1\n");
    EXPECT_NE(other.primitives->ellipsoids[0].centre_world,
              scene.primitives->ellipsoids[0].centre_world);
    EXPECT_TRUE(other.objects.empty());
}

TEST_F(PrimitiveScenes, GlyphsFollowTheirKeysFromFrameToFrame) {
    const SceneFile scene = read("[[object]]\nmesh = \"mesh:knot\"\nresolution = 40\n"
                                 "glyphs = 50\nfilter = \"bspline\"\n");
    SceneObjects objects;
    objects.open(scene);
    const auto first_of = [&](const std::function<void(SceneFile&)>& change) {
        SceneFile changed = scene;
        change(changed);
        const Scene composed = objects.compose(changed, {}, [](const std::string&) {});
        EXPECT_EQ(composed.primitives->ellipsoids.size(), 50);
        return composed.primitives->ellipsoids.at(0);
    };
    const Ellipsoid plain = first_of([](SceneFile&) {});
    const auto expect_moved = [&](const Ellipsoid& other) {
        EXPECT_NE(other.centre_world, plain.centre_world);
    };
    expect_moved(first_of([](SceneFile& s) { s.objects[0].glyph_seed = 1; }));
    expect_moved(first_of([](SceneFile& s) { s.objects[0].iso_world = 0.02; }));
    expect_moved(first_of([](SceneFile& s) { s.objects[0].filter = Filter::Interpolating; }));
    EXPECT_NE(first_of([](SceneFile& s) { s.curvature_scale_voxels = 2; }).axes_world,
              plain.axes_world);
    EXPECT_NE(first_of([](SceneFile& s) { s.objects[0].glyph_size_world = 1; }).axes_world,
              plain.axes_world);
    EXPECT_EQ(first_of([](SceneFile&) {}).axes_world, plain.axes_world);
}

TEST_F(PrimitiveScenes, AreNoOperandsAndTakeNoKeysOfFields) {
    EXPECT_THROW(read("[[object]]\nname = \"a\"\nmolecule = \"water.xyz\"\n"
                      "[[object]]\nname = \"b\"\nfield = \"field:torus@8\"\n"
                      "[[object]]\ncsg = \"union\"\nof = [\"a\", \"b\"]\n"),
                 InputError);
    EXPECT_THROW(read("[[object]]\nmolecule = \"water.xyz\"\niso = 1\n"), InputError);
    EXPECT_THROW(read("[[object]]\nfield = \"field:torus@8\"\nsurface = \"excluded\"\n"),
                 InputError);
    EXPECT_THROW(read("[[object]]\nmolecule = \"missing.pdb\"\n"), InputError);
    const std::string knot = "[[object]]\nname = \"knot\"\nmesh = \"mesh:knot\"\n";
    for (const char* key : {"iso = 0.1\n", "resolution = 64\n", "filter = \"bspline\"\n",
                            "cut_colour = [1, 0, 0]\n"}) {
        EXPECT_NO_THROW(read(knot + key));
        EXPECT_THROW(read(knot + "as = \"triangles\"\n" + key), InputError) << key;
    }
    EXPECT_THROW(read(knot + "crease = 20\n"), InputError);
    EXPECT_THROW(read("[[object]]\nfield = \"field:torus@8\"\nas = \"triangles\"\n"), InputError);
    EXPECT_THROW(read(knot + "as = \"triangles\"\n[[object]]\nname = \"b\"\n"
                             "field = \"field:torus@8\"\n[[object]]\nmorph = [\"knot\", \"b\"]\n"),
                 InputError);
}

} // namespace
} // namespace isocast::test
