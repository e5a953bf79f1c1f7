// Reading and checking clouds: variants of files, estimated normals, errors that name their cause.
// SPDX-License-Identifier: MPL-2.0
#include "clouds.h"
#include "distance_transform/mesh_files.h"
#include "volume/errors.h"

#include "../../volume/temporary_folder.h"

#include <fstream>
#include <numbers>

namespace isocast::test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

struct PointFiles : testing::Test {
    TemporaryFolder folder;
    PointCloud read(const std::string& name, const std::string& text) {
        std::ofstream(folder / name, std::ios::binary) << text;
        return read_cloud(folder / name);
    }
    std::string error(const std::string& name, const std::string& text) {
        return message_of<InputError>([&] { read(name, text); });
    }
};

TEST_F(PointFiles, VariantsGiveTheSamePoints) {
    const std::string ply = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n"
                            "property float y\nproperty float z\n";
    const std::string ply_normals = "property float nx\nproperty uchar red\nproperty float ny\n"
                                    "property float nz\n";
    for (const PointCloud& cloud :
         {read("a.xyz", "# x y z\n1 2 3\r\n\n  4 5e0 6 # last"),
          read("b.xyz", "1 2 3 0 0 1\n4 5 6 1 0 0\n"), read("c.obj", "v 1 2 3\nv 4 5 6\n"),
          read("d.obj", "v 1 2 3\nvn 0 0 1\nv 4 5 6\nvn 1 0 0\n"),
          read("e.ply", ply + "end_header\n1 2 3\n4 5 6\n"),
          read("f.ply", ply + ply_normals + "end_header\n1 2 3 0 9 0 1\n4 5 6 1 9 0 0\n")}) {
        EXPECT_THAT(cloud.points_world, ElementsAre(Vec3d(1, 2, 3), Vec3d(4, 5, 6)));
        if (!cloud.normals.empty()) {
            EXPECT_THAT(cloud.normals, ElementsAre(Vec3d(0, 0, 1), Vec3d(1, 0, 0)));
        }
    }
    for (const char* name : {"b.xyz", "d.obj", "f.ply"})
        EXPECT_EQ(read_cloud(folder / name).normals.size(), 2u) << name;
    for (const char* name : {"a.xyz", "c.obj", "e.ply"})
        EXPECT_TRUE(read_cloud(folder / name).normals.empty()) << name;
}

TEST_F(PointFiles, MeshesGiveTheirVerticesAndNormals) {
    for (const char* name : {"a.obj", "a.ply", "a.off"}) {
        write_mesh(octahedron(), folder / name);
        const PointCloud cloud = read_cloud(folder / name);
        ASSERT_EQ(cloud.points_world.size(), 6u);
        for (std::size_t i = 0; i < 6; ++i) // by symmetry, to some roundings
            EXPECT_LT((cloud.normals[i].normalized() - cloud.points_world[i]).norm(), 1e-15);
    }
}

TEST_F(PointFiles, DamageIsNamed) {
    EXPECT_THAT(error("a.xyz", "1 2 3\n4 5\n"),
                AllOf(HasSubstr("a.xyz: line 2: 2 numbers instead of")));
    EXPECT_THAT(error("a.xyz", "1 2 3\n4 5 6 0 0 1\n"),
                HasSubstr("line 2: 6 numbers where the first line has 3"));
    EXPECT_THAT(error("a.xyz", "1 2 x\n"), HasSubstr("line 1: z is not a number: 'x'"));
    EXPECT_THAT(error("a.xyz", "1 2 3 0 nan 0\n"), HasSubstr("ny is not finite"));
    EXPECT_THAT(error("a.xyz", "3\n\nO 0 0 0\nH 1 0 0\nH 0 1 0\n"), HasSubstr("1 numbers"));
    EXPECT_THAT(error("a.xyz", "# none\n"), HasSubstr("a.xyz: no points"));
    EXPECT_THAT(error("a.xyz", ""), HasSubstr("a.xyz: the file is empty"));
    EXPECT_THAT(error("a.pts", "1 2 3\n"), AllOf(HasSubstr("'.pts'"), HasSubstr(".xyz, .obj")));
    EXPECT_THAT(error("a.obj", "v 1 2 inf\n"), HasSubstr("line 1: z is not finite"));
    EXPECT_THAT(error("a.ply", "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n"
                               "property float y\nproperty float z\nproperty float nx\n"
                               "end_header\n1 2 3 4\n"),
                HasSubstr("no number 'ny'"));
    EXPECT_THAT(error("a.ply", "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n"
                               "property float y\nproperty float z\nend_header\n1 2 3\n4 5\n"),
                HasSubstr("truncated: it holds 1 of 2 elements 'vertex'"));
}

TEST_F(PointFiles, MeshReadersSendPointsOn) {
    std::ofstream(folder / "a.ply") << "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                                       "property float y\nproperty float z\nend_header\n1 2 3\n";
    EXPECT_THAT(message_of<InputError>([&] { read_mesh(folder / "a.ply"); }),
                HasSubstr("--method points"));
}

