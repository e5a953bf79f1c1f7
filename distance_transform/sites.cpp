// The Voronoi sites of a mesh: towers, wedges and cones.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/sites.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace isocast {

namespace {

/// Samples that a region misses by rounding are caught by the next, if they overlap [voxels].
constexpr double least_overlap = 1e-6;
/// A bend over which the half width opens no further than this [voxels] needs no wedge or cone: the
/// towers overlap by more (scan_kernel.inl, tower_slack).
constexpr double least_opening = 1e-10;
/// Of two normals together [radians]; beyond it the edge's wedge is not told.
constexpr double greatest_noise = 0.1;
/// Half the width of a wedge or cone over its height, from which on a cylinder or ball serves.
constexpr double greatest_slope = 3;

void write(double (&to)[3], const Vec3d& from) {
    std::ranges::copy(from, to);
}

/// How far the normal of a triangle may be off [radians], from rounding of its corners.
double normal_noise(double height, double length) {
    constexpr double rounding = 1e-15;
    return height > rounding * length ? std::min(1.0, rounding * length / height) : 1.0;
}

/// A region over `corners`; `low` and `high` bound the heights along `direction`.
class RegionOf {
public:
    RegionOf(std::span<const Vec3d> corners, const Vec3d& direction, double low, double high)
        : corners_(corners) {
        int axis = 0;
        direction.cwiseAbs().maxCoeff(&axis);
        const bool is_turned = direction[axis] < 0;
        direction_ = is_turned ? Vec3d(-direction) : direction;
        region_.axis = axis;
        region_.low = static_cast<float>(is_turned ? -high : low);
        region_.high = static_cast<float>(is_turned ? -low : high);
        Eigen::Map<Eigen::Vector3f>(region_.direction) = direction_.cast<float>();
        // What float leaves of positions and of heights times directions.
        double largest = std::max(-low, high);
        for (const Vec3d& corner : corners) largest = std::max(largest, corner.cwiseAbs().maxCoeff());
        pad_ = least_overlap + 1e-6 * largest;
    }

    /// Offsets in all directions across the region's.
    RegionOf& around(double lateral, double slope) {
        set_lateral(lateral, slope, (Vec3d::Ones() - direction_.cwiseAbs2()).cwiseSqrt(), 1);
        return *this;
    }
    /// Offsets along `across` only.
    RegionOf& aside(double lateral, double slope, const Vec3d& across) {
        const auto [u, v] = axes();
        const double over_slab = -direction_[v] * across[u] + direction_[u] * across[v];
        set_lateral(lateral, slope, across.cwiseAbs(), std::abs(over_slab));
        return *this;
    }

    SiteRegion get() {
        const auto [u, v] = axes();
        Vec3d least = corners_[0];
        Vec3d greatest = corners_[0];
        double slab_min = std::numeric_limits<double>::infinity();
        double slab_max = -slab_min;
        for (const Vec3d& corner : corners_) {
            least = least.cwiseMin(corner);
            greatest = greatest.cwiseMax(corner);
            // With the direction as rounded, since the kernel compares with that.
            const double across =
                -double{region_.direction[v]} * corner[u] + double{region_.direction[u]} * corner[v];
            slab_min = std::min(slab_min, across);
            slab_max = std::max(slab_max, across);
        }
        for (int k = 0; k < 3; ++k) {
            region_.base_min[k] = static_cast<float>(least[k] - pad_);
            region_.base_max[k] = static_cast<float>(greatest[k] + pad_);
        }
        region_.slab_min = static_cast<float>(slab_min - 2 * pad_);
        region_.slab_max = static_cast<float>(slab_max + 2 * pad_);
        return region_;
    }

private:
    std::pair<int, int> axes() const { return {(region_.axis + 1) % 3, (region_.axis + 2) % 3}; }

    void set_lateral(double lateral, double slope, const Vec3d& factor, double slab_factor) {
        region_.lateral = static_cast<float>(lateral);
        region_.lateral_slope = static_cast<float>(slope);
        Eigen::Map<Eigen::Vector3f>(region_.lateral_factor) = factor.cast<float>();
        region_.slab_factor = static_cast<float>(slab_factor);
    }

