// Built-in fields with exact value, gradient and Hessian.
// SPDX-License-Identifier: MPL-2.0
#include "volume/analytic_fields.h"

#include "volume/assert.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace isocast {

namespace {

using std::numbers::pi;

AnalyticField gyroid_field() {
    const auto jet_at = [](const Vec3d& p_world) {
        const double k = 2 * pi;
        const Eigen::Array3d s = (k * p_world.array()).sin();
        const Eigen::Array3d c = (k * p_world.array()).cos();
        Jet jet;
        jet.value = (s[0] * c[1] + s[1] * c[2] + s[2] * c[0]) / k;
        for (int i = 0; i < 3; ++i) {
            // The terms are s_i c_j, s_j c_l and s_l c_i: cyclic.
            const int j = (i + 1) % 3;
            const int l = (i + 2) % 3;
            jet.gradient[i] = c[i] * c[j] - s[l] * s[i];
            jet.hessian(i, i) = -k * (s[i] * c[j] + s[l] * c[i]);
            jet.hessian(i, j) = jet.hessian(j, i) = -k * c[i] * s[j];
        }
        return jet;
    };
    return {"gyroid", jet_at, 1};
}

AnalyticField saddle_field() {
    const auto jet_at = [](const Vec3d& p_world) {
        const double x = p_world.x();
        const double y = p_world.y();
        return Jet{p_world.z() - (x * x - y * y) / 2, Vec3d(-x, y, 1),
                   Vec3d(-1, 1, 0).asDiagonal().toDenseMatrix()};
    };
    return {"saddle", jet_at, 1};
}

AnalyticField marschner_lobb_field() {
    const auto jet_at = [](const Vec3d& p_world) {
        const double alpha = 0.25;
        const double a = 2 * pi * 6; // 2 pi f_M
        const double h = pi / 2;
        const double norm = 1 / (2 * (1 + alpha));
        const double r = std::hypot(p_world.x(), p_world.y());
        // rho_r(r) = cos(a cos(h r)); rho_r'/r and rho_r'' are finite at r = 0.
        const double c = std::cos(h * r);
        const double s = std::sin(h * r);
        const double s_by_r = r > 0 ? s / r : h;
        const double rho = std::cos(a * c);
        const double d1_by_r = a * h * s_by_r * std::sin(a * c);
        const double d2 = a * h * h * (c * std::sin(a * c) - a * s * s * std::cos(a * c));
        Jet jet;
        jet.value = norm * (1 - std::sin(h * p_world.z()) + alpha * (1 + rho)) - 0.5;
        const Eigen::Vector2d p = p_world.head<2>();
        const Eigen::Vector2d u = r > 0 ? Eigen::Vector2d(p / r) : Eigen::Vector2d::UnitX();
        jet.gradient.head<2>() = norm * alpha * d1_by_r * p;
        jet.gradient.z() = -norm * h * std::cos(h * p_world.z());
        jet.hessian.topLeftCorner<2, 2>() =
            norm * alpha *
            (d1_by_r * Eigen::Matrix2d::Identity() + (d2 - d1_by_r) * (u * u.transpose()));
        jet.hessian(2, 2) = norm * h * h * std::sin(h * p_world.z());
        return jet;
    };
    return {"marschner-lobb", jet_at, 1};
}

AnalyticField cube_field() {
    const auto jet_at = [](const Vec3d& p_world) {
        const Eigen::Array3d p = p_world.array();
        const Eigen::Array3d square = p * p;
        return Jet{(square * square - square).sum(), (4 * square * p - 2 * p).matrix(),
                   (12 * square - 2).matrix().asDiagonal().toDenseMatrix()};
    };
    return {"cube", jet_at, 1.5};
}

std::vector<AnalyticField> builtin_fields() {
    std::vector<AnalyticField> fields{sphere_field(Vec3d::Zero(), 1),
                                      torus_field(Vec3d::Zero(), Vec3d::UnitZ(), 1, 0.4),
                                      cylinder_field(Vec3d::Zero(), Vec3d::UnitZ(), 0.5),
                                      gyroid_field(),
                                      saddle_field(),
                                      marschner_lobb_field(),
                                      cube_field()};
    fields[0].half_extent_world = 1.5;
    fields[1].half_extent_world = 1.75;
    fields[2].half_extent_world = 1;
    return fields;
}

/// See sampled().
class SampledField final : public FieldSource {
public:
    SampledField(AnalyticField field, int samples_per_axis, std::optional<double> half_width_voxels)
        : field_(std::move(field)) {
        if (samples_per_axis < 4 || samples_per_axis > 4096) {
            throw InputError(fmt::format("{} samples per axis of the field {}: not in 4 … 4096",
                                         samples_per_axis, field_.name));
        }
        const double half = field_.half_extent_world;
        const double voxel_size = 2 * half / (samples_per_axis - 1);
        space_ = GridSpace::uniform(voxel_size, Vec3d::Constant(-half));
        extent_.hi.setConstant(samples_per_axis);
        if (half_width_voxels) half_width_world_ = *half_width_voxels * voxel_size;
    }

    const GridSpace& space() const override { return space_; }
    IndexBox extent() const override { return extent_; }
    std::optional<double> half_width_world() const override { return half_width_world_; }
    std::vector<IndexBox> active_boxes() const override { return {extent_}; }
    int finest_level(const IndexBox&) const override { return 0; }

