// A field, every sample of it, against the truth: distances by brute force, sides by winding
// number.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/brute_force.h"
#include "distance_transform/convert.h"
#include "stability/hard_meshes.h"
#include "stability/shapes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <functional>
#include <limits>
#include <sstream>

namespace isocast::test {

using namespace stability; // its meshes

/// Unsigned distance at a point in voxels from some lattice point.
using Distance = std::function<double(const Vec3d& p_voxels)>;

/// Truths about a surface, asked for at points in voxels from some lattice point.
struct Truth {
    /// A distance that need be right only within `reach` of `middle`.
    std::function<Distance(const Vec3d& middle, double reach)> distance_near;
    std::function<double(const Vec3d& p_voxels)> winding;
    Sides sides = Sides::Closed;
};

/// The truth at every sample of a box, x fastest.
struct KnownField {
    IndexBox box;
    std::vector<double> distances; // [voxels]
    std::vector<char> sides;       // 'i'nside, 'o'utside, or '?' where it is not to be checked

    std::size_t place(const Index3& at) const {
        const Index3 p = at - box.lo;
        const Index3 n = box.size();
        return p.x() + std::size_t(n.x()) * (p.y() + std::size_t(n.y()) * p.z());
    }
    Index3 index(std::size_t i) const {
        const auto nx = std::size_t(box.size().x());
        const auto ny = std::size_t(box.size().y());
        return box.lo + Index3(int(i % nx), int(i / nx % ny), int(i / (nx * ny)));
    }
    /// In voxels from the box's first sample.
    Vec3d position(std::size_t i) const { return (index(i) - box.lo).cast<double>(); }
};

/// For every sample the number of a sample on the same side of a closed surface: the farthest from
/// the surface of those that are joined to it by steps that cannot cross the surface, since the
/// distances at their ends add up to more than their length.
inline std::vector<std::size_t> spokesmen(const KnownField& known) {
    const std::vector<double>& distances = known.distances;
    const Index3 n = known.box.size();
    const std::array<std::size_t, 3> stride = {1, std::size_t(n.x()), std::size_t(n.x()) * n.y()};
    constexpr std::size_t nobody = std::numeric_limits<std::size_t>::max();
    std::vector<std::size_t> result(distances.size(), nobody);
    std::vector<std::size_t> group;
    for (std::size_t start = 0; start < distances.size(); ++start) {
        if (result[start] != nobody) continue;
        result[start] = start;
        group = {start};
        std::size_t farthest = start;
        for (std::size_t done = 0; done < group.size(); ++done) {
            const std::size_t i = group[done];
            if (distances[i] > distances[farthest]) farthest = i;
            const Index3 at = known.index(i) - known.box.lo;
            for (int axis = 0; axis < 3; ++axis)
                for (const int step : {-1, 1}) {
                    if (at[axis] + step < 0 || at[axis] + step >= n[axis]) continue;
                    const std::size_t j = step > 0 ? i + stride[axis] : i - stride[axis];
                    // 1e-9: far above the rounding of the distances.
                    if (result[j] != nobody || distances[i] + distances[j] <= 1 + 1e-9) continue;
                    result[j] = start;
                    group.push_back(j);
                }
        }
        for (const std::size_t i : group) result[i] = farthest;
    }
    return result;
}

/// half_width  [voxels] of the widest band to be compared: farther off, distances are lower bounds
inline KnownField known_field(const Truth& truth, const IndexBox& box, double half_width) {
    const auto count = static_cast<std::size_t>(box.sample_count());
    KnownField known = {box, std::vector<double>(count), std::vector<char>(count, '?')};
    // By cells of 4^3 samples: none is farther than 2.6 from the middle of its cell, and the
    // distance changes by no more than that.
    constexpr int edge = 4;
    constexpr double reach = 2.6;
    const IndexBox cells = {Index3::Zero(), floor_div(Index3(box.size().array() + edge - 1), edge)};
    const Index3 n = cells.size();
    tbb::parallel_for(std::int64_t{0}, cells.sample_count(), [&](std::int64_t c) {
        const Index3 first =
            edge * Index3(int(c % n.x()), int(c / n.x() % n.y()), int(c / n.x() / n.y()));
        const Vec3d middle = first.cast<double>().array() + (edge - 1) / 2.0;
        const Distance distance = truth.distance_near(middle, reach);
        const double from_middle = distance(middle);
        const bool is_far = from_middle > half_width + reach;
        const Index3 lo = box.lo + first;
        const IndexBox cell = intersection({lo, Index3(lo.array() + edge)}, box);
        for (int z = cell.lo.z(); z < cell.hi.z(); ++z)
            for (int y = cell.lo.y(); y < cell.hi.y(); ++y)
                for (int x = cell.lo.x(); x < cell.hi.x(); ++x) {
                    const std::size_t i = known.place({x, y, z});
                    const Vec3d p = known.position(i);
                    known.distances[i] = is_far ? from_middle - (p - middle).norm() : distance(p);
                }
    });
    if (truth.sides == Sides::None) return known;
    const bool is_closed = truth.sides == Sides::Closed;
    const std::vector<std::size_t> spokesman =
        is_closed ? spokesmen(known) : std::vector<std::size_t>();
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
        // 1e-9: nearer to the surface the oracle's own rounding decides.
        if ((is_closed && spokesman[i] != i) || known.distances[i] <= 1e-9) return;
        const double winding = truth.winding(known.position(i));
        if (is_closed || std::abs(winding - 0.5) > 0.1) known.sides[i] = winding > 0.5 ? 'i' : 'o';
    });
    if (is_closed)
        for (std::size_t i = 0; i < count; ++i)
            if (known.distances[i] > 1e-9) known.sides[i] = known.sides[spokesman[i]];
    return known;
}

