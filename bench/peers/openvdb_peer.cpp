// OpenVDB's own tracer of level sets.
// SPDX-License-Identifier: MPL-2.0
#include "peers/peer_frame.h"
#include "volume/vdb_grid.h"

#include <openvdb/tools/RayTracer.h>
#include <tbb/global_control.h>

namespace isocast {

namespace {

openvdb::Vec3R vdb_vector(const Vec3d& v) {
    return {v.x(), v.y(), v.z()};
}

} // namespace

PeerFrame openvdb_peer(const PeerScene& scene) {
    using namespace openvdb::tools;
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism,
                                      static_cast<std::size_t>(scene.threads));
    openvdb::initialize();
    const openvdb::FloatGrid::Ptr grid = to_vdb_grid(scene.field);

    // No shade of a NormalShader is negative. The film's alpha would not tell: it is lost on hits
    // and misses alike.
    const Film::RGBA missed(-1.f);
    const auto size = static_cast<std::size_t>(scene.size);
    Film film(size, size, missed);
    const double aperture = 1; // any: only its ratio to the focal length counts
    PerspectiveCamera camera(
        film, openvdb::Vec3R(0), vdb_vector(scene.eye_world),
        PerspectiveCamera::fieldOfViewToFocalLength(scene.fov_degrees, aperture), aperture);
    camera.lookAt(vdb_vector(scene.target_world), vdb_vector(scene.up));

    const auto start = std::chrono::steady_clock::now();
    const LevelSetRayIntersector<openvdb::FloatGrid> intersector(*grid);
    const double setup_seconds = seconds_since(start);
    const NormalShader<> shader;
    const double frame_seconds = median_seconds(scene.repeats, [&] {
        film.fill(missed);
        rayTrace(*grid, intersector, shader, camera);
    });

    std::vector<bool> covered;
    for (std::size_t i = 0; i < film.numPixels(); ++i) covered.push_back(film.pixels()[i].r >= 0);
    return peer_frame("OpenVDB LevelSetRayIntersector", "trilinear; setup: the intersector alone",
                      setup_seconds, frame_seconds, std::move(covered));
}

} // namespace isocast
