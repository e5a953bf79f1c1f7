// What the search of a ray must find, by the double reference caster, and how far float32 may be
// off: the judge of single pixels.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "filtering/reconstruct.h"
#include "hard_fields.h"
#include "raycaster/brick_layout.h"
#include "raycaster/image.h"
#include "raycaster/reference.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

namespace isocast::test {

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

/// The truth about a subject, and how far float32 may be off.
class Oracle {
public:
    explicit Oracle(const Subject& subject)
        : control_(control_samples(subject.samples, subject.filter)),
          subject_(subject), options_{.kernel = subject.kernel(), .step_voxels = reference_step},
          exact_(*control_, subject.iso, options_) {
        const IndexBox extent = control_->extent();
        // Greatest |sample - iso| that a point of the surface reads, and the greatest slope there.
        for_each_sample({extent.lo, (extent.hi.array() - 1).matrix()}, [&](const Index3& cell) {
            const Index3 lo = (cell.array() - 1).matrix();
            const auto support = copied(*control_, {lo, (lo.array() + 4).matrix()});
            const auto [min, max] = std::ranges::minmax(support);
            if (min > subject.iso || max < subject.iso) return;
            magnitude_ = std::max({magnitude_, subject.iso - min, max - subject.iso});
        });
    }

    const FieldSource& control() const { return *control_; }

    /// To be called with slopes at the reference's hits before the errors are asked for.
    void see_slope(double slope) { slope_ = std::max(slope_, slope); }
    bool has_seen_slope() const { return slope_ > 0; }

    /// How far an evaluated value may lie from f at a hit's place in double:
    /// 2^-20 of the samples, sixteen roundings of a sum of 64 products (twice that for Catmull-Rom,
    /// whose weights' sizes add up to 1.25 along each axis, 1.95 in all), what the storage says,
    /// and a displacement of 3e-5 voxel: coordinates of up to 200 voxels before the middle is taken
    /// off round by 1e-5 along each axis, and the search ends within 1e-5.
    double value_error() const {
        const double weights = subject_.filter == Filter::CatmullRom ? 1.96 : 1;
        return weights * (0x1p-20 * magnitude_ + subject_.storage_error) + 3e-5 * slope_;
    }
    /// The casters of the surfaces that lie value_error() inside and outside.
    void prepare() {
        deep_.clear();
        for (const double sign : {-1.0, 1.0})
            deep_.emplace_back(*control_, subject_.iso + sign * value_error(), options_);
    }

    std::optional<double> first_root(const Ray& ray) const { return exact_.hit(ray); }
    double value(const Vec3d& p_index) const { return exact_.value(p_index); }
    double slope(const Vec3d& p_index, const Vec3d& direction_index) const {
        return kernel_jet(*control_, p_index, subject_.kernel()).gradient.dot(direction_index);
    }

    /// Where a unit ray is sure to be stopped at the latest: it enters a stretch longer than the
    /// guarantee in which the value has the other sign by more than its error.
    ///
    /// t_end  where the ray leaves the extent
    std::optional<double> first_certain(const Ray& ray, bool starts_inside, double t_end) const {
        // From outside f falls below iso - error, from inside it rises above iso + error.
        const ReferenceCaster& deep = deep_[starts_inside ? 1 : 0];
        const auto next = [&](double t) -> std::optional<double> {
            const auto hit =
                deep.hit({ray.origin_world + t * ray.direction_world, ray.direction_world});
            return hit ? std::optional(t + *hit) : std::nullopt;
        };
        // 1e-9: past a root that is known to 1e-12.
        for (auto enter = next(0); enter;) {
            const double exit = next(*enter + 1e-9).value_or(t_end);
            // 1e-4: places of float32, as above.
            if (exit - *enter > guarantee + 1e-4) return enter;
            if (exit + 1e-9 >= t_end) return std::nullopt;
            enter = next(exit + 1e-9);
        }
        return std::nullopt;
    }

private:
    std::shared_ptr<const FieldSource> control_;
    Subject subject_;
    ReferenceOptions options_;
    ReferenceCaster exact_;
    std::vector<ReferenceCaster> deep_;
    double magnitude_ = 0;
    double slope_ = 0;
};

/// Where a ray is in the extent, for t >= 0; x > y if nowhere.
inline Eigen::Vector2d clip(const Ray& ray, const IndexBox& extent) {
    double t_in = 0;
    double t_out = 1e30;
    for (int axis = 0; axis < 3; ++axis) {
        const double lo = extent.lo[axis] - ray.origin_world[axis];
        const double hi = extent.hi[axis] - 1 - ray.origin_world[axis];
        if (ray.direction_world[axis] == 0) {
            if (lo > 0 || hi < 0) return {1, 0};
            continue;
        }
        const double t0 = lo / ray.direction_world[axis];
        const double t1 = hi / ray.direction_world[axis];
        t_in = std::max(t_in, std::min(t0, t1));
        t_out = std::min(t_out, std::max(t0, t1));
    }
    return {t_in, t_out};
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

/// Unit rays, since voxels here are of unit size and world is index space.
inline Ray unit_ray(const Camera& camera, int size, int x, int y) {
    Ray ray = camera_ray(camera, size, size, x + 0.5, y + 0.5);
    ray.direction_world.normalize();
    return ray;
}

inline Verdict judge_pixel(const Oracle& oracle, const Camera& camera, const Image& image, int x,
                           int y) {
    const float* hit = image.pixel(x, y);
    const bool is_hit = hit[3] != 0;
    Verdict out;
    const Ray ray = unit_ray(camera, image.width, x, y);
    const Vec3d& d = ray.direction_world;
    const Eigen::Vector2d range = clip(ray, oracle.control().extent());
    const double t_in = range.x();
    const double t_out = range.y();
    const Vec3d p_hit = camera.eye_world + Vec3d(hit[0], hit[1], hit[2]);
    const double t_hit = (p_hit - ray.origin_world).dot(d);
    const auto report = [&](int& count, const std::string& what) {
        ++count;
        std::ostringstream text;
        text.precision(9);
        text << what << " at pixel " << x << ", " << y << ": hit " << (is_hit ? t_hit : -1) << ", "
             << "extent " << t_in << " to " << t_out << ", root "
             << oracle.first_root(ray).value_or(-1) << ", f there "
             << (is_hit ? oracle.value(p_hit) : 0) << ", error " << oracle.value_error();
        out.example = text.str();
    };
    if (is_hit) {
        ++out.hits;
        // On its ray, in the extent, and on the surface. 1e-4: as in first_certain.
        const bool is_on_ray =
            (p_hit - ray.origin_world - t_hit * d).norm() < 1e-4 && t_hit > -1e-4;
        const bool is_on_surface = std::abs(oracle.value(p_hit)) <= oracle.value_error();
        if (!is_on_ray || !is_on_surface || t_hit < t_in - 1e-4 || t_hit > t_out + 1e-4)
            report(out.false_hits, "false");
    }
    if (!(t_in <= t_out)) return out;
    const double value_before = oracle.value(ray.origin_world + t_in * d);
    // Where the ray starts on the surface it may be taken for either side.
    if (std::abs(value_before) <= oracle.value_error()) return out;
    const auto certain = oracle.first_certain(ray, value_before < 0, t_out);
    if (!certain) return out;
    ++out.certain;
    if (!is_hit) {
        report(out.missed, "missed");
        return out;
    }
    const double t_root = oracle.first_root(ray).value_or(*certain);
    const double slope = std::abs(oracle.slope(ray.origin_world + t_root * d, d));
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
