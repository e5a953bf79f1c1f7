// SPDX-License-Identifier: MPL-2.0
#include "apps/scene_objects.h"

#include "apps/molecule_skin.h"
#include "distance_transform/convert.h"
#include "distance_transform/corner_normals.h"
#include "distance_transform/mesh_files.h"
#include "filtering/morph.h"
#include "quadrics/quadratic_spline.h"
#include "quadrics/slim_blend.h"
#include "quadrics/slim_file.h"
#include "raycaster/shown_surfaces.h"
#include "volume/errors.h"
#include "volume/files.h"
#include "volume/histogram.h"
#include "volume/octree_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace isocast {

namespace {

CsgOperation operation_of(SceneObject::Csg csg) {
    switch (csg) {
    case SceneObject::Csg::Union:
        return CsgOperation::Union;
    case SceneObject::Csg::Intersection:
        return CsgOperation::Intersection;
    case SceneObject::Csg::Difference:
        break;
    }
    return CsgOperation::Difference;
}

/// Which of the objects no other one is made of.
std::vector<std::size_t> drawn_objects(const SceneFile& scene) {
    std::vector<std::size_t> drawn;
    for (std::size_t i = 0; i < scene.objects.size(); ++i)
        if (const SceneObject& object = scene.objects[i];
            object.is_shown && users_of(scene, i).empty() && !is_of_primitives(object))
            drawn.push_back(i);
    return drawn;
}

void add_part(const ScenePart& part, Composition& out) {
    const auto found = std::ranges::find(out.parts, part);
    out.tree.push_back({CsgOperation::Object, static_cast<int>(found - out.parts.begin())});
    if (found == out.parts.end()) out.parts.push_back(part);
}

/// Appends an object: its part of the tree, and what it is made of.
///
/// around  has the colours of the csg that it is in
void add(const SceneFile& scene, std::size_t i, ScenePart around, Composition& out) {
    const SceneObject& object = scene.objects[i];
    if (object.colour) around.colour = object.colour;
    if (object.cut_colour) around.cut_colour = object.cut_colour;
    if (object.csg) {
        for (std::size_t k = 0; k < object.of.size(); ++k) {
            add(scene, object_named(scene, object.of[k]).value(), around, out);
            if (k > 0) out.tree.push_back({operation_of(*object.csg)});
        }
        return;
    }
    constexpr std::size_t most_steps = 4096; // a csg that is named twice has its steps twice
    if (out.tree.size() >= most_steps)
        throw InputError(fmt::format("the csg of the scene has more than {} steps", most_steps));
    around.object = i;
    add_part(around, out);
}

/// Quads as they are, triangles with a corner twice, and the fans of other faces.
PatchMesh read_patches(const Input& input) {
    if (input.kind != Input::Kind::MeshFile)
        throw InputError(fmt::format("{}: patches are read from .obj and .ply", input.text));
    PolygonMesh read = read_polygons(input.name);
    PatchMesh out{.vertices_world = std::move(read.mesh.vertices_world), .quads = {}};
    std::size_t first = 0; // triangle of the face
    for (const int corners : read.corner_counts) {
        const auto end = first + static_cast<std::size_t>(corners) - 2;
        if (corners == 4) {
            const auto& [a, b, c] = read.mesh.triangles[first];
            out.quads.push_back({a, b, c, read.mesh.triangles[first + 1][2]});
        } else {
            for (std::size_t i = first; i < end; ++i) {
                const auto& [a, b, c] = read.mesh.triangles[i];
                out.quads.push_back({a, b, c, a});
            }
        }
        first = end;
    }
    return out;
}

/// Where the scene says a key of an object, for messages.
std::string place_of(const SceneFile& scene, std::size_t object, const char* key) {
    const std::string name = fmt::format("object.{}.{}", object, key);
    const auto place = scene.places.find(name);
    return place == scene.places.end() ? name : fmt::format("{}: {}", place->second, name);
}

/// The files of an object at its time; one or two of a series.
std::vector<std::string> inputs_of(const SceneObject& object) {
    if (!object.series.empty()) {
        const TimeNeighbours next = files_of_series(object);
        if (next.fraction == 0) return {next.before.path};
        return {next.before.path, next.after.path};
    }
    if (object.csg || !object.morph.empty() || !object.molecule.empty() || !object.points.empty() ||
        !object.tetrahedra.empty() || !object.slim.empty())
        return {};
    return {object.mesh.empty() ? object.field : object.mesh};
}

} // namespace

