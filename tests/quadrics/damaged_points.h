// Small files of points with everything in them that the readers know, and damaged copies of them.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "molecule_writers.h" // damaged
#include "quadrics/point_data.h"
#include "volume/errors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <span>

namespace isocast::test {

/// The bytes of `values`, each as a `T`, of the byte order that a PLY file of `format` has.
template<class T>
std::string ply_bytes(const std::string& format, std::initializer_list<double> values) {
    std::string bytes;
    for (const double value : values) {
        const T number = static_cast<T>(value);
        std::string raw(sizeof(T), '\0');
        std::memcpy(raw.data(), &number, sizeof(T));
        if ((format == "binary_little_endian") != (std::endian::native == std::endian::little))
            std::reverse(raw.begin(), raw.end());
        bytes += raw;
    }
    return bytes;
}

struct PointFile {
    std::string name;
    std::string bytes;
};

/// Three points in each format, with a list among the vertex's properties and elements around it.
inline std::vector<PointFile> point_files() {
    const auto header = [](const std::string& format) {
        return "ply\nformat " + format +
               " 1.0\ncomment a test\nelement camera 1\nproperty float fov\n"
               "property list uchar int parts\nelement vertex 3\nproperty double x\n"
               "property float y\nproperty list uchar short more\nproperty int z\n"
               "property uchar red\nproperty uchar green\nproperty uchar blue\n"
               "property float radius\nproperty double txx\nproperty double tyy\n"
               "property double tzz\nproperty double txy\nproperty double txz\n"
               "property double tyz\nelement face 1\nproperty list uchar int vertex_indices\n"
               "end_header\n";
    };
    std::vector<PointFile> files = {
        {"a.csv", "# a test\n\nx,\"y\", z ,label,r,g,b,radius\n1,2,3,\"a, \"\"b\"\"\",0,0.5,1,2\n"
                  "-1e1,+.5,\"7\",,1,1,1,0\n\n# more\n0,0,0,c,0.25,0.25,0.25,0.125\n"},
        {"tensors.csv", "x,y,z,txx,tyy,tzz,txy,txz,tyz,red,green,blue\n"
                        "1,2,3,1,2,3,0,0,0,0,128,255\n4,5,6,0,0,0,0,0,0,1,2,3\n"
                        "7,8,9,1,1,1,1,1,1,1,2,3\n"},
        {"a.ply", header("ascii") + "30 2 7 8\n1 2 1 9 3 0 128 255 0.5 1 2 3 0 0 0\n"
                                    "4 5 0 6 1 2 3 1 0 0 0 0 0 0\n"
                                    "7 8 3 1 2 3 9 1 2 3 1 1 1 1 1 1 1\n3 0 1 2\n"}};
    for (const std::string format : {"binary_little_endian", "binary_big_endian"}) {
        const auto f32 = [&](std::initializer_list<double> v) {
            return ply_bytes<float>(format, v);
        };
        const auto f64 = [&](std::initializer_list<double> v) {
            return ply_bytes<double>(format, v);
        };
        const auto u8 = [&](std::initializer_list<double> v) {
            return ply_bytes<std::uint8_t>(format, v);
        };
        const auto i16 = [&](std::initializer_list<double> v) {
            return ply_bytes<std::int16_t>(format, v);
        };
        const auto i32 = [&](std::initializer_list<double> v) {
            return ply_bytes<std::int32_t>(format, v);
        };
        files.push_back(
            {format + ".ply", header(format) + f32({30}) + u8({2}) + i32({7, 8}) + //
                                  f64({1}) + f32({2}) + u8({1}) + i16({9}) + i32({3}) +
                                  u8({0, 128, 255}) + f32({0.5}) + f64({1, 2, 3, 0, 0, 0}) + //
                                  f64({4}) + f32({5}) + u8({0}) + i32({6}) + u8({1, 2, 3}) +
                                  f32({1}) + f64({0, 0, 0, 0, 0, 0}) + //
                                  f64({7}) + f32({8}) + u8({3}) + i16({1, 2, 3}) + i32({9}) +
                                  u8({1, 2, 3}) + f32({1}) + f64({1, 1, 1, 1, 1, 1}) + //
                                  u8({3}) + i32({0, 1, 2})});
    }
    return files;
}

/// Expects that each of `count` damaged copies of each file is read to what can be drawn, or gives
/// an InputError that names the file.
inline void expect_points_read_or_refused(int count, unsigned seed) {
    std::mt19937 random(seed);
    for (const PointFile& whole : point_files()) {
        int read = 0;
        for (int k = 0; k < count; ++k) {
            const std::string bytes = damaged(whole.bytes, random);
            try {
                const PointData points = points_of_bytes(bytes, whole.name);
                ++read;
                ASSERT_GT(points.count(), 0U);
                for (const auto& column : points.columns) ASSERT_EQ(column.size(), points.count());
                const PointPrimitives shown = primitives_of(points);
                ASSERT_EQ(shown.spheres.size() + shown.ellipsoids.size() + shown.dropped,
                          points.count());
                check(std::span<const Sphere>(shown.spheres));
                check(std::span<const Ellipsoid>(shown.ellipsoids));
            } catch (const InputError& error) {
                ASSERT_NE(std::string_view(error.what()).find(whole.name), std::string::npos)
                    << error.what() << "\n"
                    << bytes;
            } catch (const std::exception& error) {
                FAIL() << whole.name << ", copy " << k << ": " << error.what() << "\n" << bytes;
            }
        }
        // Else the copies are so damaged that they test only the first lines of the readers. A
        // 20th: most of a text PLY is its header, where nearly each byte counts, and 10 % survive.
        EXPECT_GT(read, count / 20) << whole.name;
        EXPECT_LT(read, count) << whole.name;
    }
}

} // namespace isocast::test
