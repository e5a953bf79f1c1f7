// A field, every sample of it, against the truth: distances by brute force, sides by winding
// number. SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/brute_force.h"
#include "distance_transform/convert.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <mutex>

namespace isocast::test {

/// Where the sign is checked, and against what.
enum class Sides {
    /// The winding number of a closed surface, in or out of the band, wherever |d| > 1e-9 voxel.
    Closed,
    /// The winding number in the band, where it is more than 0.1 from 1/2: that is the error that
    /// WindingNumber's hierarchy may have.
    Open,
    /// Not at all.
    None,
};

/// Truths about a surface, asked for at points in voxels from some lattice point.
struct Truth {
    std::function<double(const Vec3d& p_voxels)> distance; // unsigned
    std::function<double(const Vec3d& p_voxels)> winding;
    Sides sides = Sides::Closed;
    /// Of the distances that the oracle gives; 0 where it makes no error.
    double rounding_voxels = 1e-10;
};

/// The mesh in voxels of the field's lattice, measured from sample `origin`. In long double: the
/// true positions of samples far from the world's origin need more than 53 bits.
inline Mesh in_voxels(Mesh mesh, const GridSpace& space, const Index3& origin) {
    const long double voxel = space.voxel_size_world();
    for (Vec3d& p : mesh.vertices_world)
        for (int k = 0; k < 3; ++k)
            p[k] = static_cast<double>(
                (p[k] - static_cast<long double>(space.world_from_index.translation()[k])) / voxel -
                origin[k]);
    return mesh;
}

/// Samples of a box, x fastest.
struct BoxOfSamples {
    IndexBox box;
    std::vector<float> values;
    std::vector<char> is_active;

