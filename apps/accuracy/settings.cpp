// SPDX-License-Identifier: MPL-2.0
#include "apps/accuracy/settings.h"

#include "volume/errors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace isocast {

namespace {

const std::vector<Subject> any_field{Subject::Mesh, Subject::BuiltinField, Subject::FieldFile};
const std::vector<Subject> mesh{Subject::Mesh};
const std::vector<Subject> molecule{Subject::Molecule};
const std::vector<Subject> all{Subject::Mesh, Subject::BuiltinField, Subject::FieldFile,
                               Subject::Molecule};

std::vector<Knob> all_knobs() {
    return {
        {"resolution", {Subject::Mesh, Subject::BuiltinField}, "", true},
        {"band", mesh, "object.0.band", true},
        {"method", mesh, "", true},
        {"device", mesh, "", true},
        {"octree_error", mesh, "", true},
        {"voxel", molecule, "object.0.voxel", true, {"object.0.surface=van-der-waals"}},
        {"filter", any_field, "quality.filter"},
        {"derivative_filter", any_field, "quality.derivative_filter"},
        {"storage", any_field, "quality.storage"},
        {"texture_memory",
         any_field,
         "quality.texture_memory",
         false,
         {"quality.over_budget=coarsen"}},
        {"fetch", any_field, "quality.fetch"},
        {"traversal", any_field, "quality.traversal"},
        {"guarantee", any_field, "quality.guarantee"},
        {"rate", any_field, "quality.rate"},
        {"rate_factor", any_field, "quality.rate_factor"},
        {"refine_steps", any_field, "quality.refine_steps"},
        {"splats", molecule, "quality.splats"},
        {"detail_pixels", molecule, "quality.detail_pixels"},
        {"samples", all, "output.samples", false, {}, "64"},
        {"shadow_map_pixels",
         all,
         "light.0.shadow_map_pixels",
         false,
         {"light.0.shadow=hard", "light.0.direction=[-1, 0.7, 0.4]"},
         "4096"},
        {"occlusion_rays",
         all,
         "effects.occlusion.rays",
         false,
         {"effects.occlusion.strength=1"},
         "64"},
    };
}

bool is_of(const Knob& knob, Subject subject) {
    return std::ranges::find(knob.subjects, subject) != knob.subjects.end();
}

/// As a user would write it.
std::string number_text(double number) {
    return fmt::format("{:.3g}", number);
}

} // namespace

std::string text_of(const Setting& setting) {
    if (setting.empty()) return "as usual";
    std::vector<std::string> parts;
    for (const auto& [knob, value] : setting) parts.push_back(knob + "=" + value);
    return fmt::format("{}", fmt::join(parts, " "));
}

Subject subject_of(const Input& input) {
    if (input.is_slim())
        throw InputError(
            fmt::format("{}: a SLIM surface, whose error is that of its file", input.text));
    return input.is_mesh()                           ? Subject::Mesh
           : input.kind == Input::Kind::BuiltinField ? Subject::BuiltinField
           : input.kind == Input::Kind::FieldFile    ? Subject::FieldFile
                                                     : Subject::Molecule;
}

const Knob& knob_named(std::string_view name, Subject subject) {
    static const std::vector<Knob> knobs = all_knobs();
    const auto found = std::ranges::find(knobs, name, &Knob::name);
    if (found != knobs.end() && is_of(*found, subject)) return *found;
    std::vector<std::string_view> known;
    for (const Knob& knob : knobs)
        if (is_of(knob, subject)) known.push_back(knob.name);
    throw UsageError(
        fmt::format("'{}' is no knob of this input (there are: {})", name, fmt::join(known, ", ")));
}

void set_resolution(SceneObject& object, int resolution) {
    if (!object.mesh.empty())
        object.resolution = resolution;
    else
        object.field =
            fmt::format("{}@{}", object.field.substr(0, object.field.find('@')), resolution);
}

void apply(const Setting& setting, Subject subject, SceneFile& scene) {
    for (const auto& [name, value] : setting) {
        const Knob& knob = knob_named(name, subject);
        if (name == "resolution") {
            set_resolution(scene.objects.front(), integer_from(value));
        } else if (!knob.key.empty()) {
            for (const std::string_view key : knob.also) set_key(scene, key);
            set_key(scene, fmt::format("{}={}", knob.key, value));
        }
    }
}

Setting field_part(const Setting& setting, Subject subject) {
    Setting part;
    for (const auto& [name, value] : setting)
        if (knob_named(name, subject).makes_field) part[name] = value;
    return part;
}

std::optional<Setting> best_picture_of(const Setting& setting, Subject subject) {
    std::optional<Setting> best;
    for (const auto& [name, value] : setting) {
        const Knob& knob = knob_named(name, subject);
        if (knob.best.empty()) continue;
        if (!best) best = setting;
        (*best)[name] = knob.best;
    }
    return best;
}

std::vector<Setting> settings_of(const Sweep& sweep) {
    std::vector<Setting> settings{{}};
    for (const auto& [knob, values] : sweep) {
        std::vector<Setting> crossed;
        for (const Setting& setting : settings)
            for (const std::string& value : values) {
                crossed.push_back(setting);
                crossed.back()[knob] = value;
            }
        settings = std::move(crossed);
    }
    return settings;
}

