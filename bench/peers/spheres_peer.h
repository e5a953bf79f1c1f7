// Other renderers of spheres and sticks, timed from the same camera as ours.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace isocast {

struct Camera;
struct Primitives;

struct SpheresPeerScene {
    const Primitives& primitives; // spheres and sticks; these in pairs, the halves of bonds
    const Camera& camera;
    int width = 1024;
    int height = 768;
    int repeats = 5;
    std::vector<bool> covered; // pixels of our picture, row by row from the top
};

struct SpheresPeerFrame {
    std::string name;
    double seconds = std::numeric_limits<double>::quiet_NaN(); // the median
    std::string note; // who drew and what it covers, or why there is no frame
};

/// VTK's sphere and stick mappers, PyMOL's OpenGL, PyMOL's `ray` with shadows (one frame), each
/// with lighting, drawn and read back; child processes under Xvfb. throws  ResourceError, with the
/// words of the child process, if one fails
std::vector<SpheresPeerFrame> spheres_peers(const SpheresPeerScene& scene);

} // namespace isocast
