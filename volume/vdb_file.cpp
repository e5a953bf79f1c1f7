// OpenVDB files.
// SPDX-License-Identifier: MPL-2.0
#include "volume/vdb_file.h"

#include "volume/atomic_file.h"
#include "volume/errors.h"
#include "volume/vdb_grid.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <openvdb/io/File.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Prune.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <set>

namespace isocast {

namespace {

namespace vdb = openvdb;

static_assert(vdb::FloatTree::LeafNodeType::DIM == block_size);

// 2.2 GB of blocks: a tile of a top-level node alone would become 2^27 of them.
constexpr std::size_t most_expanded_blocks = std::size_t{1} << 20;

/// OpenVDB's archive with the parts opened that tell a whole file from a truncated one, and that
/// write to a stream of ours: its own File ignores errors of the stream in both directions.
struct VdbArchive : vdb::io::Archive {
    using Archive::inputHasGridOffsets;
    using Archive::readGridCount;
    using Archive::readHeader;
    using Archive::setDataCompression;
    using Archive::setFormatVersion;
    using Archive::setLibraryVersion;
    using Archive::write;
};

vdb::Coord to_coord(const Index3& index) {
    return {index.x(), index.y(), index.z()};
}
Index3 to_index(const vdb::Coord& coord) {
    return {coord.x(), coord.y(), coord.z()};
}

/// Our place of the sample that OpenVDB, z fastest, has at `offset` of a leaf.
std::size_t place_of(vdb::Index offset) {
    const std::size_t x = offset >> 6;
    const std::size_t y = offset >> 3 & 7;
    const std::size_t z = offset & 7;
    return x + block_size * (y + block_size * z);
}

// ---------------------------------------------------------------------------------------- writing

vdb::math::Transform::Ptr to_transform(const GridSpace& space) {
    using vdb::math::Transform;
    const Mat3d& linear = space.world_from_index.linear();
    const Vec3d& origin = space.world_from_index.translation();
    if (linear.isDiagonal(0)) {
        // Step by step: the constructor that takes a whole map rounds its scale, as the difference
        // of two points. Equal scales make the uniform map that readers expect of a level set.
        const Vec3d scale = linear.diagonal();
        const Transform::Ptr transform = Transform::createLinearTransform(1.0);
        if (scale == Vec3d::Constant(scale.x())) {
            transform->postScale(scale.x());
        } else {
            transform->postScale(vdb::Vec3d(scale.x(), scale.y(), scale.z()));
        }
        transform->postTranslate(vdb::Vec3d(origin.x(), origin.y(), origin.z()));
        return transform;
    }
    // OpenVDB multiplies row vectors from the left: its matrix is the transpose of ours.
    vdb::Mat4d affine;
    for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j) affine(i, j) = space.world_from_index.matrix()(j, i);
    }
    return Transform::createLinearTransform(affine);
}

/// Sets tiles of - background wherever the field's row rule says so, then merges them.
void fill_inside(const SparseField& field, vdb::FloatTree& tree) {
    const float inside = -static_cast<float>(field.background_world());
    vdb::tree::ValueAccessor<vdb::FloatTree> accessor(tree);
    const auto blocks = field.blocks();
    const int x_end = floor_div(field.extent().hi, block_size).x();
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        if (!is_inside_beyond(blocks[i])) continue;
        const Index3& from = blocks[i].coordinate;
        const bool last_of_row =
            i + 1 == blocks.size() || blocks[i + 1].coordinate.tail<2>() != from.tail<2>();
        const int to = last_of_row ? x_end : blocks[i + 1].coordinate.x();
        for (int x = from.x() + 1; x < to; ++x) {
            const Index3 tile = block_size * Index3(x, from.y(), from.z());
            accessor.addTile(1, to_coord(tile), inside, false);
        }
    }
    // Level 1: leaves stay, even those that hold only ± background, since the row rule needs them.
    vdb::tools::TolerancePruneOp<vdb::FloatTree, 1> prune(tree, 0);
    vdb::tree::NodeManager<vdb::FloatTree, vdb::FloatTree::DEPTH - 2> nodes(tree);
    nodes.foreachBottomUp(prune);
}

