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

namespace {

/// One beside the other; all of one size.
Image side_by_side(const std::vector<FrameImages>& views, FrameImage image) {
    const Image& first = views.front().at(image);
    if (views.size() == 1) return first;
    Image out{static_cast<int>(views.size()) * first.width, first.height, {}};
    for (int y = 0; y < first.height; ++y)
        for (const FrameImages& view : views) {
            const float* row = view.at(image).pixel(0, y);
            out.rgba.insert(out.rgba.end(), row, row + 4 * first.width);
        }
    return out;
}

} // namespace

PictureFile::PictureFile(std::filesystem::path path, const SceneFile& scene,
                         const std::vector<PictureView>& views, ExrImage like)
    : path_(std::move(path)), scene_(scene), views_(views), like_(std::move(like)) {
    if (is_png(path_))
        png_.emplace(path_, static_cast<int>(views.size()) * scene.output.width,
                     scene.output.height, scene.output.is_transparent);
}

ExrImage PictureFile::exr_of(const FrameImages& rows, const PictureView& view) const {
    const OutputSpec& output = scene_.output;
    ExrImage exr = exr_image(rows, view.camera, output.layers.value_or(ExrLayers{}),
                             double(output.width) / output.height, view.off_axis(output.width));
    if (is_opaque(scene_, path_) && output.has_beauty)
        std::ranges::fill(exr.channels.at("A").values, 1.0F);
    return exr;
}

void PictureFile::write(const std::vector<FrameImages>& rows) {
    if (png_) {
        png_->write(side_by_side(rows, FrameImage::Beauty));
        return;
    }
    ExrImage exr = exr_of(rows.front(), views_.front());
    if (rows.size() > 1) exr = stereo(std::move(exr), exr_of(rows.back(), views_.back()));
    exr.floats = like_.floats;
    exr.strings = like_.strings;
    if (!exr_) exr_.emplace(path_, scene_.output.width, scene_.output.height, exr);
    exr_->write(exr);
}

void PictureFile::finish() {
    if (png_)
        png_->finish();
    else
        exr_->finish();
}

} // namespace isocast
