// VTK's ray caster, in a child process: see vtk_child.cpp.
// SPDX-License-Identifier: MPL-2.0
#include "peers/child.h"
#include "peers/peer_frame.h"
#include "peers/programs.h"
#include "volume/errors.h"
#include "volume/files.h"

#include <fmt/format.h>

#include <sstream>

namespace isocast {

PeerFrame vtk_peer(const PeerScene& scene) {
    const std::string name = "VTK GPU ray caster, isosurface";
    if (vtk_child_program.empty())
        return {.name = name, .note = "not built (packages libvtk9-dev, xvfb and xauth)"};
    const ScratchFolder folder;
    write_vti(scene.field, folder / "field.vti");
    const auto vector = [](const Vec3d& v) {
        return fmt::format("{:.17g} {:.17g} {:.17g}", v.x(), v.y(), v.z());
    };
    // The threads are those of Mesa's software rasteriser, which draws under Xvfb.
    const std::string output = run_child(
        fmt::format("LP_NUM_THREADS={} '{}' -a '{}' {} {} {} {} {} {} {} {}", scene.threads,
                    xvfb_run_program, vtk_child_program, folder / "field.vti", folder / "mask.pgm",
                    vector(scene.eye_world), vector(scene.target_world), vector(scene.up),
                    scene.fov_degrees, scene.size, scene.repeats));
    // The last line; VTK may have warned before.
    const auto at = output.rfind("vtk_child: ");
    std::istringstream words(at == std::string::npos ? "" : output.substr(at + 11));
    double setup_seconds = 0;
    double frame_seconds = 0;
    std::string renderer;
    words >> setup_seconds >> frame_seconds >> std::ws;
    if (!std::getline(words, renderer))
        throw ResourceError("the child process of VTK did not say its times:\n" + output);
    return peer_frame(
        name,
        "trilinear, step 1, no root; setup: first frame, with upload and shaders; " + renderer,
        setup_seconds, frame_seconds, read_mask(folder / "mask.pgm", scene.size, scene.size));
}

} // namespace isocast
