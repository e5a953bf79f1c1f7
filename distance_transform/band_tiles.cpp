// Which tiles the band can reach: the sites of each, side by side in one array.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/band_tiles.h"

#include "distance_transform/progress_meter.h"
#include "volume/errors.h"
#include "volume/index_hash.h"
#include "volume/sparse_field.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <unordered_map>

namespace isocast {

namespace {

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

/// Whether a large face or edge comes near a tile; its box alone says little.
class NearTest {
public:
    NearTest(const SiteArrays& sites, std::int32_t site, const SiteRegion& region)
        : region_(region) {
        for (int k = 0; k < 3; ++k)
            is_large_ |= region.base_max[k] - region.base_min[k] > tile_size;
        if (!is_large_) return;
        if (site < sites.face_count) {
            origin_ = vertex(sites, sites.triangles[site][0]);
        } else {
            const EdgeData& edge = sites.edges[site - sites.face_count];
            origin_ = vertex(sites, edge.ends[0]);
            along_ = (vertex(sites, edge.ends[1]) - origin_).normalized();
        }
    }

    bool may_meet(const Index3& tile) const {
        if (!is_large_) return true;
        const Vec3d offset =
            tile_size * tile.cast<double>() + Vec3d::Constant(half_extent) - origin_;
        const double height = std::max(-region_.low, region_.high);
        if (along_.isZero()) {
            const Eigen::Map<const Vec3d> normal(region_.direction);
            return std::abs(normal.dot(offset)) <=
                   height + 1 + half_extent * normal.cwiseAbs().sum();
        }
        const double reach = std::numbers::sqrt2 * height + 1 + std::numbers::sqrt3 * half_extent;
        return (offset - offset.dot(along_) * along_).squaredNorm() <= reach * reach;
    }

private:
    static constexpr double half_extent = (tile_size - 1) / 2.0; // of a tile's samples

    static Vec3d vertex(const SiteArrays& sites, std::int32_t v) {
        return Eigen::Map<const Vec3d>(sites.vertices[v]);
    }

    const SiteRegion& region_;
    bool is_large_ = false;
    Vec3d origin_ = Vec3d::Zero();
    Vec3d along_ = Vec3d::Zero(); // of an edge
};

/// The bits of BandTile::blocks of a tile's samples first … last along an axis.
std::uint64_t blocks_along(int axis, int first, int last) {
    constexpr std::array<std::uint64_t, 3> one = {0x1111111111111111, 0x000f000f000f000f, 0xffff};
    const int step = axis == 0 ? 1 : axis == 1 ? tile_blocks : tile_blocks * tile_blocks;
    std::uint64_t bits = 0;
    for (int b = first / block_size; b <= last / block_size; ++b) bits |= one[axis] << b * step;
    return bits;
}

/// Without the library call that std::floor is on old instruction sets.
int floor_to_int(double x) {
    const int i = static_cast<int>(x);
    return i - (static_cast<double>(i) > x);
}

/// The bits of the blocks of `box` in a tile.
std::uint64_t blocks_in(const SampleBox& box, const Index3& tile) {
    std::uint64_t bits = ~std::uint64_t{0};
    for (int k = 0; k < 3; ++k) {
        const int begin = tile_size * tile[k];
        bits &= blocks_along(k, std::max(box.first[k] - begin, 0),
                             std::min(box.last[k] - begin, tile_size - 1));
    }
    return bits;
}

/// Calls visit(tile, its blocks) for every tile that has a sample in the region; it may call for a
/// few more.
///
/// box  of the region's samples, not empty
template<class Visit>
void for_each_tile(const SampleBox& box, const SiteRegion& region, const Visit& visit) {
    const int k = region.axis;
    const int u = (k + 1) % 3;
    const int v = (k + 2) % 3;
    const double* w = region.direction;
    const double reach = region.lateral + region.lateral_slope * std::max(-region.low, region.high);
    const double aside = reach * region.lateral_factor[k];
    const double inverse_w = 1 / w[k];
    Index3 tile;
    for (tile[k] = tile_of(box.first[k]); tile[k] <= tile_of(box.last[k]); ++tile[k]) {
        const double first = tile_size * tile[k];
        const double low = std::max(region.low, (first - region.base_max[k] - aside) * inverse_w);
        const double high =
            std::min(region.high, (first + tile_size - 1 - region.base_min[k] + aside) * inverse_w);
        if (!(low <= high)) continue;
        const double lateral = region.lateral + region.lateral_slope * std::max(-low, high);
        SampleBox slice = box;
        for (const int axis : {u, v}) {
            const double side = lateral * region.lateral_factor[axis];
            slice.first[axis] = -floor_to_int(
                -(region.base_min[axis] + std::min(low * w[axis], high * w[axis]) - side));
            slice.last[axis] = floor_to_int(region.base_max[axis] +
                                            std::max(low * w[axis], high * w[axis]) + side);
        }
        if (slice.first[u] > slice.last[u] || slice.first[v] > slice.last[v]) continue;
        for (tile[v] = tile_of(slice.first[v]); tile[v] <= tile_of(slice.last[v]); ++tile[v])
            for (tile[u] = tile_of(slice.first[u]); tile[u] <= tile_of(slice.last[u]); ++tile[u])
                visit(tile, blocks_in(slice, tile));
    }
}

/// Tiles by coordinate, numbered as they come.
class TileNumbers {
public:
    std::uint32_t number(const Index3& tile) {
        // Neighbours in the mesh mostly lie in the same few tiles.
        Recent& recent = recent_[(tile.x() & 3) + 4 * (tile.y() & 3) + 16 * (tile.z() & 3)];
        if (recent.number != none && recent.tile == tile) return recent.number;
        const auto [at, is_new] =
            numbers_.try_emplace(tile, static_cast<std::uint32_t>(tiles.size()));
        if (is_new) tiles.push_back({.coordinate = tile, .blocks = 0, .first = 0, .count = 0});
        recent = {tile, at->second};
        return at->second;
    }
    std::vector<BandTile> tiles;

private:
    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
    struct Recent {
        Index3 tile = Index3::Zero();
        std::uint32_t number = none;
    };