    BoxOfSamples(const SparseField& field, const IndexBox& all)
        : box(all), values(static_cast<std::size_t>(all.sample_count())), is_active(values.size()) {
        field.copy_box(box, 0, values);
        for (const FieldBlock& block : field.blocks())
            for (int i = 0; i < samples_per_block; ++i) {
                const Index3 at = block_size * block.coordinate + Index3(i % 8, i / 8 % 8, i / 64);
                if (!block.active[i]) continue;
                // The box holds all that is within the band of the mesh.
                if (!box.contains(at))
                    ADD_FAILURE() << "active far away: " << at.transpose();
                else
                    is_active[place(at)] = 1;
            }
    }
    std::size_t place(const Index3& at) const {
        const Index3 p = at - box.lo;
        const Index3 n = box.size();
        return p.x() + static_cast<std::size_t>(n.x()) * (p.y() + std::size_t(n.y()) * p.z());
    }
    Index3 index(std::size_t i) const {
        const auto nx = static_cast<std::size_t>(box.size().x());
        const auto ny = static_cast<std::size_t>(box.size().y());
        return box.lo + Index3(int(i % nx), int(i / nx % ny), int(i / (nx * ny)));
    }
};

/// For every sample the number of a sample on the same side of a closed surface: the farthest from
/// the surface of those that are joined to it by steps that cannot cross the surface, since the
/// distances at their ends add up to more than their length.
inline std::vector<std::size_t> spokesmen(const BoxOfSamples& samples,
                                          const std::vector<double>& distances) {
    const Index3 n = samples.box.size();
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
            const Index3 at = samples.index(i) - samples.box.lo;
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

struct Faults {
    std::int64_t active = 0;
    std::int64_t missing = 0;         // in the band, but not active
    std::int64_t beyond = 0;          // active, but not in the band
    std::int64_t wrong_distances = 0; // off by more than 1e-5 voxel and half a unit in last place
    std::int64_t wrong_signs = 0;
    double worst_error_voxels = 0;
    std::string example; // of the first fault seen
};

inline Faults faults_of(const SparseField& field, const BoxOfSamples& samples, const Truth& truth,
                        double half_width) {
    const double voxel = field.space().voxel_size_world();
    const auto background = static_cast<float>(field.background_world());
    std::vector<double> distances(samples.values.size());
    const auto position = [&](std::size_t i) {
        return Vec3d((samples.index(i) - samples.box.lo).cast<double>());
    };
    tbb::parallel_for(std::size_t{0}, distances.size(),
                      [&](std::size_t i) { distances[i] = truth.distance(position(i)); });

    Faults faults;
    std::mutex mutex;
    const auto blame = [&](std::int64_t Faults::*kind, std::size_t i, std::string_view what) {
        const std::lock_guard lock(mutex);
        if (++(faults.*kind) == 1)
            faults.example += "\n  " + std::string(what) + " at sample " +
                              std::to_string(samples.index(i).x()) + " " +
                              std::to_string(samples.index(i).y()) + " " +
                              std::to_string(samples.index(i).z()) + ": " +
                              std::to_string(samples.values[i] / voxel) + " voxels, truth " +
                              std::to_string(distances[i]);
    };
    for (std::size_t i = 0; i < distances.size(); ++i) {
        const double d = distances[i];
        const float value = std::abs(samples.values[i]);
        if (!samples.is_active[i]) {
            if (d <= half_width - truth.rounding_voxels) blame(&Faults::missing, i, "missing");
            if (!(value == background)) blame(&Faults::wrong_distances, i, "not background");
            continue;
        }
        ++faults.active;
        // 1e-6: what the active set may be too large by.
        if (d > half_width + 1e-6) blame(&Faults::beyond, i, "beyond the band");
        const float next = std::nextafter(value, std::numeric_limits<float>::infinity());
        const double half_ulp = (double{next} - double{value}) / 2;
        const double error = (std::abs(value - d * voxel) - half_ulp) / voxel;
        // 1e-5: what the project promises. Written so that it catches what is no number.
        if (!(error <= 1e-5)) blame(&Faults::wrong_distances, i, "wrong distance");
        faults.worst_error_voxels = std::max(faults.worst_error_voxels, error);
    }

    const auto check_sign = [&](std::size_t i, double winding) {
        if (std::signbit(samples.values[i]) != (winding > 0.5))
            blame(&Faults::wrong_signs, i, "wrong sign");
    };
    if (truth.sides == Sides::Open)
        tbb::parallel_for(std::size_t{0}, distances.size(), [&](std::size_t i) {
            if (!samples.is_active[i] || distances[i] <= 1e-9) return;
            const double winding = truth.winding(position(i));
            if (std::abs(winding - 0.5) > 0.1) check_sign(i, winding);
        });
    if (truth.sides == Sides::Closed) {
        const std::vector<std::size_t> spokesman = spokesmen(samples, distances);
        std::vector<double> winding(distances.size());
        // 1e-9: nearer to the surface the oracle's own rounding decides.
        tbb::parallel_for(std::size_t{0}, distances.size(), [&](std::size_t i) {
            if (spokesman[i] == i && distances[i] > 1e-9) winding[i] = truth.winding(position(i));
        });
        for (std::size_t i = 0; i < distances.size(); ++i)
            if (distances[i] > 1e-9) check_sign(i, winding[spokesman[i]]);
    }
    return faults;
}

/// The samples within the band of `surface` and three voxels more.
inline BoxOfSamples samples_about(const SparseField& field, const Mesh& surface,
                                  double half_width) {
    const WorldBox bounds = bounding_box(in_voxels(surface, field.space(), Index3::Zero()));
    const int reach = static_cast<int>(half_width) + 3;
    return {field,
            {bounds.min.array().floor().cast<int>() - reach,
             bounds.max.array().ceil().cast<int>() + reach + 1}};
}

inline void expect_no_faults(const Faults& faults) {
    EXPECT_GT(faults.active, 0);
    EXPECT_EQ(faults.missing, 0) << faults.example;
    EXPECT_EQ(faults.beyond, 0) << faults.example;
    EXPECT_EQ(faults.wrong_distances, 0)
        << faults.example << "\n  worst error " << faults.worst_error_voxels << " voxels";
    EXPECT_EQ(faults.wrong_signs, 0) << faults.example;
}

/// Distances to every triangle of `surface`; sides by the winding number of `solid`, which is the
/// same surface without what must not count (repeats, flips).
inline void expect_exact(const SparseField& field, const Mesh& surface, const Mesh& solid,
                         double half_width, Sides sides = Sides::Closed,
                         double rounding_voxels = 1e-10) {
    const BoxOfSamples samples = samples_about(field, surface, half_width);
    const Mesh near = in_voxels(surface, field.space(), samples.box.lo);
    const Mesh near_solid = in_voxels(solid, field.space(), samples.box.lo);
    const Truth truth = {
        .distance = [&](const Vec3d& p) { return brute_force_distance(near, p); },
        .winding = [&](const Vec3d& p) { return brute_force_winding_number(near_solid, p); },
        .sides = sides,
        .rounding_voxels = rounding_voxels};
    expect_no_faults(faults_of(field, samples, truth, half_width));
}

/// Converts with `--sign auto` at two band widths and expects exactness of both. Returns the result
/// of the narrow one.
inline ConvertResult expect_exact_conversion(const Mesh& mesh, double voxel_size_world,
                                             const Mesh& solid, Sides sides = Sides::Closed) {
    const CheckedMesh checked = check(mesh);
    for (const double half_width : {8.0, 3.0}) {
        SCOPED_TRACE(half_width);
        ConvertResult result = convert(
            checked, {.voxel_size_world = voxel_size_world, .half_width_voxels = half_width});
        expect_exact(result.field, mesh, solid, half_width, sides);
        if (half_width == 3) return result;
    }
    throw std::logic_error("the narrow band comes last");
}

inline ConvertResult expect_exact_conversion(const Mesh& mesh, double voxel_size_world) {
    return expect_exact_conversion(mesh, voxel_size_world, mesh);
}

} // namespace isocast::test