/// A grid over the active samples of `field`, with value(number of the block, sample).
template<class Grid, class Value>
typename Grid::Ptr grid_beside(const SparseField& field, const std::string& name,
                               const Value& value) {
    using Leaf = typename Grid::TreeType::LeafNodeType;
    const auto grid = Grid::create();
    grid->setName(name);
    grid->setTransform(to_transform(field.space()));
    const auto blocks = field.blocks();
    std::vector<std::unique_ptr<Leaf>> leaves(blocks.size());
    tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t i) {
        auto leaf = std::make_unique<Leaf>(to_coord(block_size * blocks[i].coordinate));
        for (vdb::Index offset = 0; offset < Leaf::SIZE; ++offset) {
            const std::size_t place = place_of(offset);
            if (blocks[i].active[place])
                leaf->setValueOn(offset, value(i, static_cast<int>(place)));
        }
        leaves[i] = std::move(leaf);
    });
    for (std::unique_ptr<Leaf>& leaf : leaves) grid->tree().addLeaf(leaf.release());
    return grid;
}

vdb::GridCPtrVec to_grids(const SparseField& field,
                          const std::map<std::string, std::string>& metadata,
                          const ClosestGrids& closest) {
    const vdb::FloatGrid::Ptr surface = to_vdb_grid(field);
    for (const auto& [key, text] : metadata) surface->insertMeta(key, vdb::StringMetadata(text));
    vdb::GridCPtrVec grids = {surface};
    if (closest.offset_world) {
        const auto offsets =
            grid_beside<vdb::Vec3SGrid>(field, "closest", [&](std::size_t block, int sample) {
                const Eigen::Vector3f v = closest.offset_world(block, sample);
                return vdb::Vec3s(v.x(), v.y(), v.z());
            });
        offsets->setVectorType(vdb::VEC_CONTRAVARIANT_RELATIVE);
        grids.push_back(offsets);
    }
    if (closest.feature)
        grids.push_back(grid_beside<vdb::Int32Grid>(field, "feature", closest.feature));
    return grids;
}

} // namespace

vdb::FloatGrid::Ptr to_vdb_grid(const SparseField& field) {
    using Leaf = vdb::FloatTree::LeafNodeType;
    const bool is_signed = field.outside() == Outside::SignedBackground;
    const auto grid = vdb::FloatGrid::create(static_cast<float>(field.background_world()));
    grid->setName("surface");
    grid->setGridClass(is_signed ? vdb::GRID_LEVEL_SET : vdb::GRID_UNKNOWN);
    grid->setTransform(to_transform(field.space()));
    const auto blocks = field.blocks();
    std::vector<std::unique_ptr<Leaf>> leaves(blocks.size());
    tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t i) {
        auto leaf = std::make_unique<Leaf>(to_coord(block_size * blocks[i].coordinate));
        float* const values = leaf->buffer().data();
        for (vdb::Index offset = 0; offset < Leaf::SIZE; ++offset) {
            const std::size_t place = place_of(offset);
            values[offset] = blocks[i].values[place];
            if (blocks[i].active[place]) leaf->setValueOn(offset);
        }
        leaves[i] = std::move(leaf);
    });
    for (std::unique_ptr<Leaf>& leaf : leaves) grid->tree().addLeaf(leaf.release());
    if (is_signed) fill_inside(field, grid->tree());
    return grid;
}

