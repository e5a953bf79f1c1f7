// One input of `isocast accuracy`: draws it at any setting, measures errors and times.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/accuracy/measurement.h"
#include "apps/accuracy/truth.h"
#include "apps/render_options.h"
#include "apps/scene_objects.h"
#include "distance_transform/mesh_distance.h"
#include "raycaster/reference.h"
#include "raycaster/renderer.h"

#include <memory>

namespace isocast {

struct StudyOptions {
    std::string input;
    std::vector<std::string> settings; // --set: of all pictures
    int width = 256;
    int height = 256;
    std::filesystem::path folder; // of the results; octrees pass through it
    std::vector<std::filesystem::path> shader_folders;
};

/// Seconds of one round at a setting, by Measurement's names.
using RoundSeconds = std::map<std::string, double>;

class Study {
public:
    /// Reads the input, draws it as usual, and finds the truth.
    /// renderer  of the current context; both must outlive this
    Study(StudyOptions options, gl::Context& context, Renderer& renderer, Progress progress);
    ~Study();

    Subject subject() const { return subject_; }
    const Input& input() const { return input_; }
    /// What all bricks take on the GPU [MiB], as usual.
    double brick_mib() const { return brick_mib_; }
    std::string truth_source() const { return truth_ ? truth_->source : "none: the samples"; }
    /// Of what is drawn [world].
    double diagonal_world() const { return diagonal_world_; }
    double voxel_size_world() const { return base_voxel_world_; }

    /// Draws at a setting and compares; fields are kept until new_round().
    /// throws  InputError or ResourceError where the input cannot be drawn so
    std::map<std::string, Error> errors_at(const Setting& setting);
    /// The picture that errors_at() drew last.
    const Image& picture() const { return picture_; }
    RoundSeconds seconds_at(const Setting& setting);
    /// Fields are made anew, and timed.
    void new_round();

private:
    struct Made;
    SceneFile scene_at(const Setting& setting) const;
    Made& made_at(const Setting& setting, const SceneFile& scene);
    Made made_by_converting(const Setting& of_field, const SceneFile& scene);
    /// Loads it. returns  the scene as loaded
    Scene load(const Setting& setting, const SceneFile& scene, RoundSeconds& seconds);
    Image draw_beauty(const SceneFile& scene);

    Error sample_error(const FieldSource& field) const;
    void add_hit_errors(const Scene& scene, bool is_usual_field,
                        std::map<std::string, Error>& errors);
    void add_curvature_error(const Scene& scene, std::map<std::string, Error>& errors);
    const ReferenceCaster& caster_of(const FieldObject& object, bool is_usual_field);

    StudyOptions options_;
    gl::Context& context_;
    Renderer& renderer_;
    Progress progress_;
    Input input_;
    Subject subject_;
    SceneFile base_;
    std::optional<CheckedMesh> mesh_;
    std::optional<MeshDistance> distance_;
    Fetch fetch_ = Fetch::Rows;
    View view_;
    std::optional<Truth> truth_;
    double brick_mib_ = 0;
    double diagonal_world_ = 0;
    double base_voxel_world_ = 0;
    Image picture_;
    std::map<std::string, std::unique_ptr<Made>> made_; // by the setting's part that makes it
    /// Of the last field and filter that were compared.
    std::shared_ptr<const FieldSource> cast_field_;
    Filter cast_filter_ = Filter::Linear;
    std::unique_ptr<ReferenceCaster> caster_;
    std::map<Filter, FirstHits> reference_hits_; // of the usual field
    std::map<std::string, Image> best_pictures_;
};

} // namespace isocast
