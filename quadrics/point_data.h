// Points with named numbers, from PLY and CSV files, and the spheres and ellipsoids that show them.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/primitives.h"

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace isocast {

/// A table: each point has a number in each column.
struct PointData {
    std::vector<std::string> names;           // of the columns, in the file's order, each once
    std::vector<std::vector<double>> columns; // all as long

    std::size_t count() const { return columns.empty() ? 0 : columns[0].size(); }
    /// The column called `name`; null if there is none.
    const std::vector<double>* find(std::string_view name) const;
    /// The columns called `a`, `b` and `c`, which must be there.
    std::vector<Vec3d> vectors(std::string_view a, std::string_view b, std::string_view c) const;
    std::vector<Vec3d> positions_world() const { return vectors("x", "y", "z"); }
};

/// The points in a .ply or .csv file.
///
/// PLY: text or binary of either byte order; the properties of the element "vertex" that are no
/// lists, under their names. CSV: the first line names the columns, and cells are between commas,
/// within double quotes if need be, but on one line; blank lines and those that begin with '#' do
/// not count.
///
/// Numbers are finite and within 1e30 in the columns that primitives_of() knows, and as it wants
/// them; elsewhere a cell of a CSV file that holds no number is NaN.
///
/// throws  InputError that names the file, the line, element or byte, and the cause: text that is
///         not of its format, missing x, y or z, a name that two columns have, some of a tensor's
///         or of a colour's columns without the others, fewer or more values than the file says,
///         a number that cannot be one, no points. Nothing is reserved for points that the file is
///         too short to hold.
PointData read_points(const std::filesystem::path& path);
/// The same for the bytes of a file, whose name's extension says its format.
PointData points_of_bytes(std::string_view bytes, const std::filesystem::path& name);

bool is_point_file(const std::filesystem::path& path);
std::string point_file_extensions(); // ".ply, .csv"

// Squares of smaller ones would leave the floats in which pictures are made.
inline constexpr double least_glyph_size = 1e-30;

/// What shows a tensor.
enum class TensorGlyph { Ellipsoid, Superquadric };

struct PointLook {
    double radius_world = 1;             // of points without a column "radius"
    std::optional<double> radius_pixels; // of all points, instead
    TensorGlyph glyph = TensorGlyph::Ellipsoid;
    double tensor_scale = 1;               // world units per unit of an eigenvalue
    double sharpness = 3;                  // of superquadrics: superquadric_of()
    double least_axis = 0.01;              // of the greatest semi-axis of the same glyph
    Vec3d colour = Vec3d(0.72, 0.6, 0.42); // linear; of points without colours
};

/// What shows points, in their order: ellipsoids or superquadrics where there are tensors, else
/// spheres or dots.
struct PointPrimitives {
    std::vector<Sphere> spheres;
    std::vector<Dot> dots;
    std::vector<Ellipsoid> ellipsoids;
    std::vector<Superquadric> superquadrics;
    std::size_t dropped = 0; // points of radius 0 or with a tensor of zeros, which show nothing
};

/// Columns "radius" (not negative); "txx", "tyy", "tzz", "txy", "txz", "tyz" of a symmetric tensor,
/// with which a radius does not count; colours "red", "green", "blue" from 0 to 255 or else "r",
/// "g", "b" from 0 to 1, both sRGB.
///
/// A glyph's semi-axes lie along the tensor's eigenvectors and are as long as the absolute
/// values of its eigenvalues, times look.tensor_scale; one shorter than look.least_axis of the
/// greatest becomes that long, so that linear and planar tensors have a body. What would be smaller
/// than 1e-30 is dropped as if it were zero.
///
/// accuracy  lengths within 1e-14 of the greatest, by Eigen's SelfAdjointEigenSolver
PointPrimitives primitives_of(const PointData& points, const PointLook& look = {});

/// The symmetric tensors of `points`; empty if it has none.
std::vector<Mat3d> tensors_of(const PointData& points);
/// The colours of `points`, linear; all `fallback` if it has none.
std::vector<Vec3d> colours_of(const PointData& points, const Vec3d& fallback);

/// A symmetric tensor by the absolute values of its eigenvalues, the greatest first.
struct TensorAxes {
    Vec3d lengths = Vec3d::Zero();
    Mat3d directions = Mat3d::Identity(); // columns, orthonormal, right-handed
};
TensorAxes axes_of_tensor(const Mat3d& tensor);

} // namespace isocast
