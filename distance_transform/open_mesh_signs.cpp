// Signs away from the band of a mesh that is not closed, by winding numbers block by block.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/open_mesh_signs.h"

#include "distance_transform/block_signs.h"
#include "distance_transform/progress_meter.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <optional>

namespace isocast {

namespace {

constexpr int last = block_size - 1;

int index_of(const Index3& sample) {
    return sample.x() + block_size * (sample.y() + block_size * sample.z());
}

/// Index of sample (u, v) of a block's layer `at` across `axis`.
int layer_index(int axis, int at, int u, int v) {
    Index3 sample;
    sample[axis] = at;
    sample[(axis + 1) % 3] = u;
    sample[(axis + 2) % 3] = v;
    return index_of(sample);
}

bool is_inside(const FieldBlock& block, int i) {
    return block.values[i] < 0;
}

class OutsideSigns {
public:
    OutsideSigns(FieldBlocks& blocks, const WindingNumber& winding, float background,
                 double memory_bytes, const Progress& progress)
        : blocks_(blocks), winding_(winding), background_(background), progress_(progress) {
        Index3 least = blocks.front().coordinate;
        Index3 greatest = least;
        for (const FieldBlock& block : blocks) {
            least = least.cwiseMin(block.coordinate);
            greatest = greatest.cwiseMax(block.coordinate);
        }
        // One cell more at high x, where the rule must give + to what lies beyond.
        box_ = {least, greatest + Index3(2, 1, 1)};
        const Vec3d size = box_.size().cast<double>();
        if (size.prod() * sizeof(int) > memory_bytes)
            throw ResourceError(
                fmt::format("the mesh is not closed, and the signs of the {:.3g} blocks of its box "
                            "do not fit in memory; use a larger voxel size",
                            size.prod()));
        cells_.assign(static_cast<std::size_t>(box_.sample_count()), outside);
        for (std::size_t i = 0; i < blocks.size(); ++i)
            cells_[cell_index(blocks[i].coordinate)] = static_cast<int>(i);
    }

    void run() {
        mend_cut_band_blocks();
        sign_missing_cells();
        store_cut_cells();
        store_sign_changes_along_rows();
    }

private:
    // A cell without a block holds one of these, others the index of their block.
    static constexpr int outside = -1;
    static constexpr int inside = -2;

    std::size_t cell_index(const Index3& coordinate) const {
        const Index3 at = coordinate - box_.lo;
        const Index3 size = box_.size();
        return at.x() + std::size_t(size.x()) * (at.y() + std::size_t(size.y()) * at.z());
    }

    bool is_sample_inside(const Index3& block, int i) const {
        return winding_.is_inside((block_size * block + sample_of(i)).cast<double>());
    }

    float background(bool is_negative) const { return is_negative ? -background_ : background_; }

    /// Whether the sign changes between neighbours of which one is inactive, hence not at the
    /// surface, or differs from the winding number's at an inactive corner.
    bool is_cut(const FieldBlock& block) const {
        for (int i = 0; i < samples_per_block; ++i) {
            const Index3 sample = sample_of(i);
            for (int axis = 0; axis < 3; ++axis) {
                if (sample[axis] == last) continue;
                const int next = index_of(sample + Index3::Unit(axis));
                if ((!block.active[i] || !block.active[next]) &&
                    is_inside(block, i) != is_inside(block, next))
                    return true;
            }
        }
        for (int corner = 0; corner < 8; ++corner) {
            const int i = index_of(last * Index3(corner & 1, corner >> 1 & 1, corner >> 2));
            if (!block.active[i] && is_sample_inside(block.coordinate, i) != is_inside(block, i))
                return true;
        }
        return false;
    }

    /// Within the band's blocks the surface w = 1/2 may pass between inactive samples.
    void mend_cut_band_blocks() {
        ProgressMeter meter(progress_, "signs", 2.0 * static_cast<double>(blocks_.size()), 64);
        tbb::parallel_for(std::size_t{0}, blocks_.size(), [&](std::size_t b) {
            FieldBlock& block = blocks_[b];
            if (is_cut(block))
                for (int i = 0; i < samples_per_block; ++i)
                    if (!block.active[i])
                        block.values[i] = background(is_sample_inside(block.coordinate, i));
            meter.add(1);
        });
    }

    void sign_missing_cells() {
        const Index3 size = box_.size();
        const int rows = size.y() * size.z();
        ProgressMeter meter(progress_, "signs", 2.0 * rows, 16);
        meter.add(rows);
        tbb::parallel_for(0, rows, [&](int row) {
            const Index3 first = box_.lo + Index3(0, row % size.y(), row / size.y());
            // The last cell stands for what lies beyond: it stays outside.
            for (int x = 0; x + 1 < size.x(); ++x) {
                const Index3 block = first + Index3(x, 0, 0);
                int& cell = cells_[cell_index(block)];
                if (cell >= 0) continue;
                const int middle = index_of(Index3::Constant(block_size / 2));
                cell = is_sample_inside(block, middle) ? inside : outside;
            }
            meter.add(1);
        });
    }