namespace {

// ---------------------------------------------------------------------------------------- opening

[[noreturn]] void cannot_read(const std::filesystem::path& path, const std::string& cause) {
    throw InputError(fmt::format("cannot read {}: {}", path.string(), cause));
}

/// Throws InputError unless the file is whole. OpenVDB does not look whether its reads succeed, and
/// takes what it has not read for sizes.
void require_whole(const std::filesystem::path& path) {
    if (std::filesystem::is_directory(path)) cannot_read(path, "it is a folder");
    std::ifstream file(path, std::ios::binary);
    if (!file) cannot_read(path, std::strerror(errno));
    const auto size = static_cast<std::int64_t>(std::filesystem::file_size(path));
    file.exceptions(std::ios::failbit | std::ios::badbit | std::ios::eofbit);
    try {
        VdbArchive archive;
        archive.readHeader(file);
        auto stream_metadata = std::make_shared<vdb::io::StreamMetadata>();
        vdb::io::setStreamMetadataPtr(file, stream_metadata, /*transfer=*/false);
        archive.setFormatVersion(file);
        archive.setLibraryVersion(file);
        archive.setDataCompression(file);
        if (!archive.inputHasGridOffsets()) {
            cannot_read(path, "written to a stream, without grid offsets; convert it with OpenVDB");
        }
        vdb::MetaMap().readMeta(file);
        for (int grids = VdbArchive::readGridCount(file); grids > 0; --grids) {
            vdb::io::GridDescriptor descriptor;
            descriptor.read(file);
            if (descriptor.getEndPos() > size) {
                cannot_read(path, fmt::format("truncated: {} of at least {} bytes", size,
                                              descriptor.getEndPos()));
            }
            descriptor.seekToEnd(file);
        }
    } catch (const std::ios_base::failure&) {
        cannot_read(path, size < 8 ? "not an OpenVDB file" : "truncated");
    } catch (const vdb::IoError&) {
        cannot_read(path, "not an OpenVDB file, or of a version that this OpenVDB does not know");
    }
}

/// Opens `path`, calls use(file), and turns what OpenVDB throws into InputError. Grids are read
/// without their leaves' values, which stay in the mapped file until they are asked for.
template<class Use>
auto with_vdb(const std::filesystem::path& path, Use use) {
    vdb::initialize(); // does nothing after the first time
    try {
        require_whole(path);
        vdb::io::File file(path.string());
        file.setCopyMaxBytes(0); // no private copy of the file for delayed loading
        file.open(/*delayLoad=*/true);
        return use(file);
    } catch (const vdb::Exception& error) {
        cannot_read(path, error.what());
    } catch (const std::ios_base::failure& error) {
        cannot_read(path, error.what());
    } catch (const std::bad_alloc&) {
        throw ResourceError(fmt::format("cannot read {}: out of memory", path.string()));
    }
}

std::string value_type_of(const vdb::GridBase& grid) {
    return grid.saveFloatAsHalf() ? "half" : grid.valueType();
}

std::string grids_there(const vdb::GridPtrVec& grids) {
    std::vector<std::string> names;
    for (const vdb::GridBase::Ptr& grid : grids) {
        names.push_back(grid->getName() + " " + value_type_of(*grid));
    }
    return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

bool is_scalar(const vdb::GridBase& grid) {
    return grid.isType<vdb::FloatGrid>() || grid.isType<vdb::DoubleGrid>();
}

GridSpace to_space(const vdb::math::Transform& transform) {
    if (!transform.isLinear()) {
        throw InputError("its transform is not linear (a frustum); only affine ones can be read");
    }
    const vdb::Mat4d affine = transform.baseMap()->getAffineMap()->getMat4();
    GridSpace space;
    for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j) space.world_from_index.matrix()(i, j) = affine(j, i);
    }
    return space;
}

// ---------------------------------------------------------------------------------------- reading

FieldBlock constant_block(const Index3& coordinate, float value, bool active) {
    FieldBlock block;
    block.coordinate = coordinate;
    block.values.fill(value);
    if (active) block.active.set();
    return block;
}

IndexBox blocks_of_tile(const vdb::CoordBBox& box) {
    return blocks_over({to_index(box.min()), (to_index(box.max()).array() + 1).matrix()});
}

/// Boxes [blocks] of tiles that SparseField has no value for by itself, or only by its row rule.
struct Tiles {
    struct Constant {
        IndexBox blocks;
        float value;
        bool is_active;
    };
    std::vector<Constant> constant; // neither background nor, in signed fields, its opposite
    std::size_t constant_blocks = 0;
    std::vector<IndexBox> inside; // inactive ones of that opposite
};

template<class Tree>
Tiles tiles_of(const Tree& tree, bool is_signed) {
    Tiles tiles;
    auto tile = tree.cbeginValueAll();
    tile.setMaxDepth(Tree::ValueAllCIter::LEAF_DEPTH - 1);
    for (; tile; ++tile) {
        const auto value = *tile;
        if (!tile.isValueOn() && value == tree.background()) continue;
        const IndexBox box = blocks_of_tile(tile.getBoundingBox());
        if (!tile.isValueOn() && is_signed && value == -tree.background()) {
            tiles.inside.push_back(box);
            continue;
        }
        tiles.constant.push_back({box, static_cast<float>(value), tile.isValueOn()});
        tiles.constant_blocks += static_cast<std::size_t>(box.sample_count());
        if (tiles.constant_blocks > most_expanded_blocks) {
            throw ResourceError(fmt::format("its constant tiles would become more than {} blocks",
                                            most_expanded_blocks));
        }
    }
    return tiles;
}

