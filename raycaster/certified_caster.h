// Casts rays at an isosurface in double: every change of sign is found, whatever its neighbours.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "filtering/bspline.h"
#include "raycaster/camera.h"
#include "volume/field_source.h"
#include "volume/progress.h"

#include <array>
#include <bitset>
#include <cstdint>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

namespace isocast {

/// Along a ray in a cell the reconstructed function f is a polynomial of degree 9. In Bernstein
/// form it has no root where its coefficients have one sign, and is halved where they have not:
///
///     64 control samples ─► Bezier form of the cell ─► of the box that ─► its diagonal ─► halves
///                           by axis                    the ray spans      10 numbers
///
/// Each step takes means alone, so that nothing cancels.
///
/// accuracy  a stretch on the other side is missed only if it is shorter than 2^-47 voxel, or f -
/// iso
///           is nowhere in it farther from zero than 2^-46 of the greatest |sample - iso| of its
///           cell: 110 roundings of 2^-53
/// source    Descartes' rule of signs for Bernstein coefficients: Lane & Riesenfeld 1981
class CertifiedCaster {
public:
    /// Copies what of `control`, the kernel's control samples, lies near the surface.
    /// throws  ResourceError if that is more than half of the available memory
    CertifiedCaster(std::shared_ptr<const FieldSource> control, Kernel kernel, double iso,
                    const Progress& progress = {});

    /// The changes of sign of f - iso along a ray for t >= 0 inside the extent, in their order.
    class Walk {
    public:
        /// Whether f < iso where the ray starts, or enters the extent; false if it misses that.
        bool starts_inside() const { return starts_inside_; }
        /// The next one's t, of origin + t * direction.
        std::optional<double> next();

    private:
        friend class CertifiedCaster;
        Walk(const CertifiedCaster& caster, const Ray& ray);
        /// To the next cell; what changes in this one goes to changes_.
        void cross_cell();

        const CertifiedCaster& caster_;
        Vec3d entry_ = Vec3d::Zero();     // index space
        Vec3d direction_ = Vec3d::Zero(); // the same
        double t_entry_ = 0;
        double length_ = 0; // of the ray's part in the extent [t]; at its parameter s there
        double s_ = 0;      // the point is entry_ + s * direction_, which a far start leaves exact
        Index3 cell_ = Index3::Zero();
        bool is_done_ = true;
        bool starts_inside_ = false;
        bool is_inside_ = false;
        std::vector<double> changes_; // s, in this cell
        std::size_t seen_ = 0;        // of them
    };
    Walk walk(const Ray& ray) const { return {*this, ray}; }

    /// The first of them.
    std::optional<double> hit(const Ray& ray) const { return walk(ray).next(); }

    const FieldSource& control() const { return *control_; }
    Kernel kernel() const { return kernel_; }

private:
    /// 32^3 cells, and the control samples that they read.
    struct Page {
        std::vector<float> samples;        // 35^3, x fastest; the first is below the first cell
        std::bitset<32 * 32 * 32> unknown; // cells whose samples are not all on one side
    };
    /// Of degree 9, over [0, 1].
    using Bernstein = std::array<double, 10>;

    /// Of f - iso between two points of a cell, [0, 1]^3, and the greatest |sample - iso|; nothing
    /// where all samples are on one side.
    struct InCell {
        Bernstein polynomial;
        double greatest;
    };
    std::optional<InCell> in_cell(const Index3& cell, const Vec3d& from, const Vec3d& to) const;
    /// Adds the changes of sign in s_lo ... s_hi, from the side `is_inside`, which follows them.
    static void find_changes(const Bernstein& polynomial, double noise, double s_lo, double s_hi,
                             int depth, bool& is_inside, std::vector<double>& changes);

    std::shared_ptr<const FieldSource> control_;
    Kernel kernel_;
    double iso_;
    IndexBox extent_;
    std::unordered_map<std::uint64_t, Page> pages_; // with unknown cells; by key_of
};

} // namespace isocast
