// SPDX-License-Identifier: MPL-2.0
#include "apps/view/loading.h"

namespace isocast::view {

Loading::Loading(SceneFile what, Prepare prepare, SceneObjects& objects, std::function<void()> wake)
    : scene(std::move(what)),
      work(
          [this, prepare = std::move(prepare), &objects](const Progress& progress) {
              progress("reading", 0);
              if (prepare) prepare(scene, progress);
              objects.open(scene);
              progress("converting", 0);
              loaded = objects.compose(scene, progress, [this](const std::string& warning) {
                  warnings.push_back(warning);
              });
          },
          std::move(wake)) {}

} // namespace isocast::view
