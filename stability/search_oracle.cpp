// SPDX-License-Identifier: MPL-2.0
#include "stability/search_oracle.h"

#include "raycaster/field_on_gpu.h"
#include "stability/fields.h"

#include <algorithm>
#include <array>

namespace isocast::stability {

Ray unit_ray(const Camera& camera, int width, int height, int x, int y) {
    Ray ray = camera_ray(camera, width, height, x + 0.5, y + 0.5);
    ray.direction_world.normalize();
    return ray;
}

RaySpan span_in(const Ray& ray, const IndexBox& extent) {
    return span_in_box(ray.origin_world, ray.direction_world, extent.lo.cast<double>(),
                       (extent.hi.array() - 1).matrix().cast<double>());
}

SearchOracle::SearchOracle(const std::shared_ptr<const FieldSource>& samples, Filter filter,
                           double iso, double guarantee_voxels, double storage_error)
    : control_(control_samples(samples, filter)), filter_(filter), iso_(iso),
      guarantee_voxels_(guarantee_voxels),
      storage_error_(storage_error), options_{.kernel = kernel_of(filter),
                                              .step_voxels = guarantee_voxels / 2},
      exact_(*control_, iso, options_) {
    const IndexBox extent = control_->extent();
    for_each_sample({extent.lo, (extent.hi.array() - 1).matrix()}, [&](const Index3& cell) {
        std::array<float, 64> support;
        control_->copy_box({(cell.array() - 1).matrix(), (cell.array() + 3).matrix()}, 0, support);
        const auto [min, max] = std::ranges::minmax(support);
        if (min > iso || max < iso) return;
        magnitude_ = std::max({magnitude_, iso - min, max - iso});
    });
}

void SearchOracle::prepare(const std::vector<Camera>& cameras, int width, int height) {
    double slope = 0;
    for (const Camera& camera : cameras)
        for (int y = 0; y < height; y += 3)
            for (int x = 0; x < width; x += 3) {
                const Ray ray = unit_ray(camera, width, height, x, y);
                if (const auto t = exact_.hit(ray))
                    slope = std::max(
                        slope, exact_.gradient(ray.origin_world + *t * ray.direction_world).norm());
            }
    prepare(slope);
}

void SearchOracle::prepare(double greatest_slope) {
    slope_ = greatest_slope;
    deep_.clear();
    for (const double sign : {-1.0, 1.0})
        deep_.emplace_back(*control_, iso_ + sign * value_error(), options_);
}

double SearchOracle::value_error() const {
    const double weights = filter_ == Filter::CatmullRom ? 1.96 : 1;
    return weights * (0x1p-20 * magnitude_ + storage_error_) + 3e-5 * slope_;
}

std::optional<double> SearchOracle::first_certain(const Ray& ray, bool starts_inside,
                                                  double t_end) const {
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
        if (exit - *enter > guarantee_voxels_ + place_error_voxels) return enter;
        if (exit + 1e-9 >= t_end) return std::nullopt;
        enter = next(exit + 1e-9);
    }
    return std::nullopt;
}

} // namespace isocast::stability
