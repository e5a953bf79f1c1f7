// Derivatives in pictures: normals and curvatures of known shapes and where the gradient vanishes,
// and fields in units of any size.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/curvature.h"
#include "stability/fields.h"
#include "stability/picture_judge.h"
#include "volume/analytic_fields.h"

namespace isocast::stability {

namespace {

constexpr int n = 28;
const Vec3d middle = Vec3d::Constant(0.5 * (n - 1)) + Vec3d(0.1, 0.6, -0.2);
const Camera camera{.eye_world = middle + Vec3d(30, 24, 60), .target_world = middle};

/// Images of a field of unit voxels.
struct Pictures {
    Image hits, other;

    /// Calls visit(p_world, pixel of the other image) at hits farther from the border than what a
    /// point reads there.
    template<class Visit>
    void for_each_hit(Visit visit) const {
        for (std::size_t i = 0; i < hits.rgba.size(); i += 4) {
            if (hits.rgba[i + 3] == 0) continue;
            const Vec3d p =
                camera.eye_world + Vec3d(hits.rgba[i], hits.rgba[i + 1], hits.rgba[i + 2]);
            if (p.minCoeff() > 3 && p.maxCoeff() < n - 4) visit(p, &other.rgba[i]);
        }
    }
};

Pictures draw(Device& device, const Scene& scene, FrameImage image) {
    device.renderer.load(scene);
    device.renderer.draw(camera, 40, 40, {FrameImage::Hit, image});
    return {device.renderer.read(FrameImage::Hit), device.renderer.read(image)};
}

/// A field of a world-space function, in voxels.
template<class Value>
Scene scene_of(Value value) {
    return {.field = unit_field(n, value), .filter = Filter::Interpolating};
}

Worst normals_of_a_plane(Device& device, double scale) {
    const Vec3d normal = Vec3d(0.3, 0.5, 0.8).normalized();
    const Pictures p =
        draw(device, scene_of([&](const Vec3d& q) { return scale * normal.dot(q - middle); }),
             FrameImage::Gradient);
    Worst worst;
    p.for_each_hit([&](const Vec3d&, const float* g) {
        worst.see((Vec3d(g[0], g[1], g[2]) / scale - normal).norm());
    });
    return worst;
}

Worst curvatures_of(Device& device, const AnalyticField& field, FrameImage image) {
    const Pictures p =
        draw(device, scene_of([&](const Vec3d& q) { return field.jet(q).value; }), image);
    Worst worst;
    p.for_each_hit([&](const Vec3d& q, const float* k) {
        const Jet jet = field.jet(q);
        const Curvatures c = principal_curvatures(jet.gradient, jet.hessian);
        if (image == FrameImage::Curvature) {
            worst.see(std::abs(k[0] - c.k1));
            worst.see(std::abs(k[1] - c.k2));
        } else
            worst.see(flow_line_curvature(jet.gradient, jet.hessian) == 0
                          ? std::abs(k[0])
                          : std::abs(k[0] - flow_line_curvature(jet.gradient, jet.hessian)));
    });
    return worst;
}

/// (x + y - 2 m)^3/8 is its own spline, and its gradient vanishes on all of its surface.
Worst no_gradient_is_flagged(Device& device, FrameImage image) {
    const Pictures p = draw(
        device, scene_of([&](const Vec3d& q) { return std::pow((q.x() + q.y() - 27.5) / 2, 3); }),
        image);
    Worst worst;
    p.for_each_hit([&](const Vec3d&, const float* k) {
        worst.must(k[0] == 0 && k[1] == 0 && k[2] == 0 &&
                   k[3] == (image == FrameImage::Curvature ? 2 : 0));
    });
    return worst;
}

/// A quadratic sphere is its own spline: umbilics everywhere, as far as roundings tell.
Worst umbilics_are_flagged(Device& device, double scale) {
    const auto sphere = [=](const Vec3d& q) {
        return scale * ((q - middle).squaredNorm() / 9 - 9) / 2;
    };
    const Pictures k = draw(device, scene_of(sphere), FrameImage::Curvature);
    Worst worst;
    k.for_each_hit([&](const Vec3d&, const float* pixel) { worst.must(pixel[3] == 3); });
    const Pictures d = draw(device, scene_of(sphere), FrameImage::Direction);
    d.for_each_hit([&](const Vec3d&, const float* pixel) {
        worst.must(pixel[3] == 0);
        // Some tangent.
        worst.must(std::abs(Vec3d(pixel[0], pixel[1], pixel[2]).norm() - 1) < 1e-6);
    });
    return worst;
}

/// All images are numbers: on noise, where gradients come near to zero anywhere.
Worst finite_on_noise(Device& device) {
    Worst worst;
    for (const Filter filter : {Filter::Interpolating, Filter::CatmullRom, Filter::Linear}) {
        device.renderer.load({.field = white_noise(n, 1), .filter = filter});
        const std::array images{FrameImage::Gradient, FrameImage::Curvature, FrameImage::Direction,
                                FrameImage::FlowLineCurvature, FrameImage::ViewCurvature};
        ImageSet wanted;
        for (const FrameImage image : images) wanted.insert(image);
        device.renderer.draw(camera, 40, 40, wanted);
        for (const FrameImage image : images)
            for (const float value : device.renderer.read(image).rgba)
                worst.must(std::isfinite(value));
    }
    return worst;
}

std::shared_ptr<const DenseField> scaled_ball(double scale) {
    return unit_field(n, [=](const Vec3d& p) { return scale * ((p - middle).norm() - 9); });
}

/// Where a field times a power of two is zero does not change, by a bit.
Worst values_scale_exactly(Device& device, int exponent, const StorageOptions& storage) {
    const auto one = scaled_ball(1);
    std::vector<float> values(one->values().begin(), one->values().end());
    for (float& value : values) value = std::ldexp(value, exponent);
    Scene a{.field = one, .storage = storage};
    Scene b{.field = std::make_shared<DenseField>(one->space(), one->extent(), values),
            .storage = storage};
    Worst worst;
    for (const FrameImage image : {FrameImage::Gradient, FrameImage::Curvature}) {
        const Pictures first = draw(device, a, image);
        Pictures second = draw(device, b, image);
        worst.see(same_pictures(first.hits, second.hits));
        if (image == FrameImage::Gradient)
            for (std::size_t i = 0; i < second.other.rgba.size(); ++i)
                if (i % 4 != 3) second.other.rgba[i] = std::ldexp(second.other.rgba[i], -exponent);
        worst.see(same_pictures(first.other, second.other));
    }
    return worst;
}

Worst positions_in_units(Device& device, double unit) {
    return judge_positions(device, {.samples = scaled_ball(unit), .filter = Filter::Interpolating},
                           camera);
}

/// World, voxels and distances in that unit.
Worst world_in_units(Device& device, double unit) {
    const auto field =
        field_in(GridSpace::uniform(unit), {Index3::Zero(), Index3::Constant(n)},
                 [&](const Vec3d& p) { return (p - unit * middle).norm() - 9 * unit; });
    Camera there = camera;
    there.eye_world *= unit;
    there.target_world *= unit;
    return judge_positions(device, {.samples = field, .filter = Filter::Interpolating}, there);
}

/// Samples on the surface are denormal instead of zero.
Worst denormals_at_the_surface(Device& device) {
    Random random(2);
    const auto slab = unit_field(n, [&](const Vec3d& p) {
        const double d = std::abs(p.z() - 13) - 4;
        return d == 0 ? random.uniform(-1, 1) * 1e-42 : d;
    });
    return judge_search(device, {.samples = slab}, {camera}, {40, 40});
}

/// A value far above all others in a corner where no surface is.
Worst a_spike_far_off(Device& device, double spike) {
    const auto field = unit_field(n, [&](const Vec3d& p) {
        return p == Vec3d(26, 26, 26) ? spike : (p - middle).norm() - 9;
    });
    return judge_positions(device, {.samples = field, .filter = Filter::BSpline}, camera);
}

/// An offset that is taken off: f + 2^20 at iso 2^20, the samples being exact.
Worst iso_far_from_zero(Device& device) {
    const auto rounded = [](double offset) {
        return unit_field(n, [=](const Vec3d& p) {
            return offset + std::round(((p - middle).norm() - 9) * 8) / 8;
        });
    };
    Subject subject{.samples = rounded(0x1p20)};
    subject.iso = 0x1p20;
    return same_pictures(hits_of(device, {.samples = rounded(0)}, camera),
                         hits_of(device, subject, camera));
}

} // namespace

void append_unit_cases(std::vector<Case>& cases) {
    const auto add = [&](const std::string& name, const char* compares, double bound,
                         const char* from, auto run) {
        append(cases, {name, compares, bound, from, run});
    };
    const char* plane = "gradients of a plane and its normal";
    const char* sums = "samples up to 25 round to 2^-20, sums of 64 products";
    for (const auto& [name, scale] :
         {std::pair{"normals.plane", 1.0}, std::pair{"normals.plane-in-1e-9", 1e-9},
          std::pair{"normals.plane-in-1e9", 1e9}})
        add(name, plane, 16 * 0x1p-20, sums,
            [scale = scale](Device& device) { return normals_of_a_plane(device, scale); });

    const char* curvatures = "k1 and k2 in the picture and the shape's [1/voxel]";
    const char* order = "the spline's second order, h^2/12 of fourth derivatives, and roundings";
    const Vec3d axis = Vec3d(0.3, 1, 0.5);
    // Fourth derivatives of |p| are at most 9/r^3.
    add("curvatures.sphere", curvatures, 9 / std::pow(9, 3) / 12 * 3, order, [](Device& device) {
        return curvatures_of(device, sphere_field(middle, 9), FrameImage::Curvature);
    });
    add("curvatures.torus", curvatures, 15 / std::pow(3, 3) / 12, order, [axis](Device& device) {
        return curvatures_of(device, torus_field(middle, axis, 7, 3), FrameImage::Curvature);
    });
    add("curvatures.cylinder", curvatures, 9 / std::pow(5, 3) / 12 * 3, order,
        [axis](Device& device) {
            return curvatures_of(device, cylinder_field(middle, axis, 5), FrameImage::Curvature);
        });
    add("curvatures.plane", curvatures, 64 * 0x1p-20, sums, [axis](Device& device) {
        const Vec3d normal = axis.normalized();
        return curvatures_of(device,
                             {"plane",
                              [=](const Vec3d& p) {
                                  return Jet{normal.dot(p - middle), normal, Mat3d::Zero()};
                              }},
                             FrameImage::Curvature);
    });
    add("curvatures.flow-lines-of-a-sphere", "flow line curvature of a sphere and none [1/voxel]",
        9 / std::pow(9, 3) / 12 * 3, order, [](Device& device) {
            return curvatures_of(device, sphere_field(middle, 9), FrameImage::FlowLineCurvature);
        });
    for (const FrameImage image : {FrameImage::Curvature, FrameImage::Direction})
        add(image == FrameImage::Curvature ? "curvatures.no-gradient" : "directions.no-gradient",
            "where the gradient vanishes and zero, flagged", 0, "defined so",
            [image](Device& device) { return no_gradient_is_flagged(device, image); });
    for (const auto& [name, scale] :
         {std::pair{"curvatures.umbilics", 1.0}, std::pair{"curvatures.umbilics-in-1e-9", 1e-9},
          std::pair{"curvatures.umbilics-in-1e9", 1e9}})
        add(name, "flags on a quadratic sphere and umbilics; directions are tangents", 0,
            "all that is left of k1 - k2 are roundings",
            [scale = scale](Device& device) { return umbilics_are_flagged(device, scale); });
    add("derivatives.noise", "derivatives on white noise and numbers", 0, "finite",
        finite_on_noise);

    const char* bits = "hits, gradients and curvatures of a ball times a power of two";
    for (const int exponent : {-90, -30, 30, 90})
        add("units.values-2^" + std::to_string(exponent), bits, 0, "bit for bit",
            [exponent](Device& device) { return values_scale_exactly(device, exponent, {}); });
    for (const int exponent : {-20, 20})
        add("units.norm16-2^" + std::to_string(exponent), bits, 0, "bit for bit",
            [exponent](Device& device) {
                return values_scale_exactly(device, exponent, {.format = SampleFormat::Norm16});
            });
    const char* positions = "hits and the double caster's, along each ray [voxels]";
    const char* tolerance = "as view.*";
    add("units.denormal-values", positions, 1e-3, tolerance,
        [](Device& device) { return positions_in_units(device, 0x1p-140); });
    for (const auto& [name, unit] : {std::pair{"1e-9", 1e-9}, std::pair{"1e9", 1e9}}) {
        add(std::string("units.values-in-") + name, positions, 1e-3, tolerance,
            [unit = unit](Device& device) { return positions_in_units(device, unit); });
        add(std::string("units.world-in-") + name, positions, 1e-3, tolerance,
            [unit = unit](Device& device) { return world_in_units(device, unit); });
    }
    add("units.denormals-at-the-surface", "values at hits over what float32 makes of them", 1,
        "as search.*", denormals_at_the_surface);
    for (const auto& [name, spike] : {std::pair{"1e6", 1e6}, std::pair{"1e15", 1e15}})
        add(std::string("units.spike-of-") + name, positions, 1e-3, tolerance,
            [spike = spike](Device& device) { return a_spike_far_off(device, spike); });
    add("units.iso-2^20", "hits of f at 0 and of f + 2^20 at 2^20", 0, "bit for bit",
        iso_far_from_zero);
}

} // namespace isocast::stability
