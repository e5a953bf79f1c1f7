// Other renderers of spheres and sticks, timed from the same camera as ours.
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
    struct PeerStick {
        std::array<double, 3> a;
        std::array<double, 3> b;
        std::array<double, 4> rest;
    };
    std::vector<PeerSphere> spheres;
    std::vector<PeerStick> sticks;
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

/// VTK's sphere and stick mappers with lighting, drawn and read back; a child process under Xvfb.
/// throws  ResourceError, with the words of the child process, if it fails
SpheresFrame vtk_spheres_peer(const SpheresPeerScene& scene);

} // namespace isocast
