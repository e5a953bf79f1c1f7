// From what a scene file says of objects to the field that is drawn.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/inputs.h"
#include "apps/scene_file.h"
#include "volume/progress.h"

#include <functional>

namespace isocast {

/// The object that a scene draws, read from its file.
struct OpenedObject {
    Input input;
    std::optional<CheckedMesh> mesh; // to be converted
    std::shared_ptr<const FieldSource> field;
};

/// throws  InputError if the file cannot be read, or if the scene asks for what cannot be drawn
OpenedObject open_object(const SceneFile& scene);

/// What the renderer loads. Meshes are converted here, which is the long work.
///
/// warn  told what was noticed on the way
Scene scene_from(const SceneFile& scene, OpenedObject object, const Progress& progress,
                 const std::function<void(const std::string&)>& warn);

/// The look, with the object's colour. Pictures that are not opaque have no background.
Look look_of(const SceneFile& scene, bool is_opaque);

} // namespace isocast
