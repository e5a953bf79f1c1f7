// What tests of shading share: a context, a renderer, and pictures of scenes.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "renderer_test_base.h"
#include "volume/analytic_fields.h"

#include <cmath>

namespace isocast::test {

struct Shading : RendererTest {
    Camera camera{.eye_world = {1.6, 1.2, 4.5}, .target_world = Vec3d::Zero()};
    int size = 96;

    Image draw(const Scene& scene, FrameImage image = FrameImage::Beauty) {
        renderer.load(scene);
        report = renderer.draw(camera, size, size, {image});
        return renderer.read(image);
    }
    const PassReport& pass(std::string_view name) const {
        for (const PassReport& p : report.passes)
            if (p.name == name) return p;
        throw std::logic_error("no such pass: " + std::string(name));
    }

    FrameReport report;
};

} // namespace isocast::test
