// Readers of points: every format gives the same table, and tables become spheres and ellipsoids.
// SPDX-License-Identifier: MPL-2.0
#include "quadrics/point_data.h"

#include "damaged_points.h"
#include "quadrics/molecule_styles.h"
#include "random_primitives.h"

#include <gmock/gmock.h>

#include <fstream>

namespace isocast::test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

PointData read_csv(const std::string& text) {
    return points_of_bytes(text, "a.csv");
}

std::string error_of(const std::string& bytes, const std::string& name) {
    return message_of<InputError>([&] { points_of_bytes(bytes, name); });
}

PointData tensor_points(std::span<const Mat3d> tensors) {
    PointData points{.names = {"x", "y", "z", "txx", "tyy", "tzz", "txy", "txz", "tyz"},
                     .columns = std::vector<std::vector<double>>(9)};
    for (const Mat3d& t : tensors) {
        const std::array row{0.0, 0.0, 0.0, t(0, 0), t(1, 1), t(2, 2), t(0, 1), t(0, 2), t(1, 2)};
        for (std::size_t k = 0; k < 9; ++k) points.columns[k].push_back(row[k]);
    }
    return points;
}

Mat3d symmetric(const Mat3d& rotation, const Vec3d& eigenvalues) {
    const Mat3d t = rotation * eigenvalues.asDiagonal() * rotation.transpose();
    return (t + t.transpose()) / 2;
}

// ----------------------------------------------------------------------------------------- files

TEST(PointFiles, TextAndBothByteOrdersHoldTheSameTable) {
    for (const PointFile& file : point_files()) {
        if (!file.name.ends_with(".ply")) continue;
        const PointData points = points_of_bytes(file.bytes, file.name);
        ASSERT_EQ(points.count(), 3U) << file.name;
        EXPECT_THAT(points.names, ElementsAre("x", "y", "z", "red", "green", "blue", "radius",
                                              "txx", "tyy", "tzz", "txy", "txz", "tyz"));
        const std::vector<Vec3d> positions = points.positions_world();
        EXPECT_EQ(positions[0], Vec3d(1, 2, 3));
        EXPECT_EQ(positions[2], Vec3d(7, 8, 9));
        EXPECT_EQ(*points.find("radius"), (std::vector<double>{0.5, 1, 1}));
        EXPECT_EQ(*points.find("blue"), (std::vector<double>{255, 3, 3}));
        EXPECT_EQ(tensors_of(points)[0], Mat3d(Vec3d(1, 2, 3).asDiagonal()));
        EXPECT_EQ(tensors_of(points)[2], Mat3d::Ones());
        EXPECT_EQ(points.find("more"), nullptr); // a list
    }
}

TEST(PointFiles, CsvHasQuotesCommentsBlankLinesAndTextThatIsNoNumber) {
    const PointData points = points_of_bytes(point_files()[0].bytes, "a.csv");
    EXPECT_THAT(points.names, ElementsAre("x", "y", "z", "label", "r", "g", "b", "radius"));
    EXPECT_THAT(points.positions_world(),
                ElementsAre(Vec3d(1, 2, 3), Vec3d(-10, 0.5, 7), Vec3d(0, 0, 0)));
    for (const double label : *points.find("label")) EXPECT_TRUE(std::isnan(label));
    // A mark of UTF-8, carriage returns, and no newline at the end.
    EXPECT_THAT(read_csv("\xEF\xBB\xBF\"x\",y,z\r\n1,2,3\r\n4,5,6").positions_world(),
                ElementsAre(Vec3d(1, 2, 3), Vec3d(4, 5, 6)));
}

TEST(PointFiles, ExtensionsAreKnownInAnyCase) {
    EXPECT_TRUE(is_point_file("a.PLY"));
    EXPECT_TRUE(is_point_file("b/a.csv"));
    EXPECT_FALSE(is_point_file("a.xyz"));
    EXPECT_EQ(point_file_extensions(), ".ply, .csv");
    EXPECT_THAT(error_of("", "a.txt"), AllOf(HasSubstr("a.txt"), HasSubstr("known: .ply, .csv")));
}

