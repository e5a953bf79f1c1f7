// The file that a picture's rows go to.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/stereo.h"
#include "raycaster/image_files.h"

namespace isocast {

bool is_png(const std::filesystem::path& path);

/// A PNG shows the background; an OpenEXR has coverage in its place.
bool is_opaque(const SceneFile& scene, const std::filesystem::path& output);

/// A PNG or OpenEXR file by its extension, of one view or of a pair: a PNG shows one beside the
/// other, an OpenEXR has the views by their names. It appears whole, by finish(), or not at all.
class PictureFile {
public:
    /// scene, views  of the picture; both must outlive this
    /// like          gives an OpenEXR's attributes
    PictureFile(std::filesystem::path path, const SceneFile& scene,
                const std::vector<PictureView>& views, ExrImage like);
    /// The next rows, of each view.
    void write(const std::vector<FrameImages>& rows);
    void finish();

private:
    ExrImage exr_of(const FrameImages& rows, const PictureView& view) const;

    std::filesystem::path path_;
    const SceneFile& scene_;
    const std::vector<PictureView>& views_;
    ExrImage like_;
    std::optional<PngFile> png_;
    std::optional<ExrFile> exr_;
};

} // namespace isocast
