// SPDX-License-Identifier: MPL-2.0
#include "raycaster/loaded_object.h"

#include "filtering/smoothed_field.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace isocast {

namespace {

/// The active pages' ranges of samples become those of another field of control samples.
BlockRanges with_samples_of(const FieldSource& control, BlockRanges ranges,
                            const std::vector<ActivePage>& active) {
    tbb::parallel_for(std::size_t{0}, active.size(), [&](std::size_t i) {
        BlockPage& page = ranges.pages[active[i].page];
        const Index3 lo = (page_size * page.coordinate.array() - filter_support_below).matrix();
        std::vector<float> values(in_page(0, 0, page_samples));
        control.copy_box({lo, (lo.array() + page_samples).matrix()}, 0, values);
        const auto [min, max] = std::ranges::minmax(values);
        page.samples = {min, max};
    });
    return ranges;
}

} // namespace

bool LoadedObject::takes(const FieldObject& object, const StorageOptions& storage,
                         Traversal traversal, double curvature_scale_voxels) {
    const auto with_no_colours = [](FieldObject plain) {
        plain.colour = plain.cut_colour = {};
        return plain;
    };
    const bool is_same = with_no_colours(object) == with_no_colours(object_) &&
                         storage == storage_ && traversal == traversal_ &&
                         curvature_scale_voxels == curvature_scale_voxels_;
    if (is_same) object_ = object;
    return is_same;
}

void LoadedObject::load(FieldObject object, const StorageOptions& storage, Traversal traversal,
                        double curvature_scale_voxels, const Progress& progress) {
    const Filter derivative_filter = object.derivative_filter.value_or(object.filter);
    if (storage.fetch == Fetch::Linear && kernel_of(object.filter) == Kernel::CatmullRom)
        throw InputError(fmt::format("linear fetches need weights of one sign, which the filter {} "
                                     "does not have: fetch rows or samples",
                                     filter_name(object.filter)));
    if (storage.over_budget == OverBudget::Coarsen &&
        (storage.fetch == Fetch::Linear || derivative_filter != object.filter))
        throw InputError("coarse bricks cannot be fetched linearly, nor have a derivative filter");
    // The old field goes first, so that both are never in memory.
    field_ = {};
    moving_.reset();
    derivative_field_ = {};
    derivative_control_ = {};
    keep_smoothed(false);
    object_ = std::move(object);
    storage_ = storage;
    traversal_ = traversal;
    curvature_scale_voxels_ = curvature_scale_voxels;
    control_ = control_samples(object_.field, object_.filter, progress);
    if (!share_control_samples(object_.filter, derivative_filter))
        derivative_control_ = control_samples(object_.field, derivative_filter, progress);
    coarse_.reset();
    const float iso = static_cast<float>(object_.iso_world);
    if (object_.field->is_adaptive() && derivative_filter == object_.filter) {
        coarse_ = adapt(*object_.field, control_, kernel_of(object_.filter), ranges_, active_, iso,
                        storage_, progress);
    } else {
        ranges_ = find_block_ranges(*control_, kernel_of(object_.filter), progress);
        active_ = active_pages(ranges_, iso);
    }
    is_adapted_ = coarse_.has_value();
    if (!is_adapted_) active_ = active_pages(ranges_, iso, error_of_storage());
    if (!is_adapted_ && storage_.over_budget == OverBudget::Coarsen)
        coarse_ =
            coarsen(control_, kernel_of(object_.filter), ranges_, active_, iso, storage_, progress);
    if (coarse_) control_ = coarse_->field;
    upload(progress);
}

void LoadedObject::set_iso(double iso_world) {
    if (object_.field->is_adaptive() ||
        storage_.over_budget == OverBudget::Coarsen) { // ranges depend on what is coarse
        FieldObject object = object_;
        object.iso_world = iso_world;
        load(std::move(object), storage_, traversal_, curvature_scale_voxels_);
        return;
    }
    if (!moving_)
        moving_.emplace(ranges_, static_cast<float>(object_.iso_world), error_of_storage());
    object_.iso_world = iso_world;
    const float iso = static_cast<float>(iso_world);
    moving_->move_to(iso);
    active_ = moving_->pages();
    if (const float error = error_of_storage(); error > 0) {
        moving_->move_to(iso, error);
        active_ = moving_->pages();
    }
    upload({});
}

float LoadedObject::error_of_storage() const {
    return storage_error(ranges_, active_, static_cast<float>(object_.iso_world), storage_.format);
}

void LoadedObject::upload(const Progress& progress) {
    surface_box_.reset();
    field_ = {};
    derivative_field_ = {};
    keep_smoothed(false);
    const float iso = static_cast<float>(object_.iso_world);
    const StorageOptions storage = storage_share();
    field_ = FieldOnGpu(*object_.field, *control_, kernel_of(object_.filter), ranges_, active_, iso,
                        storage, progress, traversal_, coarse_ ? &*coarse_ : nullptr);
    if (derivative_control_) {
        derivative_ranges_ = with_samples_of(*derivative_control_, ranges_, active_);
        derivative_field_ =
            FieldOnGpu(*object_.field, *derivative_control_, kernel_of(*object_.derivative_filter),
                       derivative_ranges_, active_, iso, storage, progress);
    }
}

StorageOptions LoadedObject::storage_share() const {
    StorageOptions storage = storage_;
    storage.budget_bytes /=
        1 + (derivative_control_ ? 1 : 0) + (curvature_scale_voxels_ > 0 ? 1 : 0);
    return storage;
}

void LoadedObject::keep_smoothed(bool is_needed) {
    if (!is_needed) smoothed_ = {};
    if (!is_needed || smoothed_.control) return;
    const Filter filter = object_.derivative_filter.value_or(object_.filter);
    smoothed_.control = control_samples(
        std::make_shared<SmoothedField>(object_.field, curvature_scale_voxels_), filter);
    smoothed_.ranges = with_samples_of(*smoothed_.control, ranges_, active_);
    smoothed_.field =
        FieldOnGpu(*object_.field, *smoothed_.control, kernel_of(filter), smoothed_.ranges, active_,
                   static_cast<float>(object_.iso_world), storage_share());
}

const IndexBox& LoadedObject::surface_box() const {
    if (!surface_box_)
        surface_box_ =
            find_surface_box(*control_, ranges_, active_, static_cast<float>(object_.iso_world));
    return *surface_box_;
}

Eigen::AlignedBox3d LoadedObject::box_world() const {
    IndexBox box;
    for (const ActivePage& page : active_) {
        const Index3 lo = page_size * ranges_.pages[page.page].coordinate;
        box = bounding_box(box, {lo, (lo.array() + page_size + 1).matrix()});
    }
    return world_box(box, object_.field->space());
}

} // namespace isocast