TEST(PointFiles, AreReadFromDisk) {
    const TemporaryFolder folder;
    std::ofstream(folder / "a.csv") << "x,y,z\n1,2,3\n";
    EXPECT_EQ(read_points(folder / "a.csv").positions_world().at(0), Vec3d(1, 2, 3));
    EXPECT_THAT(message_of<InputError>([&] { read_points(folder / "b.csv"); }), HasSubstr("b.csv"));
}

// ---------------------------------------------------------------------------------------- errors

TEST(PointErrors, OfCsvNameTheLineAndTheCause) {
    struct Case {
        const char* text;
        const char* expected;
    };
    for (const auto& [text, expected] : {
             Case{"", "a.csv: there is no line of names"},
             Case{"# only\n\n", "a.csv: there is no line of names"},
             Case{"x,y,z\n", "a.csv: it holds no points"},
             Case{"\nx,y,w\n1,2,3\n", "a.csv:2: there is no column 'z' (has: x, y, w)"},
             Case{"x,y,z,w,w\n1,2,3\n", "a.csv:1: two columns are called 'w'"},
             Case{"x,y,z\n1,2,3\n1,2\n", "a.csv:3: the line has 2 cells, but there are 3 columns"},
             Case{"x,y,z\n1,2,3,4\n", "a.csv:2: the line has 4 cells, but there are 3 columns"},
             Case{"x,y,z\n1,two,3\n", "a.csv:2: y: 'two' is not a number"},
             Case{"x,y,z\n1,,3\n", "a.csv:2: y: '' is not a number"},
             Case{"x,y,z\n1,nan,3\n", "a.csv:2: y: nan is not finite"},
             Case{"x,y,z\n1,2,-inf\n", "a.csv:2: z: -inf is not finite"},
             Case{"x,y,z\n1,2,1e31\n", "a.csv:2: z: 1e+31 is not from -1e+30 to 1e+30"},
             Case{"x,y,z,radius\n1,2,3,-1\n", "a.csv:2: radius: -1 is not from 0 to 1e+30"},
             Case{"x,y,z,red,green,blue\n1,2,3,256,0,0\n",
                  "a.csv:2: red: 256 is not from 0 to 255"},
             Case{"x,y,z,r,g,b\n1,2,3,0,2,0\n", "a.csv:2: g: 2 is not from 0 to 1"},
             Case{"x,y,z,red,green\n",
                  "a.csv:1: of the columns red, green, blue there are no blue"},
             Case{"x,y,z,txx,tyy\n", "there are no tzz, txy, txz, tyz"},
             Case{"x,y,z\n1,2,\"3\n", "a.csv:2: a quote is not closed"},
             Case{"x,y,z\n1,2,\"3\"4\n", "a.csv:2: '4' follows a quoted cell"},
         })
        EXPECT_THAT(error_of(text, "a.csv"), HasSubstr(expected)) << text;
}