/// The block of a leaf whose values may still be in the file; they stay there.
template<class Leaf>
FieldBlock block_of(const Leaf& leaf) {
    using Buffer = typename Leaf::Buffer;
    // The copy is read in the leaf's place, and dropped.
    auto buffer = std::make_unique<Buffer>(leaf.buffer());
    const typename Leaf::ValueType* values = nullptr;
    try {
        values = std::as_const(*buffer).data();
    } catch (...) {
        // After a read that failed, what OpenVDB's destructor would free is freed already.
        static_cast<void>(buffer.release());
        throw;
    }
    FieldBlock block;
    block.coordinate = floor_div(to_index(leaf.origin()), block_size);
    for (vdb::Index offset = 0; offset < Leaf::SIZE; ++offset) {
        const std::size_t place = place_of(offset);
        block.values[place] = static_cast<float>(values[offset]);
        block.active[place] = leaf.isValueOn(offset);
    }
    return block;
}

/// A block for each leaf and for each 8^3 samples of the constant tiles.
///
/// memory_bytes  beyond it the blocks lie in a scratch file
template<class Tree>
FieldBlocks blocks_of(const Tree& tree, const Tiles& tiles, double memory_bytes) {
    std::vector<const typename Tree::LeafNodeType*> leaves;
    leaves.reserve(tree.leafCount());
    tree.getNodes(leaves); // in the order of the file
    const std::size_t count = leaves.size() + tiles.constant_blocks;
    const FreshMemory<FieldBlock> memory(medium_for(count * sizeof(FieldBlock), memory_bytes));
    FieldBlocks blocks(count, memory);
    tbb::parallel_for(std::size_t{0}, leaves.size(),
                      [&](std::size_t i) { std::construct_at(&blocks[i], block_of(*leaves[i])); });
    std::size_t next = leaves.size();
    for (const auto& [box, value, is_active] : tiles.constant) {
        for (int z = box.lo.z(); z < box.hi.z(); ++z) {
            for (int y = box.lo.y(); y < box.hi.y(); ++y) {
                for (int x = box.lo.x(); x < box.hi.x(); ++x) {
                    std::construct_at(&blocks[next++], constant_block({x, y, z}, value, is_active));
                }
            }
        }
    }
    return blocks;
}

/// First sample along x [index] after the tile of `tree` that holds `at`.
template<class Tree, class Accessor>
int end_of_tile(const Accessor& accessor, const vdb::Coord& at) {
    using Top = typename Tree::RootNodeType::ChildNodeType;
    const int depth = accessor.getValueDepth(at); // -1: background, 0: tile of the root, …
    const int size = depth <= 0   ? static_cast<int>(Top::DIM)
                     : depth == 1 ? static_cast<int>(Top::ChildNodeType::DIM)
                                  : block_size;
    return (floor_div(to_index(at), size).x() + 1) * size;
}

