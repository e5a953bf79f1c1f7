// PNG and EXR files, read back by their libraries.
// SPDX-License-Identifier: MPL-2.0
#include "raycaster/image_files.h"

#include "volume/errors.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfMatrixAttribute.h>
#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <fstream>
#include <limits>

namespace isocast {
namespace {

std::filesystem::path temporary(const std::string& name) {
    return std::filesystem::path(testing::TempDir()) / ("isocast_image_test_" + name);
}

TEST(Png, HoldsTheSrgbBytesTopRowFirst) {
    Image image{2, 2, std::vector<float>(16, 1.0f)};
    // Linear 0.21404114 is sRGB 0.5, hence byte 127.5 rounded to 128 (IEC 61966-2-1).
    const float values[4][3] = {{0, 0.21404114f, 1}, {2, -1, NAN}, {1, 0, 0}, {0, 0, 1}};
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t c = 0; c < 3; ++c) image.rgba[4 * i + c] = values[i][c];
    const auto path = temporary("a.png");
    write_png(image, path);

    png_image read{};
    read.version = PNG_IMAGE_VERSION;
    ASSERT_NE(png_image_begin_read_from_file(&read, path.c_str()), 0);
    read.format = PNG_FORMAT_RGB;
    std::vector<png_byte> bytes(PNG_IMAGE_SIZE(read));
    ASSERT_NE(png_image_finish_read(&read, nullptr, bytes.data(), 0, nullptr), 0);
    EXPECT_EQ(bytes, (std::vector<png_byte>{0, 128, 255, 255, 0, 0, 255, 0, 0, 0, 0, 255}));
    std::filesystem::remove(path);
}

TEST(Png, WithAlphaHoldsColoursThatAreNotMultipliedByIt) {
    const auto path = temporary("alpha.png");
    PngFile file(path, 2, 2, true);
    file.write({2, 1, {0.25f, 0.5f, 0, 0.5f, 0, 0, 0, 0}});
    file.write({2, 1, {1, 1, 1, 1, 0.1f, 0.1f, 0.1f, 0.1f}});
    EXPECT_FALSE(std::filesystem::exists(path));
    file.finish();
    const Image image = read_picture(path);
    // 0.003: a byte of sRGB near linear 0.5 is 0.0037 wide.
    EXPECT_NEAR(image.pixel(0, 0)[0], 0.5, 0.003);
    EXPECT_EQ(image.pixel(0, 0)[1], 1);
    EXPECT_NEAR(image.pixel(0, 0)[3], 0.5, 0.002); // a byte
    EXPECT_EQ(image.pixel(1, 0)[3], 0);
    EXPECT_EQ(image.pixel(1, 1)[2], 1);
    std::filesystem::remove(path);
}

TEST(Png, GivesBackEveryByte) {
    Image image{256, 1, {}};
    for (int i = 0; i < 256; ++i) image.rgba.insert(image.rgba.end(), 4, linear_from_srgb(i));
    const auto path = temporary("bytes.png");
    write_png(image, path);
    const Image read = read_picture(path);
    for (int i = 0; i < 256; ++i) {
        EXPECT_EQ(read.pixel(i, 0)[1], linear_from_srgb(i));
        EXPECT_EQ(read.pixel(i, 0)[3], 1);
    }
    std::filesystem::remove(path);
}

TEST(Exr, IsReadAsAPictureWithOrWithoutColour) {
    const auto path = temporary("picture.exr");
    ExrImage image{.width = 2, .height = 1};
    image.channels["Y"].values = {0.25f, 7};
    write_exr(image, path);
    EXPECT_EQ(read_picture(path).rgba, (std::vector<float>{0.25f, 0.25f, 0.25f, 1, 7, 7, 7, 1}));
    image.channels["R"].values = {1, 2};
    const auto refused = [&] {
        try {
            read_picture(path);
        } catch (const InputError& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    write_exr(image, path);
    EXPECT_NE(refused().find("no channel G (has: R, Y)"), std::string::npos) << refused();
    image.channels["G"].values = {3, 4};
    image.channels["B"].values = {5, NAN};
    write_exr(image, path);
    EXPECT_NE(refused().find("finite"), std::string::npos) << refused();
    image.channels["B"].values = {5, 6};
    write_exr(image, path);
    EXPECT_EQ(read_picture(path).rgba, (std::vector<float>{1, 3, 5, 1, 2, 4, 6, 1}));
    std::filesystem::remove(path);
}

TEST(Exr, WrittenInRowsIsTheSameFile) {
    ExrImage image{.width = 3, .height = 5};
    for (int i = 0; i < 15; ++i) {
        image.channels["R"].values.push_back(float(i));
        image.channels["Z"].values.push_back(float(i) / 3);
    }
    image.channels["R"].as_half = true;
    const auto at_once = temporary("at_once.exr");
    const auto in_rows = temporary("in_rows.exr");
    write_exr(image, at_once);
    ExrFile file(in_rows, 3, 5, image);
    for (const auto& [first, count] : {std::pair(0, 2), std::pair(2, 1), std::pair(3, 2)}) {
        ExrImage rows = image;
        rows.height = count;
        for (auto& [name, channel] : rows.channels) {
            channel.values.erase(channel.values.begin(), channel.values.begin() + 3 * first);
            channel.values.resize(std::size_t{3} * count);
        }
        file.write(rows);
    }
    file.finish();
    const auto bytes = [](const std::filesystem::path& path) {
        std::ifstream stream(path, std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(stream), {});
    };
    EXPECT_EQ(bytes(in_rows), bytes(at_once));
    std::filesystem::remove(at_once);
    std::filesystem::remove(in_rows);
}

TEST(Exr, GivesBackChannelsAndAttributes) {
    ExrImage image;
    image.width = 3;
    image.height = 2;
    image.channels["Z"].values = {1, 2, 3, 1e-30f, std::numeric_limits<float>::infinity(), 6.125f};
    image.channels["R"] = {{0.5f, 0.25f, 1, 2, 3, 4}, true};
    image.matrices["worldToCamera"] = Eigen::Matrix4f::Identity();
    image.matrices["worldToCamera"](0, 3) = 7; // a translation by 7 along x
    image.floats["iso"] = 0.75f;
    const auto path = temporary("a.exr");
    write_exr(image, path);

    Imf::InputFile file(path.c_str());
    EXPECT_EQ(file.header().channels().findChannel("R")->type, Imf::HALF);
    EXPECT_EQ(file.header().channels().findChannel("Z")->type, Imf::FLOAT);
    std::vector<float> z(6);
    std::vector<float> r(6);
    Imf::FrameBuffer frame;
    frame.insert("Z", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(z.data()), 4, 12));
    frame.insert("R", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(r.data()), 4, 12));
    file.setFrameBuffer(frame);
    file.readPixels(0, 1);
    EXPECT_EQ(z, image.channels["Z"].values);
    EXPECT_EQ(r, image.channels["R"].values);
    // OpenEXR's convention: row vectors, so the translation stands in the last row.
    EXPECT_EQ(file.header().typedAttribute<Imf::M44fAttribute>("worldToCamera").value()[3][0], 7);
    std::filesystem::remove(path);
}

TEST(ImageFiles, MissingFolderIsNamed) {
    const auto path = temporary("no_such_folder") / "a.png";
    for (const auto& write : {+[](const std::filesystem::path& p) {
                                  write_png({1, 1, {0, 0, 0, 0}}, p);
                              },
                              +[](const std::filesystem::path& p) {
                                  write_exr({1, 1, {{"R", {{0}, false}}}, {}, {}, {}}, p);
                              }}) {
        try {
            write(path);
            FAIL() << "no error";
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find("no_such_folder"), std::string::npos);
        }
    }
}

} // namespace
} // namespace isocast
