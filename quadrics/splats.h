// What a picture takes of each primitive that it can show: a rectangle of pixels, and the numbers
// by which rays meet the primitive.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/cut.h"
#include "quadrics/screen_bounds.h"

#include <array>
#include <vector>

namespace isocast {

/// What is drawn around a primitive; of triangles always another one.
enum class BoundingShape {
    Rectangle, // with its sides along and across what is long
    Box,       // with its sides along the picture's, for comparison
    Square,    // around that, as point sprites are
};

/// A picture, or a part of one, as a camera sees it.
struct SplatView {
    PictureSpace space;
    double pixels_per_unit = 1; // of the plane of the picture: of a slope, or of a world unit
    /// Where the camera looks, from the part's bottom left corner, upwards [pixels].
    Eigen::Vector2d middle_pixels = Eigen::Vector2d::Zero();
    int width = 1; // of the part [pixels]
    int height = 1;
    /// Spheres and sticks of lesser radius [pixels] are thinned out: 0, none. Few of many are
    /// drawn, as large as this or, for a while, growing to it, so that the mean area of all stays:
    /// neither do they flicker when the camera moves, nor does a crowd of them have holes.
    double detail_pixels = 0;
    std::vector<CutPlane> planes; // of unit normals, in front of which nothing is drawn
    BoundingShape shape = BoundingShape::Rectangle;
};

/// The primitives with a sphere for each dot, after all others.
///
/// With s the slope of its radius, a dot at depth d becomes a sphere of radius d s / sqrt(1 + s^2):
/// at an angle phi off the axis it is d / cos(phi) away, under a half angle with the sine cos(phi)
/// s / sqrt(1 + s^2), and the lesser semi-axis of that cone's image is s, whatever phi.
///
/// space, pixels_per_unit  of the whole picture, as in SplatView; of the viewer, also for what else
///                         looks at the scene, such as lights
Primitives with_dots_as_spheres(Primitives primitives, const PictureSpace& space,
                                double pixels_per_unit);

/// Which code meets a splat's rays.
enum class SplatKind {
    Sphere,
    Ellipsoid,
    Cone,
    General,
    Superquadric,
    Triangle,
    Patch,
    Tetrahedron,
    Slim, // pieces that are blended: slim_splats.h
};
inline constexpr int splat_kind_count = 9;
inline constexpr unsigned all_splat_kinds = (1U << splat_kind_count) - 1; // by bits
template<class Primitive>
inline constexpr SplatKind splat_kind = SplatKind::Cone; // of cylinders, too
template<>
inline constexpr SplatKind splat_kind<Sphere> = SplatKind::Sphere;
template<>
inline constexpr SplatKind splat_kind<Ellipsoid> = SplatKind::Ellipsoid;
template<>
inline constexpr SplatKind splat_kind<ClippedQuadric> = SplatKind::General;
template<>
inline constexpr SplatKind splat_kind<Superquadric> = SplatKind::Superquadric;
template<class Primitive>
constexpr SplatKind splat_kind_of(const Primitive&) {
    return splat_kind<Primitive>;
}

/// Floats of a splat, by kind; shaders/quadrics/splat.glsl says which.
inline constexpr std::array<int, splat_kind_count> splat_floats{12, 24, 20, 36, 24, 24, 24, 52, 36};

/// Of these its place in the picture, before its body.
constexpr int place_floats(SplatKind kind) {
    return kind == SplatKind::Sphere ? 4 : 8;
}
constexpr int body_floats(SplatKind kind) {
    return splat_floats[static_cast<std::size_t>(kind)] - place_floats(kind);
}

/// The numbers by which rays meet a primitive in the axes of `space`, body_floats many
/// (shaders/quadrics/splat.glsl).
void put_body(const Sphere& sphere, const PictureSpace& space, float* to);
void put_body(const Superquadric& superquadric, const PictureSpace& space, float* to);
template<class Primitive>
void put_body(const Primitive& primitive, const PictureSpace& space, float* to);

/// Pixels from the part's bottom left corner, upwards.
struct PixelBox {
    float x_lo, x_hi;
    float y_lo, y_hi;
};

/// The primitives that a picture can show: of quadrics the nearest first within each kind.
struct Splats {
    std::array<std::vector<float>, splat_kind_count> records;
    std::vector<PixelBox> boxes;     // that hold them, of all
    bool shows_slims_inside = false; // of any SLIM surface

    int count(SplatKind kind) const {
        const auto k = static_cast<std::size_t>(kind);
        return static_cast<int>(records[k].size() / static_cast<std::size_t>(splat_floats[k]));
    }
};

/// Primitives are numbered kind by kind in the order of Primitives; of meshes all
/// elements have the mesh's number.
///
/// primitives  checked, without dots
/// returns     those of which some part is in front of the eye and within the part of the picture,
///             and that no nearer spheres, ellipsoids or superquadrics hide (visible_footprints)
/// accuracy    rectangles have a 16th of a pixel to spare; differences from the eye are taken in
///             double, so that the distance of the scene from the world's origin costs nothing
Splats splats_of(const Primitives& primitives, const SplatView& view);

} // namespace isocast
