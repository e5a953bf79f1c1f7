// SPDX-License-Identifier: MPL-2.0
#include "quadrics/point_data.h"

#include "quadrics/molecule_styles.h" // linear_light
#include "quadrics/point_parsers.h"
#include "quadrics/superquadric.h"
#include "volume/errors.h"
#include "volume/mapped_file.h"
#include "volume/volume_file.h" // lower_case

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>

namespace isocast {

namespace {

struct PointFormat {
    std::string_view extension;
    PointData (*parse)(std::string_view bytes, const std::string& name);
};
constexpr std::array formats = {PointFormat{".ply", parse_ply_points},
                                PointFormat{".csv", parse_csv_points}};

const PointFormat* find_format(const std::filesystem::path& path) {
    const std::string extension = lower_case(path.extension().string());
    const auto found = std::find_if(formats.begin(), formats.end(), [&](const auto& format) {
        return format.extension == extension;
    });
    return found == formats.end() ? nullptr : &*found;
}

const PointFormat& format_of(const std::filesystem::path& path) {
    if (const PointFormat* format = find_format(path)) return *format;
    throw InputError(fmt::format("{}: unknown point format '{}' (known: {})", path.string(),
                                 path.extension().string(), point_file_extensions()));
}

constexpr std::array<std::string_view, 3> bytes_of_colour = {"red", "green", "blue"};
constexpr std::array<std::string_view, 3> shares_of_colour = {"r", "g", "b"};
constexpr std::array<std::string_view, 6> tensor_names = {"txx", "tyy", "tzz", "txy", "txz", "tyz"};

bool has(std::span<const std::string> names, std::string_view name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

/// Whether all of `group` are there.
/// throws  InputError if only some are
bool has_whole(std::span<const std::string> names, std::span<const std::string_view> group,
               const std::string& file) {
    std::vector<std::string_view> missing;
    for (const std::string_view name : group)
        if (!has(names, name)) missing.push_back(name);
    if (!missing.empty() && missing.size() < group.size())
        throw InputError(fmt::format("{}: of the columns {} there are no {} (has: {})", file,
                                     fmt::join(group, ", "), fmt::join(missing, ", "),
                                     fmt::join(names, ", ")));
    return missing.empty();
}

// Beyond it squares would leave the floats in which pictures are made.
constexpr double greatest_value = 1e30;

} // namespace

std::vector<ColumnRange> ranges_of(std::span<const std::string> names, const std::string& file) {
    for (std::size_t i = 0; i < names.size(); ++i)
        if (has(names.first(i), names[i]))
            throw InputError(fmt::format("{}: two columns are called '{}'", file, shown(names[i])));
    for (const char* axis : {"x", "y", "z"})
        if (!has(names, axis))
            throw InputError(fmt::format("{}: there is no column '{}' (has: {})", file, axis,
                                         shown(fmt::format("{}", fmt::join(names, ", ")))));
    has_whole(names, bytes_of_colour, file);
    has_whole(names, tensor_names, file);
    // Alone, "r", "g" and "b" are names of many things.
    const bool has_shares = std::all_of(shares_of_colour.begin(), shares_of_colour.end(),
                                        [&](std::string_view name) { return has(names, name); });
    const auto is_of = [](std::span<const std::string_view> group, std::string_view name) {
        return std::find(group.begin(), group.end(), name) != group.end();
    };
    std::vector<ColumnRange> ranges(names.size());
    for (std::size_t i = 0; i < names.size(); ++i) {
        const std::string& name = names[i];
        if (name == "x" || name == "y" || name == "z" || is_of(tensor_names, name))
            ranges[i] = {true, -greatest_value, greatest_value};
        if (name == "radius") ranges[i] = {true, 0, greatest_value};
        if (is_of(bytes_of_colour, name)) ranges[i] = {true, 0, 255};
        if (has_shares && is_of(shares_of_colour, name)) ranges[i] = {true, 0, 1};
    }
    return ranges;
}

std::string problem_of(const ColumnRange& range, double value) {
    if (!range.is_checked || (value >= range.lo && value <= range.hi)) return "";
    if (!std::isfinite(value)) return fmt::format("{} is not finite", value);
    return fmt::format("{} is not from {} to {}", value, range.lo, range.hi);
}

const std::vector<double>* PointData::find(std::string_view name) const {
    const auto found = std::find(names.begin(), names.end(), name);
    return found == names.end() ? nullptr
                                : &columns[static_cast<std::size_t>(found - names.begin())];
}

std::vector<Vec3d> PointData::vectors(std::string_view a, std::string_view b,
                                      std::string_view c) const {
    std::array<const std::vector<double>*, 3> parts{};
    for (std::size_t k = 0; k < 3; ++k) {
        const std::string_view name = std::array{a, b, c}[k];
        if ((parts[k] = find(name)) == nullptr)
            throw InputError(
                fmt::format("there is no column '{}' (has: {})", name, fmt::join(names, ", ")));
    }
    std::vector<Vec3d> vectors;
    vectors.reserve(count());
    for (std::size_t i = 0; i < count(); ++i)
        vectors.emplace_back((*parts[0])[i], (*parts[1])[i], (*parts[2])[i]);
    return vectors;
}

PointData points_of_bytes(std::string_view bytes, const std::filesystem::path& name) {
    const PointFormat& format = format_of(name);
    PointData points = format.parse(bytes, name.string());
    if (points.count() == 0) throw InputError(fmt::format("{}: it holds no points", name.string()));
    return points;
}

PointData read_points(const std::filesystem::path& path) {
    format_of(path); // before all of a large file is read
    const MappedFile file(path);
    const auto bytes = file.bytes();
    return points_of_bytes({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, path);
}

bool is_point_file(const std::filesystem::path& path) {
    return find_format(path) != nullptr;
}

std::string point_file_extensions() {
    std::vector<std::string_view> extensions;
    for (const PointFormat& format : formats) extensions.push_back(format.extension);
    return fmt::format("{}", fmt::join(extensions, ", "));
}

std::vector<Mat3d> tensors_of(const PointData& points) {
    if (!points.find("txx")) return {};
    const std::vector<Vec3d> diagonals = points.vectors("txx", "tyy", "tzz");
    const std::vector<Vec3d> others = points.vectors("txy", "txz", "tyz");
    std::vector<Mat3d> tensors(points.count());
    for (std::size_t i = 0; i < tensors.size(); ++i) {
        const Vec3d &d = diagonals[i], &o = others[i];
        tensors[i] << d.x(), o.x(), o.y(), o.x(), d.y(), o.z(), o.y(), o.z(), d.z();
    }
    return tensors;
}

std::vector<Vec3d> colours_of(const PointData& points, const Vec3d& fallback) {
    const bool has_bytes = points.find("red") != nullptr;
    if (!has_bytes && !(points.find("r") && points.find("g") && points.find("b")))
        return std::vector<Vec3d>(points.count(), fallback);
    std::vector<Vec3d> colours =
        has_bytes ? points.vectors("red", "green", "blue") : points.vectors("r", "g", "b");
    const double full = has_bytes ? 255 : 1;
    for (Vec3d& colour : colours)
        for (double& c : colour) c = linear_light(c / full);
    return colours;
}

TensorAxes axes_of_tensor(const Mat3d& tensor) {
    const Eigen::SelfAdjointEigenSolver<Mat3d> solver(tensor);
    const Vec3d values = solver.eigenvalues().cwiseAbs();
    std::array order{0, 1, 2};
    std::stable_sort(order.begin(), order.end(),
                     [&](int a, int b) { return values[a] > values[b]; });
    TensorAxes axes;
    for (int k = 0; k < 3; ++k) {
        axes.lengths[k] = values[order[k]];
        axes.directions.col(k) = solver.eigenvectors().col(order[k]);
    }
    if (axes.directions.determinant() < 0) axes.directions.col(2) *= -1;
    return axes;
}

PointPrimitives primitives_of(const PointData& points, const PointLook& look) {
    PointPrimitives primitives;
    const std::vector<Vec3d> positions = points.positions_world();
    const std::vector<Vec3d> colours = colours_of(points, look.colour);
    const std::vector<Mat3d> tensors = tensors_of(points);
    const std::vector<double>* radius = points.find("radius");
    for (std::size_t i = 0; i < positions.size(); ++i) {
        if (tensors.empty()) {
            const double r = radius ? (*radius)[i] : look.radius_world;
            if (look.radius_pixels)
                primitives.dots.push_back({positions[i], *look.radius_pixels, colours[i]});
            else if (r < least_glyph_size)
                ++primitives.dropped;
            else
                primitives.spheres.push_back({positions[i], r, colours[i]});
            continue;
        }
        if (look.glyph == TensorGlyph::Superquadric) {
            std::optional<Superquadric> glyph = superquadric_of(positions[i], tensors[i], look);
            primitives.dropped += !glyph;
            if (!glyph) continue;
            glyph->colour = colours[i];
            primitives.superquadrics.push_back(*glyph);
            continue;
        }
        TensorAxes axes = axes_of_tensor(tensors[i]);
        axes.lengths *= look.tensor_scale;
        if (axes.lengths[0] * look.least_axis < least_glyph_size) {
            ++primitives.dropped;
            continue;
        }
        axes.lengths = axes.lengths.cwiseMax(look.least_axis * axes.lengths[0]);
        primitives.ellipsoids.push_back(
            {positions[i], axes.directions * axes.lengths.asDiagonal(), colours[i]});
    }
    return primitives;
}

} // namespace isocast
