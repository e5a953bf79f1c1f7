// Which tiles the band can reach: the sites of each, side by side in one array.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/band_tiles.h"

#include "distance_transform/progress_meter.h"
#include "volume/errors.h"
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
        const double reach =
            std::numbers::sqrt2 * height + 1 + std::numbers::sqrt3 * half_extent;
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
    constexpr std::array<int, 3> step = {1, tile_blocks, tile_blocks* tile_blocks};
    std::uint64_t bits = 0;
    for (int b = first / block_size; b <= last / block_size; ++b) bits |= one[axis] << b * step[axis];
    return bits;
}

/// Without the library call that std::floor is on old instruction sets.
int floor_to_int(double x) {
    const int i = static_cast<int>(x);
    return i - (static_cast<double>(i) > x);
}

/// Samples first … last along an axis, from the anchor.
struct Samples {
    int first;
    int last;

    Samples(double low, double high) : first(-floor_to_int(-low)), last(floor_to_int(high)) {}
    int first_tile() const { return first >> tile_shift; }
    int last_tile() const { return last >> tile_shift; }
    std::uint64_t blocks(int axis, int tile) const {
        const int begin = tile * tile_size;
        return blocks_along(axis, std::max(first - begin, 0), std::min(last - begin, tile_size - 1));
    }

private:
    static constexpr int tile_shift = std::countr_zero(unsigned{tile_size});
};

/// Calls visit(tile, its blocks) for every tile that has a sample in the region; it may call for a
/// few more.
template<class Visit>
void for_each_tile(const SiteRegion& region, const Visit& visit) {
    if (region.low > region.high) return;
    const int k = region.axis;
    const int u = (k + 1) % 3;
    const int v = (k + 2) % 3;
    const double* w = region.direction;
    const auto samples = [&](int axis, double low, double high, double lateral) {
        const double aside = lateral * region.lateral_factor[axis];
        return Samples(region.base_min[axis] + std::min(low * w[axis], high * w[axis]) - aside,
                       region.base_max[axis] + std::max(low * w[axis], high * w[axis]) + aside);
    };
    const double reach = region.lateral + region.lateral_slope * std::max(-region.low, region.high);
    const double aside = reach * region.lateral_factor[k];
    const double inverse_w = 1 / w[k];
    const Samples along_k = samples(k, region.low, region.high, reach);
    if (along_k.first > along_k.last) return;
    Index3 tile;
    for (tile[k] = along_k.first_tile(); tile[k] <= along_k.last_tile(); ++tile[k]) {
        const double first = tile_size * tile[k];
        const double low =
            std::max(region.low, (first - region.base_max[k] - aside) * inverse_w);
        const double high =
            std::min(region.high, (first + tile_size - 1 - region.base_min[k] + aside) * inverse_w);
        if (!(low <= high)) continue;
        const double lateral = region.lateral + region.lateral_slope * std::max(-low, high);
        const Samples along_u = samples(u, low, high, lateral);
        const Samples along_v = samples(v, low, high, lateral);
        if (along_u.first > along_u.last || along_v.first > along_v.last) continue;
        const std::uint64_t blocks_k = along_k.blocks(k, tile[k]);
        for (tile[v] = along_v.first_tile(); tile[v] <= along_v.last_tile(); ++tile[v]) {
            const std::uint64_t blocks_kv = blocks_k & along_v.blocks(v, tile[v]);
            for (tile[u] = along_u.first_tile(); tile[u] <= along_u.last_tile(); ++tile[u])
                visit(tile, blocks_kv & along_u.blocks(u, tile[u]));
        }
    }
}

struct Index3Hash {
    std::size_t operator()(const Index3& p) const {
        // Odd factors near 2^64 over powers of the golden ratio.
        return static_cast<std::size_t>(p.x()) * 0x9e3779b97f4a7c15 ^
               static_cast<std::size_t>(p.y()) * 0xbf58476d1ce4e5b9 ^
               static_cast<std::size_t>(p.z()) * 0x94d049bb133111eb;
    }
};

/// Tiles by coordinate, numbered as they come.
class TileNumbers {
public:
    /// The number of a tile; neighbours in the mesh mostly lie in the same one.
    std::uint32_t number(const Index3& tile) {
        if (tile == last_ && !tiles.empty()) return last_number_;
        const auto [at, is_new] =
            numbers_.try_emplace(tile, static_cast<std::uint32_t>(tiles.size()));
        if (is_new) tiles.push_back({.coordinate = tile, .blocks = 0, .first = 0, .count = 0});
        last_ = tile;
        return last_number_ = at->second;
    }
    std::vector<BandTile> tiles;

private:
    std::unordered_map<Index3, std::uint32_t, Index3Hash> numbers_;
    Index3 last_ = Index3::Zero();
    std::uint32_t last_number_ = 0;
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
    std::array<SiteRegion, 64> regions;
    for (std::int32_t first = begin; first < end; first += std::ssize(regions)) {
        const auto last = std::min<std::int32_t>(end, first + static_cast<int>(regions.size()));
        sites.kernels().find_regions(sites.arrays(), first, last, regions.data());
        for (std::int32_t site = first; site < last; ++site) {
            const SiteRegion& region = regions[static_cast<std::size_t>(site - first)];
            const NearTest near(sites.arrays(), site, region);
            for_each_tile(region, [&](const Index3& tile, std::uint64_t blocks) {
                if (!near.may_meet(tile)) return;
                const std::uint32_t number = part.numbers.number(tile);
                part.numbers.tiles[number].blocks |= blocks;
                ++part.numbers.tiles[number].count;
                part.pairs.push_back({number, site});
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
        const auto end =
            static_cast<std::int32_t>(std::min<std::int64_t>(std::int64_t{begin} + sites_per_part,
                                                             sites.count()));
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
