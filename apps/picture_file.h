// The file that a picture's rows go to.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/scene_file.h"
#include "raycaster/image_files.h"

namespace isocast {

bool is_png(const std::filesystem::path& path);

/// A PNG shows the background; an OpenEXR has coverage in its place.
bool is_opaque(const SceneFile& scene, const std::filesystem::path& output);

/// A PNG or OpenEXR file by its extension. It appears whole, by finish(), or not at all.
class PictureFile {
public:
    /// scene, camera  of the picture; both must outlive this
    /// like           gives an OpenEXR's attributes
    PictureFile(std::filesystem::path path, const SceneFile& scene, const Camera& camera,
                ExrImage like);
    /// The next rows.
    void write(const FrameImages& rows);
    void finish();

private:
    std::filesystem::path path_;
    const SceneFile& scene_;
    const Camera& camera_;
    ExrImage like_;
    std::optional<PngFile> png_;
    std::optional<ExrFile> exr_;
};

} // namespace isocast
