// SPDX-License-Identifier: MPL-2.0
#include "raycaster/reference.h"

#include "raycaster/ray_span.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace isocast {

namespace {

/// The cubic of Catmull-Rom's kernel in Bernstein form: four coefficients for each run of four
/// samples `stride` apart.
void to_bernstein(std::array<double, 64>& c, std::size_t stride) {
    for (std::size_t i = 0; i < 64; ++i) {
        if (i / stride % 4 != 0) continue;
        const double before = c[i];
        const double first = c[i + stride];
        const double last = c[i + 2 * stride];
        const double after = c[i + 3 * stride];
        // Ends, and points a third of the way along the end slopes, half the neighbours'
        // difference.
        c[i] = first;
        c[i + stride] = first + (last - before) / 6;
        c[i + 2 * stride] = last - (after - first) / 6;
        c[i + 3 * stride] = last;
    }
}

} // namespace

ReferenceCaster::ReferenceCaster(const FieldSource& control, double iso,
                                 const ReferenceOptions& options)
    : options_(options), iso_(iso), space_(control.space()), extent_(control.extent()),
      stored_(dilated(extent_, 1, 2)), cells_((extent_.size().array() - 1).max(1).matrix()) {
    if (extent_.sample_count() > std::int64_t{1} << 30) {
        throw ResourceError(fmt::format("{} samples are too many for the reference caster",
                                        extent_.sample_count()));
    }
    const Index3 n = stored_.size();
    const std::size_t plane = static_cast<std::size_t>(n.x()) * static_cast<std::size_t>(n.y());
    samples_.resize(plane * static_cast<std::size_t>(n.z()));
    tbb::parallel_for(0, n.z(), [&](int z) {
        IndexBox slice = stored_;
        slice.lo.z() += z;
        slice.hi.z() = slice.lo.z() + 1;
        control.copy_box(slice, 0,
                         std::span(samples_).subspan(static_cast<std::size_t>(z) * plane, plane));
    });
    signs_.resize(static_cast<std::size_t>(std::int64_t{cells_.x()} * cells_.y() * cells_.z()));
    tbb::parallel_for(0, cells_.z(), [&](int z) {
        for (int y = 0; y < cells_.y(); ++y) {
            for (int x = 0; x < cells_.x(); ++x) {
                signs_[cell_number({x, y, z})] = sign_over({x, y, z});
            }
        }
    });
}

Index3 ReferenceCaster::cell_of(const Vec3d& p_index) const {
    const Index3 cell = p_index.array().floor().cast<int>().matrix() - extent_.lo;
    return cell.cwiseMax(0).cwiseMin((cells_.array() - 1).matrix());
}

std::size_t ReferenceCaster::cell_number(const Index3& cell) const {
    return static_cast<std::size_t>((std::int64_t{cell.z()} * cells_.y() + cell.y()) * cells_.x() +
                                    cell.x());
}

ReferenceCaster::Support ReferenceCaster::support_of(const Index3& cell) const {
    Support support;
    const Index3 n = stored_.size();
    for (int k = 0; k < 4; ++k) {
        for (int j = 0; j < 4; ++j) {
            const std::int64_t row =
                (std::int64_t{cell.z() + k} * n.y() + cell.y() + j) * n.x() + cell.x();
            std::copy_n(&samples_[static_cast<std::size_t>(row)], 4,
                        &support[static_cast<std::size_t>(4 * (j + 4 * k))]);
        }
    }
    return support;
}

ReferenceCaster::Sign ReferenceCaster::sign_over(const Index3& cell) const {
    Support c = support_of(cell);
    const auto sign = [&] {
        const auto inside = std::ranges::count_if(c, [&](double value) { return value < iso_; });
        return inside == 0 ? Sign::Outside : inside == 64 ? Sign::Inside : Sign::Unknown;
    };
    // Linear and B-spline weights are not negative: samples of one sign make values of one sign.
    // Some of Catmull-Rom's are; the same then holds for the coefficients in Bernstein form.
    if (options_.kernel == Kernel::CatmullRom) {
        for (const std::size_t stride : {1, 4, 16}) to_bernstein(c, stride);
    }
    return sign();
}