TEST(PointErrors, OfPlyNameTheLineOrElementAndTheCause) {
    const std::string head = "ply\nformat ascii 1.0\n";
    const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
    const auto vertices = [&](const std::string& count) {
        return "element vertex " + count + "\n" + xyz + "end_header\n";
    };
    struct Case {
        std::string text;
        const char* expected;
    };
    for (const auto& [text, expected] : {
             Case{"", "a.ply:1: not a PLY file"},
             Case{"plywood\n", "a.ply:1: not a PLY file"},
             Case{"ply\nformat ascii 1.0\n", "a.ply:2: truncated: the header has no 'end_header'"},
             Case{"ply\nformat utf8 1.0\n", "a.ply:2: unknown format 'utf8' (known: ascii, "},
             Case{head + "format ascii 1.0\n", "a.ply:3: a second 'format'"},
             Case{"ply\nelement vertex 1\n" + xyz + "end_header\n1 2 3\n", "has no 'format'"},
             Case{head + "end_header\n", "a.ply:3: the header has no element 'vertex'"},
             Case{head + "property float x\n", "a.ply:3: a property before the first element"},
             Case{head + "element vertex 1\nproperty half x\n", "unknown property type 'half'"},
             Case{head + "element vertex 1\nproperty x\n",
                  "a.ply:4: 'property', a type and a name"},
             Case{head + "element vertex -1\n", "a.ply:3: '-1' is not a number of elements"},
             Case{head + "element vertex 1e99\n", "a.ply:3: '1e99' is not a number of elements"},
             Case{head + "element vertex 1\nelement vertex 1\n", "a second element 'vertex'"},
             Case{head + "rhubarb\n", "a.ply:3: unexpected 'rhubarb' in the header"},
             Case{head + "element vertex 1\nproperty float x\nend_header\n",
                  "no column 'y' (has: x)"},
             Case{head + "element vertex 1\n" + xyz + "property float x\nend_header\n1 2 3 4\n",
                  "a.ply: two columns are called 'x'"},
             Case{head + vertices("0"), "a.ply: it holds no points"},
             Case{head + vertices("2147483647") + "1 2 3\n",
                  "a.ply:8: truncated: the file ends after 1 of 2147483647 elements 'vertex'"},
             Case{head + vertices("1") + "1 2\n", "a.ply:8: the line ends before z"},
             Case{head + vertices("1") + "1 2 3 4\n", "a.ply:8: the line has 1 values too many"},
             Case{head + vertices("1") + "1 2 3\n4 5 6\n",
                  "a.ply:9: more lines than the header has elements"},
             Case{head + vertices("1") + "1 x 3\n", "a.ply:8: y: 'x' is not a number"},
             Case{head + vertices("1") + "1 nan 3\n", "a.ply:8: y: nan is not finite"},
             Case{head + "element vertex 1\n" + xyz +
                      "property list int int more\nend_header\n1 2 3 4000000000 1\n",
                  "a.ply:9: the line does not hold a list of 4000000000 entries"},
         })
        EXPECT_THAT(error_of(text, "a.ply"), HasSubstr(expected)) << text;
}

TEST(PointErrors, OfBinaryPlyNameTheElementAndReserveNothingForWhatIsNotThere) {
    const std::string format = "binary_little_endian";
    const auto header = [&](const std::string& count, const std::string& more = "") {
        return "ply\nformat " + format + " 1.0\nelement vertex " + count +
               "\nproperty float x\nproperty float y\nproperty float z\n" + more + "end_header\n";
    };
    const std::string point = ply_bytes<float>(format, {1, 2, 3});
    EXPECT_EQ(points_of_bytes(header("1") + point, "a.ply").count(), 1U);
    EXPECT_THAT(error_of(header("2147483647") + point, "a.ply"), // 26 GB
                HasSubstr("a.ply: truncated: it holds at most 1 of 2147483647 elements 'vertex'"));
    EXPECT_THAT(error_of(header("2") + point + "abc", "a.ply"),
                HasSubstr("it holds at most 1 of 2 elements 'vertex'"));
    EXPECT_THAT(error_of(header("1") + point + "abc", "a.ply"),
                HasSubstr("a.ply: 3 bytes follow the last element"));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THAT(error_of(header("2") + point + ply_bytes<float>(format, {1, nan, 3}), "a.ply"),
                HasSubstr("a.ply: vertex 1: y: nan is not finite"));
    const std::string list = "property list uint double more\n";
    EXPECT_THAT(
        error_of(header("1", list) + point + ply_bytes<std::uint32_t>(format, {4e9}), "a.ply"),
        HasSubstr("a.ply: truncated: it holds at most 0 of 1 elements 'vertex'"));
    EXPECT_THAT(error_of(header("1", "property list float int more\n") + point +
                             ply_bytes<float>(format, {-1}),
                         "a.ply"),
                HasSubstr("a.ply: vertex 0: a list has -1 entries"));
    // An element without properties takes no space and no time, whatever it says.
    EXPECT_EQ(points_of_bytes(header("1", "element nothing 2147483647\n") + point, "a.ply").count(),
              1U);
}

