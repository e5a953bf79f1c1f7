// How hits are turned into a picture: lights, material, shading model, environment and effects.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/image.h"
#include "volume/field_source.h"

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace isocast {

/// Coefficients of the shading models; colours are linear RGB.
struct Material {
    Vec3d colour = Vec3d(0.72, 0.60, 0.42);
    double ambient = 0.18;
    double diffuse = 0.82;
    double specular = 0.25;
    double shininess = 40;

    bool operator==(const Material&) const = default;
};

enum class Shadow { None, Hard, Soft };

/// A light infinitely far away.
struct Light {
    /// Towards the light, of any length. In view space (x right, y up, z to the viewer) it moves
    /// with the camera.
    Vec3d direction = Vec3d(-0.35, 0.5, 1.0);
    bool is_in_view_space = true;
    Vec3d colour = Vec3d(1, 1, 1);
    Shadow shadow = Shadow::None; // of one light at most
    double shadow_strength = 1;
    double size_degrees = 3; // Shadow::Soft: the angle under which the light is seen
    /// Along the longer side of what the light sees; else as the picture's longer side, 4096 at
    /// most.
    std::optional<int> shadow_map_pixels;

    bool operator==(const Light&) const = default;
};

/// The shader arrays' size.
inline constexpr std::size_t max_light_count = 8;

enum class ShadingModel {
    BlinnPhong, // [Blinn 1977]
    Gooch,      // from cool to warm [Gooch et al. 1998]
    Flat,       // the surface colour, unlit
};

/// Gooch's tones, linear RGB: the surface colour is mixed into both.
struct GoochTones {
    Vec3d cool = Vec3d(0.02, 0.05, 0.30);
    Vec3d warm = Vec3d(0.45, 0.40, 0.05);
    double cool_share = 0.25; // alpha: of the surface colour in the cool tone
    double warm_share = 0.55; // beta

    bool operator==(const GoochTones&) const = default;
};

/// Light from all directions, for reflection, refraction and the background.
struct Environment {
    enum class Kind { Sky, Stripes, Picture };
    Kind kind = Kind::Sky;
    Image picture = {}; // equirectangular, linear, the top row up; +y is up in world space
    int stripes = 24;   // horizontal ones, from pole to pole

    bool operator==(const Environment&) const = default;
};

// The effects. Each has a strength in [0, 1]; at 0 it does not exist.

/// Texture coordinates are affine in world space (thesis section 6.4.2, "Solid texturing").
struct SolidTexture {
    double strength = 0;
    enum class Kind { Checker, Stripes, Marble, Wood, Volume } kind = Kind::Marble;
    std::optional<double> scale_world; // one period; else 1/12 of the field's diagonal
    Vec3d origin_world = Vec3d::Zero();
    Vec3d axis = Vec3d::UnitY(); // across stripes and marble's veins, along the trunk
    Vec3d colour_a = Vec3d(0.85, 0.82, 0.75);
    Vec3d colour_b = Vec3d(0.20, 0.13, 0.09);
    /// Kind::Volume: 0 is colour_a, 1 colour_b; it lies where its own grid says.
    std::shared_ptr<const FieldSource> volume;
    std::string volume_filter = "bspline"; // of its samples, as they are; or "linear"

    bool operator==(const SolidTexture&) const = default;
};

enum class CurvatureMeasure { K1, K2, Mean, Gauss, ShapeIndex, Curvedness };
enum class ColourMap { Viridis, CoolWarm };

/// One curvature measure through a 1D map.
struct CurvatureColour {
    double strength = 0;
    CurvatureMeasure measure = CurvatureMeasure::Mean;
    /// Cool-warm, symmetric about 0, for signed measures, viridis for curvedness.
    std::optional<ColourMap> map;
    /// [1/world, for Gauss 1/world^2]; else from the picture's percentiles.
    std::optional<std::array<double, 2>> range;

    bool operator==(const CurvatureColour&) const = default;
};

/// (k1, k2) through a picture: x from k1 = -range to range, y upwards from k2 likewise.
struct CurvatureMap {
    double strength = 0;
    Image picture = {}; // linear; empty: a built-in one
    std::optional<double> range;

    bool operator==(const CurvatureMap&) const = default;
};

/// Darkens where k2 < 0, an approximation of accessibility [Miller 1994] (thesis figure 6.11).
struct Accessibility {
    double strength = 0;
    std::optional<double> radius_world; // at k2 = -1/radius the surface is black

    bool operator==(const Accessibility&) const = default;
};

/// Ambient occlusion, by rays through fields and among primitives.
struct Occlusion {
    double strength = 0;
    /// How far occluders count; else a tenth of the diagonal of the surface's box.
    std::optional<double> distance_world;
    int rays = 16; // of each pixel

    bool operator==(const Occlusion&) const = default;
};

/// Contours of even thickness [Kindlmann et al. 2003].
struct Contours {
    double strength = 0;
    double thickness_pixels = 2;
    Vec3d colour = Vec3d::Zero();

    bool operator==(const Contours&) const = default;
};

/// Ridge and valley lines in the (k1, k2) domain [Kindlmann et al. 2003].
struct Ridges {
    double strength = 0;
    std::optional<double> threshold; // [1/world]; else from the picture's percentiles
    Vec3d ridge_colour = Vec3d(0.9, 0.85, 0.7);
    Vec3d valley_colour = Vec3d(0.1, 0.05, 0.02);

    bool operator==(const Ridges&) const = default;
};

/// Where a small change of the iso value moves the surface far, or the field bends fast along its
/// gradient [Kindlmann et al. 2003].
struct Uncertainty {
    double strength = 0;
    std::optional<double> range; // flow-line curvature of full uncertainty [1/world]
    /// Half of it is where weak gradients begin to count; else the picture's median.
    std::optional<double> typical_gradient;
    Vec3d colour = Vec3d(0.8, 0.1, 0.1);

    bool operator==(const Uncertainty&) const = default;
};

/// Lines along a principal direction: line-integral convolution of a noise in space, as a factor of
/// the surface's colour.
struct Flow {
    double strength = 0;
    int direction = 1; // of k1 or k2
    double length_pixels = 20;
    double grain_pixels = 1.5;
    std::optional<double> phase; // with period 1: the kernel travels along the lines

    bool operator==(const Flow&) const = default;
};

struct Reflection {
    double strength = 0;
    bool has_fresnel = false; // Schlick's, with the index of `Refraction`

    bool operator==(const Reflection&) const = default;
};

struct Refraction {
    double strength = 0;
    double index = 1.5;

    bool operator==(const Refraction&) const = default;
};

/// Sobel edges of depth and normals (thesis section 7.3.3).
struct Outlines {
    double strength = 0;
    double silhouette_threshold = 0.02; // a step in depth, relative to the field's diagonal
    double crease_threshold = 0.8;      // the length of a step in unit normals
    Vec3d colour = Vec3d::Zero();

    bool operator==(const Outlines&) const = default;
};

/// A plane that shows the field of the scene's first object itself: tones by its distance from the
/// iso value, lines where it is a multiple of `spacing_world`, a thick one where it is iso.
struct Slice {
    double strength = 0;
    Vec3d normal = Vec3d::UnitZ();       // any length but 0
    double offset_world = 0;             // of the unit normal
    std::optional<double> spacing_world; // of lines; else as slice_spacing_world() finds it
    std::optional<double> range_world;   // of tones; else as slice_range_world() finds it
    Vec3d inside = Vec3d(0.10, 0.25, 0.65);
    Vec3d outside = Vec3d(0.75, 0.35, 0.10);
    Vec3d line = Vec3d(0.02, 0.02, 0.02);

    bool operator==(const Slice&) const = default;
};

struct Effects {
    SolidTexture solid_texture;
    CurvatureColour curvature_colour;
    CurvatureMap curvature_map;
    Uncertainty uncertainty;
    Flow flow;
    Accessibility accessibility;
    Occlusion occlusion;
    Refraction refraction;
    Reflection reflection;
    Ridges ridges;
    Contours contours;
    Outlines outlines;
    Slice slice;

    bool operator==(const Effects&) const = default;
};

/// All that a picture needs beside geometry; it changes without a new load.
struct Look {
    Material material;
    std::vector<Light> lights = {Light{}};
    ShadingModel model = ShadingModel::BlinnPhong;
    GoochTones tones;
    Environment environment;
    Vec3d background = Vec3d(0.93, 0.94, 0.95);
    bool shows_environment = false; // as the background
    Effects effects;

    bool operator==(const Look&) const = default;
};

} // namespace isocast
