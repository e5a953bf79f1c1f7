// SPDX-License-Identifier: MPL-2.0
#include "peers/peer_frame.h"

#include <algorithm>

namespace isocast {

PeerScene scene_of_the_table(const SparseField& field, int resolution) {
    const IndexBox box = field.extent();
    const Vec3d middle = 0.5 * ((box.lo + box.hi).cast<double>() - Vec3d::Ones());
    const Vec3d target = field.space().to_world(middle);
    const double distance = 2.2 * resolution * field.space().voxel_size_world();
    return {.field = field,
            .eye_world = target + distance * Vec3d(0.45, 0.35, 1).normalized(),
            .target_world = target};
}

double median_seconds(int repeats, const std::function<void()>& draw) {
    draw();
    std::vector<double> seconds;
    for (int i = 0; i < repeats; ++i) {
        const auto start = std::chrono::steady_clock::now();
        draw();
        seconds.push_back(seconds_since(start));
    }
    return median(std::move(seconds));
}

PeerFrame peer_frame(std::string name, std::string note, double setup_seconds, double frame_seconds,
                     std::vector<bool> covered) {
    const auto count = std::ranges::count(covered, true);
    return {.name = std::move(name),
            .note = std::move(note),
            .setup_seconds = setup_seconds,
            .frame_seconds = frame_seconds,
            .covered_fraction = double(count) / double(covered.size()),
            .covered = std::move(covered)};
}

} // namespace isocast
