// What a scene file says: objects, camera, lights, look, quality and output (docs/scenes.md).
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/camera_spec.h"
#include "apps/exr_layers.h"
#include "quadrics/molecular_surface.h"
#include "quadrics/molecule_styles.h"
#include "quadrics/point_data.h"
#include "raycaster/scene.h"
#include "volume/placed_field.h"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace isocast {

struct Input;

/// A field, and how it is drawn; or primitives: atoms, points, triangles. One of field, mesh, csg,
/// morph, series, molecule, points, tetrahedra and slim says where it comes from.
struct SceneObject {
    enum class Csg { Union, Intersection, Difference };
    std::string name;
    std::string field; // as input_from understands it
    std::string mesh;
    std::optional<Csg> csg;
    std::vector<std::string> of; // names of operands
    std::vector<std::string> morph;
    double t = 0;               // morph: 0 is the first, 1 the second
    std::string series;         // a file name with a place for a number, as field_series has it
    std::optional<double> time; // of the series; else that of its first file

    std::string molecule;                    // file
    MoleculeOptions atoms;                   // of it
    MoleculeLook molecule_look;              // of it
    std::optional<MolecularSurface> surface; // instead of its atoms, as a field
    double probe_radius_angstrom = 1.4;      // of the surface
    double voxel_angstrom = 0.5;             // of the surface
    std::string points;                      // file of points with attributes
    PointLook point_look;                    // of them

    std::string tetrahedra; // file of quadratic functions in tetrahedra
    std::string slim;       // file of a SLIM surface
    /// Meshes as they are, not as fields; fields and molecules' skins as quadrics in tetrahedra.
    enum class As { Field, Triangles, Patches, Spline, Skin };
    As as = As::Field;
    std::optional<double> crease_degrees; // of triangles
    std::optional<double> skin_shrink;    // 0.5
    std::optional<int> glyphs;            // so many of its curvature, instead of its surface
    int glyph_seed = 0;
    std::optional<double> glyph_size_world;

    std::optional<int> resolution; // of meshes
    double band_voxels = 3;        // of meshes, half width
    Placement placement;
    std::optional<double> iso_world; // before it is placed
    std::optional<Filter> filter;
    std::optional<Vec3d> colour;
    std::optional<Vec3d> cut_colour;
    bool is_shown = true;
    bool is_cut = true; // of fields: by the planes of the scene's cut
};

/// Where the camera is at a time of a sequence.
struct CameraKey {
    double time = 0; // in any unit: the first key belongs to the first frame, the last to the last
    Vec3d eye_world = Vec3d::Zero();
    std::optional<Vec3d> target_world;
    std::optional<double> fov_y_degrees;
};

/// A number of the scene that changes from frame to frame.
struct Animation {
    std::string key; // "object.0.t"
    double from = 0;
    double to = 1;
    bool is_loop = false; // `to` then belongs to the frame after the last
};

/// Of a sequence, numbers of frames.
struct FrameRange {
    int first = 0;
    int last = 0;
    int count() const { return last - first + 1; }
};

/// How samples become pixels.
enum class PixelFilter {
    Box,  // of a pixel's width
    Tent, // of two pixels' width
};

struct OutputSpec {
    int width = 1024;
    int height = 1024;
    int samples = 1; // a pixel
    PixelFilter pixel_filter = PixelFilter::Box;
    bool is_transparent = false;
    bool has_beauty = true;
    std::optional<ExrLayers> layers;
    std::optional<FrameRange> frames;
    int tile_pixels = 0; // the picture is drawn in tiles of that edge; 0: only if it is large
};

/// The files that parts of a look were read from.
struct LookFiles {
    std::string environment;
    std::string curvature_map;
    std::string texture_volume; // or a built-in name
};

struct SceneFile {
    std::filesystem::path path; // empty where a command alone says what is drawn
    std::vector<SceneObject> objects;
    CameraSpec camera;
    double turntable_degrees = 0; // over a sequence
    std::vector<CameraKey> camera_keys;
    bool has_smooth_path = true; // Catmull-Rom; else linear
    Look look;
    LookFiles look_files;
    Cut cut;
    Quality quality;
    StorageOptions storage;
    std::optional<Fetch> fetch; // the fastest
    Filter filter = Filter::Interpolating;
    std::optional<Filter> derivative_filter;
    double curvature_scale_voxels = 0;
    std::optional<double> memory_bytes;
    OutputSpec output;
    std::vector<Animation> animations;

    /// Of each key that was set, by its full name: "scene.toml:3:7" or "command line".
    std::map<std::string, std::string> places;
};

/// All that a TOML file says. Fields and meshes are only looked for; pictures are read.
/// throws  InputError with file, line and column of every problem
SceneFile read_scene_file(const std::filesystem::path& path);

/// The other way: TOML that read_scene_file makes the same scene of, with what differs from a new
/// scene alone.
///
/// folder  of the file; paths are relative to it where they lie below it, else absolute
/// throws  InputError for what no file can say: a picture or a volume that is from none, text that
///         is not UTF-8
std::string scene_text(const SceneFile& scene, const std::filesystem::path& folder);
/// The file appears whole or not at all.
/// throws  InputError as scene_text and if the folder does not exist; ResourceError if it cannot be
///         written
void write_scene_file(const SceneFile& scene, const std::filesystem::path& path);

/// Sets a key as a command line does: "effects.contours.strength=1", "light.0.shadow=soft", or
/// "light.shadow" for the first. Values are TOML's, or a bare word. Paths are relative to the
/// working folder. An index one past the last adds an element.
/// throws  UsageError that names the key and the known ones, or the type expected; InputError for
///         a file that cannot be used
void set_key(SceneFile& scene, std::string_view assignment);

/// Sets a number by its full name.
/// throws  UsageError if there is no such number
void set_number(SceneFile& scene, const std::string& key, double value);

/// What keys alone cannot show: references between objects, and keys that exclude each other.
/// throws  InputError with every problem
void check_scene(const SceneFile& scene);

/// Where it says that it comes from such an input.
std::string& source_of(SceneObject& object, const Input& input);

/// By its name.
std::optional<std::size_t> object_named(const SceneFile& scene, const std::string& name);

/// Whether it has a field, which its glyphs stand on if it has some.
inline bool has_field(const SceneObject& object) {
    return !object.csg && (object.molecule.empty() || object.surface) && object.points.empty() &&
           object.tetrahedra.empty() && object.slim.empty() && object.as == SceneObject::As::Field;
}
/// Whether it is drawn as primitives, not as a field.
inline bool is_of_primitives(const SceneObject& object) {
    return object.glyphs || (!object.csg && !has_field(object));
}

/// Names of what an object is made of; none for a field, a mesh or a series.
const std::vector<std::string>& operands_of(const SceneObject& object);
/// The objects that object i is an operand of.
std::vector<std::size_t> users_of(const SceneFile& scene, std::size_t i);

} // namespace isocast
