// Which blocks the band can reach: sites are sorted into tiles, and within them into blocks.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/band_blocks.h"

#include "distance_transform/progress_meter.h"
#include "volume/errors.h"
#include "volume/sparse_field.h"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <unordered_map>

namespace isocast {

namespace {

constexpr int tile_blocks = 8; // along an edge
constexpr int blocks_per_tile = tile_blocks * tile_blocks * tile_blocks;

/// A number of blocks that the field surely has, from areas and lengths alone.
double least_block_count(const Mesh& mesh, double half_width) {
    constexpr double edge = block_size;
    // No plane cuts a larger area out of a cube than through two opposite edges.
    const double largest_section = edge * edge * std::numbers::sqrt2;
    const double longest_chord = edge * std::numbers::sqrt3;
    double area = 0;
    double longest_edge = 0;
    for (const auto& [ia, ib, ic] : mesh.triangles) {
        const Vec3d u = mesh.vertices_world[ib] - mesh.vertices_world[ia];
        const Vec3d v = mesh.vertices_world[ic] - mesh.vertices_world[ia];
        area += u.cross(v).norm() / 2;
        longest_edge = std::max({longest_edge, u.norm(), v.norm()});
    }
    // A block may hold several sheets of the surface: four full sections are more than most do.
    constexpr double sheets = 4;
    const double ball = 4 * std::numbers::pi / 3 * std::pow(half_width, 3);
    return std::max({area / (sheets * largest_section), longest_edge / longest_chord,
                     ball / samples_per_block});
}

/// Whether a large face or edge comes near a cell; its box alone says little.
class NearTest {
public:
    NearTest(const Sites& sites, int cell_size)
        : sites_(sites.arrays()), half_extent_((cell_size - 1) / 2.0), cell_size_(cell_size) {}

    bool may_meet(std::int32_t site, const Index3& cell) const {
        const SiteRegion& region = sites_.regions[site];
        double extent = 0;
        for (int k = 0; k < 3; ++k)
            extent = std::max(extent, double{region.base_max[k]} - region.base_min[k]);
        if (extent <= cell_size_) return true;
        const Vec3d centre = cell_size_ * cell.cast<double>() + Vec3d::Constant(half_extent_);
        if (site < sites_.face_count) {
            const FaceSite& face = sites_.faces[site];
            const Eigen::Map<const Vec3d> normal(face.t);
            return std::abs(normal.dot(centre - Eigen::Map<const Vec3d>(face.origin))) <=
                   double{region.high} + 1 + half_extent_ * normal.cwiseAbs().sum();
        }
        if (site < sites_.face_count + sites_.edge_count) {
            const EdgeSite& edge = sites_.edges[site - sites_.face_count];
            const Vec3d offset = centre - Eigen::Map<const Vec3d>(edge.origin);
            const Eigen::Map<const Vec3d> along(edge.e);
            const double reach = std::numbers::sqrt2 * std::max(-region.low, region.high) + 1 +
                                 std::numbers::sqrt3 * half_extent_;
            return (offset - offset.dot(along) * along).squaredNorm() <= reach * reach;
        }
        return true;
    }

private:
    SiteArrays sites_;
    double half_extent_; // of a cell's samples
    int cell_size_;
};

struct Index3Hash {
    std::size_t operator()(const Index3& p) const {
        // Odd factors near 2^64 over powers of the golden ratio.
        return static_cast<std::size_t>(p.x()) * 0x9e3779b97f4a7c15 ^
               static_cast<std::size_t>(p.y()) * 0xbf58476d1ce4e5b9 ^
               static_cast<std::size_t>(p.z()) * 0x94d049bb133111eb;
    }
};

/// Sites of each tile, in ascending order.
struct Tiles {
    std::vector<Index3> coordinates;
    std::vector<std::vector<std::int32_t>> sites;
};

Tiles find_tiles(const Sites& sites) {
    using TileMap = std::unordered_map<Index3, std::vector<std::int32_t>, Index3Hash>;
    constexpr int tile_size = tile_blocks * block_size;
    constexpr int unlimited = std::numeric_limits<int>::max() / 2;
    const IndexBox everywhere{Index3::Constant(-unlimited), Index3::Constant(unlimited)};
    const NearTest near_test(sites, tile_size);
    tbb::enumerable_thread_specific<TileMap> maps;
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, sites.regions.size(), 4096), [&](const auto& range) {
            TileMap& map = maps.local();
            Index3 last = Index3::Constant(unlimited);
            std::vector<std::int32_t>* list = nullptr;
            for (std::size_t i = range.begin(); i < range.end(); ++i) {
                const auto site = static_cast<std::int32_t>(i);
                for_each_cell(sites.regions[i], tile_size, everywhere, [&](const Index3& tile) {
                    if (!near_test.may_meet(site, tile)) return;
                    // Neighbours in the mesh mostly lie in the same tile.
                    if (tile != last) {
                        last = tile;
                        list = &map[tile];
                    }
                    list->push_back(site);
                });
            }
        });
    TileMap all;
    for (TileMap& map : maps) {
        for (auto& [tile, list] : map) {
            std::vector<std::int32_t>& to = all[tile];
            if (to.empty())
                to = std::move(list);
            else
                to.insert(to.end(), list.begin(), list.end());
        }
    }
    Tiles tiles;
    for (const auto& [tile, list] : all) tiles.coordinates.push_back(tile);
    std::ranges::sort(tiles.coordinates, zyx_less);
    for (const Index3& tile : tiles.coordinates) tiles.sites.push_back(std::move(all[tile]));
    tbb::parallel_for(std::size_t{0}, tiles.sites.size(),
                      [&](std::size_t i) { std::ranges::sort(tiles.sites[i]); });
    return tiles;
}