    ValueRange value_range(const IndexBox& box) const override {
        const Index3 n = box.size();
        const ValueRange none{std::numeric_limits<float>::infinity(),
                              -std::numeric_limits<float>::infinity()};
        return tbb::parallel_reduce(
            Rows(0, std::int64_t{n.y()} * n.z()), none,
            [&](const Rows& rows, ValueRange range) {
                for (std::int64_t row = rows.begin(); row < rows.end(); ++row) {
                    const Index3 at = box.lo + Index3(0, static_cast<int>(row % n.y()),
                                                      static_cast<int>(row / n.y()));
                    for (int x = 0; x < n.x(); ++x) {
                        const float value = value_at(at + Index3(x, 0, 0));
                        range = {std::min(range.min, value), std::max(range.max, value)};
                    }
                }
                return range;
            },
            [](const ValueRange& a, const ValueRange& b) {
                return ValueRange{std::min(a.min, b.min), std::max(a.max, b.max)};
            });
    }

    void copy_box(const IndexBox& box, int level, std::span<float> out) const override {
        ISOCAST_ASSERT(std::ssize(out) == box.sample_count(), "%td values for %td samples",
                       std::ssize(out), static_cast<std::ptrdiff_t>(box.sample_count()));
        const Index3 n = box.size();
        // 64 rows: a filter's support is read at once, without the cost of tasks.
        tbb::parallel_for(Rows(0, std::int64_t{n.y()} * n.z(), 64), [&](const Rows& rows) {
            for (std::int64_t row = rows.begin(); row < rows.end(); ++row) {
                const Index3 at = box.lo + Index3(0, static_cast<int>(row % n.y()),
                                                  static_cast<int>(row / n.y()));
                for (int x = 0; x < n.x(); ++x) {
                    out[static_cast<std::size_t>(row * n.x() + x)] =
                        value_at((1 << level) * (at + Index3(x, 0, 0)));
                }
            }
        });
    }

private:
    using Rows = tbb::blocked_range<std::int64_t>;

    float value_at(const Index3& index) const {
        if (half_width_world_ && !extent_.contains(index)) {
            return static_cast<float>(*half_width_world_);
        }
        const Index3 inside =
            index.cwiseMax(extent_.lo).cwiseMin((extent_.hi.array() - 1).matrix());
        const double value = field_.jet(space_.to_world(inside.cast<double>())).value;
        if (!half_width_world_) return static_cast<float>(value);
        return static_cast<float>(std::clamp(value, -*half_width_world_, *half_width_world_));
    }

    AnalyticField field_;
    GridSpace space_;
    IndexBox extent_;
    std::optional<double> half_width_world_;
};

} // namespace

AnalyticField sphere_field(const Vec3d& centre_world, double radius_world) {
    const auto jet_at = [=](const Vec3d& p_world) {
        const Vec3d offset = p_world - centre_world;
        const double r = offset.norm();
        Jet jet;
        jet.value = r - radius_world;
        if (r == 0) return jet;
        jet.gradient = offset / r;
        jet.hessian = (Mat3d::Identity() - jet.gradient * jet.gradient.transpose()) / r;
        return jet;
    };
    return {"sphere", jet_at, centre_world.cwiseAbs().maxCoeff() + 1.5 * radius_world};
}

AnalyticField torus_field(const Vec3d& centre_world, const Vec3d& axis, double major_radius_world,
                          double minor_radius_world) {
    const Vec3d a = axis.normalized();
    const auto jet_at = [=](const Vec3d& p_world) {
        const Vec3d offset = p_world - centre_world;
        const double height = offset.dot(a);
        const Vec3d radial = offset - height * a;
        const double rho = radial.norm();
        const double across = rho - major_radius_world;
        const double l = std::hypot(across, height);
        Jet jet;
        jet.value = l - minor_radius_world;
        if (rho == 0 || l == 0) return jet;
        // A distance in the half plane (u, a), turned about the axis along t.
        const Vec3d u = radial / rho;
        const Vec3d t = a.cross(u);
        const Vec3d tangent = (height * u - across * a) / l;
        jet.gradient = (across * u + height * a) / l;
        jet.hessian = tangent * tangent.transpose() / l + across / (l * rho) * (t * t.transpose());
        return jet;
    };
    return {"torus", jet_at,
            centre_world.cwiseAbs().maxCoeff() + 1.25 * (major_radius_world + minor_radius_world)};
}

AnalyticField cylinder_field(const Vec3d& point_world, const Vec3d& axis, double radius_world) {
    const Vec3d a = axis.normalized();
    const auto jet_at = [=](const Vec3d& p_world) {
        const Vec3d offset = p_world - point_world;
        const Vec3d radial = offset - offset.dot(a) * a;
        const double rho = radial.norm();
        Jet jet;
        jet.value = rho - radius_world;
        if (rho == 0) return jet;
        jet.gradient = radial / rho;
        jet.hessian =
            (Mat3d::Identity() - a * a.transpose() - jet.gradient * jet.gradient.transpose()) / rho;
        return jet;
    };
    return {"cylinder", jet_at, point_world.cwiseAbs().maxCoeff() + 2 * radius_world};
}

std::vector<std::string> builtin_field_names() {
    std::vector<std::string> names;
    for (const AnalyticField& field : builtin_fields()) names.push_back(field.name);
    return names;
}

AnalyticField builtin_field(std::string_view name) {
    for (AnalyticField& field : builtin_fields()) {
        if (field.name == name) return std::move(field);
    }
    throw InputError(fmt::format("no built-in field '{}' (there are: {})", name,
                                 fmt::join(builtin_field_names(), ", ")));
}

AnalyticField at_iso(AnalyticField field, double iso_world) {
    field.jet = [jet = std::move(field.jet), iso_world](const Vec3d& p_world) {
        Jet out = jet(p_world);
        out.value -= iso_world;
        return out;
    };
    return field;
}

std::unique_ptr<FieldSource> sampled(AnalyticField field, int samples_per_axis,
                                     std::optional<double> half_width_voxels) {
    return std::make_unique<SampledField>(std::move(field), samples_per_axis, half_width_voxels);
}

} // namespace isocast
