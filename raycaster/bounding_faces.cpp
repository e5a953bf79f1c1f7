// SPDX-License-Identifier: MPL-2.0
#include "raycaster/bounding_faces.h"

#include <algorithm>

namespace isocast {

std::vector<Eigen::Vector4i> bounding_faces(const ActiveBlocks& blocks,
                                            const Index3& local_origin_index) {
    const auto is_before = [](const Index3& a, const Index3& b) {
        return std::tie(a.z(), a.y(), a.x()) < std::tie(b.z(), b.y(), b.x());
    };
    std::vector<Eigen::Vector4i> faces;
    for (const Index3& block : blocks.coordinates)
        for (int face = 0; face < 6; ++face) {
            const Index3 neighbour = block + (face % 2 ? 1 : -1) * Index3::Unit(face / 2);
            if (std::ranges::binary_search(blocks.coordinates, neighbour, is_before)) continue;
            Eigen::Vector4i record;
            record << block * block_size - local_origin_index, face;
            faces.push_back(record);
        }
    return faces;
}

} // namespace isocast
