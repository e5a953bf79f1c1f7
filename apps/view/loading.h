// A scene on its way: read, converted, composed.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/scene_objects.h"
#include "apps/view/work.h"

namespace isocast::view {

struct Loading {
    /// Changes a scene before it is read.
    using Prepare = std::function<void(SceneFile&, const Progress&)>;

    /// prepare  if there is something to be found out first
    /// objects  what was read before; nobody else may use it until the work is done
    Loading(SceneFile what, Prepare prepare, SceneObjects& objects, std::function<void()> wake);

    // Of the thread, until it is done.
    SceneFile scene; // prepared
    Scene loaded;
    std::vector<std::string> warnings;
    Work work; // the last: it uses the others
};

} // namespace isocast::view