Composition composition_of(const SceneFile& scene) {
    Composition out;
    for (const std::size_t i : drawn_objects(scene)) {
        const SceneObject& object = scene.objects[i];
        const bool is_first = out.tree.empty();
        add(scene, i, {}, out);
        for (std::size_t k = 0; object.is_cut && k < scene.cut.planes.size(); ++k) {
            add_part({.plane = k,
                      .colour = object.cut_colour ? object.cut_colour : object.colour,
                      .cut_colour = {}},
                     out);
            out.tree.push_back({CsgOperation::Difference});
        }
        if (!is_first) out.tree.push_back({CsgOperation::Union});
    }
    return out;
}

TimeNeighbours files_of_series(const SceneObject& object) {
    const std::vector<TimedFile> files = field_series(object.series);
    const double time = object.time.value_or(static_cast<double>(files.front().time));
    // 1e-6: far above the roundings of times that are animated; a blend with so much of another
    // file could not be told from the file alone.
    const bool is_at_a_number = std::abs(time - std::round(time)) < 1e-6;
    return neighbours_of(files, is_at_a_number ? std::round(time) : time);
}

std::string name_of(const SceneFile& scene, std::size_t object) {
    const std::string& name = scene.objects[object].name;
    return name.empty() ? fmt::format("object.{}", object) : name;
}

SceneObjects::SourceKey SceneObjects::key_of(const SceneObject& object, const std::string& input) {
    if (object.mesh.empty()) return {input};
    if (object.as == SceneObject::As::Triangles || object.as == SceneObject::As::Patches)
        return {.input = input, .as = object.as};
    return {input, object.resolution.value_or(256), object.band_voxels};
}

void SceneObjects::open(const SceneFile& scene) {
    std::map<SourceKey, Source> needed;
    for (const SceneObject& object : scene.objects)
        for (const std::string& input : inputs_of(object)) {
            const SourceKey key = key_of(object, input);
            if (auto kept = sources_.extract(key)) needed.insert(std::move(kept));
            needed.try_emplace(key);
        }
    if (!sources_.empty()) {
        pairs_.clear();
        placed_.clear();
    }
    sources_ = std::move(needed); // what is not needed goes before more is read
    for (auto& [key, source] : sources_) {
        if (source.mesh || source.field || source.patches) continue;
        source.input = input_from(key.input);
        if (key.as == SceneObject::As::Patches)
            source.patches = read_patches(source.input);
        else if (source.input.is_mesh())
            source.mesh = read_checked_mesh(source.input);
        else
            source.field =
                read_field(source.input, scene.memory_bytes.value_or(default_field_bytes()));
    }
    std::vector<std::pair<MoleculeKey, std::shared_ptr<const Molecule>>> molecules;
    for (const SceneObject& object : scene.objects) {
        if (object.molecule.empty()) continue;
        const MoleculeKey key{object.molecule, object.atoms};
        const auto kept = std::ranges::find(molecules_, key, [](const auto& m) { return m.first; });
        molecules.emplace_back(
            key, kept != molecules_.end()
                     ? kept->second
                     : std::make_shared<Molecule>(read_molecule(object.molecule, object.atoms)));
    }
    molecules_ = std::move(molecules);
    const auto read_once = [&](std::string SceneObject::*path_of, auto& held, auto read) {
        std::remove_reference_t<decltype(held)> wanted;
        for (const SceneObject& object : scene.objects) {
            const std::string& path = object.*path_of;
            if (path.empty() || wanted.contains(path)) continue;
            auto kept = held.extract(path);
            wanted.emplace(path, kept ? std::move(kept.mapped()) : read(path));
        }
        held = std::move(wanted);
    };
    read_once(&SceneObject::points, points_, [](const auto& path) { return read_points(path); });
    read_once(&SceneObject::tetrahedra, tetrahedra_,
              [](const auto& path) { return read_tetrahedra(path); });
    read_once(&SceneObject::slim, slims_, [](const auto& path) { return read_slim(path); });
}

std::shared_ptr<const Molecule> SceneObjects::molecule_of(const SceneObject& object) const {
    const MoleculeKey key{object.molecule, object.atoms};
    return std::ranges::find(molecules_, key, [](const auto& m) { return m.first; })->second;
}