    std::unordered_map<Index3, std::uint32_t, IndexHash> numbers_;
    std::array<Recent, 64> recent_;
};

/// What some consecutive sites reach.
struct Part {
    struct Pair {
        std::uint32_t tile; // number in `numbers`
        std::int32_t site;
    };
    TileNumbers numbers;
    std::vector<Pair> pairs;
};

constexpr std::int32_t sites_per_part = 8192;

Part find_part(const Sites& sites, std::int32_t begin, std::int32_t end) {
    Part part;
    part.pairs.reserve(static_cast<std::size_t>(end - begin) * 2);
    constexpr std::int32_t batch = 64;
    std::array<SampleBox, batch> boxes;
    std::array<SiteRegion, batch> regions;
    for (std::int32_t first = begin; first < end; first += batch) {
        const std::int32_t last = std::min(end, first + batch);
        sites.kernels().find_regions(sites.arrays(), first, last, boxes.data(), regions.data());
        for (std::int32_t site = first; site < last; ++site) {
            const SampleBox& box = boxes[static_cast<std::size_t>(site - first)];
            if (box.first[0] > box.last[0] || box.first[1] > box.last[1] ||
                box.first[2] > box.last[2])
                continue;
            const auto add = [&](const Index3& tile, std::uint64_t blocks) {
                const std::uint32_t number = part.numbers.number(tile);
                part.numbers.tiles[number].blocks |= blocks;
                ++part.numbers.tiles[number].count;
                part.pairs.push_back({number, site});
            };
            const Index3 first_tile(tile_of(box.first[0]), tile_of(box.first[1]),
                                    tile_of(box.first[2]));
            const Index3 last_tile(tile_of(box.last[0]), tile_of(box.last[1]),
                                   tile_of(box.last[2]));
            if (first_tile == last_tile) {
                add(first_tile, blocks_in(box, first_tile));
                continue;
            }
            const SiteRegion& region = regions[static_cast<std::size_t>(site - first)];
            const NearTest near(sites.arrays(), site, region);
            for_each_tile(box, region, [&](const Index3& tile, std::uint64_t blocks) {
                if (near.may_meet(tile)) add(tile, blocks);
            });
        }
    }
    return part;
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

BandTiles find_band_tiles(const Sites& sites, double memory_bytes, const Progress& progress) {
    const std::size_t part_count = (static_cast<std::size_t>(sites.count()) + sites_per_part - 1) /
                                   static_cast<std::size_t>(sites_per_part);
    std::vector<Part> parts(part_count);
    ProgressMeter meter(progress, "prepare", static_cast<double>(part_count), 16);
    std::atomic<double> list_bytes = 0;
    tbb::parallel_for(std::size_t{0}, part_count, [&](std::size_t i) {
        const auto begin = static_cast<std::int32_t>(i) * sites_per_part;
        const auto end = static_cast<std::int32_t>(
            std::min<std::int64_t>(std::int64_t{begin} + sites_per_part, sites.count()));
        parts[i] = find_part(sites, begin, end);
        const double more = static_cast<double>(parts[i].pairs.size() * sizeof(Part::Pair));
        if (const double sum = list_bytes.fetch_add(more) + more; sum > memory_bytes)
            refuse_memory(sum, memory_bytes);
        meter.add(1);
    });

    TileNumbers all;
    std::size_t site_count = 0;
    std::vector<std::vector<std::uint32_t>> number_of(part_count); // of a part's tiles among all
    for (std::size_t i = 0; i < part_count; ++i) {
        for (const BandTile& tile : parts[i].numbers.tiles) {
            const std::uint32_t number = all.number(tile.coordinate);
            number_of[i].push_back(number);
            all.tiles[number].blocks |= tile.blocks;
            all.tiles[number].count += tile.count;
        }
        site_count += parts[i].pairs.size();
    }
    std::vector<std::uint32_t> order(all.tiles.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::sort(order, zyx_less,
                      [&](std::uint32_t i) -> const Index3& { return all.tiles[i].coordinate; });
    BandTiles result;
    std::size_t next = 0;
    for (const std::uint32_t i : order) {
        all.tiles[i].first = next;
        next += all.tiles[i].count;
        result.tiles.push_back(all.tiles[i]);
        result.block_count += static_cast<std::size_t>(std::popcount(all.tiles[i].blocks));
    }
    if (const double bytes = static_cast<double>(result.block_count * sizeof(FieldBlock) +
                                                 site_count * sizeof(std::int32_t));
        bytes > memory_bytes)
        refuse_memory(bytes, memory_bytes);

    // Where each part's sites of each of its tiles begin: parts in order keep them ascending.
    for (std::size_t i = 0; i < part_count; ++i) {
        for (std::size_t t = 0; t < number_of[i].size(); ++t) {
            BandTile& tile = all.tiles[number_of[i][t]];
            parts[i].numbers.tiles[t].first = tile.first;
            tile.first += parts[i].numbers.tiles[t].count;
        }
    }
    result.sites.resize(site_count);
    tbb::parallel_for(std::size_t{0}, part_count, [&](std::size_t i) {
        for (const auto& [tile, site] : parts[i].pairs)
            result.sites[parts[i].numbers.tiles[tile].first++] = site;
    });
    return result;
}

} // namespace isocast