/// Adds blocks of ± background where the tiles' sign is not what the row rule makes of the blocks.
///
/// inside  boxes [blocks] of the tiles of the inside
template<class Tree>
void add_sign_blocks(const Tree& tree, const std::vector<IndexBox>& inside, FieldBlocks& stored) {
    const std::vector<std::uint32_t> order = zyx_order(stored);
    const OrderedBlocks blocks(stored, order);
    const auto background = static_cast<float>(tree.background());
    std::set<std::pair<int, int>> rows; // (z, y)
    int x_begin = std::numeric_limits<int>::max();
    int x_end = std::numeric_limits<int>::min();
    for (const FieldBlock& block : blocks) {
        rows.emplace_hint(rows.end(), block.coordinate.z(), block.coordinate.y());
        x_begin = std::min(x_begin, block.coordinate.x());
        x_end = std::max(x_end, block.coordinate.x() + 1);
    }
    for (const IndexBox& box : inside) {
        for (int z = box.lo.z(); z < box.hi.z(); ++z) {
            for (int y = box.lo.y(); y < box.hi.y(); ++y) rows.emplace(z, y);
        }
        x_begin = std::min(x_begin, box.lo.x());
        x_end = std::max(x_end, box.hi.x());
    }
    const vdb::tree::ValueAccessor<const Tree> accessor(tree);
    FieldBlocks added;
    std::size_t next = 0; // the first block that is not before the place looked at
    for (const auto& [z, y] : rows) {
        const auto next_is_in_row = [&, z = z, y = y] {
            return next < blocks.size() && blocks[next].coordinate.z() == z &&
                   blocks[next].coordinate.y() == y;
        };
        bool is_inside = false;
        for (int x = x_begin; x < x_end;) {
            if (next_is_in_row() && blocks[next].coordinate.x() == x) {
                is_inside = is_inside_beyond(blocks[next++]);
                ++x;
                continue;
            }
            const vdb::Coord at = to_coord(block_size * Index3(x, y, z));
            const bool tile_is_inside = accessor.getValue(at) < 0;
            if (tile_is_inside != is_inside) {
                added.push_back(
                    constant_block({x, y, z}, tile_is_inside ? -background : background, false));
                is_inside = tile_is_inside;
            }
            const int after_tile = end_of_tile<Tree>(accessor, at) / block_size;
            const int before_block = next_is_in_row() ? blocks[next].coordinate.x() : x_end;
            x = std::min({after_tile, before_block, x_end});
        }
    }
    stored.reserve(stored.size() + added.size());
    stored.insert(stored.end(), added.begin(), added.end());
}

template<class Grid>
SparseField to_field(const Grid& grid, double memory_bytes) {
    GridSpace space = to_space(grid.transform());
    const bool is_signed = grid.getGridClass() == vdb::GRID_LEVEL_SET;
    const auto background = static_cast<double>(grid.background());
    if (is_signed && !(background > 0)) {
        throw InputError(fmt::format("a level set with background {}, not above 0", background));
    }
    const Tiles tiles = tiles_of(grid.tree(), is_signed);
    FieldBlocks blocks = blocks_of(grid.tree(), tiles, memory_bytes);
    if (is_signed) add_sign_blocks(grid.tree(), tiles.inside, blocks);
    return {std::move(space), background,
            is_signed ? Outside::SignedBackground : Outside::Background, std::move(blocks)};
}

/// Active voxels and their box, from the statistics in the metadata or else from the tree.
void describe_active(const vdb::GridBase& grid, GridDescription& description) {
    const auto count = grid.getMetadata<vdb::Int64Metadata>(vdb::GridBase::META_FILE_VOXEL_COUNT);
    const auto lo = grid.getMetadata<vdb::Vec3IMetadata>(vdb::GridBase::META_FILE_BBOX_MIN);
    const auto hi = grid.getMetadata<vdb::Vec3IMetadata>(vdb::GridBase::META_FILE_BBOX_MAX);
    vdb::CoordBBox box;
    if (count && lo && hi) {
        description.active_voxels = count->value();
        box.reset(vdb::Coord(lo->value()), vdb::Coord(hi->value()));
    } else {
        description.active_voxels = static_cast<std::int64_t>(grid.activeVoxelCount());
        box = grid.evalActiveVoxelBoundingBox();
    }
    if (description.active_voxels == 0) return;
    description.active_box = {to_index(box.min()), (to_index(box.max()).array() + 1).matrix()};
}

GridDescription describe(const vdb::GridBase& grid) {
    GridDescription description;
    description.name = grid.getName();
    description.grid_class = vdb::GridBase::gridClassToString(grid.getGridClass());
    description.value_type = value_type_of(grid);
    description.is_affine = grid.transform().isLinear();
    if (description.is_affine) {
        description.world_from_index = to_space(grid.transform()).world_from_index;
    }
    if (grid.isType<vdb::FloatGrid>()) {
        description.background_world = static_cast<const vdb::FloatGrid&>(grid).background();
    } else if (grid.isType<vdb::DoubleGrid>()) {
        description.background_world = static_cast<const vdb::DoubleGrid&>(grid).background();
    }
    describe_active(grid, description);
    for (auto item = grid.beginMeta(); item != grid.endMeta(); ++item) {
        description.metadata[item->first] = item->second->str();
    }
    return description;
}

} // namespace

