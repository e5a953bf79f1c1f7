// A mesh measured in an octree's finest cells, and which of these it meets, by brute force.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/exact_distance.h"
#include "distance_transform/mesh.h"

#include <vector>

namespace isocast {

/// In the middle of [0, 2^depth]^3, its longest side `margin_cells` from two faces.
Mesh mesh_in_cells(const Mesh& mesh, int depth, double margin_cells = 2);

void add_mesh(const Mesh& part, Mesh& whole);

/// Tetrahedra 30 times as long as thick, at random places and in random directions in [0,
/// 2^depth]^3, each with some cells of free space around it.
std::vector<Mesh> needles_in_cells(int depth, double thickness, unsigned seed);

/// Whether no axis separates them: the cube's three, the triangle's normal, and the nine that are
/// normal to an edge of each.
/// source  Akenine-Möller 2001, from the theorem, without his order of tests
bool meet(const std::array<Vec3d, 3>& triangle, const Cube& cube);

/// A set of the cells of edge 1 in [0, 2^depth]^3.
class CellSet {
public:
    explicit CellSet(int depth) : depth_(depth), is_in_(std::size_t{1} << 3 * depth) {}
    bool contains(const Index3& cell) const { return is_in_[place_of(cell)]; }
    void insert(const Index3& cell) { is_in_[place_of(cell)] = true; }
    std::size_t count() const;
    int across() const { return 1 << depth_; }

private:
    std::size_t place_of(const Index3& cell) const {
        const Eigen::Matrix<std::size_t, 3, 1> at = cell.cast<std::size_t>();
        return at.x() | at.y() << depth_ | at.z() << 2 * depth_;
    }
    int depth_;
    std::vector<bool> is_in_;
};

/// Cells that a triangle meets, each triangle against all cells of its box.
/// grown_by  cells are larger by this on each side, or smaller
CellSet surface_cells(const Mesh& mesh, int depth, double grown_by = 0);

} // namespace isocast