/// Where the object places them, without a colour.
TriangleMesh SceneObjects::triangles_of(const SceneObject& object) const {
    const CheckedMesh& checked = *sources_.at(key_of(object, object.mesh)).mesh;
    TriangleMesh out{.vertices_world = checked.mesh.vertices_world,
                     .triangles = checked.mesh.triangles};
    const double crease_degrees = object.crease_degrees.value_or(40);
    if (crease_degrees > 0)
        out.normals_world = corner_normals(checked.mesh, checked.topology, crease_degrees);
    const Eigen::Affine3d to_world = object.placement.to_world();
    for (Vec3d& vertex : out.vertices_world) vertex = to_world * vertex;
    const Eigen::Matrix3f turn = (to_world.linear() / object.placement.scale).cast<float>();
    for (Eigen::Vector3f& normal : out.normals_world) normal = turn * normal;
    return out;
}

/// Where the object places them, without a colour.
PatchMesh SceneObjects::patches_of(const SceneObject& object) const {
    PatchMesh out = *sources_.at(key_of(object, object.mesh)).patches;
    const Eigen::Affine3d to_world = object.placement.to_world();
    for (Vec3d& vertex : out.vertices_world) vertex = to_world * vertex;
    return out;
}

/// Fields of a frame's objects.
class SceneObjects::Making {
public:
    Making(SceneObjects& kept, const SceneFile& scene, const Progress& progress,
           const std::function<void(const std::string&)>& warn)
        : kept_(kept), scene_(scene), progress_(progress), warn_(warn) {}

    Surface surface_of(std::size_t i) {
        const SceneObject& object = scene_.objects[i];
        Surface surface = object.surface           ? molecular_surface_of(i)
                          : !object.morph.empty()  ? morph_of(i)
                          : !object.series.empty() ? series_of(i)
                                                   : source_of(i, inputs_of(object).front());
        surface.iso_world = object.iso_world.value_or(surface.iso_world);
        if (object.placement == Placement()) return surface;
        Placed& placed = kept_.placed_[i];
        if (placed.from != surface.field || placed.placement != object.placement)
            placed = {surface.field, object.placement,
                      std::make_shared<PlacedField>(surface.field, object.placement)};
        return {placed.field, surface.iso_world * object.placement.scale};
    }

    /// Of object i, on its field.
    std::vector<Ellipsoid> glyphs_of(std::size_t i) {
        const SceneObject& object = scene_.objects[i];
        const Surface surface = surface_of(i);
        const FieldObject on{surface.field, surface.iso_world,
                             object.filter.value_or(scene_.filter), scene_.derivative_filter};
        MadeGlyphs& made = kept_.glyphs_[i];
        const MadeGlyphs::Of of{on, *object.glyphs, object.glyph_seed,
                                scene_.curvature_scale_voxels};
        if (made.of != of) {
            try {
                made = {of, curved_points(on, static_cast<std::size_t>(of.count),
                                          static_cast<std::uint64_t>(of.seed),
                                          of.curvature_scale_voxels, progress_)};
            } catch (const InputError& error) {
                throw InputError(
                    fmt::format("{}: {}", place_of(scene_, i, "glyphs"), error.what()));
            }
        }
        if (made.points.lost > 0)
            warn(i, fmt::format("{} glyphs found no place on the surface", made.points.lost));
        // 0.4: the closest pairs are 0.65 of the spacing apart, and few are long towards each
        // other.
        return curvature_ellipsoids(
            made.points.points,
            {.size_world = object.glyph_size_world.value_or(0.4 * made.points.spacing_world)});
    }

private:
    /// A blend of what is 0 on the surfaces, each field less its iso value, is 0 where that of the
    /// fields has the blend of the iso values.
    static double blended_iso(double a, double b, double t) { return (1 - t) * a + t * b; }

    Surface morph_of(std::size_t i) {
        const SceneObject& object = scene_.objects[i];
        const Surface a = surface_of(object_named(scene_, object.morph[0]).value());
        const Surface b = surface_of(object_named(scene_, object.morph[1]).value());
        Fields fields{a.field, b.field};
        if (object.t > 0 && object.t < 1) {
            Pair& pair = kept_.pairs_[i];
            if (pair.fields != fields)
                pair = {fields, on_one_lattice(a.field, b.field, Filter::Interpolating, progress_)};
            fields = pair.on_one_lattice;
        }
        return {checked(i, morph(fields[0], fields[1], object.t)),
                blended_iso(a.iso_world, b.iso_world, object.t)};
    }

