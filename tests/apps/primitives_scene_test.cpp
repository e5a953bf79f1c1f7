// Molecules and points in scenes, and runs of the program that draws them.
// SPDX-License-Identifier: MPL-2.0
#include "apps/scene_objects.h"

#include "../volume/temporary_folder.h"
#include "program.h"
#include "volume/errors.h"

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
    EXPECT_EQ(scene.primitives->cylinders.size(), 4); // half of each bond in its atom's colour
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
