// The judge of single pixels, by what the search of a ray must find.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "filtering/reconstruct.h"
#include "hard_fields.h"
#include "raycaster/brick_layout.h"
#include "raycaster/image.h"
#include "stability/search_oracle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

namespace isocast::test {

using stability::SearchOracle;
using stability::span_in;
using stability::unit_ray;

/// What a picture is of, and by which filter.
struct Subject {
    std::string name;
    std::shared_ptr<const FieldSource> samples;
    Filter filter = Filter::BSpline;
    double iso = 0;
    StorageOptions storage;
    double storage_error = 0;

    Kernel kernel() const { return kernel_of(filter); }
};

/// A field whose control samples are those given, so that the B-spline is what it says.
inline Subject subject_of(const HardField& field, Filter filter = Filter::BSpline) {
    return {.name = field.name, .samples = field.control, .filter = filter};
}

/// The steps of the reference [voxels]: half the guarantee, so that it sees what must be seen.
inline constexpr double reference_step = 0.005;
inline constexpr double guarantee = 0.01;

inline SearchOracle oracle_of(const Subject& subject) {
    return {subject.samples, subject.filter, subject.iso, guarantee, subject.storage_error};
}

/// What became of a picture's rays.
struct Verdict {
    int hits = 0;        // of the picture
    int certain = 0;     // rays that must be stopped
    int transversal = 0; // whose first root is certain and known to 1e-3 voxel
    int missed = 0;
    int late = 0; // stopped after where they must have been
    int false_hits = 0;
    int misplaced = 0;
    double worst_voxels = 0; // of transversal ones
    std::string example;     // of what went wrong

    Verdict& operator+=(const Verdict& other) {
        hits += other.hits;
        certain += other.certain;
        transversal += other.transversal;
        missed += other.missed;
        late += other.late;
        false_hits += other.false_hits;
        misplaced += other.misplaced;
        worst_voxels = std::max(worst_voxels, other.worst_voxels);
        if (example.empty()) example = other.example;
        return *this;
    }
    bool is_right() const { return missed + late + false_hits + misplaced == 0; }
};

inline std::ostream& operator<<(std::ostream& out, const Verdict& v) {
    return out << v.hits << " hits, " << v.certain << " certain, " << v.transversal
               << " transversal, " << v.missed << " missed, " << v.late << " late, " << v.false_hits
               << " false, " << v.misplaced << " misplaced, worst " << v.worst_voxels << "; "
               << v.example;
}

inline Verdict judge_pixel(const SearchOracle& oracle, const Camera& camera, const Image& image,
                           int x, int y) {
    const float* hit = image.pixel(x, y);
    const bool is_hit = hit[3] != 0;
    Verdict out;
    const Ray ray = unit_ray(camera, image.width, image.height, x, y);
    const Vec3d& d = ray.direction_world;
    const RaySpan span = span_in(ray, oracle.control().extent());
    const double t_in = span.begin;
    const double t_out = span.end;
    const Vec3d p_hit = camera.eye_world + Vec3d(hit[0], hit[1], hit[2]);
    const double t_hit = (p_hit - ray.origin_world).dot(d);
    const auto report = [&](int& count, const std::string& what) {
        ++count;
        std::ostringstream text;
        text.precision(9);
        text << what << " at pixel " << x << ", " << y << ": hit " << (is_hit ? t_hit : -1) << ", "
             << "extent " << t_in << " to " << t_out << ", root "
             << oracle.exact().hit(ray).value_or(-1) << ", f there "
             << (is_hit ? oracle.exact().value(p_hit) : 0) << ", error " << oracle.value_error();
        out.example = text.str();
    };
    if (is_hit) {
        ++out.hits;
        // On its ray, in the extent, and on the surface. 1e-4: SearchOracle::place_error_voxels.
        const bool is_on_ray =
            (p_hit - ray.origin_world - t_hit * d).norm() < 1e-4 && t_hit > -1e-4;
        const bool is_on_surface = std::abs(oracle.exact().value(p_hit)) <= oracle.value_error();
        if (!is_on_ray || !is_on_surface || t_hit < t_in - 1e-4 || t_hit > t_out + 1e-4)
            report(out.false_hits, "false");
    }
    if (!(t_in <= t_out)) return out;
    const double value_before = oracle.exact().value(ray.origin_world + t_in * d);
    // Where the ray starts on the surface it may be taken for either side.
    if (std::abs(value_before) <= oracle.value_error()) return out;
    const auto certain = oracle.first_certain(ray, value_before < 0, t_out);
    if (!certain) return out;
    ++out.certain;
    if (!is_hit) {
        report(out.missed, "missed");
        return out;
    }
    const double t_root = oracle.exact().hit(ray).value_or(*certain);
    const double slope = std::abs(oracle.exact().gradient(ray.origin_world + t_root * d).dot(d));
    // To first order the error of the value over the slope, on each side of the root.
    const double tolerance = 1e-5 + 2 * oracle.value_error() / slope;
    if (t_hit > *certain + 1e-4 + tolerance) report(out.late, "late");
    // The first root opens that stretch, and it is transversal.
    if (tolerance > 1e-3 || *certain - t_root > 1e-3) return out;
    // A root before it can be one that the reference's steps passed; it was checked above.
    if (t_hit < t_root - 1e-3) return out;
    ++out.transversal;
    out.worst_voxels = std::abs(t_hit - t_root);
    if (out.worst_voxels > 1e-3) report(out.misplaced, "misplaced");
    return out;
}

} // namespace isocast::test