    Surface molecular_surface_of(std::size_t i) {
        const SceneObject& object = scene_.objects[i];
        const std::shared_ptr<const Molecule> molecule = kept_.molecule_of(object);
        MadeSurface& made = kept_.surfaces_[i];
        const MolecularSurfaceOptions options{
            .kind = *object.surface,
            .probe_radius_world = object.probe_radius_angstrom,
            .voxel_size_world = object.voxel_angstrom,
            .half_width_voxels = object.band_voxels,
            .memory_bytes = scene_.memory_bytes.value_or(MolecularSurfaceOptions{}.memory_bytes)};
        if (made.molecule != molecule || made.options != options) {
            const MoleculePrimitives atoms =
                primitives_of(*molecule, {.style = MoleculeStyle::SpaceFilling});
            made = {molecule, options,
                    std::make_shared<SparseField>(
                        molecular_surface(atoms.spheres, options, progress_))};
        }
        return {made.field, 0};
    }

    Surface series_of(std::size_t i) {
        const SceneObject& object = scene_.objects[i];
        const TimeNeighbours next = files_of_series(object);
        const Surface before = source_of(i, next.before.path);
        const Surface after = source_of(i, next.after.path);
        return {checked(i, morph(before.field, after.field, next.fraction, Filter::Interpolating,
                                 progress_)),
                blended_iso(before.iso_world, after.iso_world, next.fraction)};
    }

    Surface source_of(std::size_t i, const std::string& input) {
        const SceneObject& object = scene_.objects[i];
        Source& source = kept_.sources_.at(key_of(object, input));
        if (source.mesh) {
            const ConvertOptions options{
                .voxel_size_world = voxel_size_for_resolution(bounding_box(source.mesh->mesh),
                                                              object.resolution.value_or(256)),
                .half_width_voxels = object.band_voxels,
                .memory_bytes = scene_.memory_bytes.value_or(ConvertOptions{}.memory_bytes)};
            ConvertResult result = convert(*source.mesh, options, progress_);
            for (const auto& warning : source.mesh->warnings) warn(i, warning);
            for (const auto& warning : result.warnings) warn(i, warning);
            source.field = std::make_shared<SparseField>(std::move(result.field));
            source.mesh.reset();
        }
        // A file may hold anything; meshes, octrees and built-in fields have their surface at 0.
        if (!source.iso_world && !object.iso_world)
            source.iso_world =
                source.input.kind == Input::Kind::FieldFile && !is_octree_file(source.input.name)
                    ? suggested_iso(*source.field).iso
                    : 0;
        return {source.field, source.iso_world.value_or(0)};
    }

    std::shared_ptr<const FieldSource> checked(std::size_t i, const Morph& morph) {
        if (morph.warning) warn(i, *morph.warning);
        return morph.field;
    }

    void warn(std::size_t i, const std::string& warning) {
        warn_(scene_.objects.size() == 1 ? warning
                                         : fmt::format("{}: {}", name_of(scene_, i), warning));
    }

    SceneObjects& kept_;
    const SceneFile& scene_;
    const Progress& progress_;
    const std::function<void(const std::string&)>& warn_;
};

