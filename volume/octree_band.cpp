// A narrow band of an octree's surface on one lattice.
// SPDX-License-Identifier: MPL-2.0
#include "volume/octree_band.h"

#include "volume/octree_field.h"
#include "volume/sparsify.h"

#include <algorithm>
#include <cmath>

namespace isocast {

namespace {

/// An octree's values within its reach; beyond it they are ± that.
class Band final : public FieldSource {
public:
    Band(OctreeField field, double half_width_world)
        : field_(std::move(field)), half_width_world_(half_width_world) {}

    const GridSpace& space() const override { return field_.space(); }
    IndexBox extent() const override { return field_.extent(); }
    std::optional<double> half_width_world() const override { return half_width_world_; }
    std::vector<IndexBox> active_boxes() const override { return field_.active_boxes(); }
    int finest_level(const IndexBox& box) const override { return field_.finest_level(box); }
    ValueRange value_range(const IndexBox& box) const override {
        const ValueRange range = field_.value_range(box);
        return {clamped(range.min), clamped(range.max)};
    }
    void copy_box(const IndexBox& box, int level, std::span<float> out) const override {
        field_.copy_box(box, level, out);
        std::ranges::transform(out, out.begin(), [&](float value) { return clamped(value); });
    }

private:
    float clamped(float value) const {
        const auto limit = static_cast<float>(half_width_world_);
        return std::clamp(value, -limit, limit);
    }

    OctreeField field_;
    double half_width_world_;
};

} // namespace

SparseField band_of_octree(std::shared_ptr<const HashedOctree> tree, const GridSpace& space,
                           int lattice, double half_width_voxels, const Progress& progress) {
    const double half_width = half_width_voxels * std::exp2(lattice) * space.voxel_size_world();
    return to_sparse(Band({std::move(tree), space, half_width, lattice}, half_width), progress);
}

} // namespace isocast
