// An octree as a field source: samples at any level, without a dense grid.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/field_source.h"
#include "volume/hashed_octree.h"

#include <memory>

namespace isocast {

/// The interpolant of an octree at the corners of the cells of one level, its lattice.
///
/// It has no band: every sample holds the interpolant's own value. Isosurfaces at up to ± reach are
/// found.
class OctreeField final : public FieldSource {
public:
    /// space         of the finest cells
    /// reach_world   >= 0
    /// lattice       level of the cells between whose corners samples lie
    OctreeField(std::shared_ptr<const HashedOctree> tree, const GridSpace& space,
                double reach_world, int lattice = 0);

    const std::shared_ptr<const HashedOctree>& tree() const { return tree_; }
    int lattice() const { return lattice_; }
    const GridSpace& space() const override { return space_; }
    IndexBox extent() const override;
    std::optional<double> half_width_world() const override { return std::nullopt; }
    /// Blocks of 8^3 cells, or larger leaves, that hold an isosurface within reach.
    std::vector<IndexBox> active_boxes() const override;
    /// Of the leaves that hold an isosurface within reach, above the lattice; greatest_octree_depth
    /// where there is none. Below 0 in blocks that another field of fields_of_octree() shows.
    int finest_level(const IndexBox& box) const override;
    bool is_adaptive() const override { return true; }
    ValueRange value_range(const IndexBox& box) const override;
    void copy_box(const IndexBox& box, int level, std::span<float> out) const override;

private:
    friend std::vector<std::shared_ptr<const OctreeField>>
    fields_of_octree(std::shared_ptr<const HashedOctree> tree, const GridSpace& space,
                     double reach_world, std::size_t greatest_block_count);

    bool is_in_reach(const OctreeCell& leaf) const;
    /// The finest leaf in a cell that holds an isosurface within reach.
    int finest_leaf(const OctreeCell& cell) const;
    /// Calls at_leaf(leaf, part) for the leaves under `cell` that hold a part of the box, in
    /// samples 2^level finest cells apart.
    template<class AtLeaf>
    void visit_leaves(const OctreeCell& cell, const IndexBox& box, int level,
                      const AtLeaf& at_leaf) const;
    /// A box of the lattice's samples, with the finest cells' corners between them.
    IndexBox finest_box(const IndexBox& box) const;

    std::shared_ptr<const HashedOctree> tree_;
    GridSpace space_;
    double reach_world_;
    int lattice_;
    /// Sorted; those that are shown, if not all.
    std::optional<std::vector<OctreeCell>> blocks_;
};

/// The fields that together show an octree's isosurfaces: one, on the lattice of the finest leaf
/// that holds a piece, if its blocks of 8^3 cells there are few (2^18 bricks of a cell each take 67
/// MB); else one for each four levels, and
/// each block is shown by the coarsest of them that has all of its detail.
std::vector<std::shared_ptr<const OctreeField>>
fields_of_octree(std::shared_ptr<const HashedOctree> tree, const GridSpace& space,
                 double reach_world, std::size_t greatest_block_count = 1 << 18);

} // namespace isocast