namespace {

// Each is moved by `to_world`, which scales all lengths alike, by `scale`.

Sphere moved(Sphere sphere, const Eigen::Affine3d& to_world, double scale) {
    sphere.centre_world = to_world * sphere.centre_world;
    sphere.radius_world *= scale;
    return sphere;
}

Cylinder moved(Cylinder stick, const Eigen::Affine3d& to_world, double scale) {
    stick.a_world = to_world * stick.a_world;
    stick.b_world = to_world * stick.b_world;
    stick.radius_world *= scale;
    return stick;
}

Dot moved(Dot dot, const Eigen::Affine3d& to_world, double) {
    dot.centre_world = to_world * dot.centre_world;
    return dot;
}

template<class Body> // with axes
Body moved(Body body, const Eigen::Affine3d& to_world, double) {
    body.centre_world = to_world * body.centre_world;
    body.axes_world = to_world.linear() * body.axes_world;
    return body;
}

/// throws  InputError if the points have no use for a key that the object has
void check_point_keys(const SceneFile& scene, std::size_t i, const PointData& points) {
    const PointLook& look = scene.objects[i].point_look;
    const bool has_tensors = points.find("txx") != nullptr;
    if (look.radius_pixels && has_tensors)
        throw InputError(fmt::format("{}: the points in {} have tensors, whose glyphs have their "
                                     "size",
                                     place_of(scene, i, "radius_pixels"), scene.objects[i].points));
    if (look.glyph != PointLook{}.glyph && !has_tensors)
        throw InputError(fmt::format("{}: the points in {} have no tensors (columns txx, tyy, tzz, "
                                     "txy, txz, tyz)",
                                     place_of(scene, i, "glyph"), scene.objects[i].points));
}

/// Appends what an object is drawn as, where the object places it.
template<class Primitive>
void append(const std::vector<Primitive>& drawn, const Placement& placement,
            std::vector<Primitive>& out) {
    const Eigen::Affine3d to_world = placement.to_world();
    for (const Primitive& one : drawn) out.push_back(moved(one, to_world, placement.scale));
}

} // namespace

namespace {

/// A field as it is drawn: an octree of many levels as several.
std::vector<std::shared_ptr<const FieldSource>>
fields_of(const std::shared_ptr<const FieldSource>& field, double iso_world) {
    const auto octree = std::dynamic_pointer_cast<const OctreeField>(field);
    if (!octree) return {field};
    GridSpace finest = octree->space();
    finest.world_from_index.scale(std::exp2(-octree->lattice()));
    const auto fields = fields_of_octree(octree->tree(), finest, std::abs(iso_world));
    return {fields.begin(), fields.end()};
}

/// The tree with each part as the union of its objects, from first_objects[part] on.
CsgTree with_parts_divided(const CsgTree& tree, const std::vector<int>& first_objects) {
    CsgTree divided;
    for (const CsgStep& step : tree) {
        if (step.operation != CsgOperation::Object) {
            divided.push_back(step);
            continue;
        }
        const auto part = static_cast<std::size_t>(step.object);
        for (int object = first_objects[part]; object < first_objects[part + 1]; ++object) {
            divided.push_back({CsgOperation::Object, object});
            if (object > first_objects[part]) divided.push_back({CsgOperation::Union});
        }
    }
    return divided;
}

} // namespace

SceneObjects::Surface SceneObjects::plane_of(const SceneFile& scene, std::size_t plane,
                                             const Eigen::AlignedBox3d& box_world) {
    const CutPlane& cut = scene.cut.planes[plane];
    MadePlane& kept = planes_[plane];
    if (!kept.made.field || kept.normal != cut.normal || kept.box_world.min() != box_world.min() ||
        kept.box_world.max() != box_world.max())
        kept = {cut.normal, box_world, half_spaces(cut.normal, box_world)};
    return {kept.made.field, kept.made.iso_of(cut.offset_world)};
}

