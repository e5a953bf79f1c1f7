// Other renderers of spheres, timed from the same camera as ours.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <array>
#include <limits>
#include <string>
#include <vector>

namespace isocast {

struct SpheresPeerScene {
    struct PeerSphere {
        std::array<double, 3> centre;
        std::array<double, 4> rest; // radius and linear colour
    };
    std::vector<PeerSphere> spheres;
    std::array<double, 3> eye;
    std::array<double, 3> target;
    std::array<double, 3> up;
    double fov_degrees = 30;
    int width = 1024;
    int height = 768;
    int repeats = 5;
};

struct SpheresFrame {
    double seconds = std::numeric_limits<double>::quiet_NaN(); // the median
    std::string note; // the GL's renderer, or why there is no frame
};

/// VTK's sphere mapper with lighting, drawn and read back; a child process under Xvfb.
/// throws  ResourceError, with the words of the child process, if it fails
SpheresFrame vtk_spheres_peer(const SpheresPeerScene& scene);

} // namespace isocast
