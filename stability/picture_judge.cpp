// SPDX-License-Identifier: MPL-2.0
#include "stability/picture_judge.h"

#include "raycaster/primitives_reference.h"
#include "stability/search_oracle.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace isocast::stability {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Calls judge(x, y) -> Worst for all pixels, on all threads.
template<class JudgePixel>
Worst over_pixels(const PictureSize& size, const JudgePixel& judge) {
    std::vector<Worst> rows(static_cast<std::size_t>(size.height));
    tbb::parallel_for(0, size.height, [&](int y) {
        for (int x = 0; x < size.width; ++x) rows[static_cast<std::size_t>(y)].see(judge(x, y));
    });
    Worst worst;
    for (const Worst& row : rows) worst.see(row);
    return worst;
}

Worst judge_pixel(const SearchOracle& oracle, const Camera& camera, const PictureSize& size,
                  const float* hit, int x, int y) {
    Worst out;
    const double place = SearchOracle::place_error_voxels;
    const Ray ray = unit_ray(camera, size.width, size.height, x, y);
    const Vec3d& d = ray.direction_world;
    const auto [t_in, t_out] = span_in(ray, oracle.control().extent());
    const Vec3d p_hit = camera.eye_world + Vec3d(hit[0], hit[1], hit[2]);
    const double t_hit = (p_hit - ray.origin_world).dot(d);
    const bool is_hit = hit[3] != 0;
    if (is_hit) {
        const bool is_on_its_way = (p_hit - ray.origin_world - t_hit * d).norm() < place &&
                                   t_hit > t_in - place && t_hit < t_out + place;
        out.must(is_on_its_way);
        out.see(std::abs(oracle.exact().value(p_hit)) / oracle.value_error());
    }
    if (!(t_in <= t_out)) return out;
    const double before = oracle.exact().value(ray.origin_world + t_in * d);
    // Where the ray starts on the surface it may be taken for either side.
    if (std::abs(before) <= oracle.value_error()) return out;
    const auto certain = oracle.first_certain(ray, before < 0, t_out);
    if (!certain) return out;
    if (!is_hit) {
        out.see(infinity);
        return out;
    }
    const double t_root = oracle.exact().hit(ray).value_or(*certain);
    const double slope = std::abs(oracle.exact().gradient(ray.origin_world + t_root * d).dot(d));
    // To first order the error of the value over the slope, on each side of the root.
    out.must(t_hit <= *certain + place + 1e-5 + 2 * oracle.value_error() / slope);
    return out;
}

} // namespace

Image hits_of(Device& device, const Subject& subject, const Camera& camera,
              const PictureSize& size) {
    device.renderer.load({.field = subject.samples,
                          .iso_world = subject.iso,
                          .filter = subject.filter,
                          .storage = subject.storage,
                          .quality = subject.quality});
    device.renderer.draw(camera, size.width, size.height, {FrameImage::Hit});
    return device.renderer.read(FrameImage::Hit);
}

Worst judge_search(Device& device, const Subject& subject, const std::vector<Camera>& cameras,
                   const PictureSize& size) {
    std::vector<Image> images;
    for (const Camera& camera : cameras) images.push_back(hits_of(device, subject, camera, size));
    SearchOracle oracle(subject.samples, subject.filter, subject.iso,
                        subject.quality.guarantee_voxels, device.renderer.pool().storage_error());
    oracle.prepare(cameras, size.width, size.height);
    Worst worst;
    for (std::size_t i = 0; i < cameras.size(); ++i)
        worst.see(over_pixels(size, [&](int x, int y) {
            return judge_pixel(oracle, cameras[i], size, images[i].pixel(x, y), x, y);
        }));
    return worst;
}

Worst judge_positions(Device& device, const Subject& subject, const Camera& camera,
                      const PictureSize& size) {
    const Image image = hits_of(device, subject, camera, size);
    const auto control = control_samples(subject.samples, subject.filter);
    const ReferenceCaster reference(*control, subject.iso, {.kernel = kernel_of(subject.filter)});
    const double voxel = control->space().voxel_size_world();
    return over_pixels(size, [&](int x, int y) {
        Worst out;
        const Ray ray = unit_ray(camera, size.width, size.height, x, y);
        const auto t = reference.hit(ray);
        const float* hit = image.pixel(x, y);
        if (t.has_value() != (hit[3] != 0)) {
            out.see(infinity);
        } else if (t) {
            const Vec3d p = ray.origin_world - camera.eye_world + *t * ray.direction_world;
            out.see((Vec3d(hit[0], hit[1], hit[2]) - p).norm() / voxel);
        }
        return out;
    });
}

Worst judge_primitives(Device& device, Primitives primitives, const Camera& camera,
                       const PictureSize& size, const Cut& cut) {
    // Numbered by their colours, which floats hold exactly.
    double number = 1;
    for_each_kind(primitives, [&](auto& some) {
        for (auto& primitive : some) primitive.colour = Vec3d(number++, 0, 0);
    });
    for (TriangleMesh& mesh : primitives.meshes) mesh.colour = Vec3d(number++, 0, 0);
    // Triangles are numbered one by one, colours are of meshes: one triangle a mesh.
    device.renderer.load({.primitives = std::make_shared<Primitives>(primitives), .cut = cut});
    device.renderer.draw(camera, size.width, size.height,
                         {FrameImage::Hit, FrameImage::SplatColour});
    const Image hits = device.renderer.read(FrameImage::Hit);
    const Image colours = device.renderer.read(FrameImage::SplatColour);
    const std::vector<SeenPrimitive> shown =
        cast_primitives(primitives, camera, size.width, size.height, cut);
    return over_pixels(size, [&](int x, int y) {
        Worst out;
        const float* hit = hits.pixel(x, y);
        const SeenPrimitive& seen =
            shown[static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width) +
                  static_cast<std::size_t>(x)];
        const bool is_right = (hit[3] != 0) == (seen.number >= 0) &&
                              (seen.number < 0 || colours.pixel(x, y)[0] == seen.number + 1);
        if (!is_right) {
            out.see(infinity);
        } else if (seen.number >= 0) {
            const Ray ray = camera_ray(camera, size.width, size.height, x + 0.5, y + 0.5);
            const Vec3d p = ray.origin_world - camera.eye_world + ray.direction_world * seen.t;
            out.see(std::abs(seen.normal.dot(Vec3d(hit[0], hit[1], hit[2]) - p)) / p.norm());
        }
        return out;
    });
}

Worst same_pictures(const Image& a, const Image& b) {
    Worst worst;
    int seen = 0;
    for (std::size_t i = 0; i < a.rgba.size(); ++i) {
        worst.must(a.rgba[i] == b.rgba[i]);
        seen += i % 4 == 3 && a.rgba[i] != 0;
    }
    worst.must(seen > 0 && a.rgba.size() == b.rgba.size());
    return worst;
}

} // namespace isocast::stability