Scene SceneObjects::compose(const SceneFile& scene, const Progress& progress,
                            const std::function<void(const std::string&)>& warn) {
    Making making(*this, scene, progress, warn);
    const Composition composition = composition_of(scene);
    Scene out{.curvature_scale_voxels = scene.curvature_scale_voxels,
              .storage = scene.storage,
              .quality = scene.quality,
              .tree = {}};
    std::vector<Surface> surfaces;
    Eigen::AlignedBox3d box_world; // of all fields
    for (const ScenePart& part : composition.parts) {
        surfaces.push_back(part.plane ? Surface{} : making.surface_of(part.object));
        if (const auto& field = surfaces.back().field)
            box_world.extend(world_box(field->extent(), field->space()));
    }
    std::vector<int> first_objects; // of each part
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
        const ScenePart& part = composition.parts[i];
        first_objects.push_back(static_cast<int>(out.objects.size()));
        if (part.plane) {
            const Surface plane = plane_of(scene, *part.plane, box_world);
            out.objects.push_back(
                {plane.field, plane.iso_world, Filter::BSpline, {}, part.colour, {}});
            continue;
        }
        const Surface& surface = surfaces[i];
        for (const auto& field : fields_of(surface.field, surface.iso_world))
            out.objects.push_back({field, surface.iso_world,
                                   scene.objects[part.object].filter.value_or(scene.filter),
                                   scene.derivative_filter, part.colour, part.cut_colour});
    }
    first_objects.push_back(static_cast<int>(out.objects.size()));
    out.tree = with_parts_divided(composition.tree, first_objects);
    auto primitives = std::make_shared<Primitives>();
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        const SceneObject& object = scene.objects[i];
        if (!object.is_shown) continue;
        if (object.glyphs) append(making.glyphs_of(i), {}, primitives->ellipsoids);
        if (!object.molecule.empty() && !object.surface && object.as != SceneObject::As::Skin) {
            MoleculeLook look = object.molecule_look;
            look.ends_sticks_in_balls = scene.cut == Cut{};
            const MoleculePrimitives drawn = primitives_of(*molecule_of(object), look);
            append(drawn.spheres, object.placement, primitives->spheres);
            append(drawn.sticks, object.placement, primitives->cylinders);
        }
        if (!object.points.empty()) {
            check_point_keys(scene, i, points_.at(object.points));
            PointLook look = object.point_look;
            look.colour = object.colour.value_or(scene.look.material.colour);
            const PointPrimitives drawn = primitives_of(points_.at(object.points), look);
            append(drawn.spheres, object.placement, primitives->spheres);
            append(drawn.dots, object.placement, primitives->dots);
            append(drawn.ellipsoids, object.placement, primitives->ellipsoids);
            append(drawn.superquadrics, object.placement, primitives->superquadrics);
            if (drawn.dropped > 0)
                warn(fmt::format("{}: {} points of no size are not drawn", name_of(scene, i),
                                 drawn.dropped));
        }
    }
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        const SceneObject& object = scene.objects[i];
        if (!object.is_shown) continue;
        const auto add = [&](auto& meshes, auto mesh) {
            meshes.push_back(std::move(mesh));
            meshes.back().colour = object.colour.value_or(scene.look.material.colour);
        };
        if (object.as == SceneObject::As::Triangles) add(primitives->meshes, triangles_of(object));
        if (object.as == SceneObject::As::Patches) add(primitives->patches, patches_of(object));
        if (object.as == SceneObject::As::Spline) {
            const Surface surface = making.surface_of(i);
            MadeSpline& made = splines_[i];
            if (made.field != surface.field || made.iso_world != surface.iso_world)
                made = {surface.field, surface.iso_world,
                        quadratic_spline(*surface.field, surface.iso_world, progress)};
            add(primitives->tetrahedra, made.mesh);
        }
        const auto add_placed = [&](TetrahedralMesh mesh) {
            const Eigen::Affine3d to_world = object.placement.to_world();
            for (Vec3d& vertex : mesh.vertices_world) vertex = to_world * vertex;
            add(primitives->tetrahedra, std::move(mesh));
        };
        if (object.as == SceneObject::As::Skin) {
            const std::shared_ptr<const Molecule> molecule = molecule_of(object);
            const double shrink = object.skin_shrink.value_or(0.5);
            MadeSkin& made = skins_[i];
            if (made.molecule != molecule || made.shrink != shrink)
                made = {
                    molecule, shrink,
                    molecule_skin(
                        primitives_of(*molecule, {.style = MoleculeStyle::SpaceFilling}).spheres,
                        shrink)};
            add_placed(made.mesh);
        }
        if (!object.tetrahedra.empty())
            add_placed(isosurface(tetrahedra_.at(object.tetrahedra), object.iso_world.value_or(0)));
        if (!object.slim.empty())
            add(primitives->slims, placed(slims_.at(object.slim), object.placement.to_world()));
    }
    if (primitives->count() > 0) out.primitives = std::move(primitives);
    out.cut = scene.cut;
    return out;
}

std::string why_nothing_is_seen(const Scene& scene) {
    if (is_composed(scene)) return "nothing is left of the objects together";
    const FieldObject& object = scene.objects.front();
    const ValueRange range = object.field->value_range(object.field->extent());
    return fmt::format("the field never crosses the iso value {}: its values lie in {} ... {}",
                       object.iso_world, range.min, range.max);
}

Look look_of(const SceneFile& scene, bool is_opaque) {
    Look look = scene.look;
    if (!is_opaque) {
        look.background = Vec3d::Zero();
        look.shows_environment = false;
    }
    return look;
}

} // namespace isocast
