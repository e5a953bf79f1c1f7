// What `isocast render` says of its work.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/render_options.h"
#include "raycaster/fetch_choice.h"

namespace isocast {

struct RenderSeconds {
    double field = 0;   // reading, and for meshes converting
    double context = 0; // OpenGL
    double load = 0;    // active blocks, bricks to the GPU
    double draw = 0;    // all frames
    double write = 0;
    double total = 0;
};

struct RenderReport {
    const RenderCommand& command;
    const SceneFile& scene;
    const gl::DriverInfo* driver; // none of the reference
    const Renderer* renderer;
    std::optional<FetchChoice> fetch; // if there are fields
    const Scene& loaded;              // its objects are those of the renderer
    int frame_count = 1;
    FrameReport frame; // the last one's
    std::vector<std::string> warnings;
    RenderSeconds seconds;
};

/// What the scene asks for: outputs, effects, samples; for people.
std::vector<std::string> asked_for(const SceneFile& scene);

void print_json(const RenderReport& report);
/// What the scene asked for, and what each pass cost.
void explain(const RenderReport& report);
void print(const RenderReport& report);

} // namespace isocast