struct Faults {
    std::int64_t active = 0;
    std::int64_t missing = 0;         // in the band, but not active
    std::int64_t beyond = 0;          // active, but not in the band
    std::int64_t wrong_distances = 0; // off by more than 1e-5 voxel and half a unit in last place
    std::int64_t wrong_signs = 0;
    double worst_error_voxels = 0;
    std::string examples; // the first of each kind
};

/// rounding_voxels  of the known distances
inline Faults faults_of(const SparseField& field, const KnownField& known, double half_width,
                        bool is_open = false, double rounding_voxels = 1e-10) {
    const double voxel = field.space().voxel_size_world();
    const auto background = static_cast<float>(field.background_world());
    std::vector<float> values(known.distances.size());
    field.copy_box(known.box, 0, values);
    Faults faults;
    const auto blame = [&](std::int64_t Faults::*kind, const Index3& at, const std::string& what) {
        if (++(faults.*kind) > 1) return;
        std::ostringstream text;
        text << "\n  " << what << " at sample " << at.transpose();
        if (known.box.contains(at))
            text << ": " << values[known.place(at)] / voxel << " voxels, truth "
                 << known.distances[known.place(at)] << ' ' << known.sides[known.place(at)];
        faults.examples += text.str();
    };
    std::vector<char> is_active(values.size());
    for (const FieldBlock& block : field.blocks())
        for (int i = 0; i < samples_per_block; ++i) {
            if (!block.active[i]) continue;
            const Index3 at = block_size * block.coordinate + Index3(i % 8, i / 8 % 8, i / 64);
            if (known.box.contains(at))
                is_active[known.place(at)] = 1;
            else
                blame(&Faults::beyond, at, "far beyond the band");
        }
    for (std::size_t i = 0; i < values.size(); ++i) {
        const double d = known.distances[i];
        const float value = std::abs(values[i]);
        if (is_active[i]) {
            ++faults.active;
            // 1e-6: what the active set may be too large by.
            if (d > half_width + 1e-6) blame(&Faults::beyond, known.index(i), "beyond the band");
            const float next = std::nextafter(value, std::numeric_limits<float>::infinity());
            const double half_ulp = (double{next} - double{value}) / 2;
            const double error = (std::abs(value - d * voxel) - half_ulp) / voxel;
            // 1e-5: what the project promises. Written so that it catches what is no number.
            if (!(error <= 1e-5)) blame(&Faults::wrong_distances, known.index(i), "wrong distance");
            faults.worst_error_voxels = std::max(faults.worst_error_voxels, error);
        } else {
            if (d <= half_width - rounding_voxels)
                blame(&Faults::missing, known.index(i), "missing");
            if (value != background)
                blame(&Faults::wrong_distances, known.index(i), "not background");
            // Beyond the band of an open mesh the sign need only change where w = 1/2 is near.
            if (is_open) continue;
        }
        if (known.sides[i] != '?' && std::signbit(values[i]) != (known.sides[i] == 'i'))
            blame(&Faults::wrong_signs, known.index(i), "wrong sign");
    }
    return faults;
}

