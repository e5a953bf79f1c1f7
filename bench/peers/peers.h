// Other renderers of the surface of a distance field, timed from the same camera as ours.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/sparse_field.h"

#include <limits>
#include <string>
#include <vector>

namespace isocast {

/// What all peers draw: the zero set of a field in a square perspective picture. Rays pass through
/// the centres of pixels.
struct PeerScene {
    const SparseField& field; // signed; cubic voxels, axes along the world's
    Vec3d eye_world;
    Vec3d target_world;
    Vec3d up = Vec3d::UnitY();
    double fov_degrees = 30;
    int size = 512; // pixels
    int threads = 2;
    int repeats = 3; // timed frames, after one to warm up
};

struct PeerFrame {
    std::string name;
    std::string note; // what the peer did, or why there is no frame: "not built (package …)"
    /// Once per field: see each peer's note. NaN if it is not known.
    double setup_seconds = std::numeric_limits<double>::quiet_NaN();
    double frame_seconds = std::numeric_limits<double>::quiet_NaN(); // the median
    double covered_fraction = std::numeric_limits<double>::quiet_NaN();
    std::vector<bool> covered = {}; // size * size, row by row from the top left; or empty

    bool was_drawn() const { return !covered.empty(); }
};

/// The camera of the project's table of peers: from (0.45, 0.35, 1), 2.2 `resolution` voxels away
/// from the middle of the field's blocks. The bunny covers 44 to 46 % of its picture.
PeerScene scene_of_the_table(const SparseField& field, int resolution);

// All throw ResourceError, with the words of the child process, where a peer that was built fails.

/// OpenVDB's LevelSetRayTracer with its NormalShader: trilinear.
PeerFrame openvdb_peer(const PeerScene& scene);
/// VTK's ray caster for GPUs in isosurface mode: trilinear, one sample a voxel, no root.
/// A child process under Xvfb.
PeerFrame vtk_peer(const PeerScene& scene);
/// teem's miter: cubic B-spline with curvature, one sample a voxel, no root; one frame, whatever
/// the repeats. A child process.
PeerFrame teem_peer(const PeerScene& scene);
/// A mesh of the surface under Embree's rays, with interpolated normals.
PeerFrame embree_peer(const PeerScene& scene);

} // namespace isocast
