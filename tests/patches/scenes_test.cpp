// Patches, splines and tetrahedra as scenes say them.
// SPDX-License-Identifier: MPL-2.0
#include "../volume/temporary_folder.h"
#include "apps/scene_objects.h"
#include "quadrics/quadratic_spline.h"
#include "quadrics/slim_file.h"
#include "volume/analytic_fields.h"
#include "volume/errors.h"

#include <gmock/gmock.h>

#include <fstream>

namespace isocast::test {
namespace {

struct PatchScenes : testing::Test {
    TemporaryFolder folder;

    void write(const char* name, const std::string& text) const {
        std::ofstream(folder / name) << text;
    }
    Scene compose(const std::string& text) const {
        write("scene.toml", text);
        const SceneFile scene = read_scene_file(folder / "scene.toml");
        check_scene(scene);
        SceneObjects objects;
        objects.open(scene);
        return objects.compose(scene, {}, [](const std::string&) {});
    }
    std::string problem_of(const std::string& text) const {
        try {
            compose(text);
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    }
};

TEST_F(PatchScenes, FacesOfFourCornersArePatches) {
    // A quad, a triangle and a pentagon.
    const std::string points = "v 0 0 0\nv 1 0 0\nv 1 1 1\nv 0 1 0\nv 2 0 0\nv 2 2 0\nv 1 3 0\n";
    write("mixed.obj", points + "f 1 2 3 4\nf 2 5 3\nf 3 5 6 7 4\n");
    write("mixed.ply",
          "ply\nformat ascii 1.0\nelement vertex 7\nproperty float x\nproperty float y\n"
          "property float z\nelement face 3\nproperty list uchar int vertex_indices\n"
          "end_header\n0 0 0\n1 0 0\n1 1 1\n0 1 0\n2 0 0\n2 2 0\n1 3 0\n"
          "4 0 1 2 3\n3 1 4 2\n5 2 4 5 6 3\n");
    const std::vector<std::array<int, 4>> expected{
        {0, 1, 2, 3}, {1, 4, 2, 1}, {2, 4, 5, 2}, {2, 5, 6, 2}, {2, 6, 3, 2}};
    for (const char* name : {"mixed.obj", "mixed.ply"}) {
        const Scene scene = compose("[[object]]\nmesh = \"" + std::string(name) +
                                    "\"\nas = \"patches\"\ncolour = [0, 1, 0]\nscale = 2\n"
                                    "translate = [10, 0, 0]\n");
        EXPECT_TRUE(scene.objects.empty());
        ASSERT_EQ(scene.primitives->patches.size(), 1);
        const PatchMesh& mesh = scene.primitives->patches[0];
        EXPECT_EQ(mesh.quads, expected);
        EXPECT_EQ(mesh.vertices_world[2], Vec3d(12, 2, 2));
        EXPECT_EQ(mesh.colour, Vec3d(0, 1, 0));
    }
}

TEST_F(PatchScenes, FieldsAreSplines) {
    const Scene scene = compose("[[object]]\nfield = \"field:torus@24\"\nas = \"spline\"\n"
                                "iso = 0.05\n");
    EXPECT_TRUE(scene.objects.empty());
    ASSERT_EQ(scene.primitives->tetrahedra.size(), 1);
    EXPECT_EQ(scene.primitives->tetrahedra[0].coefficients,
              quadratic_spline(*sampled(builtin_field("torus"), 24), 0.05).coefficients);
}

TEST_F(PatchScenes, TetrahedraAreThoseOfAFile) {
    write("one.vtk", "# vtk DataFile Version 3.0\na plane\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                     "POINTS 4 float\n0 0 0 1 0 0 0 1 0 0 0 1\nCELLS 1 5\n4 0 1 2 3\n"
                     "CELL_TYPES 1\n10\nPOINT_DATA 4\nSCALARS f float\nLOOKUP_TABLE default\n"
                     "0 1 2 3\n");
    const Scene scene = compose("[[object]]\ntetrahedra = \"one.vtk\"\niso = 0.5\nscale = 3\n");
    const TetrahedralMesh& mesh = scene.primitives->tetrahedra.at(0);
    EXPECT_EQ(mesh.vertices_world[3], Vec3d(0, 0, 3));
    EXPECT_EQ(mesh.coefficients.at(0),
              (std::array<float, 10>{-0.5F, 0.5F, 1.5F, 2.5F, 0, 0.5F, 1, 1, 1.5F, 2}));
}

TEST_F(PatchScenes, SlimSurfacesAreThoseOfAFile) {
    write_slim({.levels = {{{{.radius_world = 2}}, 0.1}}}, folder / "a.slim");
    const Scene scene = compose("[[object]]\nslim = \"a.slim\"\nscale = 2\ntranslate = [1, 0, 0]\n"
                                "colour = [0, 1, 0]\n");
    EXPECT_TRUE(scene.objects.empty());
    const SlimSurface& surface = scene.primitives->slims.at(0);
    EXPECT_EQ(surface.colour, Vec3d(0, 1, 0));
    EXPECT_DOUBLE_EQ(surface.levels.at(0).max_error_world, 0.2);
    EXPECT_DOUBLE_EQ(surface.levels[0].patches.at(0).radius_world, 4);
    EXPECT_EQ(surface.levels[0].patches[0].centre_world, Vec3d(1, 0, 0));
}

TEST_F(PatchScenes, ThatCannotBeAreRefused) {
    using testing::HasSubstr;
    write_slim({.levels = {{{{}}, 0.1}}}, folder / "a.slim");
    EXPECT_THAT(problem_of("[[object]]\nslim = \"a.slim\"\niso = 1\n"),
                HasSubstr("for fields, which molecules, points and triangles are not"));
    EXPECT_THAT(problem_of("[[object]]\nmesh = \"mesh:knot\"\nas = \"skin\"\n"),
                HasSubstr("only molecules have skins"));
    EXPECT_THAT(problem_of("[[object]]\nmesh = \"mesh:knot\"\nshrink = 0.4\n"),
                HasSubstr("for molecules that are drawn as their skin"));
#ifndef ISOCAST_WITH_SKIN
    write("a.xyz", "1\n\nC 0 0 0\n");
    EXPECT_THAT(problem_of("[[object]]\nmolecule = \"a.xyz\"\nas = \"skin\"\n"),
                HasSubstr("-DISOCAST_SKIN=ON"));
#endif
    EXPECT_THAT(problem_of("[[object]]\nslim = \"a.slim\"\nas = \"spline\"\n"),
                HasSubstr("splines are made of fields"));
    EXPECT_THAT(problem_of("[[object]]\nslim = \"a.slim\"\nmesh = \"mesh:knot\"\n"),
                HasSubstr("points, tetrahedra and slim is needed, not 2"));
    write("a.stl", "solid a\n");
    EXPECT_THAT(problem_of("[[object]]\nmesh = \"mesh:knot\"\nas = \"patches\"\n"),
                HasSubstr("patches are read from .obj and .ply"));
    EXPECT_THAT(problem_of("[[object]]\nmesh = \"a.stl\"\nas = \"patches\"\n"),
                HasSubstr("polygons are read from .obj and .ply"));
    EXPECT_THAT(problem_of("[[object]]\nfield = \"field:torus@24\"\nas = \"patches\"\n"),
                HasSubstr("only meshes have triangles and patches"));
    EXPECT_THAT(problem_of("[[object]]\nmesh = \"mesh:knot\"\nas = \"patches\"\nresolution = 64\n"),
                HasSubstr("only meshes that become fields are converted"));
}

} // namespace
} // namespace isocast::test
