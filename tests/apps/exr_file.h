// What an OpenEXR file holds, for tests.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/grid_space.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>

#include <map>
#include <string>
#include <vector>

namespace isocast::test {

/// Channels of an EXR file, as float.
struct ExrFile {
    explicit ExrFile(const std::string& path) : file(path.c_str()) {
        const Imath::Box2i window = file.header().dataWindow();
        width = window.max.x + 1;
        height = window.max.y + 1;
        Imf::FrameBuffer frame;
        const auto row = static_cast<std::size_t>(width);
        for (auto c = file.header().channels().begin(); c != file.header().channels().end(); ++c) {
            auto& values = channels[c.name()];
            values.resize(row * static_cast<std::size_t>(height));
            frame.insert(c.name(), Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()),
                                              sizeof(float), row * sizeof(float)));
        }
        file.setFrameBuffer(frame);
        file.readPixels(0, height - 1);
    }
    Vec3d vector(const std::string& layer, std::size_t i) const {
        return {channels.at(layer + ".X")[i], channels.at(layer + ".Y")[i],
                channels.at(layer + ".Z")[i]};
    }

    Imf::InputFile file;
    int width = 0;
    int height = 0;
    std::map<std::string, std::vector<float>> channels;
};

} // namespace isocast::test
