// An object of a scene in memory and on the GPU.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "filtering/active_set.h"
#include "raycaster/field_on_gpu.h"
#include "raycaster/shown_surfaces.h"

namespace isocast {

/// Its control samples, its active blocks and their bricks.
class LoadedObject {
public:
    LoadedObject() = default;
    LoadedObject(const LoadedObject&) = delete; // the bricks on the GPU refer to the ranges here
    LoadedObject& operator=(const LoadedObject&) = delete;

    /// storage                 its budget is that of this object
    /// curvature_scale_voxels  Scene's
    /// throws   InputError for filters that the storage cannot serve; ResourceError if it does not
    ///          fit
    void load(FieldObject object, const StorageOptions& storage, Traversal traversal,
              double curvature_scale_voxels, const Progress& progress = {});
    /// Whether load() would make the same of these; then takes on the object's colours.
    bool takes(const FieldObject& object, const StorageOptions& storage, Traversal traversal,
               double curvature_scale_voxels);
    /// Renderer::set_iso.
    void set_iso(double iso_world);

    const FieldObject& object() const { return object_; }
    const BlockRanges& ranges() const { return ranges_; }
    const std::vector<ActivePage>& active() const { return active_; }
    const std::optional<CoarseBricks>& coarse_bricks() const { return coarse_; }
    /// Whether coarse bricks are all the detail that the field has, not what memory has room for.
    bool is_adapted() const { return is_adapted_; }
    FieldOnGpu& field() { return field_; }
    const FieldOnGpu& field() const { return field_; }
    /// Of the derivative filter; `field` where control samples are shared.
    FieldOnGpu& derivative_field() { return derivative_control_ ? derivative_field_ : field_; }
    /// At the scale of curvatures, once it is kept.
    FieldOnGpu& curvature_field() {
        return curvature_scale_voxels_ > 0 ? smoothed_.field : derivative_field();
    }
    /// Makes what curvatures at a scale are derived from, or takes it away.
    void keep_smoothed(bool is_needed);
    std::int64_t byte_count() const {
        return field_.byte_count() + derivative_field_.byte_count() + smoothed_.field.byte_count();
    }

    /// Box of the isosurface, found when it is first asked for; empty if there is none.
    const IndexBox& surface_box() const;
    /// Box of the active pages.
    Eigen::AlignedBox3d box_world() const;

private:
    /// Greatest error of the stored samples of active_ [world].
    float error_of_storage() const;
    /// Of each of the fields that may be needed.
    StorageOptions storage_share() const;
    /// The active blocks to the GPU.
    void upload(const Progress& progress);

    FieldObject object_;
    StorageOptions storage_;
    Traversal traversal_ = Traversal::TileLists;
    double curvature_scale_voxels_ = 0;
    std::shared_ptr<const FieldSource> control_;
    BlockRanges ranges_;
    std::vector<ActivePage> active_;
    std::optional<ActiveSet> moving_; // made when the iso value moves first
    std::optional<CoarseBricks> coarse_;
    bool is_adapted_ = false;
    FieldOnGpu field_;
    // Where the derivative filter has control samples of its own.
    std::shared_ptr<const FieldSource> derivative_control_;
    BlockRanges derivative_ranges_;
    FieldOnGpu derivative_field_;
    // What curvatures at a scale are derived from, while passes ask for them.
    struct Smoothed {
        std::shared_ptr<const FieldSource> control;
        BlockRanges ranges;
        FieldOnGpu field;
    } smoothed_;
    mutable std::optional<IndexBox> surface_box_;
};

} // namespace isocast
