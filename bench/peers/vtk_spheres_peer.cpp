// VTK's sphere mapper, in a child process: see vtk_spheres_child.cpp.
// SPDX-License-Identifier: MPL-2.0
#include "peers/child.h"
#include "peers/peer_frame.h"
#include "peers/programs.h"
#include "peers/spheres_peer.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <fmt/ostream.h>

#include <fstream>
#include <sstream>

namespace isocast {

SpheresFrame vtk_spheres_peer(const SpheresPeerScene& scene) {
    if (vtk_spheres_child_program.empty())
        return {.note = "not built (packages libvtk9-dev, xvfb and xauth)"};
    const ScratchFolder folder;
    {
        std::ofstream file(folder / "scene.txt");
        for (const SpheresPeerScene::PeerSphere& s : scene.spheres)
            fmt::print(file, "{} {}\n", fmt::join(s.centre, " "), fmt::join(s.rest, " "));
    }
    const std::string output = run_child(
        fmt::format("LP_NUM_THREADS=2 '{}' -a '{}' {} {} {} {} {} {} {} {}", xvfb_run_program,
                    vtk_spheres_child_program, folder / "scene.txt", fmt::join(scene.eye, " "),
                    fmt::join(scene.target, " "), fmt::join(scene.up, " "), scene.fov_degrees,
                    scene.width, scene.height, scene.repeats));
    const auto at = output.rfind("vtk_child: ");
    std::istringstream words(at == std::string::npos ? "" : output.substr(at + 11));
    double setup_seconds = 0;
    SpheresFrame frame;
    words >> setup_seconds >> frame.seconds >> std::ws;
    if (!std::getline(words, frame.note))
        throw ResourceError("the child process of VTK did not say its times:\n" + output);
    return frame;
}

} // namespace isocast