SparseField read_vdb(const std::filesystem::path& path, const std::string& grid_name,
                     double memory_bytes) {
    return with_vdb(path, [&](vdb::io::File& file) {
        const vdb::GridPtrVecPtr grids = file.readAllGridMetadata();
        const auto wanted = std::ranges::find_if(*grids, [&](const vdb::GridBase::Ptr& grid) {
            return grid_name.empty() ? is_scalar(*grid) : grid->getName() == grid_name;
        });
        if (wanted == grids->end()) {
            const std::string cause =
                grid_name.empty() ? "no float grid" : fmt::format("no grid named '{}'", grid_name);
            cannot_read(path, fmt::format("{} (has: {})", cause, grids_there(*grids)));
        }
        const std::string name = (*wanted)->getName();
        const std::string context =
            fmt::format("while reading grid '{}' of {}", name, path.string());
        if (!is_scalar(**wanted)) {
            throw InputError(
                fmt::format("{}: not a float grid (has: {})", context, grids_there(*grids)));
        }
        try {
            const vdb::GridBase::Ptr grid = file.readGrid(name);
            if (const auto floats = vdb::gridPtrCast<vdb::FloatGrid>(grid)) {
                return to_field(*floats, memory_bytes);
            }
            return to_field(*vdb::gridPtrCast<vdb::DoubleGrid>(grid), memory_bytes);
        } catch (const InputError& error) {
            throw InputError(fmt::format("{}: {}", context, error.what()));
        } catch (const ResourceError& error) {
            throw ResourceError(fmt::format("{}: {}", context, error.what()));
        }
    });
}

std::vector<GridDescription> describe_vdb(const std::filesystem::path& path) {
    return with_vdb(path, [&](vdb::io::File& file) {
        std::vector<GridDescription> descriptions;
        // With their topology, in which the background stands.
        const vdb::GridPtrVecPtr grids = file.getGrids();
        for (const vdb::GridBase::Ptr& grid : *grids) descriptions.push_back(describe(*grid));
        return descriptions;
    });
}

namespace {

void write_grids(const std::function<vdb::GridCPtrVec()>& make_grids,
                 const std::filesystem::path& path) {
    AtomicFile output(path);
    vdb::initialize();
    const auto fail = [&](const std::string& cause) {
        return fmt::format("cannot write {}: {}", path.string(), cause);
    };
    try {
        const vdb::GridCPtrVec grids = make_grids();
        std::ofstream file(output.temporary_path(), std::ios::binary | std::ios::trunc);
        file.exceptions(std::ios::failbit | std::ios::badbit);
        errno = 0;
        const VdbArchive archive;
        archive.write(file, grids, /*seekable=*/true, vdb::MetaMap());
        file.close();
    } catch (const std::ios_base::failure&) {
        throw ResourceError(fail(errno != 0 ? std::strerror(errno) : "the write failed"));
    } catch (const vdb::ArithmeticError& error) {
        throw InputError(fail(fmt::format("OpenVDB refuses its transform: {}", error.what())));
    }
    output.commit();
}

} // namespace

void write_vdb(const SparseField& field, const std::filesystem::path& path,
               const std::map<std::string, std::string>& metadata, const ClosestGrids& closest) {
    write_grids([&] { return to_grids(field, metadata, closest); }, path);
}

void write_vdb_levels(const std::function<SparseField(int level)>& field_of, int level_count,
                      const std::filesystem::path& path,
                      const std::map<std::string, std::string>& metadata) {
    const auto make_grids = [&] {
        vdb::GridCPtrVec grids;
        for (int level = 0; level < level_count; ++level) {
            const vdb::FloatGrid::Ptr grid = to_vdb_grid(field_of(level));
            grid->setName(fmt::format("surface_level_{}", level));
            for (const auto& [key, text] : metadata)
                grid->insertMeta(key, vdb::StringMetadata(text));
            grids.push_back(grid);
        }
        return grids;
    };
    write_grids(make_grids, path);
}

} // namespace isocast
