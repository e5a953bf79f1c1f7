// A mesh of the surface under Embree's rays.
// SPDX-License-Identifier: MPL-2.0
#include "peers/peer_frame.h"
#include "peers/surface_mesh.h"
#include "volume/errors.h"

#include <embree3/rtcore.h>
#include <fmt/format.h>
#include <tbb/blocked_range2d.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <numbers>

namespace isocast {

namespace {

using Vec3f = Eigen::Vector3f;

/// A mesh in Embree's tree.
class MeshTree {
public:
    MeshTree(const SurfaceMesh& mesh, int threads)
        : device_(rtcNewDevice(fmt::format("threads={}", threads).c_str())) {
        if (!device_) throw ResourceError("Embree makes no device");
        scene_ = rtcNewScene(device_);
        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* points = static_cast<float*>(
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                    sizeof(Vec3f), mesh.points_world.size()));
        auto* triangles = static_cast<std::uint32_t*>(
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                    3 * sizeof(std::uint32_t), mesh.triangles.size()));
        if (!points || !triangles) throw ResourceError("Embree has no memory for the mesh");
        for (const Vec3f& p : mesh.points_world) points = std::copy_n(p.data(), 3, points);
        for (const auto& corners : mesh.triangles)
            triangles = std::copy_n(corners.data(), 3, triangles);
        const auto start = std::chrono::steady_clock::now();
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene_, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene_);
        build_seconds_ = seconds_since(start);
    }
    ~MeshTree() {
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
    }
    MeshTree(const MeshTree&) = delete;
    MeshTree& operator=(const MeshTree&) = delete;

    RTCScene scene() const { return scene_; }
    double build_seconds() const { return build_seconds_; }

private:
    RTCDevice device_;
    RTCScene scene_;
    double build_seconds_;
};

/// Rays through pixels.
struct Rays {
    Vec3f eye;
    Vec3f first; // through the top left corner of the picture
    Vec3f right; // one pixel
    Vec3f down;  // one pixel

    explicit Rays(const PeerScene& scene) : eye(scene.eye_world.cast<float>()) {
        const Vec3d forward = (scene.target_world - scene.eye_world).normalized();
        const Vec3d to_right = forward.cross(scene.up).normalized();
        const Vec3d to_top = to_right.cross(forward);
        const double half = std::tan(scene.fov_degrees * std::numbers::pi / 360);
        first = (forward + half * (to_top - to_right)).cast<float>();
        right = (2 * half / scene.size * to_right).cast<float>();
        down = (-2 * half / scene.size * to_top).cast<float>();
    }
};

struct Pixel {
    Vec3f colour;
    bool is_covered;
};

// Packets are of 4 x 2 pixels.
constexpr int packet_width = 4;
constexpr int packet_height = 2;
constexpr int packet_size = packet_width * packet_height;

/// The light is at the eye, as with OpenVDB's DiffuseShader; the colour is the normal's.
void trace_packet(const MeshTree& tree, const SurfaceMesh& mesh, const Rays& rays, int size,
                  int x_lo, int y_lo, std::vector<Pixel>& picture) {
    alignas(32) std::array<int, packet_size> valid;
    alignas(32) RTCRayHit8 packet;
    for (int i = 0; i < packet_size; ++i) {
        const int x = x_lo + i % packet_width;
        const int y = y_lo + i / packet_width;
        valid[static_cast<std::size_t>(i)] = x < size && y < size ? -1 : 0;
        const Vec3f direction =
            rays.first + (float(x) + 0.5f) * rays.right + (float(y) + 0.5f) * rays.down;
        packet.ray.org_x[i] = rays.eye.x();
        packet.ray.org_y[i] = rays.eye.y();
        packet.ray.org_z[i] = rays.eye.z();
        packet.ray.dir_x[i] = direction.x();
        packet.ray.dir_y[i] = direction.y();
        packet.ray.dir_z[i] = direction.z();
        packet.ray.tnear[i] = 0;
        packet.ray.tfar[i] = std::numeric_limits<float>::infinity();
        packet.ray.time[i] = 0;
        packet.ray.mask[i] = ~0u;
        packet.ray.id[i] = 0;
        packet.ray.flags[i] = 0;
        packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
        packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect8(valid.data(), tree.scene(), &context, &packet);
    for (int i = 0; i < packet_size; ++i) {
        if (!valid[static_cast<std::size_t>(i)]) continue;
        Pixel& pixel = picture[static_cast<std::size_t>(y_lo + i / packet_width) *
                                   static_cast<std::size_t>(size) +
                               static_cast<std::size_t>(x_lo + i % packet_width)];
        pixel.is_covered = packet.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
        if (!pixel.is_covered) {
            pixel.colour = Vec3f::Zero();
            continue;
        }
        const auto& [a, b, c] = mesh.triangles[packet.hit.primID[i]];
        const float u = packet.hit.u[i];
        const float v = packet.hit.v[i];
        const Vec3f normal =
            ((1 - u - v) * mesh.normals[a] + u * mesh.normals[b] + v * mesh.normals[c])
                .normalized();
        const Vec3f direction(packet.ray.dir_x[i], packet.ray.dir_y[i], packet.ray.dir_z[i]);
        const float lit = std::abs(normal.dot(direction)) / direction.norm();
        pixel.colour = 0.5f * lit * (normal + Vec3f::Ones());
    }
}

} // namespace

PeerFrame embree_peer(const PeerScene& scene) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism,
                                      static_cast<std::size_t>(scene.threads));
    const SurfaceMesh mesh = extract_surface(scene.field);
    const MeshTree tree(mesh, scene.threads);
    const Rays rays(scene);
    const auto size = static_cast<std::size_t>(scene.size);
    std::vector<Pixel> picture(size * size);
    const double frame_seconds = median_seconds(scene.repeats, [&] {
        // In packets; 8 x 4 of them, or 32 x 8 pixels, are one task.
        const int columns = (scene.size + packet_width - 1) / packet_width;
        const int rows = (scene.size + packet_height - 1) / packet_height;
        tbb::parallel_for(tbb::blocked_range2d<int>(0, rows, 4, 0, columns, 8),
                          [&](const tbb::blocked_range2d<int>& tile) {
                              for (int y = tile.rows().begin(); y < tile.rows().end(); ++y)
                                  for (int x = tile.cols().begin(); x < tile.cols().end(); ++x)
                                      trace_packet(tree, mesh, rays, scene.size, packet_width * x,
                                                   packet_height * y, picture);
                          });
    });
    std::vector<bool> covered;
    for (const Pixel& pixel : picture) covered.push_back(pixel.is_covered);
    return peer_frame(
        "mesh on Embree",
        fmt::format("{} triangles; setup: {} {:.3f} s + tree {:.3f} s", mesh.triangles.size(),
                    mesh.extractor, mesh.extraction_seconds, tree.build_seconds()),
        mesh.extraction_seconds + tree.build_seconds(), frame_seconds, std::move(covered));
}

} // namespace isocast