TEST(PointErrors, DamagedFilesAreReadOrRefused) {
    expect_points_read_or_refused(4000, 1);
}

// ------------------------------------------------------------------------------------ primitives

TEST(PointPrimitivesOf, RadiiAndColoursAreThoseOfTheColumns) {
    const PointPrimitives by_shares =
        primitives_of(points_of_bytes(point_files()[0].bytes, "a.csv"));
    ASSERT_THAT(by_shares.spheres, SizeIs(2));
    EXPECT_EQ(by_shares.dropped, 1U); // its radius is 0
    EXPECT_EQ(by_shares.spheres[0].radius_world, 2);
    EXPECT_EQ(by_shares.spheres[0].centre_world, Vec3d(1, 2, 3));
    EXPECT_EQ(by_shares.spheres[0].colour, Vec3d(0, linear_light(0.5), 1));
    EXPECT_EQ(by_shares.spheres[1].radius_world, 0.125);

    const PointPrimitives plain = primitives_of(read_csv("x,y,z,r\n1,2,3,77\n"),
                                                {.radius_world = 4, .colour = Vec3d::Ones()});
    EXPECT_EQ(plain.spheres.at(0).radius_world, 4);
    EXPECT_EQ(plain.spheres.at(0).colour, Vec3d::Ones()); // "r" alone is no colour

    const PointPrimitives by_bytes =
        primitives_of(read_csv("x,y,z,red,green,blue\n1,2,3,18,52,86\n"));
    EXPECT_EQ(by_bytes.spheres.at(0).colour, linear_colour(0x123456));
}

// The axes of an ellipsoid give the square of its tensor back: A A^T = (scale T)^2.
TEST(PointPrimitivesOf, EllipsoidsHaveTheTensorsAxes) {
    Random random(5);
    std::vector<Mat3d> tensors;
    for (int k = 0; k < 1000; ++k)
        tensors.push_back(
            symmetric(random.rotation(), random.log_uniform(1e-20, 1e20) *
                                             Vec3d(random.uniform(0.05, 1) * (k % 2 ? 1 : -1),
                                                   random.uniform(0.05, 1), 1)));
    const PointPrimitives shown = primitives_of(tensor_points(tensors), {.tensor_scale = 0.5});
    ASSERT_EQ(shown.ellipsoids.size(), tensors.size());
    for (std::size_t i = 0; i < tensors.size(); ++i) {
        const Mat3d& axes = shown.ellipsoids[i].axes_world;
        const Mat3d square = tensors[i] * tensors[i] / 4;
        // 1e-14: that of the lengths, 2 for the squares, a few roundings of products.
        EXPECT_LE((axes * axes.transpose() - square).norm(), 4e-14 * square.norm());
        EXPECT_GT(axes.determinant(), 0);
    }
}

TEST(PointPrimitivesOf, FlatTensorsGetABodyAndZerosAreDropped) {
    Random random(6);
    const Mat3d r = random.rotation();
    const std::vector<Mat3d> tensors = {symmetric(r, Vec3d(2, 0, 0)), symmetric(r, Vec3d(2, -2, 0)),
                                        Mat3d::Zero(), Mat3d::Identity() * 1e-40,
                                        symmetric(r, Vec3d(2, 0.019, 1))};
    const PointPrimitives shown = primitives_of(tensor_points(tensors));
    EXPECT_EQ(shown.dropped, 2U);
    ASSERT_THAT(shown.ellipsoids, SizeIs(3));
    const std::array expected = {Vec3d(2, 0.02, 0.02), Vec3d(2, 2, 0.02), Vec3d(2, 1, 0.02)};
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3d lengths = shown.ellipsoids[i].axes_world.colwise().norm();
        EXPECT_LE((lengths - expected[i]).norm(), 1e-13) << i; // some roundings of the greatest
    }
    check(std::span<const Ellipsoid>(shown.ellipsoids));
}

} // namespace
} // namespace isocast::test
