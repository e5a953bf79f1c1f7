// What is wrong with a scene as a whole.
// SPDX-License-Identifier: MPL-2.0
#include "apps/inputs.h"
#include "apps/scene_objects.h"
#include "apps/sequence.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>

namespace isocast {

namespace {

/// Problems, each with the place of the key that it is about.
class Problems {
public:
    explicit Problems(const SceneFile& scene) : scene_(scene) {}

    /// key  in full; the place is that of the key, or of its table
    void add(const std::string& key, std::string_view what) {
        auto place = scene_.places.find(key);
        if (place == scene_.places.end()) place = scene_.places.find(key.substr(0, key.rfind('.')));
        const std::string front = place != scene_.places.end() ? fmt::format("{}: ", place->second)
                                  : scene_.path.empty()        ? ""
                                                        : fmt::format("{}: ", scene_.path.string());
        const std::string problem = fmt::format("{}{}: {}", front, key, what);
        if (std::ranges::find(list_, problem) == list_.end()) list_.push_back(problem);
    }
    bool empty() const { return list_.empty(); }
    void end() const {
        if (!list_.empty()) throw InputError(fmt::format("{}", fmt::join(list_, "\n")));
    }

private:
    const SceneFile& scene_;
    std::vector<std::string> list_;
};

std::string key_of(std::size_t object, const char* key) {
    return fmt::format("object.{}.{}", object, key);
}

/// The key that names the operands of an object.
std::string key_of_operands(const SceneFile& scene, std::size_t i) {
    return key_of(i, scene.objects[i].csg ? "of" : "morph");
}

void check_object(const SceneFile& scene, std::size_t i, Problems& problems) {
    const SceneObject& object = scene.objects[i];
    const int sources = !object.field.empty() + !object.mesh.empty() + object.csg.has_value() +
                        !object.morph.empty() + !object.series.empty() + !object.molecule.empty() +
                        !object.points.empty() + !object.tetrahedra.empty() + !object.slim.empty();
    if (sources != 1)
        problems.add(
            fmt::format("object.{}", i),
            fmt::format(
                "one of field, mesh, csg, morph, series, molecule, points, tetrahedra and slim "
                "is needed, not {}",
                sources == 0 ? "none" : std::to_string(sources)));
    if (!object.name.empty() && object_named(scene, object.name) != i)
        problems.add(key_of(i, "name"), fmt::format("there is another '{}'", object.name));
    if (object.csg && object.of.size() < 2)
        problems.add(key_of(i, "of"), "csg combines two objects at least");
    if (!object.csg && !object.of.empty())
        problems.add(key_of(i, "of"), "there is no csg that combines these");
    if (!object.morph.empty() && object.morph.size() != 2)
        problems.add(key_of(i, "morph"), "two objects are needed");
    using As = SceneObject::As;
    const bool keeps_faces = object.as == As::Triangles || object.as == As::Patches;
    if (keeps_faces && object.mesh.empty())
        problems.add(key_of(i, "as"), "only meshes have triangles and patches");
    if (object.as == As::Spline &&
        (object.csg || !object.points.empty() || object.glyphs || !object.tetrahedra.empty() ||
         !object.slim.empty() || (!object.molecule.empty() && !object.surface)))
        problems.add(key_of(i, "as"), "splines are made of fields");
    if (object.as == As::Skin && (object.molecule.empty() || object.surface || object.glyphs))
        problems.add(key_of(i, "as"), "only molecules have skins, in place of other surfaces");
    if (object.skin_shrink && object.as != As::Skin)
        problems.add(key_of(i, "shrink"), "for molecules that are drawn as their skin");
    if (object.crease_degrees && object.as != As::Triangles)
        problems.add(key_of(i, "crease"), "for meshes that are drawn as triangles");
    if (object.resolution && (object.mesh.empty() || keeps_faces))
        problems.add(key_of(i, "resolution"), "only meshes that become fields are converted");
    if (object.surface && object.molecule.empty())
        problems.add(key_of(i, "surface"), "only molecules have such surfaces");
    if (object.time && object.series.empty())
        problems.add(key_of(i, "time"), "only a series has times");
    if (object.glyphs && !has_field(object))
        problems.add(key_of(i, "glyphs"), "these stand on a field: a csg, a molecule without a "
                                          "surface and points have none");
    for (const auto& [key, is_there] : {std::pair{"iso", object.iso_world.has_value()},
                                        std::pair{"filter", object.filter.has_value()}})
        if (is_of_primitives(object) && !has_field(object) && is_there &&
            !(std::string_view(key) == "iso" &&
              (object.as == As::Spline || !object.tetrahedra.empty())))
            problems.add(key_of(i, key),
                         "for fields, which molecules, points and triangles are not");
    if (object.colour && is_of_primitives(object) && object.points.empty() &&
        object.tetrahedra.empty() && object.slim.empty() && object.as == As::Field)
        problems.add(key_of(i, "colour"), "molecules and glyphs have colours of their own");
    if (object.cut_colour && is_of_primitives(object))
        problems.add(key_of(i, "cut_colour"),
                     "for fields: molecules, points, triangles and glyphs are not cut");
    const bool is_operand = !users_of(scene, i).empty();
    if (!object.is_cut && (is_of_primitives(object) || is_operand))
        problems.add(key_of(i, "cut"), is_operand ? "what it is an operand of is cut as a whole"
                                                  : "for fields: all primitives are cut");
    if (!object.is_shown && is_operand)
        problems.add(key_of(i, "shown"), "it is where what it is an operand of is");
    const Placement unplaced;
    for (const auto& [key, is_there] :
         {std::pair{"iso", object.iso_world.has_value()},
          std::pair{"filter", object.filter.has_value()},
          std::pair{"scale", object.placement.scale != unplaced.scale},
          std::pair{"rotate", object.placement.rotation_degrees != unplaced.rotation_degrees},
          std::pair{"translate", object.placement.translation_world != unplaced.translation_world}})
        if (object.csg && is_there)
            problems.add(key_of(i, key), "a csg has none, those that it combines have");
    for (const std::string& name : operands_of(object)) {
        const auto operand = object_named(scene, name);
        if (!operand) {
            std::vector<std::string> known;
            for (const SceneObject& other : scene.objects)
                if (!other.name.empty()) known.push_back(other.name);
            problems.add(
                key_of_operands(scene, i),
                fmt::format("there is no object '{}' (known: {})", name, fmt::join(known, ", ")));
        } else if (is_of_primitives(scene.objects[*operand])) {
            problems.add(
                key_of_operands(scene, i),
                fmt::format("'{}' is a molecule, points, triangles or glyphs, not a field", name));
        } else if (!object.csg && scene.objects[*operand].csg) {
            problems.add(key_of_operands(scene, i),
                         fmt::format("'{}' is a csg; a morph blends two fields, meshes, morphs or "
                                     "series",
                                     name));
        }
    }
}

void check_series(const SceneFile& scene, std::size_t i, Problems& problems) {
    const SceneObject& object = scene.objects[i];
    if (object.series.empty()) return;
    try {
        field_series(object.series);
    } catch (const InputError& error) {
        problems.add(key_of(i, "series"), error.what());
        return;
    }
    try {
        files_of_series(object);
    } catch (const InputError& error) {
        problems.add(key_of(i, "time"), error.what());
    }
}

/// What the renderer cannot draw together.
void check_composition(const SceneFile& scene, Problems& problems) {
    const std::vector<ScenePart> parts = composition_of(scene).parts;
    if (parts.size() > max_object_count) {
        const ScenePart& part = parts[max_object_count];
        problems.add(part.plane ? fmt::format("cut.plane.{}", *part.plane)
                                : fmt::format("object.{}", part.object),
                     fmt::format("{} fields and planes that cut them are drawn together, {} at "
                                 "most can be",
                                 parts.size(), max_object_count));
    }
    if (parts.size() < 2) return;
    if (scene.quality.rate)
        problems.add("quality.rate", "several objects are searched by certified steps alone");
    if (scene.quality.traversal != Traversal::TileLists)
        problems.add("quality.traversal", "several objects are found through lists alone");
}

/// Each cycle of operands once.
void check_cycles(const SceneFile& scene, Problems& problems) {
    enum class State { New, Open, Done };
    std::vector<State> states(scene.objects.size(), State::New);
    std::vector<std::string> way;
    const std::function<void(std::size_t)> visit = [&](std::size_t i) {
        states[i] = State::Open;
        way.push_back(scene.objects[i].name);
        for (const std::string& name : operands_of(scene.objects[i])) {
            const auto next = object_named(scene, name);
            if (!next) continue;
            if (states[*next] == State::New) visit(*next);
            if (states[*next] != State::Open) continue;
            std::vector<std::string> cycle(std::ranges::find(way, name), way.end());
            cycle.push_back(name);
            problems.add(key_of_operands(scene, i),
                         fmt::format("an object is made of itself: {}", fmt::join(cycle, " -> ")));
        }
        way.pop_back();
        states[i] = State::Done;
    };
    for (std::size_t i = 0; i < states.size(); ++i)
        if (states[i] == State::New) visit(i);
}

void check_camera(const SceneFile& scene, Problems& problems) {
    const CameraSpec& camera = scene.camera;
    if (camera.eye_world && camera.direction_to_eye)
        problems.add("camera.direction", "eye and direction exclude each other");
    if (camera.target_world && !camera.eye_world) problems.add("camera.target", "target needs eye");
    if (camera.fov_y_degrees && camera.height_world)
        problems.add("camera.height",
                     "fov (perspective) and height (orthographic) exclude each other");
    if (camera.is_stereo && camera.height_world)
        problems.add("camera.stereo", "parallel rays (height) show both eyes the same");
    const std::vector<CameraKey>& keys = scene.camera_keys;
    if (keys.size() == 1) problems.add("camera.key.0", "two keys at least make a path");
    for (std::size_t i = 1; i < keys.size(); ++i)
        if (!(keys[i].time > keys[i - 1].time))
            problems.add(fmt::format("camera.key.{}.time", i), "keys must stand in order of time");
    if (!keys.empty() && scene.turntable_degrees != 0)
        problems.add("camera.turntable", "turntable and keys exclude each other");
    if (!scene.output.frames && (!keys.empty() || scene.turntable_degrees != 0))
        problems.add(keys.empty() ? "camera.turntable" : "camera.key.0",
                     "a sequence needs output.frames");
}

void check_animations(const SceneFile& scene, Problems& problems) {
    for (std::size_t i = 0; i < scene.animations.size(); ++i) {
        const Animation& animation = scene.animations[i];
        const std::string key = fmt::format("animate.{}.key", i);
        if (!scene.output.frames) problems.add(key, "a sequence needs output.frames");
        if (animation.key.starts_with("output.") || animation.key.starts_with("animate."))
            problems.add(key, fmt::format("'{}' is the same in all frames", animation.key));
        try {
            SceneFile trial = scene;
            set_number(trial, animation.key, animation.from);
            set_number(trial, animation.key, animation.to);
        } catch (const UsageError& error) {
            problems.add(key, error.what());
        }
    }
}

} // namespace

void check_scene(const SceneFile& scene) {
    Problems problems(scene);
    if (scene.objects.empty())
        problems.add("object", "there is none");
    else if (std::ranges::none_of(scene.objects, &SceneObject::is_shown))
        problems.add("object.0.shown", "none is");
    check_animations(scene, problems);
    // The rest holds for the first frame and the last, which numbers lie between.
    std::vector<SceneFile> frames{scene};
    if (const int count = scene.output.frames.value_or(FrameRange{}).count(); problems.empty())
        frames = {scene_at(scene, 0, count), scene_at(scene, count - 1, count)};
    for (const SceneFile& frame : frames)
        for (std::size_t i = 0; i < frame.objects.size(); ++i) {
            check_object(frame, i, problems);
            check_series(frame, i, problems);
        }
    check_cycles(scene, problems);
    if (problems.empty()) check_composition(scene, problems);
    check_camera(scene, problems);
    if (scene.look.lights.size() > max_light_count)
        problems.add(fmt::format("light.{}", max_light_count),
                     fmt::format("{} lights at most", max_light_count));
    int shadows = 0;
    for (std::size_t i = 0; i < scene.look.lights.size(); ++i)
        if (scene.look.lights[i].shadow != Shadow::None && ++shadows == 2)
            problems.add(fmt::format("light.{}.shadow", i), "one light at most casts shadows");
    if ((scene.cut.near_world || scene.cut.look != Cut{}.look) &&
        std::ranges::none_of(scene.objects, is_of_primitives))
        problems.add(scene.cut.near_world ? "cut.near" : "cut.look",
                     "this is of molecules, points and triangles, and there are none; fields are "
                     "cut by planes, and have caps");
    if (scene.cut.planes.size() > max_cut_planes)
        problems.add(fmt::format("cut.plane.{}", max_cut_planes),
                     fmt::format("{} planes at most", max_cut_planes));
    if (scene.output.is_transparent && scene.look.shows_environment)
        problems.add("output.transparent", "a transparent picture cannot show the environment");
    if (const OutputSpec& output = scene.output;
        std::max(output.width, output.height) > max_picture_extent)
        problems.add("output.size", fmt::format("{}x{}: each side must lie between 1 and {}",
                                                output.width, output.height, max_picture_extent));
    if (scene.look.effects.slice.strength > 0 && problems.empty() &&
        composition_of(scene).parts.empty())
        problems.add("effects.slice", "there is no field");
    const SolidTexture& texture = scene.look.effects.solid_texture;
    if (texture.strength > 0 && texture.kind == SolidTexture::Kind::Volume && !texture.volume)
        problems.add("effects.solid_texture.kind", "volume: which? (effects.solid_texture.volume)");
    problems.end();
}

std::string& source_of(SceneObject& object, const Input& input) {
    return input.is_mesh()    ? object.mesh
           : input.is_field() ? object.field
           : input.is_slim()  ? object.slim
                              : object.molecule;
}

std::optional<std::size_t> object_named(const SceneFile& scene, const std::string& name) {
    const auto found = std::ranges::find(scene.objects, name, &SceneObject::name);
    if (name.empty() || found == scene.objects.end()) return std::nullopt;
    return static_cast<std::size_t>(found - scene.objects.begin());
}

const std::vector<std::string>& operands_of(const SceneObject& object) {
    return object.csg ? object.of : object.morph;
}

std::vector<std::size_t> users_of(const SceneFile& scene, std::size_t i) {
    std::vector<std::size_t> users;
    const std::string& name = scene.objects[i].name;
    for (std::size_t k = 0; k < scene.objects.size() && !name.empty(); ++k)
        if (std::ranges::count(operands_of(scene.objects[k]), name) > 0) users.push_back(k);
    return users;
}

} // namespace isocast
