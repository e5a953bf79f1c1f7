// From what a scene file says of objects to the fields that are drawn.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/field_series.h"
#include "apps/inputs.h"
#include "apps/scene_file.h"
#include "quadrics/slim.h"
#include "quadrics/tetrahedral_field.h"
#include "raycaster/curved_points.h"
#include "volume/half_space.h"
#include "volume/progress.h"

#include <array>
#include <functional>
#include <map>

namespace isocast {

/// An object with a field of its own, as a part of what is drawn.
struct ScenePart {
    std::size_t object = 0; // in SceneFile::objects
    /// In place of the object, what lies in front of this one of the cut's planes.
    std::optional<std::size_t> plane = {};
    // Its own, or those of the csg that it is in.
    std::optional<Vec3d> colour;
    std::optional<Vec3d> cut_colour;
    bool operator==(const ScenePart&) const = default;
};

/// What a scene draws of fields: the union of the objects that no other one is made of, each
/// without what the cut's planes take away. What is behind a cut has the colour of the object where
/// it is cut; planes that cut several of one colour are one part.
struct Composition {
    std::vector<ScenePart> parts; // each once, in the order in which the tree first names them
    CsgTree tree;                 // of these
};
/// scene  checked, but for the number of its parts
Composition composition_of(const SceneFile& scene);

/// The files of a series next to its object's time.
/// throws  InputError if there are none, or as neighbours_of
TimeNeighbours files_of_series(const SceneObject& object);

/// An object's name; without one, its place: "object.2".
std::string name_of(const SceneFile& scene, std::size_t object);

/// The fields of a scene's objects. Between frames it keeps what comes again: files that were read,
/// meshes that were converted, fields that were resampled for a morph.
class SceneObjects {
public:
    /// Reads the files that the scene's objects need, and forgets all others.
    /// throws  InputError if one cannot be read
    void open(const SceneFile& scene);

    /// What the renderer loads, but for its look. Meshes are converted here, which is the long
    /// work.
    ///
    /// scene  opened; iso values may have changed since
    /// warn   told what was noticed on the way
    Scene compose(const SceneFile& scene, const Progress& progress,
                  const std::function<void(const std::string&)>& warn);

private:
    /// What is read, and how it becomes a field.
    struct SourceKey {
        std::string input;
        int resolution = 0; // of meshes
        double band_voxels = 0;
        SceneObject::As as = SceneObject::As::Field; // triangles, patches: not converted
        auto operator<=>(const SourceKey&) const = default;
    };
    struct Source {
        Input input;
        std::optional<CheckedMesh> mesh; // to be converted, or drawn
        std::optional<PatchMesh> patches;
        std::shared_ptr<const FieldSource> field;
        std::optional<double> iso_world; // found when it is first asked for
    };
    struct Surface {
        std::shared_ptr<const FieldSource> field;
        double iso_world = 0;
    };
    /// Two fields, and the same with their samples at the same places.
    using Fields = std::array<std::shared_ptr<const FieldSource>, 2>;
    struct Pair {
        Fields fields;
        Fields on_one_lattice;
    };
    struct Placed {
        std::shared_ptr<const FieldSource> from;
        Placement placement;
        std::shared_ptr<const FieldSource> field;
    };
    /// Atoms and points that were read, and of what.
    struct MoleculeKey {
        std::string path;
        MoleculeOptions atoms;
        bool operator==(const MoleculeKey&) const = default;
    };
    std::shared_ptr<const Molecule> molecule_of(const SceneObject& object) const;
    TriangleMesh triangles_of(const SceneObject& object) const;
    PatchMesh patches_of(const SceneObject& object) const;
    class Making; // of one frame
    /// The surface of a cut's plane, with a field that reaches over all of `box_world`.
    Surface plane_of(const SceneFile& scene, std::size_t plane,
                     const Eigen::AlignedBox3d& box_world);

    static SourceKey key_of(const SceneObject& object, const std::string& input);

    std::map<SourceKey, Source> sources_;
    std::map<std::size_t, Pair> pairs_; // of morphs, by object
    std::map<std::size_t, Placed> placed_;
    struct MadePlane {
        Vec3d normal = Vec3d::Zero();
        Eigen::AlignedBox3d box_world;
        HalfSpaces made;
    };
    std::map<std::size_t, MadePlane> planes_; // by plane
    std::vector<std::pair<MoleculeKey, std::shared_ptr<const Molecule>>> molecules_;
    std::map<std::string, PointData> points_;            // by path
    std::map<std::string, TetrahedralField> tetrahedra_; // by path
    std::map<std::string, SlimSurface> slims_;           // by path
    struct MadeSpline {
        std::shared_ptr<const FieldSource> field;
        double iso_world = 0;
        TetrahedralMesh mesh;
    };
    std::map<std::size_t, MadeSpline> splines_; // by object
    struct MadeSkin {
        std::shared_ptr<const Molecule> molecule;
        double shrink = 0;
        TetrahedralMesh mesh;
    };
    std::map<std::size_t, MadeSkin> skins_; // by object
    struct MadeSurface {
        std::shared_ptr<const Molecule> molecule;
        MolecularSurfaceOptions options;
        std::shared_ptr<const FieldSource> field;
    };
    std::map<std::size_t, MadeSurface> surfaces_; // of molecules, by object
    struct MadeGlyphs {
        struct Of {
            FieldObject on;
            int count = 0;
            int seed = 0;
            double curvature_scale_voxels = 0;
            bool operator==(const Of&) const = default;
        };
        Of of;
        CurvedPoints points;
    };
    std::map<std::size_t, MadeGlyphs> glyphs_; // by object
};

/// For people, of a scene of fields whose surface is nowhere.
std::string why_nothing_is_seen(const Scene& scene);

/// The look of the scene. Pictures that are not opaque have no background.
Look look_of(const SceneFile& scene, bool is_opaque);

} // namespace isocast