// Every file cut anywhere, or with any byte changed, is read or refused by name; nothing else.
TEST_F(PointFiles, MutatedFilesAreReadOrRefusedByName) {
    const std::string xyz = "0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0.5 0 0 -1\n";
    write_mesh(octahedron(), folder / "a.ply");
    std::ifstream file(folder / "a.ply", std::ios::binary);
    const std::string ply(std::istreambuf_iterator<char>(file), {});
    std::mt19937 random(1);
    for (const auto& [name, whole] : {std::pair("m.xyz", xyz), std::pair("m.ply", ply)}) {
        for (int i = 0; i < 400; ++i) {
            std::string bytes = whole;
            bytes[random() % bytes.size()] = static_cast<char>(random());
            if (i % 2 == 0) bytes.resize(random() % bytes.size() + 1);
            try {
                read(name, bytes);
            } catch (const InputError& error) {
                EXPECT_THAT(error.what(), HasSubstr(name));
            }
        }
    }
}

TEST(PointCloud, DuplicatesAreDroppedWithAWarning) {
    PointCloud cloud = random_sphere(100, 1);
    cloud.points_world.push_back(cloud.points_world[7]);
    cloud.normals.push_back(-cloud.normals[7]);
    const CheckedPoints points = check(cloud, 20);
    EXPECT_EQ(points.cloud.points_world.size(), 100u);
    EXPECT_GT(points.cloud.normals[7].dot(cloud.normals[7]), 0); // the first one's
    EXPECT_THAT(points.warnings, ElementsAre(HasSubstr("1 points at or next to the position")));
}

// Such pairs had no solution: the scan of a scan may well hold them.
TEST(PointCloud, NearDuplicatesAreDroppedSoThatTheRestCanBeInterpolated) {
    PointCloud cloud = random_sphere(1000, 4);
    for (std::size_t i = 0; i < 50; ++i) {
        cloud.points_world.push_back(cloud.points_world[i] + Vec3d(1e-7, 2e-7, -1e-7));
        cloud.normals.push_back(cloud.normals[i]);
    }
    EXPECT_EQ(check(cloud, 20).cloud.points_world.size(), 1000u);
    EXPECT_NEAR(meshless_of(cloud).at(cloud.points_world[0]).near, 0, 1e-10);
}

TEST(PointCloud, UnusableCloudsAreRefused) {
    const auto message = [](PointCloud cloud) {
        return message_of<InputError>([&] { check(cloud, 20); });
    };
    PointCloud cloud = random_sphere(20, 1);
    EXPECT_THAT(message(cloud), HasSubstr("20 points are too few to look at 20 neighbours"));
    cloud = random_sphere(50, 1);
    cloud.points_world[3].y() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THAT(message(cloud), HasSubstr("point 3 is not finite"));
    PointCloud line;
    for (int i = 0; i < 50; ++i) line.points_world.push_back(i * Vec3d(1, 2, 4));
    EXPECT_THAT(message(line), HasSubstr("lie on lines"));
}

TEST(PointCloud, SpacingIsTheSquareRootOfAPointsShare) {
    for (const std::size_t count : {500u, 5000u}) {
        const CheckedPoints points = check(random_sphere(count, 2), 20);
        double area = 0;
        for (const double spacing : points.spacing_world) area += spacing * spacing;
        // The density from 20 neighbours is off by 1 / sqrt(20), and its inverse by 1 / 20 on
        // average.
        EXPECT_NEAR(area / (4 * std::numbers::pi), 1, 0.1);
    }
}

TEST(PointCloud, UnevenOnesAreToldWithFigures) {
    PointCloud cloud = random_sphere(1000, 3);
    for (std::size_t i = 0; i < 100; ++i)
        cloud.points_world[i] = Vec3d(1, 0, 0) + 1e-3 * cloud.points_world[i];
    EXPECT_THAT(check(cloud, 20).warnings, ElementsAre(HasSubstr("lie unevenly")));
}

// Estimated from the 20 nearest; on a torus outward is told by one point for all.
TEST(PointNormals, AgreeWithThoseOfTheMesh) {
    for (const std::string name : {"sphere6", "torus", "knot"}) {
        PointCloud cloud = vertices_of(check(sample_mesh(name)));
        std::vector<Vec3d> expected = std::move(cloud.normals);
        cloud.normals.clear();
        const CheckedPoints points = check(cloud, 20);
        EXPECT_FALSE(points.normals_given);
        EXPECT_THAT(points.warnings, ElementsAre(HasSubstr("no normals")));
        double worst = 1;
        for (std::size_t i = 0; i < expected.size(); ++i)
            worst = std::min(worst, points.cloud.normals[i].dot(expected[i].normalized()));
        EXPECT_GT(worst, 0.7) << name; // 45 degrees, where the knot's tube bends most
    }
}

} // namespace
} // namespace isocast::test
