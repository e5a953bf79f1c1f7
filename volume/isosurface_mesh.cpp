// SPDX-License-Identifier: MPL-2.0
#include "volume/isosurface_mesh.h"

#include <algorithm>
#include <array>
#include <unordered_map>

namespace isocast {

namespace {

/// Vertices of cells, by the cells' lowest corners.
class CellVertices {
public:
    /// The vertex of `cell`, to which a crossing is added.
    int add(const Index3& cell, const Vec3d& crossing_index) {
        // 21 bits an axis, more than a lattice in memory has samples along it.
        std::uint64_t key = 0;
        for (const int at : cell) key = key << 21 | (static_cast<std::uint32_t>(at) & 0x1fffff);
        const auto [found, is_new] = numbers_.try_emplace(key, static_cast<int>(sums_.size()));
        if (is_new) sums_.emplace_back(Eigen::Vector4d::Zero());
        sums_[static_cast<std::size_t>(found->second)] += crossing_index.homogeneous();
        return found->second;
    }
    std::vector<Vec3d> means(const GridSpace& space) const {
        std::vector<Vec3d> means;
        means.reserve(sums_.size());
        for (const Eigen::Vector4d& sum : sums_) means.push_back(space.to_world(sum.hnormalized()));
        return means;
    }

private:
    std::unordered_map<std::uint64_t, int> numbers_;
    std::vector<Eigen::Vector4d> sums_; // of crossings, and how many
};

/// Boxes of at most 64^3 samples that together are `box`.
std::vector<IndexBox> chunks_of(const IndexBox& box) {
    constexpr int edge = 64;
    std::vector<IndexBox> chunks;
    for (int z = box.lo.z(); z < box.hi.z(); z += edge)
        for (int y = box.lo.y(); y < box.hi.y(); y += edge)
            for (int x = box.lo.x(); x < box.hi.x(); x += edge)
                chunks.push_back(
                    {{x, y, z}, box.hi.cwiseMin(Index3(x + edge, y + edge, z + edge))});
    return chunks;
}

} // namespace

IsosurfaceMesh isosurface_mesh(const FieldSource& field, double iso_world) {
    const IndexBox extent = field.extent();
    IsosurfaceMesh mesh;
    CellVertices vertices;
    std::vector<float> samples;
    const auto visit = [&](const IndexBox& chunk) {
        // With a sample above, where an edge from the last one ends.
        const IndexBox read{chunk.lo, (chunk.hi.array() + 1).matrix()};
        const ValueRange range = field.value_range(read);
        if (range.min >= iso_world || range.max < iso_world) return;
        samples.resize(static_cast<std::size_t>(read.sample_count()));
        field.copy_box(read, 0, samples);
        const Index3 size = read.hi - read.lo;
        const std::array<std::size_t, 3> strides{1, static_cast<std::size_t>(size.x()),
                                                 static_cast<std::size_t>(size.x() * size.y())};
        for (int z = chunk.lo.z(); z < chunk.hi.z(); ++z)
            for (int y = chunk.lo.y(); y < chunk.hi.y(); ++y)
                for (int x = chunk.lo.x(); x < chunk.hi.x(); ++x) {
                    const Index3 at(x, y, z);
                    const Index3 from = at - read.lo;
                    const std::size_t place = static_cast<std::size_t>(from.x()) +
                                              strides[1] * static_cast<std::size_t>(from.y()) +
                                              strides[2] * static_cast<std::size_t>(from.z());
                    const double here = samples[place] - iso_world;
                    for (int axis = 0; axis < 3; ++axis) {
                        if (at[axis] + 1 >= extent.hi[axis]) continue;
                        const double next =
                            samples[place + strides[static_cast<std::size_t>(axis)]] - iso_world;
                        if ((here < 0) == (next < 0)) continue;
                        const Vec3d crossing =
                            at.cast<double>() + Vec3d::Unit(axis) * (here / (here - next));
                        const Index3 u = Index3::Unit((axis + 1) % 3);
                        const Index3 v = Index3::Unit((axis + 2) % 3);
                        const int a = vertices.add(at, crossing);
                        const int b = vertices.add(at - u, crossing);
                        const int c = vertices.add(at - u - v, crossing);
                        const int d = vertices.add(at - v, crossing);
                        mesh.triangles.emplace_back(a, b, c);
                        mesh.triangles.emplace_back(a, c, d);
                    }
                }
    };
    for (const IndexBox& box : field.active_boxes())
        for (const IndexBox& chunk : chunks_of(box)) visit(chunk);
    mesh.vertices_world = vertices.means(field.space());
    return mesh;
}

} // namespace isocast
