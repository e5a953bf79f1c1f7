// SPDX-License-Identifier: MPL-2.0
#include "apps/picture_file.h"

#include <algorithm>

namespace isocast {

bool is_png(const std::filesystem::path& path) {
    return path.extension() == ".png";
}

bool is_opaque(const SceneFile& scene, const std::filesystem::path& output) {
    return !scene.output.is_transparent && (is_png(output) || scene.look.shows_environment);
}

PictureFile::PictureFile(std::filesystem::path path, const SceneFile& scene, const Camera& camera,
                         ExrImage like)
    : path_(std::move(path)), scene_(scene), camera_(camera), like_(std::move(like)) {
    if (is_png(path_))
        png_.emplace(path_, scene.output.width, scene.output.height, scene.output.is_transparent);
}

void PictureFile::write(const FrameImages& rows) {
    if (png_) {
        png_->write(rows.at(FrameImage::Beauty));
        return;
    }
    const OutputSpec& output = scene_.output;
    ExrImage exr = exr_image(rows, camera_, output.layers.value_or(ExrLayers{}),
                             double(output.width) / output.height);
    if (is_opaque(scene_, path_) && output.has_beauty)
        std::ranges::fill(exr.channels.at("A").values, 1.0F);
    exr.floats = like_.floats;
    exr.strings = like_.strings;
    if (!exr_) exr_.emplace(path_, output.width, output.height, exr);
    exr_->write(exr);
}

void PictureFile::finish() {
    if (png_)
        png_->finish();
    else
        exr_->finish();
}

} // namespace isocast
