// Sequences of pictures: what changes from frame to frame.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/scene_file.h"

namespace isocast {

/// What must be done anew for each frame, beside the camera; each includes those before.
enum class Change { Nothing, Look, Iso, Load };
Change change_of(const SceneFile& scene);
/// Of one of its keys, by its full name.
Change change_of_key(const std::string& key);

/// The scene with its animations' numbers at frame `i` of `count`.
SceneFile scene_at(const SceneFile& scene, int i, int count);

/// The camera at frame `i` of `count`: `camera` turned around its target, or moved along the keys.
///
/// Keys are passed at their times. Between them Catmull-Rom's cubics have at each key the slope
/// from the key before to the one after, by their times, and at the ends that of the next segment.
Camera camera_at(const SceneFile& scene, const Camera& camera, int i, int count);

} // namespace isocast
