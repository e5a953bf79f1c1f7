// teem's miter, in a child process.
// SPDX-License-Identifier: MPL-2.0
#include "peers/child.h"
#include "peers/peer_frame.h"
#include "peers/programs.h"
#include "volume/errors.h"
#include "volume/files.h"

#include <fmt/format.h>

#include <fstream>

namespace isocast {

namespace {

/// Opaque where the value is negative.
void write_opacity(const std::string& path, double half_width_world) {
    std::ofstream(path) << "NRRD0001\ntype: float\ndimension: 2\nsizes: 1 2\n"
                        << fmt::format("axis mins: NaN {}\naxis maxs: NaN {}\n", -half_width_world,
                                       half_width_world)
                        << "labels: \"A\" \"gage(v)\"\nencoding: ascii\n\n1 0\n";
}

/// Colours by the two principal curvatures, up to one in four voxels.
void write_colours(const std::string& path, double voxel_size_world) {
    const double greatest = 0.25 / voxel_size_world;
    std::ofstream file(path);
    file << "NRRD0001\ntype: float\ndimension: 3\nsizes: 3 16 16\n"
         << fmt::format("axis mins: NaN {0} {0}\naxis maxs: NaN {1} {1}\n", -greatest, greatest)
         << "labels: \"RGB\" \"gage(k1)\" \"gage(k2)\"\nencoding: ascii\n\n";
    for (int k2 = 0; k2 < 16; ++k2)
        for (int k1 = 0; k1 < 16; ++k1) file << k1 / 15. << " 0.5 " << k2 / 15. << "\n";
}

} // namespace

PeerFrame teem_peer(const PeerScene& scene) {
    const std::string name = "teem miter, B-spline, curvature";
    if (miter_program.empty() || unu_program.empty())
        return {.name = name, .note = "not built (package teem-apps)"};
    const double voxel = scene.field.space().voxel_size_world();
    const ScratchFolder folder;
    write_nrrd(scene.field, folder / "field.nrrd");
    write_opacity(folder / "opacity.nrrd", scene.field.background_world());
    write_colours(folder / "colours.nrrd", voxel);

    // Rays run from plane to plane, beyond the sphere around the target that holds the field.
    double radius = 0;
    const IndexBox box = scene.field.extent();
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3d p_index((corner & 1 ? box.hi : box.lo).x(), (corner & 2 ? box.hi : box.lo).y(),
                            (corner & 4 ? box.hi : box.lo).z());
        radius =
            std::max(radius, (scene.field.space().to_world(p_index) - scene.target_world).norm());
    }
    const auto vector = [](const Vec3d& v) {
        return fmt::format("{:.17g} {:.17g} {:.17g}", v.x(), v.y(), v.z());
    };
    // Right-handed: rows from the top. cubic:1,0 is the B-spline.
    const std::string output = run_child(fmt::format(
        "'{}' -i {} -txf {} {} -fr {} -at {} -up {} -rh -ar -dn {} -di 0 -df {} -fv {} -is {} {} "
        "-k00 cubic:1,0 -k11 cubicd:1,0 -k22 cubicdd:1,0 -side -1 -step {} -ref {} -nt {} -o {}",
        miter_program, folder / "field.nrrd", folder / "opacity.nrrd", folder / "colours.nrrd",
        vector(scene.eye_world), vector(scene.target_world), vector(scene.up), -radius, radius,
        scene.fov_degrees, scene.size, scene.size, voxel, voxel, scene.threads,
        folder / "picture.nrrd"));
    const std::string key = "rendering time = ";
    const auto at = output.find(key);
    if (at == std::string::npos)
        throw ResourceError("miter did not say how long it rendered:\n" + output);
    const double frame_seconds = std::stod(output.substr(at + key.size()));

    // The picture holds RGBA and depth.
    run_child(fmt::format("'{0}' slice -a 0 -p 3 -i {1} | '{0}' 2op gt - 0.5 | "
                          "'{0}' convert -t uchar | '{0}' save -f pnm -o {2}",
                          unu_program, folder / "picture.nrrd", folder / "mask.pgm"));
    return peer_frame(name, "cubic B-spline, k1 and k2, step 1, no root; one frame",
                      std::numeric_limits<double>::quiet_NaN(), frame_seconds,
                      read_mask(folder / "mask.pgm", scene.size, scene.size));
}

} // namespace isocast
