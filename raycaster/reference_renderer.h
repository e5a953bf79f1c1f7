// Pictures in double, without OpenGL: what the GPU's are compared with.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/certified_caster.h"
#include "raycaster/image.h"
#include "raycaster/primitives_reference.h"
#include "raycaster/reference_shading.h"
#include "raycaster/renderer.h"

namespace isocast {

/// Draws a scene as Renderer does, by CertifiedCaster, primitives_reference and ReferenceShading.
///
/// It knows no quality: neither storage nor steps nor budgets change its pictures. What it cannot
/// draw it refuses: shadows, ambient occlusion, reflection, refraction, environments, solid
/// textures, flow lines, uncertainty, outlines, the curvature map, steps; numbers that a look
/// leaves to the picture; curvatures of primitives; and adaptive fields, of
/// which it would look at every sample near the surface.
class ReferenceRenderer {
public:
    /// throws  InputError if the scene is wrong, or has what the reference cannot draw;
    ///         ResourceError
    void load(Scene scene, const Progress& progress = {});
    const Look& look() const { return scene_.look; }
    ShownSurfaces shown() const { return {scene_, boxes_, primitives_box_}; }

    /// Of the images of a frame those that are wanted: Hit, Gradient, Curvature, Direction, Beauty.
    ///
    /// throws  InputError for another; Interrupted
    FrameReport draw(const Camera& camera, int width, int height, const ImageSet& wanted,
                     const PicturePart& part, const Progress& progress = {});
    const Image& read(FrameImage image) const { return images_.at(image); }

private:
    /// A field, and the functions that are derived from it.
    struct Object {
        FieldObject of;
        std::optional<CertifiedCaster> caster;
        std::shared_ptr<const FieldSource> derivative_control;
        std::shared_ptr<const FieldSource> curvature_control;
        Kernel derivative_kernel;
    };
    /// What a ray hits.
    struct Hit {
        int object = 0; // number from 1, negative where it is taken away from others; 0: none
        double t = 0;
    };
    Hit first_hit(const Ray& ray) const;
    /// The pixel of a hit with a field; `flag` as FrameImage::Curvature has it.
    ReferenceSurface surface_at(const Hit& hit, const Ray& ray, bool with_curvature,
                                float& flag) const;

    Scene scene_;
    std::vector<Object> objects_;
    InsideTable inside_{};
    std::vector<IndexBox> boxes_; // of the surfaces
    Eigen::AlignedBox3d primitives_box_;
    std::map<FrameImage, Image> images_;
};

} // namespace isocast
