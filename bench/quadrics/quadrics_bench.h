// What the sections of bench_quadrics share.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "median.h"
#include "raycaster/renderer.h"

#include <functional>
#include <string>
#include <vector>

namespace isocast {

inline constexpr int width = 1024; // of pictures of scenes [pixels]
inline constexpr int height = 768;

struct BenchScene {
    std::string name;
    /// for_peers  with sticks in halves of one colour, from atom to atom
    std::function<Primitives(bool for_peers)> make;
};
/// Those with `only` in their names.
std::vector<BenchScene> bench_scenes(const std::string& only);

/// Of the loaded scene.
Camera camera_of(Renderer& renderer);

struct TimedFrame {
    double seconds; // until the GL has finished
    FrameReport report;
};
TimedFrame draw(Renderer& renderer, const Camera& camera, int w = width, int h = height);

/// Of frames seen from places a little apart, once it is warm.
double median_frame_seconds(Renderer& renderer, Camera camera, int w, int h, int repeats);

/// Pixels that show another primitive than the double ray caster's.
int wrong_pixels(Renderer& renderer, Primitives primitives, const Camera& camera);
/// Spheres at the picture's borders and corners, and some that the eye's plane cuts; prints them.
void count_hard_errors(Renderer& renderer);

/// Ellipsoids have semi-axes 1 : 0.6 : 0.4, cylinders are five times as long as wide.
enum class Specimen { Sphere, Ellipsoid, Cylinder, Cone, General, Superquadric, Triangle };
inline constexpr std::array specimen_names{"sphere",  "ellipsoid",    "cylinder", "cone",
                                           "general", "superquadric", "triangle"};

/// Of one kind, side by side, each turned at random within a ball of one size.
struct Specimens {
    Primitives primitives;
    Camera camera;
    std::vector<Eigen::Vector2f> centres_pixels; // from the bottom left corner
};
inline constexpr int specimens_width = 2048; // of their picture [pixels]
inline constexpr int specimens_height = 1536;
Specimens specimens(Specimen specimen, double radius_pixels);

/// Thesis table 7.2: primitives and fragments a second by kind, beside the GL's points.
void run_table_7_2(Renderer& renderer, int repeats);
/// Thesis table 7.3: direct and deferred shading, of the scenes with `only` in their names.
void run_table_7_3(Renderer& renderer, const std::string& only, int repeats);
/// Toledo and Levy's table 1: fragments that miss, by kind and by what is drawn around it.
void run_bounding_shapes(Renderer& renderer);
/// Wrong pixels of Sigg et al.'s eq. 7 and of ours, by a sphere's radius and distance.
void run_equation_7(Renderer& renderer);

} // namespace isocast
