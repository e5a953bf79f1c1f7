// SPDX-License-Identifier: MPL-2.0
#include "apps/scene_keys.h"

#include "apps/field_series.h"
#include "apps/key_kinds.h"
#include "apps/output_words.h"
#include "volume/files.h"

#include <algorithm>

namespace isocast {

namespace {

using namespace keys;
using Path = std::filesystem::path;

constexpr Range angle{0, 180, true, true};
// 1e-4: a few steps of float coordinates; 1: a voxel, beyond which samples alone would see less.
constexpr Range guarantee{1e-4, 1};
// 64: beyond 512 fine samples per voxel float positions do not resolve them.
constexpr Range rate{0, 64, true};

/// What gets the path of an object.
auto path_of(std::string SceneObject::*member) {
    return [member](const SceneFile& scene, std::size_t i, const Path& folder) {
        return path_value(scene.objects[i].*member, folder);
    };
}

std::string existing(std::string path) {
    if (!std::filesystem::exists(path)) throw InputError(fmt::format("{}: no such file", path));
    return path;
}

/// Something that exists; it is read when it is drawn.
///
/// what  as Input::what() says
SceneKey input(std::string name, std::string SceneObject::*member, std::string_view what,
               std::string type, std::string help) {
    return special(
        std::move(name), std::move(type), std::move(help),
        [member, what](SceneFile& scene, std::size_t i, const SceneValue& value,
                       const Path& folder) {
            const std::string path = resolved(text_of(value), folder);
            if (const Input found = input_from(path); found.what() != what)
                throw InputError(fmt::format("{} is {}, not {}", path, found.what(), what));
            scene.objects[i].*member = path;
        },
        path_of(member));
}

template<class Place>
SceneKey texts(std::string name, Place place, std::string help) {
    return key(std::move(name), "[\"name\", ...]", std::move(help), place, texts_of);
}

Names<Filter> filters() {
    return names_by(filter_from_name,
                    {"interpolating", "bspline", "exact", "catmull-rom", "linear"});
}

SceneTable camera_table() {
    constexpr auto camera =
        within([](SceneFile& file, std::size_t) -> CameraSpec& { return file.camera; });
    constexpr auto scene = within([](SceneFile& file, std::size_t) -> SceneFile& { return file; });
    return {
        "camera",
        "Without eye and direction the object fills the picture, seen from a little to the "
        "right and above.",
        {vector("eye", camera(&CameraSpec::eye_world), "Where the camera is"),
         vector("target", camera(&CameraSpec::target_world),
                "What it looks at, with `eye`; else the object's middle"),
         direction("direction", camera(&CameraSpec::direction_to_eye),
                   "From the object to the eye; the object then fills the picture"),
         direction("up", camera(&CameraSpec::up), "What points upwards in the picture (else y)"),
         number("fov", camera(&CameraSpec::fov_y_degrees), angle,
                "Vertical angle of view [degrees], 30 unless said"),
         number("height", camera(&CameraSpec::height_world), positive,
                "Orthographic: the picture's height [world]"),
         special(
             "stereo", "number above 0, or \"auto\"",
             "A pair of pictures, for eyes so far apart [world], or 1/30 of the target's "
             "distance; what is as far away as the target is in the same place of both. PNG: "
             "side by side; OpenEXR: the views left and right",
             [](SceneFile& file, std::size_t, const SceneValue& value, const Path&) {
                 const auto* text = std::get_if<std::string>(&value);
                 if (text && *text != "auto")
                     throw UsageError(fmt::format("'{}' is neither a number nor auto", *text));
                 file.camera.is_stereo = true;
                 file.camera.eye_separation_world.reset();
                 if (!text) file.camera.eye_separation_world = positive.checked(number_of(value));
             },
             [](const SceneFile& file, std::size_t, const Path&) {
                 const std::optional<double>& separation = file.camera.eye_separation_world;
                 if (!file.camera.is_stereo || separation) return value_of(separation);
                 return Value("auto");
             }),
         number("turntable", scene(&SceneFile::turntable_degrees), {},
                "Over a sequence the camera goes round the target's upward axis by so many "
                "degrees; 360 makes a loop"),
         choice("path", scene(&SceneFile::has_smooth_path),
                Names<bool>{{"catmull-rom", true}, {"linear", false}},
                "How the camera goes from key to key")}};
}

SceneTable camera_key_table() {
    constexpr auto camera_key =
        within([](SceneFile& file, std::size_t i) -> CameraKey& { return file.camera_keys[i]; });
    return {"camera.key",
            "Where the camera is during a sequence: from the first key at the first frame to the "
            "last at the last.",
            {number("time", camera_key(&CameraKey::time), {}, "In any unit; keys stand in order"),
             vector("eye", camera_key(&CameraKey::eye_world), "As in [camera]"),
             vector("target", camera_key(&CameraKey::target_world), "As in [camera], if not said"),
             number("fov", camera_key(&CameraKey::fov_y_degrees), angle,
                    "As in [camera], if not said")},
            [](const SceneFile& file) { return file.camera_keys.size(); },
            [](SceneFile& file, std::size_t n) { file.camera_keys.resize(n); }};
}

SceneTable light_table() {
    constexpr auto light =
        within([](SceneFile& file, std::size_t i) -> Light& { return file.look.lights[i]; });
    return {"light",
            "Lights infinitely far away, 8 at most; one unless any is given.",
            {direction("direction", light(&Light::direction), "Towards the light"),
             choice("space", light(&Light::is_in_view_space),
                    Names<bool>{{"view", true}, {"world", false}},
                    "Axes of `direction`: view (x right, y up, z to the viewer) moves with the "
                    "camera"),
             colour("colour", light(&Light::colour), "Its colour, and how bright it is"),
             choice("shadow", light(&Light::shadow),
                    Names<Shadow>{
                        {"none", Shadow::None}, {"hard", Shadow::Hard}, {"soft", Shadow::Soft}},
                    "Whether it casts shadows; of one light at most"),
             number("strength", light(&Light::shadow_strength), share, "Of its shadow"),
             number("size", light(&Light::size_degrees), Range{0, 90, true, true},
                    "Soft shadows: the angle under which the light is seen [degrees]"),
             integer("shadow_map_pixels", light(&Light::shadow_map_pixels), {16, 16384},
                     "Along the longer side of what the light sees; unless said as the picture's "
                     "longer side, 4096 at most")},
            [](const SceneFile& file) { return file.look.lights.size(); },
            [](SceneFile& file, std::size_t n) { file.look.lights.resize(n); }};
}

SceneTable object_table() {
    constexpr auto object =
        within([](SceneFile& file, std::size_t i) -> SceneObject& { return file.objects[i]; });
    constexpr auto placement = within(
        [](SceneFile& file, std::size_t i) -> Placement& { return file.objects[i].placement; });
    constexpr auto molecule_look = within([](SceneFile& file, std::size_t i) -> MoleculeLook& {
        return file.objects[i].molecule_look;
    });
    constexpr auto atoms = within(
        [](SceneFile& file, std::size_t i) -> MoleculeOptions& { return file.objects[i].atoms; });
    constexpr auto point_look = within(
        [](SceneFile& file, std::size_t i) -> PointLook& { return file.objects[i].point_look; });
    using Csg = SceneObject::Csg;
    using As = SceneObject::As;
    return {
        "object",
        "What is drawn. One of field, mesh, csg, morph, series, molecule, points, tetrahedra and "
        "slim says what it is. "
        "Objects that another one is made of are not drawn themselves.",
        {text("name", object(&SceneObject::name), "By which others refer to it"),
         input("field", &SceneObject::field, "a field", "file or field:NAME@N",
               "A field, with FILE:GRID for one of its grids"),
         input("mesh", &SceneObject::mesh, "a mesh", "file or mesh:NAME",
               "A mesh, converted to a field, or drawn as it is"),
         choice(
             "as", object(&SceneObject::as),
             Names<As>{{"field", As::Field},
                       {"triangles", As::Triangles},
                       {"patches", As::Patches},
                       {"spline", As::Spline},
                       {"skin", As::Skin}},
             "What it is drawn as. Meshes: a field, their triangles, or (.obj, .ply) each face of "
             "four corners as a bilinear patch. Fields: cubic by their filter, or the quadrics of "
             "a quadratic spline over tetrahedra. Molecules: their skin surface, of spheres and "
             "hyperboloids (builds with ISOCAST_SKIN)"),
         number("shrink", object(&SceneObject::skin_shrink), Range{0, 1, true, true},
                "Skins: near 1 the atoms with short necks between them, near 0 their hull; 0.5 "
                "unless said"),
         number("crease", object(&SceneObject::crease_degrees), Range{0, 180, false, false},
                "Triangles: edges that bend by less are shaded as if smooth [degrees], 40 unless "
                "said; 0: every face is flat"),
         choice("csg", object(&SceneObject::csg),
                Names<Csg>{{"union", Csg::Union},
                           {"intersection", Csg::Intersection},
                           {"difference", Csg::Difference}},
                "Made of the objects in `of`; difference: the first without the others"),
         texts("of", object(&SceneObject::of), "Names of the objects that `csg` combines"),
         texts("morph", object(&SceneObject::morph), "Names of two objects that `t` blends"),
         number("t", object(&SceneObject::t), share,
                "0: the first object of `morph`, 1: the second"),
         special(
             "series", "file name with #",
             "Fields in time, like \"field_####.vdb\": the run of # stands for a number of at "
             "least so many digits, as %04d does",
             [](SceneFile& file, std::size_t i, const SceneValue& value, const Path& folder) {
                 const std::string name = text_of(value);
                 if (!is_series(name))
                     throw UsageError(fmt::format("'{}' has no single run of #", name));
                 if (!is_field_file(name))
                     throw UsageError(fmt::format("'{}' names no field files ({})", name,
                                                  field_file_extensions()));
                 file.objects[i].series = resolved(name, folder);
             },
             path_of(&SceneObject::series)),
         number("time", object(&SceneObject::time), {},
                "A number of `series`, or between two: their fields are blended; the first unless "
                "said"),
         input("molecule", &SceneObject::molecule, "a molecule", "file",
               "Atoms and bonds from .pdb, .ent, .cif, .mmcif or .xyz; world units are angstrom"),
         choice("surface", object(&SceneObject::surface),
                Names<MolecularSurface>{{"van-der-waals", MolecularSurface::VanDerWaals},
                                        {"accessible", MolecularSurface::Accessible},
                                        {"excluded", MolecularSurface::Excluded}},
                "Molecules: this surface as a field, in place of atoms and bonds: of the atoms' "
                "spheres, of where a solvent's middle can be, of what solvent does not reach"),
         number("probe", object(&SceneObject::probe_radius_angstrom), positive,
                "Molecules: radius of the solvent [angstrom]"),
         number("voxel", object(&SceneObject::voxel_angstrom), positive,
                "Molecules: of the surface's field [angstrom]"),
         choice("style", molecule_look(&MoleculeLook::style),
                Names<MoleculeStyle>{{"balls-and-sticks", MoleculeStyle::BallsAndSticks},
                                     {"space-filling", MoleculeStyle::SpaceFilling},
                                     {"licorice", MoleculeStyle::Licorice}},
                "Molecules: how atoms and bonds are drawn"),
         choice("colours", molecule_look(&MoleculeLook::colours),
                Names<MoleculeColours>{{"element", MoleculeColours::Element},
                                       {"chain", MoleculeColours::Chain},
                                       {"residue", MoleculeColours::Residue},
                                       {"b-factor", MoleculeColours::BFactor}},
                "Molecules: what colours mean"),
         number("ball_scale", molecule_look(&MoleculeLook::ball_scale), positive,
                "Molecules: balls, of the van der Waals radius"),
         number("stick_radius", molecule_look(&MoleculeLook::stick_radius_angstrom), positive,
                "Molecules: of sticks between balls [angstrom]"),
         number("licorice_radius", molecule_look(&MoleculeLook::licorice_radius_angstrom), positive,
                "Molecules: of licorice [angstrom]"),
         integer("model", atoms(&MoleculeOptions::model), {},
                 "Molecules: its number in the file, the first unless said"),
         text("altloc", atoms(&MoleculeOptions::altloc),
              "Molecules: the alternative location; unless said the one of highest occupancy"),
         text("assembly", atoms(&MoleculeOptions::assembly),
              "Molecules: the biological assembly; unless said the atoms of the file"),
         truth("waters", atoms(&MoleculeOptions::waters), "Molecules: whether water is shown"),
         text("selection", atoms(&MoleculeOptions::selection),
              "Molecules: chains and residues, like \"A,B:10-50\"; all unless said"),
         special(
             "points", "file",
             "Points from .csv or .ply with columns x, y, z and perhaps radius; red, green, "
             "blue (to 255) or r, g, b (to 1); txx, tyy, tzz, txy, txz, tyz of a tensor, which "
             "is shown as a glyph",
             [](SceneFile& file, std::size_t i, const SceneValue& value, const Path& folder) {
                 const std::string path = resolved(text_of(value), folder);
                 if (!is_point_file(path))
                     throw UsageError(fmt::format("'{}' is no file of points ({})", path,
                                                  point_file_extensions()));
                 file.objects[i].points = existing(path);
             },
             path_of(&SceneObject::points)),
         special(
             "tetrahedra", "file",
             "A quadratic function in each tetrahedron of a mesh, from .vtk (legacy, ASCII); its "
             "surface where it is `iso`",
             [](SceneFile& file, std::size_t i, const SceneValue& value, const Path& folder) {
                 file.objects[i].tetrahedra = existing(resolved(text_of(value), folder));
             },
             path_of(&SceneObject::tetrahedra)),
         input("slim", &SceneObject::slim, "a SLIM surface", "file",
               "A surface of overlapping pieces of quadrics, from .slim (`isocast convert`)"),
         number("radius", point_look(&PointLook::radius_world), positive,
                "Points: of those without a column `radius`"),
         number("radius_pixels", point_look(&PointLook::radius_pixels), positive,
                "Points: of all, in place of their radii, as large near as far; not of tensors"),
         choice("glyph", point_look(&PointLook::glyph),
                Names<TensorGlyph>{{"ellipsoid", TensorGlyph::Ellipsoid},
                                   {"superquadric", TensorGlyph::Superquadric}},
                "Points: what shows a tensor"),
         number("sharpness", point_look(&PointLook::sharpness), not_negative,
                "Points: how fast superquadrics' edges grow with anisotropy; 0 leaves ellipsoids"),
         number("tensor_scale", point_look(&PointLook::tensor_scale), positive,
                "Points: semi-axes by eigenvalues"),
         integer(
             "glyphs", object(&SceneObject::glyphs), {1, 1 << 20},
             "Fields, meshes, morphs, series, molecules' surfaces: so many ellipsoids of its "
             "curvature, spread evenly, in place of the surface; for both give the object twice"),
         integer("glyph_seed", object(&SceneObject::glyph_seed), {},
                 "Glyphs: other places for another number"),
         number("glyph_size", object(&SceneObject::glyph_size_world), positive,
                "Glyphs: the greatest semi-axis [world]; unless said 0.4 of their spacing"),
         integer("resolution", object(&SceneObject::resolution), {},
                 "Meshes: voxels along the longest side, 256 unless said"),
         number("band", object(&SceneObject::band_voxels), Range{.lo = 1},
                "Meshes: distances are known so far from the surface [voxels]; for morphs more is "
                "needed"),
         number("scale", placement(&Placement::scale), Range{1e-6, 1e6},
                "Of its size, about the origin, and of its distances"),
         vector("rotate", placement(&Placement::rotation_degrees),
                "Then it is turned about the axes x, y and z, in this order [degrees]"),
         vector("translate", placement(&Placement::translation_world), "Then it is moved"),
         number("iso", object(&SceneObject::iso_world), {},
                "Iso value; unless said 0 for distances, for other files what `isocast info` "
                "suggests, and between two fields what lies between theirs; `scale` goes with it"),
         choice("filter", object(&SceneObject::filter), filters(), "In place of [quality] filter"),
         colour("colour", object(&SceneObject::colour),
                "In place of [shading] colour; that of a csg is for those of its objects that have "
                "none"),
         colour("cut_colour", object(&SceneObject::cut_colour),
                "Where it is taken away from others, and where planes cut it, in place of "
                "`colour`"),
         truth("shown", object(&SceneObject::is_shown),
               "Whether it is drawn; operands are where the object is that combines them"),
         truth("cut", object(&SceneObject::is_cut),
               "Fields: whether the planes of [[cut.plane]] cut it")},
        [](const SceneFile& file) { return file.objects.size(); },
        [](SceneFile& file, std::size_t n) { file.objects.resize(n); }};
}

SceneTable shading_table() {
    constexpr auto look = within([](SceneFile& file, std::size_t) -> Look& { return file.look; });
    constexpr auto material =
        within([](SceneFile& file, std::size_t) -> Material& { return file.look.material; });
    constexpr auto tones =
        within([](SceneFile& file, std::size_t) -> GoochTones& { return file.look.tones; });
    constexpr auto environment =
        within([](SceneFile& file, std::size_t) -> Environment& { return file.look.environment; });
    using Kind = Environment::Kind;
    return {
        "shading",
        "From hits to colours.",
        {choice("model", look(&Look::model),
                Names<ShadingModel>{{"blinn-phong", ShadingModel::BlinnPhong},
                                    {"gooch", ShadingModel::Gooch},
                                    {"flat", ShadingModel::Flat}},
                "How light makes colours; flat: not at all"),
         colour("colour", material(&Material::colour), "Of the surface"),
         number("ambient", material(&Material::ambient), not_negative, "Share of ambient light"),
         number("diffuse", material(&Material::diffuse), not_negative, "Of diffuse reflection"),
         number("specular", material(&Material::specular), not_negative, "Of highlights"),
         number("shininess", material(&Material::shininess), not_negative,
                "Exponent of highlights"),
         colour("cool", tones(&GoochTones::cool), "Gooch: the tone away from the light"),
         colour("warm", tones(&GoochTones::warm), "Gooch: the tone towards it"),
         number("cool_share", tones(&GoochTones::cool_share), share,
                "Gooch: of the surface colour in the cool tone"),
         number("warm_share", tones(&GoochTones::warm_share), share, "... in the warm tone"),
         colour("background", look(&Look::background), "Where nothing is hit"),
         special(
             "environment", "\"sky\" | \"stripes\" | file (.png, .exr)",
             "Light from all directions, for reflection, refraction and the background; "
             "pictures are equirectangular",
             [](SceneFile& file, std::size_t, const SceneValue& value, const Path& folder) {
                 const std::string name = text_of(value);
                 Environment& around = file.look.environment;
                 around.kind = name == "sky"       ? Kind::Sky
                               : name == "stripes" ? Kind::Stripes
                                                   : Kind::Picture;
                 if (around.kind != Kind::Picture) return;
                 const std::string path = resolved(name, folder);
                 around.picture = read_picture(path);
                 file.look_files.environment = path;
             },
             [](const SceneFile& file, std::size_t, const Path& folder) -> Value {
                 const Kind kind = file.look.environment.kind;
                 if (kind != Kind::Picture) return kind == Kind::Sky ? "sky" : "stripes";
                 return path_value_of_read(true, file.look_files.environment, folder);
             }),
         integer("stripes", environment(&Environment::stripes), {1, 1000},
                 "How many the built-in environment has from pole to pole"),
         truth("show_environment", look(&Look::shows_environment), "As the background")}};
}

SceneTable quality_table() {
    constexpr auto quality =
        within([](SceneFile& file, std::size_t) -> Quality& { return file.quality; });
    constexpr auto storage =
        within([](SceneFile& file, std::size_t) -> StorageOptions& { return file.storage; });
    constexpr auto scene = within([](SceneFile& file, std::size_t) -> SceneFile& { return file; });
    return {
        "quality",
        "How finely, and from which samples.",
        {number("guarantee", quality(&Quality::guarantee_voxels), guarantee,
                "No ray passes through more than this of the object unseen [voxels]"),
         number("rate", quality(&Quality::rate), rate,
                "Take so many samples per voxel instead of certified steps; thin pieces may be "
                "missed"),
         integer("rate_factor", quality(&Quality::rate_factor), {1, 64},
                 "With `rate`: so many times as many within a voxel of the surface"),
         integer("refine_steps", quality(&Quality::refine_steps), {0, 12},
                 "With `rate`: looks for the root between two samples, at most"),
         choice("traversal", quality(&Quality::traversal),
                names_by(traversal_from_name, {"lists", "drawn", "bounds", "walk"}),
                "How rays find what to search"),
         choice("filter", scene(&SceneFile::filter), filters(),
                "From samples to a smooth function"),
         choice("derivative_filter", scene(&SceneFile::derivative_filter), filters(),
                "Of gradients and curvatures, if another"),
         number("detail_pixels", quality(&Quality::detail_pixels), {0, 4},
                "Atoms and sticks of lesser radius than this are thinned out, few and larger ones "
                "in place of many [pixels]; 0: each is drawn"),
         choice("splats", quality(&Quality::splats),
                Names<SplatShading>{{"deferred", SplatShading::Deferred},
                                    {"direct", SplatShading::Direct}},
                "Where atoms, points and triangles are shaded: once a pixel, or, for comparison, "
                "each as it is drawn, which does plain Phong and shadows alone"),
         number("curvature_scale", scene(&SceneFile::curvature_scale_voxels), {0, 16},
                "Width of the Gaussian before curvatures are taken [voxels]"),
         choice("storage", storage(&StorageOptions::format),
                names_by(sample_format_from_name, {"float32", "float16", "norm16"}),
                "Samples on the GPU"),
         choice("fetch", scene(&SceneFile::fetch),
                Names<std::optional<Fetch>>{{"auto", std::nullopt},
                                            {"rows", Fetch::Rows},
                                            {"samples", Fetch::Samples},
                                            {"linear", Fetch::Linear}},
                "How shaders read samples; auto: the fastest"),
         choice("brick_size", storage(&StorageOptions::brick_size),
                names_by(brick_size_from_name, {"8", "16", "32", "none"}),
                "Cells along the edge of a brick"),
         special(
             "texture_memory", "number above 0", "Most memory for samples on the GPU [MiB]",
             [](SceneFile& file, std::size_t, const SceneValue& value, const Path&) {
                 const double mib = Range{0, 1 << 20, true}.checked(number_of(value));
                 file.storage.budget_bytes = static_cast<std::int64_t>(mib * (1 << 20));
             },
             [](const SceneFile& file, std::size_t, const Path&) {
                 return value_of(static_cast<double>(file.storage.budget_bytes) / (1 << 20));
             }),
         choice("over_budget", storage(&StorageOptions::over_budget),
                names_by(over_budget_from_name, {"stream", "coarsen"}),
                "Beyond that: load samples as rays ask, or halve the resolution where that shows "
                "least"),
         special(
             "max_memory", "text, like \"8G\" or \"500M\"",
             "For fields' samples; half of what is available unless said",
             [](SceneFile& file, std::size_t, const SceneValue& value, const Path&) {
                 file.memory_bytes = bytes_from(text_of(value));
             },
             [](const SceneFile& file, std::size_t, const Path&) {
                 return file.memory_bytes ? value_of(fmt::format("{}", *file.memory_bytes))
                                          : std::nullopt;
             })}};
}

SceneTable output_table() {
    constexpr auto output =
        within([](SceneFile& file, std::size_t) -> OutputSpec& { return file.output; });
    return {
        "output",
        "What is made of it.",
        {special(
             "size", "\"WxH\"", "Width and height [pixels]",
             [](SceneFile& file, std::size_t, const SceneValue& value, const Path&) {
                 const PictureSize size = size_from(text_of(value));
                 file.output.width = size.width;
                 file.output.height = size.height;
             },
             [](const SceneFile& file, std::size_t, const Path&) {
                 return value_of(fmt::format("{}x{}", file.output.width, file.output.height));
             }),
         key("samples", "1 | 2 | 4 | 8 | 16 | 32 | 64",
             "Rays through each pixel; other outputs than the picture have one, in its middle",
             output(&OutputSpec::samples),
             [](const SceneValue& value) { return samples_from(integer_of(value)); }),
         choice("pixel_filter", output(&OutputSpec::pixel_filter),
                Names<PixelFilter>{{"box", PixelFilter::Box}, {"tent", PixelFilter::Tent}},
                "Over a pixel's width, or over two pixels' with falling weight"),
         truth("transparent", output(&OutputSpec::is_transparent),
               "PNG with alpha; an OpenEXR has it anyway, unless it shows the environment"),
         truth("beauty", output(&OutputSpec::has_beauty),
               "The shaded picture; an OpenEXR can do without"),
         special(
             "aov", "text or list of texts",
             fmt::format("More channels for an OpenEXR: {}", exr_layer_names),
             [](SceneFile& file, std::size_t, const SceneValue& value, const Path&) {
                 const auto* list = std::get_if<std::vector<std::string>>(&value);
                 file.output.layers = exr_layers_from(
                     list ? fmt::format("{}", fmt::join(*list, ",")) : text_of(value));
             },
             [](const SceneFile& file, std::size_t, const Path&) {
                 return value_of(names_of(file.output.layers.value_or(ExrLayers{})));
             }),
         special(
             "frames", "integer, or \"A..B\"",
             "Makes a sequence: so many frames from 0, or those from A to B; the output's name "
             "then holds %d or %04d",
             [](SceneFile& file, std::size_t, const SceneValue& value, const Path&) {
                 const auto* count = std::get_if<std::int64_t>(&value);
                 file.output.frames = frames_from(count ? std::to_string(*count) : text_of(value));
             },
             [](const SceneFile& file, std::size_t, const Path&) {
                 const auto& frames = file.output.frames;
                 return frames ? value_of(fmt::format("{}..{}", frames->first, frames->last))
                               : std::nullopt;
             }),
         integer("tile", output(&OutputSpec::tile_pixels), {0, 1 << 14},
                 "Draw in tiles of that edge [pixels], for less memory; 0: only large pictures")}};
}

SceneTable animate_table() {
    constexpr auto animation =
        within([](SceneFile& file, std::size_t i) -> Animation& { return file.animations[i]; });
    return {"animate",
            "A number of the scene that changes over a sequence, evenly.",
            {text("key", animation(&Animation::key), "Its full name, like \"object.0.t\""),
             number("from", animation(&Animation::from), {}, "At the first frame"),
             number("to", animation(&Animation::to), {}, "At the last"),
             truth("loop", animation(&Animation::is_loop),
                   "`to` belongs to the frame after the last, so that a sequence can repeat")},
            [](const SceneFile& file) { return file.animations.size(); },
            [](SceneFile& file, std::size_t n) { file.animations.resize(n); }};
}

SceneTable cut_table() {
    constexpr auto cut = within([](SceneFile& file, std::size_t) -> Cut& { return file.cut; });
    return {"cut",
            "How molecules, points and triangles are opened; fields have caps wherever planes cut "
            "them.",
            {choice("look", cut(&Cut::look),
                    Names<CutLook>{{"inside", CutLook::Inside},
                                   {"flat", CutLook::Flat},
                                   {"capped", CutLook::Capped}},
                    "What shows in a cut: the inner side; that, as flat as the plane; or a cap in "
                    "the plane, which triangles have none of"),
             number("near", cut(&Cut::near_world), positive,
                    "What is nearer to the eye, along the camera's axis, is cut away [world]")}};
}

SceneTable cut_plane_table() {
    constexpr auto plane =
        within([](SceneFile& file, std::size_t i) -> CutPlane& { return file.cut.planes[i]; });
    return {"cut.plane",
            "What is in front of a plane is cut away, of fields, too; 8 at most. A plane counts "
            "as a field for each colour that it cuts, and 8 fields at most are drawn together.",
            {direction("normal", plane(&CutPlane::normal), "Of the plane, towards what goes"),
             number("offset", plane(&CutPlane::offset_world), {},
                    "How far along the normal the plane is from the world's origin [world]")},
            [](const SceneFile& file) { return file.cut.planes.size(); },
            [](SceneFile& file, std::size_t n) { file.cut.planes.resize(n); }};
}

} // namespace

const SceneKey* SceneTable::key(std::string_view key_name) const {
    const auto found = std::ranges::find(keys, key_name, &SceneKey::name);
    return found == keys.end() ? nullptr : &*found;
}

std::vector<SceneTable> scene_tables() {
    std::vector<SceneTable> tables{
        object_table(),    camera_table(),  camera_key_table(), light_table(),  cut_table(),
        cut_plane_table(), shading_table(), quality_table(),    output_table(), animate_table()};
    for (SceneTable& table : effect_tables()) tables.push_back(std::move(table));
    return tables;
}

std::string known_keys(const SceneTable& table) {
    std::vector<std::string_view> names;
    for (const SceneKey& key : table.keys) names.push_back(key.name);
    return fmt::format("{}", fmt::join(names, ", "));
}

std::string header_of(const SceneTable& table) {
    return table.is_array() ? fmt::format("[[{}]]", table.name) : fmt::format("[{}]", table.name);
}

std::string scene_reference() {
    std::string text;
    for (const SceneTable& table : scene_tables()) {
        text += fmt::format("### `{}`\n\n{}\n\n", header_of(table), table.help);
        text += "| key | value | unless said | |\n| --- | --- | --- | --- |\n";
        for (const SceneKey& key : table.keys) {
            std::string type;
            for (const char c : key.type) type += c == '|' ? "\\|" : std::string(1, c); // in a cell
            text +=
                fmt::format("| `{}` | {} | {} | {} |\n", key.name, type,
                            key.initial.empty() ? "" : fmt::format("`{}`", key.initial), key.help);
        }
        text += "\n";
    }
    return text;
}

} // namespace isocast