inline void expect_no_faults(const Faults& faults) {
    EXPECT_GT(faults.active, 0);
    EXPECT_EQ(faults.missing, 0) << faults.examples;
    EXPECT_EQ(faults.beyond, 0) << faults.examples;
    EXPECT_EQ(faults.wrong_distances, 0)
        << faults.examples << "\n  worst error " << faults.worst_error_voxels << " voxels";
    EXPECT_EQ(faults.wrong_signs, 0) << faults.examples;
}

/// Brute force, over the triangles that can be closest to a point within `reach` of `middle`: those
/// that are farther from it than the closest one by more than twice the reach cannot.
inline Distance brute_force_near(const Mesh& mesh, const Vec3d& middle, double reach) {
    std::vector<double> distances(mesh.triangles.size());
    Mesh one{{Vec3d::Zero(), Vec3d::Zero(), Vec3d::Zero()}, {{0, 1, 2}}};
    for (std::size_t t = 0; t < distances.size(); ++t) {
        for (int k = 0; k < 3; ++k)
            one.vertices_world[k] = mesh.vertices_world[mesh.triangles[t][k]];
        distances[t] = brute_force_distance(one, middle);
    }
    const double least = *std::ranges::min_element(distances);
    Mesh few{mesh.vertices_world, {}};
    for (std::size_t t = 0; t < distances.size(); ++t)
        // 1e-6: rounding.
        if (distances[t] <= least + 2 * reach + 1e-6) few.triangles.push_back(mesh.triangles[t]);
    return [few = std::move(few)](const Vec3d& p) { return brute_force_distance(few, p); };
}

/// By brute force: distances to every triangle of `surface`; sides by the winding number of
/// `solid`, which is the same surface without what must not count (repeats, flips).
inline KnownField brute_force_field(const Mesh& surface, const Mesh& solid, Sides sides,
                                    const GridSpace& space, double half_width) {
    const IndexBox box = box_about(surface, space, half_width);
    const Mesh near = in_voxels(surface, space, box.lo);
    const Mesh near_solid = in_voxels(solid, space, box.lo);
    return known_field(
        {.distance_near = [&](const Vec3d& middle,
                              double reach) { return brute_force_near(near, middle, reach); },
         .winding = [&](const Vec3d& p) { return brute_force_winding_number(near_solid, p); },
         .sides = sides},
        box, half_width);
}

/// Converts with `--sign auto` at two band widths and expects exactness of both. Returns the result
/// of the narrow one.
inline ConvertResult expect_exact_conversion(const Mesh& mesh, double voxel_size_world,
                                             const Mesh& solid, Sides sides = Sides::Closed) {
    const CheckedMesh checked = check(mesh);
    const auto at_half_width = [&](double half_width) {
        return convert(checked,
                       {.voxel_size_world = voxel_size_world, .half_width_voxels = half_width});
    };
    const ConvertResult wide = at_half_width(8);
    ConvertResult narrow = at_half_width(3);
    // One truth serves both.
    EXPECT_EQ(wide.field.space().world_from_index.matrix(),
              narrow.field.space().world_from_index.matrix());
    const KnownField known = brute_force_field(mesh, solid, sides, wide.field.space(), 8);
    expect_no_faults(faults_of(wide.field, known, 8, sides == Sides::Open));
    expect_no_faults(faults_of(narrow.field, known, 3, sides == Sides::Open));
    return narrow;
}

inline ConvertResult expect_exact_conversion(const Mesh& mesh, double voxel_size_world) {
    return expect_exact_conversion(mesh, voxel_size_world, mesh);
}

} // namespace isocast::test