    bool has_face_of_other_sign(const Index3& block, bool is_negative) const {
        for (int k = 0; k < 6; ++k) {
            const int axis = k / 2;
            const int step = k % 2 == 0 ? -1 : 1;
            const Index3 neighbour = block + step * Index3::Unit(axis);
            if (!box_.contains(neighbour)) continue;
            const int cell = cells_[cell_index(neighbour)];
            if (cell < 0) {
                if ((cell == inside) != is_negative) return true;
                continue;
            }
            const int facing = step < 0 ? last : 0;
            for (int v = 0; v < block_size; ++v)
                for (int u = 0; u < block_size; ++u)
                    if (is_inside(blocks_[cell], layer_index(axis, facing, u, v)) != is_negative)
                        return true;
        }
        return false;
    }

    /// The block sample by sample, if its corners lie on both sides of w = 1/2.
    std::optional<FieldBlock> cut_block(const Index3& coordinate, bool is_negative) const {
        bool differs = false;
        for (int corner = 0; corner < 8 && !differs; ++corner) {
            const int i = index_of(last * Index3(corner & 1, corner >> 1 & 1, corner >> 2));
            differs = is_sample_inside(coordinate, i) != is_negative;
        }
        if (!differs) return std::nullopt;
        FieldBlock block;
        block.coordinate = coordinate;
        for (int i = 0; i < samples_per_block; ++i)
            block.values[i] = background(is_sample_inside(coordinate, i));
        return block;
    }

    /// The surface w = 1/2 is followed from cell to cell, starting wherever neighbours disagree.
    void store_cut_cells() {
        std::vector<Index3> to_examine;
        std::vector<char> is_examined(cells_.size(), 0);
        const auto consider = [&](const Index3& block) {
            // The cell beyond the box is outside by definition.
            if (!box_.contains(block) || block.x() == box_.hi.x() - 1) return;
            const std::size_t at = cell_index(block);
            if (cells_[at] >= 0 || is_examined[at]) return;
            if (!has_face_of_other_sign(block, cells_[at] == inside)) return;
            is_examined[at] = 1;
            to_examine.push_back(block);
        };
        for (int z = box_.lo.z(); z < box_.hi.z(); ++z)
            for (int y = box_.lo.y(); y < box_.hi.y(); ++y)
                for (int x = box_.lo.x(); x < box_.hi.x(); ++x) consider({x, y, z});
        while (!to_examine.empty()) {
            if (progress_) progress_("signs", 1);
            std::vector<std::optional<FieldBlock>> cut(to_examine.size());
            tbb::parallel_for(std::size_t{0}, cut.size(), [&](std::size_t i) {
                const Index3& block = to_examine[i];
                cut[i] = cut_block(block, cells_[cell_index(block)] == inside);
            });
            to_examine.clear();
            const std::size_t before = blocks_.size();
            for (std::optional<FieldBlock>& block : cut)
                if (block) store(*block);
            for (std::size_t b = before; b < blocks_.size(); ++b) {
                const Index3 coordinate = blocks_[b].coordinate;
                for (int k = 0; k < 6; ++k)
                    consider(coordinate + (k % 2 == 0 ? -1 : 1) * Index3::Unit(k / 2));
            }
        }
    }

    void store(const FieldBlock& block) {
        cells_[cell_index(block.coordinate)] = static_cast<int>(blocks_.size());
        blocks_.push_back(block);
    }

    void store_uniform(const Index3& coordinate, bool is_negative) {
        FieldBlock block;
        block.coordinate = coordinate;
        block.values.fill(background(is_negative));
        store(block);
    }

    /// Walks each row as a reader of the field does, and stores a block where it would be wrong.
    void store_sign_changes_along_rows() {
        for (int z = box_.lo.z(); z < box_.hi.z(); ++z) {
            for (int y = box_.lo.y(); y < box_.hi.y(); ++y) {
                bool carried = false;
                for (int x = box_.lo.x(); x < box_.hi.x(); ++x) {
                    const int cell = cells_[cell_index({x, y, z})];
                    if (cell >= 0) {
                        carried = is_inside_beyond(blocks_[cell]);
                    } else if (carried != (cell == inside)) {
                        carried = cell == inside;
                        store_uniform({x, y, z}, carried);
                    }
                }
            }
        }
    }

    FieldBlocks& blocks_;
    const WindingNumber& winding_;
    float background_;
    const Progress& progress_;
    IndexBox box_; // in blocks
    std::vector<int> cells_;
};

} // namespace

void store_outside_signs(FieldBlocks& blocks, const WindingNumber& winding, float background_world,
                         double memory_bytes, const Progress& progress) {
    OutsideSigns(blocks, winding, background_world, memory_bytes, progress).run();
    std::ranges::sort(blocks, zyx_less, &FieldBlock::coordinate);
}

} // namespace isocast
