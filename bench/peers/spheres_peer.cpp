// VTK's and PyMOL's spheres and sticks, in child processes: see vtk_spheres_child.cpp and
// pymol_spheres_child.py.
// SPDX-License-Identifier: MPL-2.0
#include "peers/spheres_peer.h"

#include "peers/child.h"
#include "peers/programs.h"
#include "quadrics/primitives.h"
#include "raycaster/camera.h"
#include "volume/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <tuple>

namespace isocast {

namespace {

/// Two counts as int32, of spheres and of sticks; then as float32 each sphere's centre, radius and
/// linear colour, each stick's ends, radius and linear colour.
void write_scene(const std::string& path, const Primitives& primitives) {
    const std::array counts{static_cast<std::int32_t>(primitives.spheres.size()),
                            static_cast<std::int32_t>(primitives.cylinders.size())};
    std::vector<float> numbers;
    const auto add = [&](const Vec3d& v) {
        for (const double x : v) numbers.push_back(float(x));
    };
    const auto add_rest = [&](double radius, const Vec3d& colour) {
        numbers.push_back(float(radius));
        add(colour);
    };
    for (const Sphere& sphere : primitives.spheres) {
        add(sphere.centre_world);
        add_rest(sphere.radius_world, sphere.colour);
    }
    for (const Cylinder& stick : primitives.cylinders) {
        add(stick.a_world);
        add(stick.b_world);
        add_rest(stick.radius_world, stick.colour);
    }
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(counts.data()), sizeof counts);
    file.write(reinterpret_cast<const char*>(numbers.data()),
               std::streamsize(numbers.size() * sizeof(float)));
    if (!file.flush()) throw ResourceError("cannot write " + path);
}

/// Runs a child, which takes the arguments of vtk_spheres_child.cpp after its own.
SpheresPeerFrame frame_of(std::string name, const std::string& child, const SpheresPeerScene& scene,
                          const ScratchFolder& folder, int repeats) {
    const Camera& camera = scene.camera;
    const auto vector = [](const Vec3d& v) {
        return fmt::format("{:.17g} {:.17g} {:.17g}", v.x(), v.y(), v.z());
    };
    const std::string mask_file = folder / "mask.pgm";
    // The threads are those of Mesa's software rasteriser, which draws under Xvfb.
    const std::string output = run_child(fmt::format(
        "LP_NUM_THREADS=2 '{}' -a {} {} {} {} {} {} {} {} {} {}", xvfb_run_program, child,
        folder / "scene", mask_file, vector(camera.eye_world), vector(camera.target_world),
        vector(camera.up), camera.fov_y_degrees, scene.width, scene.height, repeats));
    const auto at = output.rfind("peer_child: ");
    std::istringstream words(at == std::string::npos ? "" : output.substr(at + 12));
    SpheresPeerFrame frame{.name = std::move(name)};
    words >> frame.seconds >> std::ws;
    if (!std::getline(words, frame.note))
        throw ResourceError("the child process did not say its time:\n" + output);
    const std::vector<bool> covered = read_mask(mask_file, scene.width, scene.height);
    const auto share = [&](const std::vector<bool>& mask) {
        return 100.0 * double(std::ranges::count(mask, true)) / double(mask.size());
    };
    int others = 0;
    for (std::size_t i = 0; i < covered.size(); ++i) others += covered[i] != scene.covered[i];
    frame.note += fmt::format("; covers {:.2f} %, ours {:.2f} %, {} pixels differ", share(covered),
                              share(scene.covered), others);
    return frame;
}

} // namespace

std::vector<SpheresPeerFrame> spheres_peers(const SpheresPeerScene& scene) {
    const ScratchFolder folder;
    write_scene(folder / "scene", scene.primitives);
    std::vector<SpheresPeerFrame> frames;
    const std::string vtk = "VTK's spheres, sticks";
    if (vtk_spheres_child_program.empty())
        frames.push_back({.name = vtk, .note = "not built (packages libvtk9-dev, xvfb and xauth)"});
    else
        frames.push_back(frame_of(vtk, fmt::format("'{}'", vtk_spheres_child_program), scene,
                                  folder, scene.repeats));
    for (const auto& [name, how, repeats] :
         {std::tuple("PyMOL's OpenGL", "gl", scene.repeats), std::tuple("PyMOL's ray", "ray", 1)})
        if (pymol_python_program.empty())
            frames.push_back({.name = name, .note = "not built (packages pymol, xvfb and xauth)"});
        else
            frames.push_back(frame_of(
                name,
                fmt::format("'{}' '{}' {}", pymol_python_program, pymol_spheres_child_script, how),
                scene, folder, repeats));
    return frames;
}

} // namespace isocast
