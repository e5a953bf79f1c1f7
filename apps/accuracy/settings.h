// What `isocast accuracy` varies, and by what each of these is judged.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/inputs.h"
#include "apps/scene_file.h"

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace isocast {

/// Values by knob, as users write them. A knob that is not in it is as usual.
using Setting = std::map<std::string, std::string>;

/// "filter=linear storage=float16"; "as usual" if empty.
std::string text_of(const Setting& setting);

/// What is measured.
enum class Subject { Mesh, BuiltinField, FieldFile, Molecule };
Subject subject_of(const Input& input);

/// Something that users can set and that accuracy or time depends on.
struct Knob {
    std::string_view name;
    std::vector<Subject> subjects;
    /// The key of a scene; empty for options of `isocast convert`.
    std::string_view key;
    /// Another value makes another field.
    bool makes_field = false;
    /// Set with it.
    std::vector<std::string_view> also = {};
    /// Of an error in the picture alone: the value whose picture is the truth.
    std::string_view best = {};
};

/// throws  UsageError that lists those of the subject
const Knob& knob_named(std::string_view name, Subject subject);

/// Of a mesh's field, or of a built-in field's samples.
void set_resolution(SceneObject& object, int resolution);

/// Sets a setting's keys; what is left are options of a conversion.
void apply(const Setting& setting, Subject subject, SceneFile& scene);
/// That part of a setting that makes the field.
Setting field_part(const Setting& setting, Subject subject);
/// The setting whose picture is the truth of this one's; nothing if it has no such knob.
std::optional<Setting> best_picture_of(const Setting& setting, Subject subject);

/// Some knobs with their values: every combination.
using Sweep = std::vector<std::pair<std::string, std::vector<std::string>>>;
std::vector<Setting> settings_of(const Sweep& sweep);

/// "filter=linear,bspline"; "rate=0.25:8": doubled from the one to the other, from 0 one by one.
/// throws  UsageError
std::pair<std::string, std::vector<std::string>> values_from(const std::string& text,
                                                             Subject subject);

/// Those of a run that says nothing else.
///
/// samples_per_axis  of a built-in field
/// brick_mib         what all bricks of the field take on the GPU
std::vector<Sweep> usual_sweeps(Subject subject, int samples_per_axis, double brick_mib);

/// Which of a setting's seconds count.
enum class Price { Field, LoadAndFrame, Frame, All };

/// A source of error by itself: what is compared, and the knobs that it depends on.
struct Stage {
    std::string_view name;
    std::string_view error; // of Measurement::errors
    std::string_view unit;
    std::string_view what; // for people
    Price price;
    std::vector<std::string_view> knobs;
};
std::span<const Stage> stages();

} // namespace isocast