double ReferenceCaster::value(const Vec3d& p_index) const {
    return sum_at(p_index, std::nullopt) - iso_;
}

Vec3d ReferenceCaster::gradient(const Vec3d& p_index) const {
    return {sum_at(p_index, 0), sum_at(p_index, 1), sum_at(p_index, 2)};
}

double ReferenceCaster::sum_at(const Vec3d& p_index, std::optional<int> derived) const {
    const Index3 cell = cell_of(p_index);
    const Vec3d a = p_index - (extent_.lo + cell).cast<double>();
    const auto weights = [&](int axis) {
        return axis == derived ? kernel_weights_d1(options_.kernel, a[axis])
                               : kernel_weights(options_.kernel, a[axis]);
    };
    const auto x = weights(0);
    const auto y = weights(1);
    const auto z = weights(2);
    const Support c = support_of(cell);
    double sum = 0;
    for (std::size_t k = 0; k < 4; ++k) {
        for (std::size_t j = 0; j < 4; ++j) {
            const double* row = &c[4 * (j + 4 * k)];
            sum += z[k] * y[j] * (x[0] * row[0] + x[1] * row[1] + x[2] * row[2] + x[3] * row[3]);
        }
    }
    return sum;
}

std::optional<double> ReferenceCaster::hit(const Ray& ray) const {
    const Vec3d origin = space_.to_index(ray.origin_world);
    const Vec3d direction = space_.world_from_index.linear().inverse() * ray.direction_world;

    const RaySpan span = span_in_box(origin, direction, extent_.lo.cast<double>(),
                                     (extent_.hi.array() - 1).matrix().cast<double>());
    if (span.is_empty()) return std::nullopt;
    const double t_begin = span.begin;
    const double t_end = span.end;

    const auto at = [&](double t) -> Vec3d { return origin + t * direction; };
    const auto is_inside = [&](double t) { return value(at(t)) < 0; };
    // Samples at t_begin + k * step, and at t_end.
    const double step = options_.step_voxels / direction.norm();
    const auto t_of = [&](double k) { return std::min(t_begin + k * step, t_end); };
    std::optional<bool> inside_before;
    double t_before = t_begin;
    for (double k = 0;; ++k) {
        double t = t_of(k);
        const Vec3d p = at(t);
        const Index3 cell = cell_of(p);
        const Sign sign = signs_[cell_number(cell)];
        const bool inside = sign == Sign::Unknown ? value(p) < 0 : sign == Sign::Inside;
        if (inside_before && inside != *inside_before) {
            double outer = t;
            while (outer - t_before > 1e-12 / direction.norm()) {
                const double middle = 0.5 * (t_before + outer);
                if (middle == t_before || middle == outer) break;
                (is_inside(middle) == *inside_before ? t_before : outer) = middle;
            }
            return 0.5 * (t_before + outer);
        }
        if (sign != Sign::Unknown) {
            // All samples in this cell have that sign: on to the last of them.
            double t_exit = t_end;
            for (int axis = 0; axis < 3; ++axis) {
                if (direction[axis] == 0) continue;
                const int face = extent_.lo[axis] + cell[axis] + (direction[axis] > 0 ? 1 : 0);
                t_exit = std::min(t_exit, (face - origin[axis]) / direction[axis]);
            }
            k = std::max(k, std::floor((t_exit - t_begin) / step));
            t = t_of(k);
        }
        if (t >= t_end) return std::nullopt;
        inside_before = inside;
        t_before = t;
    }
}

std::optional<double> reference_hit(const FieldSource& field, double iso, const Ray& ray,
                                    double step_voxels) {
    return ReferenceCaster(field, iso, {.step_voxels = step_voxels}).hit(ray);
}

} // namespace isocast
