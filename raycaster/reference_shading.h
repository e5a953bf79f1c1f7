// Shading in double: the twin of shaders/shading/ for what the reference draws.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "filtering/curvature.h"
#include "raycaster/camera.h"
#include "raycaster/look.h"

#include <string>
#include <vector>

namespace isocast {

/// A hit, as shading sees it; world axes.
struct ReferenceSurface {
    Vec3d from_eye = Vec3d::Zero();
    Vec3d gradient = Vec3d::Zero();
    Vec3d colour = Vec3d::Zero(); // of the surface, linear
    // Those below only if uses_curvature().
    Curvatures curvature;
    double view_curvature = 0; // in the direction of the ray
};

/// Whether the look asks for curvatures.
bool uses_curvature(const Look& look);

/// What of the look the reference cannot draw, in words.
std::vector<std::string> not_in_reference(const Look& look);

class ReferenceShading {
public:
    /// look    without what not_in_reference() names
    /// height  of the whole picture [pixels]
    ReferenceShading(const Look& look, const Camera& camera, int height);

    /// Linear RGB, coverage.
    ///
    /// surface    what the ray hits; nothing if none
    /// direction  of the ray, of any length
    /// twin       shaders/shading/shading.frag
    Eigen::Vector4d colour(const ReferenceSurface* surface, const Vec3d& direction) const;

private:
    Vec3d lit(const Vec3d& colour, const Vec3d& normal, const Vec3d& to_viewer) const;
    Vec3d with_surface_layers(Vec3d colour, const ReferenceSurface& surface) const;
    double contour_coverage(const ReferenceSurface& surface, const Vec3d& direction) const;

    const Look& look_;
    const Camera& camera_;
    int height_;
    std::vector<Vec3d> to_lights_; // unit length
};

} // namespace isocast