std::pair<std::string, std::vector<std::string>> values_from(const std::string& text,
                                                             Subject subject) {
    const auto equals = text.find('=');
    if (equals == std::string::npos || equals + 1 == text.size())
        throw UsageError(fmt::format("--vary {}: KNOB=VALUE,VALUE,... or KNOB=LO:HI", text));
    const std::string name(knob_named(text.substr(0, equals), subject).name);
    const std::string list = text.substr(equals + 1);
    std::vector<std::string> values;
    if (const auto colon = list.find(':'); colon != std::string::npos) {
        const double lo = number_from(list.substr(0, colon));
        const double hi = number_from(list.substr(colon + 1));
        if (!(lo >= 0 && lo <= hi))
            throw UsageError(fmt::format("--vary {}: a range goes up, from 0 or above", text));
        // 1000: more would not end within a day.
        for (double value = lo; value <= hi && values.size() < 1000;
             value = lo == 0 ? value + 1 : 2 * value)
            values.push_back(number_text(value));
    } else {
        for (std::size_t begin = 0; begin <= list.size();) {
            const auto end = std::min(list.find(',', begin), list.size());
            values.push_back(list.substr(begin, end - begin));
            begin = end + 1;
        }
    }
    return {name, values};
}

std::vector<Sweep> usual_sweeps(Subject subject, int samples_per_axis, double brick_mib) {
    const std::pair<std::string, std::vector<std::string>> samples{"samples",
                                                                   {"1", "2", "4", "8", "16"}};
    const std::pair<std::string, std::vector<std::string>> shadow{
        "shadow_map_pixels", {"64", "128", "256", "512", "1024"}};
    if (subject == Subject::Molecule)
        return {{{"voxel", {"1", "0.5", "0.25"}}},
                {{"detail_pixels", {"0.5", "1", "2", "4"}}},
                {{"splats", {"deferred", "direct"}}},
                {samples},
                {shadow},
                {{"occlusion_rays", {"2", "4", "8", "16"}}}};
    std::vector<Sweep> sweeps{
        {{"filter", {"linear", "bspline", "catmull-rom"}}},
        {{"filter", {"linear", "interpolating"}}, {"derivative_filter", {"bspline"}}},
        {{"filter", {"linear"}}, {"derivative_filter", {"interpolating"}}},
        {{"storage", {"float16", "norm16"}}},
        {{"texture_memory",
          {number_text(brick_mib / 2), number_text(brick_mib / 4), number_text(brick_mib / 8)}}},
        {{"guarantee", {"1", "0.1", "0.001"}}},
        {{"rate", {"0.25", "0.5", "1", "2", "4", "8"}}},
        {{"rate", {"1"}}, {"refine_steps", {"0", "1", "2", "3", "4", "6", "8"}}},
        {samples},
        {shadow},
    };
    if (subject == Subject::Mesh) {
        sweeps.push_back({{"resolution", {"32", "64", "256"}}, {"filter", {"interpolating"}}});
        sweeps.push_back({{"resolution", {"64", "256"}}, {"filter", {"linear", "bspline"}}});
        sweeps.push_back({{"octree_error", {"0.01", "0.003"}}});
        sweeps.push_back(
            {{"resolution", {"64"}}, {"method", {"prism", "printed", "csc", "kdtree"}}});
        sweeps.push_back({{"resolution", {"64"}}, {"device", {"gl"}}});
        sweeps.push_back({{"band", {"2", "5"}}});
    } else if (subject == Subject::BuiltinField) {
        sweeps.push_back({{"filter", {"exact"}}});
        std::vector<std::string> sizes;
        for (const int n : {samples_per_axis / 4, samples_per_axis / 2, 2 * samples_per_axis})
            if (n >= 4) sizes.push_back(std::to_string(n));
        sweeps.push_back(
            {{"resolution", sizes}, {"filter", {"linear", "bspline", "interpolating"}}});
    }
    return sweeps;
}

std::span<const Stage> stages() {
    static const std::vector<Stage> known{
        {"mesh to field",
         "samples",
         "world",
         "stored distances against the exact ones to the mesh",
         Price::Field,
         {"resolution", "band", "method", "device"}},
        {"surface",
         "surface",
         "world",
         "how far the points that are drawn lie from the true surface",
         Price::All,
         {"resolution", "octree_error", "voxel", "filter"}},
        {"normals",
         "normal",
         "degrees",
         "normals against those of the true surface",
         Price::All,
         {"resolution", "octree_error", "voxel", "filter", "derivative_filter"}},
        {"curvature",
         "curvature",
         "1/voxel",
         "principal curvatures against the true ones",
         Price::All,
         {"resolution", "filter", "derivative_filter"}},
        {"storage",
         "position",
         "voxels",
         "hits against the surface of the same function, unrounded",
         Price::LoadAndFrame,
         {"storage", "texture_memory", "fetch"}},
        {"search",
         "search",
         "share of hits",
         "pixels that miss the surface, or hit what is not there or lies behind",
         Price::Frame,
         {"guarantee", "rate", "rate_factor", "traversal", "splats", "detail_pixels"}},
        {"refinement",
         "position",
         "voxels",
         "hits against the surface of the same function, unrounded",
         Price::Frame,
         {"rate", "refine_steps"}},
        {"antialiasing",
         "picture",
         "share of white",
         "colours against those of 64 samples a pixel",
         Price::Frame,
         {"samples"}},
        {"shadows",
         "picture",
         "share of white",
         "colours against those of a shadow map of 4096 texels",
         Price::Frame,
         {"shadow_map_pixels"}},
        {"occlusion",
         "picture",
         "share of white",
         "colours against those of 64 rays a pixel",
         Price::Frame,
         {"occlusion_rays"}},
    };
    return known;
}

} // namespace isocast