/// The blocks of one tile; `list` becomes their sites, block by block.
std::vector<BandBlock> blocks_of_tile(const Sites& sites, const Index3& tile, std::uint32_t number,
                                      std::vector<std::int32_t>& list) {
    struct Pair {
        std::int32_t site;
        int block;
    };
    const Index3 first_block = tile_blocks * tile;
    const IndexBox limits{first_block, (first_block.array() + tile_blocks).matrix()};
    const NearTest near_test(sites, block_size);
    std::vector<Pair> pairs;
    pairs.reserve(4 * list.size());
    std::array<std::uint32_t, blocks_per_tile + 1> begin{};
    for (std::size_t i = 0; i < list.size(); ++i) {
        // A tile's sites lie about in memory.
        constexpr std::size_t ahead = 8;
        if (i + ahead < list.size()) {
            const auto* next = reinterpret_cast<const char*>(&sites.regions[list[i + ahead]]);
            __builtin_prefetch(next);
            __builtin_prefetch(next + 64);
        }
        const std::int32_t site = list[i];
        for_each_cell(sites.regions[site], block_size, limits, [&](const Index3& block) {
            if (!near_test.may_meet(site, block)) return;
            const Index3 at = block - first_block;
            const int local = at.x() + tile_blocks * (at.y() + tile_blocks * at.z());
            pairs.push_back({site, local});
            ++begin[local + 1];
        });
    }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::array<std::uint32_t, blocks_per_tile> next;
    std::copy_n(begin.begin(), blocks_per_tile, next.begin());
    list.resize(pairs.size());
    list.shrink_to_fit();
    for (const Pair& pair : pairs) list[next[pair.block]++] = pair.site;
    std::vector<BandBlock> blocks;
    for (int b = 0; b < blocks_per_tile; ++b) {
        if (begin[b] == begin[b + 1]) continue;
        const Index3 at(b % tile_blocks, b / tile_blocks % tile_blocks,
                        b / (tile_blocks * tile_blocks));
        blocks.push_back({.coordinate = first_block + at,
                          .list = number,
                          .first = begin[b],
                          .count = begin[b + 1] - begin[b],
                          .place = 0});
    }
    return blocks;
}

} // namespace

void refuse_memory(double bytes, double memory_bytes) {
    const auto text = [](double count) {
        return count < 0x1p30 ? fmt::format("{:.3g} MiB", count / 0x1p20)
                              : fmt::format("{:.3g} GiB", count / 0x1p30);
    };
    throw ResourceError(fmt::format(
        "the field would take at least {}, and {} of memory may be taken; use a larger voxel size "
        "or a narrower band",
        text(bytes), text(memory_bytes)));
}

double least_field_bytes(const Mesh& mesh, double half_width_voxels) {
    return least_block_count(mesh, half_width_voxels) * sizeof(FieldBlock);
}

BandBlocks find_band_blocks(const Sites& sites, double memory_bytes, const Progress& progress) {
    Tiles tiles = find_tiles(sites);
    ProgressMeter meter(progress, "prepare", static_cast<double>(tiles.sites.size()), 16);
    std::vector<std::vector<BandBlock>> blocks(tiles.sites.size());
    std::atomic<double> bytes = 0;
    tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t i) {
        blocks[i] = blocks_of_tile(sites, tiles.coordinates[i], static_cast<std::uint32_t>(i),
                                   tiles.sites[i]);
        const double more = static_cast<double>(blocks[i].size() * sizeof(FieldBlock) +
                                                tiles.sites[i].size() * sizeof(std::int32_t));
        if (const double sum = bytes.fetch_add(more) + more; sum > memory_bytes)
            refuse_memory(sum, memory_bytes);
        meter.add(1);
    });

    BandBlocks result;
    result.lists = std::move(tiles.sites);
    for (const std::vector<BandBlock>& of_tile : blocks)
        result.blocks.insert(result.blocks.end(), of_tile.begin(), of_tile.end());
    std::vector<std::uint32_t> order(result.blocks.size());
    std::iota(order.begin(), order.end(), 0);
    tbb::parallel_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return zyx_less(result.blocks[a].coordinate, result.blocks[b].coordinate);
    });
    for (std::uint32_t place = 0; place < order.size(); ++place)
        result.blocks[order[place]].place = place;
    return result;
}

} // namespace isocast