    std::span<const Vec3d> corners_;
    Vec3d direction_;
    double pad_;
    SiteRegion region_{};
};

class SiteFinder {
public:
    SiteFinder(const Mesh& mesh, const MeshTopology& topology, const Pseudonormals& normals,
               double half_width)
        : mesh_(mesh), topology_(topology), normals_(normals), half_width_(half_width),
          noise_(mesh.triangles.size()), is_open_(topology.fan_count) {
        for (std::size_t e = 0; e < topology.edge_count(); ++e) {
            if (topology.edge(e).size() == 2) continue;
            for (const std::uint32_t h : topology.edge(e)) {
                is_open_[topology.fan_of_corner[h]] = 1;
                is_open_[topology.fan_of_corner[h / 3 * 3 + (h % 3 + 1) % 3]] = 1;
            }
        }
    }

    Sites run() {
        const std::size_t face_count = mesh_.triangles.size();
        sites_.faces.resize(face_count);
        std::vector<SiteRegion> face_regions(face_count);
        for_all(face_count, [&](std::size_t t) { face_regions[t] = add_face(t); });

        std::vector<EdgeSite> edges(topology_.edge_count());
        std::vector<SiteRegion> edge_regions(topology_.edge_count());
        std::vector<char> is_bent(topology_.edge_count());
        for_all(edges.size(),
                [&](std::size_t e) { is_bent[e] = add_edge(e, edges[e], edge_regions[e]); });

        const auto fans = buckets_of(topology_.fan_of_corner.size(), topology_.fan_count,
                                     [&](std::size_t c) { return topology_.fan_of_corner[c]; });
        std::vector<VertexSite> vertices(topology_.fan_count);
        std::vector<SiteRegion> vertex_regions(topology_.fan_count);
        std::vector<char> is_pointed(topology_.fan_count);
        for_all(vertices.size(), [&](std::size_t f) {
            const auto corners =
                std::span(fans.order).subspan(fans.begin[f], fans.begin[f + 1] - fans.begin[f]);
            is_pointed[f] = add_vertex(corners, vertices[f], vertex_regions[f]);
        });

        sites_.regions = std::move(face_regions);
        for (std::size_t e = 0; e < edges.size(); ++e) {
            if (!is_bent[e]) continue;
            sites_.edges.push_back(edges[e]);
            sites_.edge_numbers.push_back(static_cast<std::int32_t>(e));
            sites_.regions.push_back(edge_regions[e]);
        }
        for (std::size_t f = 0; f < vertices.size(); ++f) {
            if (!is_pointed[f]) continue;
            sites_.vertices.push_back(vertices[f]);
            sites_.vertex_corners.push_back(static_cast<std::int32_t>(fans.order[fans.begin[f]]));
            sites_.regions.push_back(vertex_regions[f]);
        }
        return std::move(sites_);
    }

private:
    template<class Work>
    static void for_all(std::size_t count, const Work& work) {
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 1024), [&](auto& range) {
            for (std::size_t i = range.begin(); i < range.end(); ++i) work(i);
        });
    }

    const Vec3d& corner(std::size_t triangle, int k) const {
        return mesh_.vertices_world[mesh_.triangles[triangle][k % 3]];
    }

    SiteRegion add_face(std::size_t triangle) {
        int longest = 0;
        double squared_length = -1;
        for (int k = 0; k < 3; ++k) {
            const double squared = (corner(triangle, k + 1) - corner(triangle, k)).squaredNorm();
            if (squared <= squared_length) continue;
            squared_length = squared;
            longest = k;
        }
        const Vec3d& first = corner(triangle, longest);
        const Vec3d& apex = corner(triangle, longest + 2);
        const double length = std::sqrt(squared_length);
        const Vec3d r = (corner(triangle, longest + 1) - first) / length;
        // The foot lies between the ends, but for rounding.
        const double left = std::clamp((apex - first).dot(r), 0.0, length);
        const Vec3d origin = first + left * r;
        // Twice made orthogonal: what is left of a sliver's height after the first time may lean.
        Vec3d s = apex - origin;
        s -= s.dot(r) * r;
        const double h = s.norm();
        s = h > 0 ? Vec3d(s / h) : r.unitOrthogonal();
        s = (s - s.dot(r) * r).normalized();
        noise_[triangle] = normal_noise(h, length);

        FaceSite& face = sites_.faces[triangle];
        const Vec3d t = r.cross(s);
        write(face.origin, origin);
        write(face.r, r);
        write(face.s, s);
        write(face.t, t);
        const auto side = [&](double base) -> FaceSite::Side {
            const double side_length = std::sqrt(base * base + h * h);
            // Without length the side is the apex itself, at a right angle to the longest side.
            if (!(side_length > 0)) return {base, 0, 1};
            return {base, base / side_length, h / side_length};
        };
        face.right = side(length - left);
        face.left = side(left);
        const std::array corners = {first, corner(triangle, longest + 1), apex};
        return RegionOf(corners, t, -half_width_, half_width_).get();
    }

    Vec3d face_normal(std::size_t triangle) const {
        return Eigen::Map<const Vec3d>(sites_.faces[triangle].t);
    }

    /// False if no sample can be nearest to the inside of the edge alone.
    bool add_edge(std::size_t number, EdgeSite& edge, SiteRegion& region) const {
        const auto halfedges = topology_.edge(number);
        const std::array ends = {corner(halfedges[0] / 3, halfedges[0] % 3),
                                 corner(halfedges[0] / 3, halfedges[0] % 3 + 1)};
        const double length = (ends[1] - ends[0]).norm();
        const Vec3d e = (ends[1] - ends[0]) / length;
        // Directions across the edge into its triangles: a nearest point's offset leads into none.
        Vec3d into = Vec3d::Zero();
        double noise = 0;
        for (const std::uint32_t h : halfedges) {
            const bool is_along = corner(h / 3, h % 3) == ends[0];
            const Vec3d normal = face_normal(h / 3);
            into += is_along ? normal.cross(e) : e.cross(normal);
            noise += noise_[h / 3];
        }
        // A cylinder, unless more is known.
        Vec3d middle = e.unitOrthogonal();
        double low = -half_width_;
        double lateral = half_width_;
        double slope = 0;
        if (halfedges.size() == 1 && noise < greatest_noise) {
            middle = -into.normalized();
            low = 0;
        } else if (halfedges.size() == 2 && noise < greatest_noise) {
            // The sum of two unit vectors: twice the sine of half the opening, away from it.
            const double sine = into.norm() / 2;
            const double tangent = sine < 1 ? sine / std::sqrt(1 - sine * sine) : 1e300;
            if ((tangent + noise) * half_width_ < least_opening) return false;
            if (tangent <= greatest_slope) {
                // Where the edge is nearly flat, its direction is told better by the normals.
                const Vec3d first = face_normal(halfedges[0] / 3);
                const Vec3d second = face_normal(halfedges[1] / 3);
                const Vec3d between = first.dot(second) < 0 ? Vec3d(first - second) : first + second;
                middle = sine > 0.5 ? Vec3d(-into.normalized()) : between.normalized();
                if (middle.dot(into) > 0) middle = -middle;
                // So flat that even the side may be in doubt.
                low = sine < 1e-9 + noise ? -half_width_ : 0;
                lateral = std::min(noise, 1.0) * half_width_;
                slope = tangent;
            }
        }
        middle = (middle - middle.dot(e) * e).normalized();
        const Vec3d across = e.cross(middle);
        region = RegionOf(ends, middle, low, half_width_)
                     .aside(lateral, slope, across)
                     .get();
        write(edge.origin, ends[0]);
        write(edge.e, e);
        write(edge.x, middle);
        write(edge.y, across);
        edge.length = length;
        const Vec3d& normal = normals_.at(static_cast<int>(halfedges[0] / 3), edge_of(halfedges[0]));
        edge.normal_x = normal.dot(middle);
        edge.normal_y = normal.dot(across);
        return true;
    }

    static Feature edge_of(std::uint32_t halfedge) {
        constexpr std::array features = {Feature::Edge01, Feature::Edge12, Feature::Edge20};
        return features[halfedge % 3];
    }
    static Feature vertex_of(std::uint32_t corner) {
        constexpr std::array features = {Feature::Vertex0, Feature::Vertex1, Feature::Vertex2};
        return features[corner % 3];
    }

    /// False if no sample can be nearest to the vertex alone.
    ///
    /// With n the fan's normal and unit edges e_j = c_j n + s_j u_j, u_j across n, an offset h n + l
    /// leads along no edge if l·u_j <= k_j h, k_j = - c_j / s_j. A direction of l lies between two
    /// neighbouring u_j, within half of their angle of one of them, so that |l| <= h max(k_j) /
    /// cos(half the angle), the greatest over all pairs; for h < 0 the k_j change their sign.
    bool add_vertex(std::span<const std::uint32_t> corners, VertexSite& vertex,
                    SiteRegion& region) const {
        const Vec3d& p = corner(corners[0] / 3, corners[0] % 3);
        const Vec3d& pseudonormal =
            normals_.at(static_cast<int>(corners[0] / 3), vertex_of(corners[0]));
        write(vertex.origin, p);
        write(vertex.normal, pseudonormal);

        const Vec3d n = pseudonormal.stableNormalized();
        double slope_above = 0;
        double slope_below = 0;
        const int fan = topology_.fan_of_corner[corners[0]];
        bool is_ring = !is_open_[fan] && n.squaredNorm() > 0.5;
        for (std::size_t i = 0; i < corners.size() && is_ring; ++i) {
            const std::size_t t = corners[i] / 3;
            const int c = static_cast<int>(corners[i] % 3);
            const Vec3d a = (corner(t, c + 1) - p).normalized();
            const Vec3d b = (corner(t, c + 2) - p).normalized();
            const double a_up = a.dot(n);
            const double b_up = b.dot(n);
            const Vec3d a_flat = a - a_up * n;
            const Vec3d b_flat = b - b_up * n;
            const double a_length = a_flat.norm();
            const double b_length = b_flat.norm();
            const double sine = a_flat.cross(b_flat).dot(n);
            is_ring = a_length > 0.1 && b_length > 0.1 && sine > 0;
            if (!is_ring) break;
            const double cosine = a_flat.dot(b_flat) / (a_length * b_length);
            const double half_cosine = std::sqrt(std::max(0.0, (1 + cosine) / 2));
            const double a_slope = -a_up / a_length;
            const double b_slope = -b_up / b_length;
            // 0.05: beyond, greatest_slope is passed by any slope that matters.
            is_ring = half_cosine > 0.05;
            slope_above = std::max({slope_above, a_slope / half_cosine, b_slope / half_cosine});
            slope_below = std::max({slope_below, -a_slope / half_cosine, -b_slope / half_cosine});
        }
        // Closed, with all corners turning the same way: the edges surround the normal.
        if (!is_ring || std::max(slope_above, slope_below) > greatest_slope) {
            region = RegionOf(std::span(&p, 1), Vec3d::UnitX(), -half_width_, half_width_)
                         .around(half_width_, 0)
                         .get();
            return true;
        }
        const bool has_above = slope_above * half_width_ >= least_opening;
        const bool has_below = slope_below * half_width_ >= least_opening;
        if (!has_above && !has_below) return false;
        region = RegionOf(std::span(&p, 1), n, has_below ? -half_width_ : 0,
                          has_above ? half_width_ : 0)
                     .around(0, std::max(slope_above, slope_below))
                     .get();
        return true;
    }

    const Mesh& mesh_;
    const MeshTopology& topology_;
    const Pseudonormals& normals_;
    double half_width_;
    std::vector<double> noise_; // of the triangles' normals
    std::vector<char> is_open_; // fans that do not close around their vertex
    Sites sites_;
};

} // namespace

Sites voronoi_sites(const Mesh& mesh, const MeshTopology& topology, const Pseudonormals& normals,
                    double half_width_voxels) {
    return SiteFinder(mesh, topology, normals, half_width_voxels).run();
}

} // namespace isocast
