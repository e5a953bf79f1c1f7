// EXR files, read by a library that shares no code with the one that wrote them.
// SPDX-License-Identifier: MPL-2.0
#include "../volume/temporary_folder.h"
#include "program.h"

#include <gtest/gtest.h>
#include <tinyexr.h>

#include <cmath>
#include <cstring>
#include <map>

namespace isocast::test {
namespace {

struct ReadExr {
    EXRHeader header;
    EXRImage image;
    std::map<std::string, const float*> channels;

    explicit ReadExr(const std::string& path) {
        InitEXRHeader(&header);
        InitEXRImage(&image);
        EXRVersion version;
        const char* error = nullptr;
        if (ParseEXRVersionFromFile(&version, path.c_str()) != TINYEXR_SUCCESS ||
            ParseEXRHeaderFromFile(&header, &version, path.c_str(), &error) != TINYEXR_SUCCESS)
            throw std::runtime_error(error ? error : "no EXR file");
        for (int i = 0; i < header.num_channels; ++i)
            header.requested_pixel_types[i] = TINYEXR_PIXELTYPE_FLOAT;
        if (LoadEXRImageFromFile(&image, &header, path.c_str(), &error) != TINYEXR_SUCCESS)
            throw std::runtime_error(error ? error : "no EXR image");
        for (int i = 0; i < header.num_channels; ++i)
            channels[header.channels[i].name] = reinterpret_cast<const float*>(image.images[i]);
    }
    ~ReadExr() {
        FreeEXRImage(&image);
        FreeEXRHeader(&header);
    }
    ReadExr(const ReadExr&) = delete;
};

TEST(ExrOfAnotherLibrary, HasTheDocumentedChannelsAttributesAndValues) {
    const TemporaryFolder folder;
    const std::string path = folder / "a.exr";
    checked_output(
        isocast({"render", "field:sphere@32", "-o", path, "--size", "48x40", "--backend", "osmesa",
                 "--aov", "P,N,curvature,id", "--samples", "4", "--tile", "17"}));
    const ReadExr exr(path);
    EXPECT_EQ(exr.image.width, 48);
    EXPECT_EQ(exr.image.height, 40);
    std::vector<std::string> names;
    for (const auto& [name, values] : exr.channels) names.push_back(name);
    EXPECT_EQ(names,
              (std::vector<std::string>{"A", "B", "G", "N.X", "N.Y", "N.Z", "P.X", "P.Y", "P.Z",
                                        "R", "Z", "curvature.curvedness", "curvature.flag",
                                        "curvature.gauss", "curvature.k1", "curvature.k2",
                                        "curvature.mean", "curvature.shapeIndex", "id"}));
    std::map<std::string, std::string> attributes;
    for (int i = 0; i < exr.header.num_custom_attributes; ++i) {
        const EXRAttribute& attribute = exr.header.custom_attributes[i];
        attributes[attribute.name] = {reinterpret_cast<const char*>(attribute.value),
                                      static_cast<std::size_t>(attribute.size)};
    }
    EXPECT_EQ(attributes.at("filter"), "interpolating");
    EXPECT_EQ(attributes.at("worldToCamera").size(), 64u);
    EXPECT_EQ(attributes.at("worldToNDC").size(), 64u);
    EXPECT_EQ(attributes.at("iso").size(), 4u);

    int hits = 0;
    for (int i = 0; i < 48 * 40; ++i) {
        const auto at = [&](const char* name) { return double{exr.channels.at(name)[i]}; };
        if (at("id") == 0) {
            EXPECT_TRUE(std::isinf(at("Z")));
            EXPECT_EQ(at("curvature.flag"), 0);
            continue;
        }
        ++hits;
        EXPECT_EQ(at("id"), 1);
        const double radius = std::hypot(at("P.X"), at("P.Y"), at("P.Z"));
        // The interpolating spline on 32 samples: voxels of 0.08, errors of fourth order.
        EXPECT_NEAR(radius, 1, 1e-4);
        for (const char* axis : {"X", "Y", "Z"})
            EXPECT_NEAR(at((std::string("N.") + axis).c_str()),
                        at((std::string("P.") + axis).c_str()), 1e-3);
        // Second derivatives lose two orders: 0.08^2 times a small factor.
        EXPECT_NEAR(at("curvature.mean"), 1, 1e-2);
        EXPECT_GE(at("curvature.flag"), 1);
    }
    EXPECT_GT(hits, 400);
}

} // namespace
} // namespace isocast::test
