// Spheres, other quadrics and triangles of a scene as the GL draws them (thesis chapter 7).
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/splats.h"
#include "raycaster/camera.h"
#include "raycaster/field_on_gpu.h"
#include "raycaster/splat_study.h"

namespace isocast {

PictureSpace picture_space(const Camera& camera);
/// As in SplatView, of a whole picture.
double pixels_per_unit(const Camera& camera, int height);

/// With unit normals, that near the viewer among them.
std::vector<CutPlane> planes_of(const Cut& cut, const Camera& viewer);

/// The order of rectangles' corners: four vertices each, for two triangles, are a third fewer to
/// shade than six.
struct RectanglesOnGpu {
    RectanglesOnGpu() = default;
    /// count  at least 1; more than 2^14, whose vertices have indices of 16 bits, take many draws
    explicit RectanglesOnGpu(std::size_t count);

    int count = 0; // of one draw
    gl::Buffer indices;
    gl::VertexArray array;
};

/// What a scene's primitives keep on the GPU, wherever they are seen from.
struct PrimitivesOnGpu {
    PrimitivesOnGpu() = default;
    /// primitives  without dots
    explicit PrimitivesOnGpu(const Primitives& primitives);

    NumbersOnGpu colours;          // by the numbers of splats_of(); then of the halves at b
    NumbersOnGpu triangle_normals; // of all corners, if any mesh has normals
    RectanglesOnGpu rectangles;
    int first_slim = 0;      // colour of the first SLIM surface
    int to_half_colours = 0; // from a stick's colour to that of its half at b, if any has two
    bool are_sticks = false; // of SplatKind::Cone all are open cylinders

    std::int64_t byte_count() const {
        return colours.buffer.byte_count() + triangle_normals.buffer.byte_count() +
               rectangles.indices.byte_count();
    }
};

/// The primitives that one camera can see, as shaders/quadrics take them.
struct SplatsOnGpu {
    /// primitives  without dots
    /// planes      with unit normals
    /// part        of a picture of width x height
    /// detail_pixels  as in SplatView
    SplatsOnGpu(const Primitives& primitives, std::vector<CutPlane> planes, const Camera& camera,
                int width, int height, const PicturePart& part, double detail_pixels = 0,
                const SplatStudy& study = {});

    /// Those of one kind.
    struct OfKind {
        SplatKind kind = SplatKind::Sphere;
        int count = 0;
        int first_slot = 0; // splats are numbered through all kinds, from 0
        int slot_count = 0; // of SLIM surfaces one each, of others one a splat
        NumbersOnGpu records;
    };
    std::vector<OfKind> kinds;              // that are there
    std::vector<Eigen::Vector4i> tile_runs; // of tiles that can show one, as TileLists::runs()
    std::vector<CutPlane> planes;           // that cut them; with unit normals
    bool shows_slims_inside = false;        // of any SLIM surface
    SplatStudy study;
    std::int64_t byte_count = 0;
    const PrimitivesOnGpu* of_scene = nullptr;

    /// Those of SLIM surfaces; null if there are none to be seen.
    const OfKind* slim() const;
};

} // namespace isocast
