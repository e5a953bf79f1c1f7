// SPDX-License-Identifier: MPL-2.0
#include "filtering/morph.h"

#include "volume/available_memory.h"
#include "volume/blended_field.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace isocast {

namespace {

/// Samples along the edges of boxes that are resampled at a time.
constexpr int tile_size = 16;

/// The samples around p that a kernel of four reads.
IndexBox support_of(const Vec3d& lo_index, const Vec3d& hi_index) {
    return {(lo_index.array().floor().cast<int>() - 1).matrix(),
            (hi_index.array().floor().cast<int>() + 3).matrix()};
}

/// Extent of a field on another lattice, with room for a step of its own background all around.
IndexBox extent_on(const GridSpace& space, const FieldSource& field) {
    const IndexBox extent = field.extent();
    Eigen::AlignedBox3d around;
    for (int i = 0; i < 8; ++i)
        around.extend(space.to_index(
            field.space().to_world(Vec3d(i & 1 ? extent.hi.x() + 1 : extent.lo.x() - 2,
                                         i & 2 ? extent.hi.y() + 1 : extent.lo.y() - 2,
                                         i & 4 ? extent.hi.z() + 1 : extent.lo.z() - 2))));
    return {around.min().array().floor().cast<int>().matrix(),
            (around.max().array().ceil().cast<int>() + 1).matrix()};
}

} // namespace

std::shared_ptr<const DenseField> resampled(const std::shared_ptr<const FieldSource>& samples,
                                            Filter filter, const GridSpace& space,
                                            const IndexBox& extent, const Progress& progress) {
    const double bytes = 4.0 * static_cast<double>(extent.sample_count());
    if (bytes > available_memory_bytes())
        throw ResourceError(
            fmt::format("a field resampled on {} x {} x {} samples takes {:.1f} GiB",
                        extent.size().x(), extent.size().y(), extent.size().z(), bytes / 0x1p30));
    const std::shared_ptr<const FieldSource> control = control_samples(samples, filter, progress);
    const Kernel kernel = kernel_of(filter);
    const Eigen::Affine3d from_target =
        samples->space().world_from_index.inverse() * space.world_from_index;
    const std::optional<double> half_width = samples->half_width_world();
    const IndexBox stored = samples->extent();
    const auto place = [&](const Index3& index) -> Vec3d {
        const Vec3d p = from_target * index.cast<double>();
        if (half_width) return p;
        return p.cwiseMax(stored.lo.cast<double>())
            .cwiseMin((stored.hi.array() - 1).matrix().cast<double>());
    };
    const Index3 n = extent.size();
    std::vector<float> values(static_cast<std::size_t>(extent.sample_count()));
    const Index3 tiles = ((n.array() + tile_size - 1) / tile_size).matrix();
    tbb::parallel_for(0, tiles.prod(), [&](int tile) {
        const Index3 lo =
            extent.lo + tile_size * Index3(tile % tiles.x(), tile / tiles.x() % tiles.y(),
                                           tile / (tiles.x() * tiles.y()));
        const IndexBox box = intersection({lo, (lo.array() + tile_size).matrix()}, extent);
        Eigen::AlignedBox3d around;
        for (int i = 0; i < 8; ++i)
            around.extend(place(Index3(i & 1 ? box.hi.x() - 1 : box.lo.x(),
                                       i & 2 ? box.hi.y() - 1 : box.lo.y(),
                                       i & 4 ? box.hi.z() - 1 : box.lo.z())));
        const IndexBox support = support_of(around.min(), around.max());
        const ValueRange range = control->value_range(support);
        std::vector<float> c;
        if (range.min < range.max) {
            c.resize(static_cast<std::size_t>(support.sample_count()));
            control->copy_box(support, 0, c);
        }
        const Index3 m = support.size();
        const auto value_at = [&](const Vec3d& p) {
            const Index3 cell = p.array().floor().cast<int>().matrix();
            const Vec3d a = p - cell.cast<double>();
            const auto x = kernel_weights(kernel, a.x());
            const auto y = kernel_weights(kernel, a.y());
            const auto z = kernel_weights(kernel, a.z());
            const Index3 first = (cell.array() - 1).matrix() - support.lo;
            double sum = 0;
            for (std::size_t k = 0; k < 4; ++k)
                for (std::size_t j = 0; j < 4; ++j) {
                    const float* row = &c[static_cast<std::size_t>(first.x()) +
                                          static_cast<std::size_t>(m.x()) *
                                              (static_cast<std::size_t>(first.y()) + j +
                                               static_cast<std::size_t>(m.y()) *
                                                   (static_cast<std::size_t>(first.z()) + k))];
                    sum += z[k] * y[j] *
                           (x[0] * row[0] + x[1] * row[1] + x[2] * row[2] + x[3] * row[3]);
                }
            return sum;
        };
        for (int z = box.lo.z(); z < box.hi.z(); ++z)
            for (int y = box.lo.y(); y < box.hi.y(); ++y)
                for (int x = box.lo.x(); x < box.hi.x(); ++x) {
                    const Index3 at = Index3(x, y, z) - extent.lo;
                    double value = c.empty() ? range.min : value_at(place({x, y, z}));
                    if (half_width) value = std::clamp(value, -*half_width, *half_width);
                    values[static_cast<std::size_t>(
                        at.x() + std::int64_t{n.x()} * (at.y() + std::int64_t{n.y()} * at.z()))] =
                        static_cast<float>(value);
                }
    });
    return std::make_shared<DenseField>(space, extent, std::move(values), half_width);
}

std::array<std::shared_ptr<const FieldSource>, 2>
on_one_lattice(const std::shared_ptr<const FieldSource>& a,
               const std::shared_ptr<const FieldSource>& b, Filter filter,
               const Progress& progress) {
    if (share_lattice(*a, *b)) return {a, b};
    const bool is_a_finer = a->space().voxel_size_world() <= b->space().voxel_size_world();
    const FieldSource& fine = is_a_finer ? *a : *b;
    const std::shared_ptr<const FieldSource>& coarse = is_a_finer ? b : a;
    const IndexBox extent = bounding_box(fine.extent(), extent_on(fine.space(), *coarse));
    const auto moved = resampled(coarse, filter, fine.space(), extent, progress);
    if (is_a_finer) return {a, moved};
    return {moved, b};
}

Morph morph(const std::shared_ptr<const FieldSource>& a,
            const std::shared_ptr<const FieldSource>& b, double t, Filter filter,
            const Progress& progress) {
    if (!(t >= 0 && t <= 1))
        throw InputError(fmt::format("a morph's parameter lies in 0 ... 1, {} does not", t));
    if (t == 0) return {a, {}};
    if (t == 1) return {b, {}};
    const auto [from, to] = on_one_lattice(a, b, filter, progress);
    const auto blend = std::make_shared<BlendedField>(from, to, t);
    if (!blend->has_plateau()) return {blend, {}};
    return {blend, "the bands of the two fields do not meet everywhere: between them the morph is "
                   "flat, and its surface jumps; convert with a wider band"};
}

} // namespace isocast
