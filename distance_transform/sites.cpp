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
        u_ = (axis + 1) % 3;
        v_ = (axis + 2) % 3;
        region_.low = static_cast<float>(is_turned ? -high : low);
        region_.high = static_cast<float>(is_turned ? -low : high);
        Vec3d least = corners[0];
        Vec3d greatest = corners[0];
        for (const Vec3d& corner : corners) {
            least = least.cwiseMin(corner);
            greatest = greatest.cwiseMax(corner);
        }
        // What float leaves of positions and of heights times directions.
        const double largest =
            std::max({-low, high, least.cwiseAbs().maxCoeff(), greatest.cwiseAbs().maxCoeff()});
        pad_ = least_overlap + 1e-6 * largest;
        for (int k = 0; k < 3; ++k) {
            region_.direction[k] = static_cast<float>(direction_[k]);
            region_.base_min[k] = static_cast<float>(least[k] - pad_);
            region_.base_max[k] = static_cast<float>(greatest[k] + pad_);
        }
    }

    /// Offsets in all directions across the region's.
    RegionOf& around(double lateral, double slope) {
        region_.lateral = static_cast<float>(lateral);
        region_.lateral_slope = static_cast<float>(slope);
        for (int k = 0; k < 3; ++k)
            region_.lateral_factor[k] =
                static_cast<float>(std::sqrt(1 - direction_[k] * direction_[k]));
        is_round_ = true;
        return *this;
    }
    /// Offsets along `across` only.
    RegionOf& aside(double lateral, double slope, const Vec3d& across) {
        region_.lateral = static_cast<float>(lateral);
        region_.lateral_slope = static_cast<float>(slope);
        for (int k = 0; k < 3; ++k)
            region_.lateral_factor[k] = static_cast<float>(std::abs(across[k]));
        across_ = across;
        return *this;
    }

    SiteRegion get() {
        // Along the lean of a height, and along the sides of the base.
        add_strip(-direction_[v_], direction_[u_]);
        const std::size_t sides = corners_.size() == 3 ? 3 : corners_.size() - 1;
        for (std::size_t i = 0; i < sides; ++i) {
            const Vec3d side = corners_[(i + 1) % corners_.size()] - corners_[i];
            add_strip(-side[v_], side[u_]);
        }
        return region_;
    }

private:
    void add_strip(double m_u, double m_v) {
        const double length = std::sqrt(m_u * m_u + m_v * m_v);
        // A side along the axis, or no lean at all, bounds nothing.
        if (!(length > least_length)) return;
        m_u /= length;
        m_v /= length;
        SiteRegion::Strip& strip = region_.strips[region_.strip_count++];
        double low = std::numeric_limits<double>::infinity();
        double high = -low;
        for (const Vec3d& corner : corners_) {
            const double across = m_u * corner[u_] + m_v * corner[v_];
            low = std::min(low, across);
            high = std::max(high, across);
        }
        strip.across[0] = static_cast<float>(m_u);
        strip.across[1] = static_cast<float>(m_v);
        strip.low = static_cast<float>(low - 3 * pad_);
        strip.high = static_cast<float>(high + 3 * pad_);
        strip.lean = static_cast<float>(m_u * direction_[u_] + m_v * direction_[v_]);
        strip.factor =
            is_round_ ? 1.0f : static_cast<float>(std::abs(m_u * across_[u_] + m_v * across_[v_]));
    }

    // Far below any length that tells a direction, far above rounding.
    static constexpr double least_length = 1e-4;

    std::span<const Vec3d> corners_;
    Vec3d direction_;
    Vec3d across_ = Vec3d::Zero();
    bool is_round_ = false;
    int u_;
    int v_;
    double pad_;
    SiteRegion region_{};
};

constexpr std::size_t most_clipping_planes = 12;

/// The greatest |l| with l·u_j <= sign * k_j for all j, 0 if there is no such l. planes  (u_j,
/// k_j); leaving some out, or a `bound` of |l| that is too large, makes the result larger at most.
double greatest_offset(std::span<const Eigen::Vector3d> planes, double bound, double sign) {
    using Point = Eigen::Vector2d;
    // A convex polygon gains one corner at most from a cut.
    std::array<Point, most_clipping_planes + 4> polygon = {
        Point(-bound, -bound), Point(bound, -bound), Point(bound, bound), Point(-bound, bound)};
    std::array<Point, most_clipping_planes + 4> cut;
    std::size_t count = 4;
    const double slack = 1e-6 * bound; // rounding must not close a thin cone
    for (const Eigen::Vector3d& plane : planes) {
        std::size_t cut_count = 0;
        const auto excess = [&](const Point& p) {
            return p.dot(plane.head<2>()) - sign * plane.z() - slack;
        };
        for (std::size_t i = 0; i < count; ++i) {
            const Point& p = polygon[i];
            const Point& q = polygon[(i + 1) % count];
            const double at_p = excess(p);
            const double at_q = excess(q);
            if (at_p <= 0) cut[cut_count++] = p;
            if ((at_p < 0 && at_q > 0) || (at_p > 0 && at_q < 0))
                cut[cut_count++] = p + (q - p) * (at_p / (at_p - at_q));
        }
        std::swap(polygon, cut);
        count = cut_count;
        if (count == 0) return 0;
    }
    double greatest = 0;
    for (std::size_t i = 0; i < count; ++i) greatest = std::max(greatest, polygon[i].norm());
    return greatest;
}

class SiteFinder {
public:
    SiteFinder(const Mesh& mesh, const MeshTopology& topology, double half_width)
        : mesh_(mesh), topology_(topology), half_width_(half_width),
          normals_(mesh.triangles.size()), noise_(mesh.triangles.size()),
          is_open_(topology.fan_count) {
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
        const std::size_t edge_count = topology_.edge_count();
        const auto fan_count = static_cast<std::size_t>(topology_.fan_count);
        sites_.regions.resize(face_count + edge_count + fan_count);
        sites_.faces.resize(face_count);
        sites_.edges.resize(edge_count);
        sites_.vertices.resize(fan_count);
        for_all(face_count, [&](std::size_t t) { sites_.regions[t] = add_face(t); });
        for_all(edge_count, [&](std::size_t e) { sites_.regions[face_count + e] = add_edge(e); });
        for_all(fan_count, [&](std::size_t f) {
            sites_.regions[face_count + edge_count + f] = add_vertex(f, topology_.fan(f));
        });
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
        // Corners that differ in the world can be one in voxels about a distant anchor.
        const Vec3d r =
            length > 0 ? Vec3d((corner(triangle, longest + 1) - first) / length) : Vec3d::UnitX();
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
        normals_[triangle] = t;
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

    static SiteRegion empty_region() {
        SiteRegion region{};
        region.low = 1;
        region.high = 0;
        return region;
    }

    SiteRegion add_edge(std::size_t number) {
        const auto halfedges = topology_.edge(number);
        const std::array ends = {corner(halfedges[0] / 3, halfedges[0] % 3),
                                 corner(halfedges[0] / 3, halfedges[0] % 3 + 1)};
        const double length = (ends[1] - ends[0]).norm();
        if (!(length > 0)) return empty_region(); // its ends are at the same place
        const Vec3d e = (ends[1] - ends[0]) / length;
        // Directions across the edge into its triangles: a nearest point's offset leads into none.
        Vec3d into = Vec3d::Zero();
        Vec3d pseudonormal = Vec3d::Zero();
        double noise = 0;
        for (const std::uint32_t h : halfedges) {
            const bool is_along = corner(h / 3, h % 3) == ends[0];
            const Vec3d& normal = normals_[h / 3];
            into += is_along ? normal.cross(e) : e.cross(normal);
            pseudonormal += normal;
            noise += noise_[h / 3];
        }
        // A cylinder, unless more is known.
        Vec3d middle = e.unitOrthogonal();
        double low = -half_width_;
        double lateral = half_width_;
        double slope = 0;
        if (halfedges.size() == 1 && noise < greatest_noise) {
            middle = -into.normalized();
            low = -noise * half_width_; // a half cylinder that leans reaches below its foot
        } else if (halfedges.size() == 2 && noise < greatest_noise) {
            // The sum of two unit vectors: twice the sine of half the opening, away from it.
            const double sine = into.norm() / 2;
            const double tangent = sine < 1 ? sine / std::sqrt(1 - sine * sine) : 1e300;
            if ((tangent + noise) * half_width_ < least_opening) return empty_region();
            if (tangent <= greatest_slope) {
                // Where the edge is nearly flat, its direction is told better by the normals.
                const Vec3d& first = normals_[halfedges[0] / 3];
                const Vec3d& second = normals_[halfedges[1] / 3];
                const Vec3d between =
                    first.dot(second) < 0 ? Vec3d(first - second) : first + second;
                middle = sine > 0.5 ? Vec3d(-into.normalized()) : between.normalized();
                if (middle.dot(into) > 0) middle = -middle;
                // So flat that even the side may be in doubt.
                low = sine < 1e-9 + noise ? -half_width_ : 0;
                lateral = noise * half_width_;
                slope = tangent;
            }
        }
        middle = (middle - middle.dot(e) * e).normalized();
        const Vec3d across = e.cross(middle);
        EdgeSite& edge = sites_.edges[number];
        write(edge.origin, ends[0]);
        write(edge.e, e);
        write(edge.x, middle);
        write(edge.y, across);
        edge.length = length;
        edge.normal_x = pseudonormal.dot(middle);
        edge.normal_y = pseudonormal.dot(across);
        return RegionOf(ends, middle, low, half_width_).aside(lateral, slope, across).get();
    }

    /// With n the fan's normal and unit edges e_j = c_j n + s_j u_j, u_j across n, an offset h n +
    /// l leads along no edge if l·u_j <= k_j h, k_j = - c_j / s_j. A direction of l lies between
    /// two neighbouring u_j, within half of their angle of one of them, so that |l| <= h max(k_j) /
    /// cos(half the angle), the greatest over all pairs; for h < 0 the k_j change their sign.
    SiteRegion add_vertex(std::size_t fan, std::span<const std::uint32_t> corners) {
        const Vec3d& p = corner(corners[0] / 3, static_cast<int>(corners[0] % 3));
        Vec3d pseudonormal = Vec3d::Zero();
        for (const std::uint32_t c : corners) {
            const auto [a, b] = edges_at(c);
            pseudonormal += std::atan2(a.cross(b).norm(), a.dot(b)) * normals_[c / 3];
        }
        VertexSite& vertex = sites_.vertices[fan];
        write(vertex.origin, p);
        write(vertex.normal, pseudonormal);
        vertex.number = mesh_.triangles[corners[0] / 3][corners[0] % 3];

        const Vec3d n = pseudonormal.stableNormalized();
        double slope_above = 0;
        double slope_below = 0;
        std::array<Eigen::Vector3d, most_clipping_planes> planes; // u_j in the plane across n, k_j
        std::size_t plane_count = 0;
        const Vec3d right = n.unitOrthogonal();
        const Vec3d forward = n.cross(right);
        bool is_ring = !is_open_[fan] && n.squaredNorm() > 0.5;
        for (std::size_t i = 0; i < corners.size() && is_ring; ++i) {
            const auto [a, b] = edges_at(corners[i]);
            const double a_up = a.dot(n);
            const double b_up = b.dot(n);
            const Vec3d a_flat = a - a_up * n;
            const Vec3d b_flat = b - b_up * n;
            const double a_length = a_flat.norm();
            const double b_length = b_flat.norm();
            const double cosine = a_flat.dot(b_flat) / (a_length * b_length);
            const double half_cosine = std::sqrt(std::max(0.0, (1 + cosine) / 2));
            // Below 0.1 and 0.05 greatest_slope is passed by any slope that matters.
            is_ring = a_length > 0.1 * a.norm() && b_length > 0.1 * b.norm() &&
                      half_cosine > 0.05 && a_flat.cross(b_flat).dot(n) > 0;
            const double a_slope = -a_up / (a_length * half_cosine);
            const double b_slope = -b_up / (b_length * half_cosine);
            if (plane_count < planes.size())
                planes[plane_count++] = {a_flat.dot(right) / a_length,
                                         a_flat.dot(forward) / a_length, -a_up / a_length};
            slope_above = std::max({slope_above, a_slope, b_slope});
            slope_below = std::max({slope_below, -a_slope, -b_slope});
        }
        // Closed, with all corners turning the same way: the edges surround the normal.
        if (!is_ring || std::max(slope_above, slope_below) > greatest_slope)
            return RegionOf(std::span(&p, 1), Vec3d::UnitX(), -half_width_, half_width_)
                .around(half_width_, 0)
                .get();
        // Cones of saddles are mostly empty; where they would be wide, that is worth finding out.
        if (std::max(slope_above, slope_below) * half_width_ > 0.5) {
            const auto known = std::span(planes).first(plane_count);
            slope_above = std::min(slope_above, greatest_offset(known, slope_above, 1));
            slope_below = std::min(slope_below, greatest_offset(known, slope_below, -1));
        }
        const bool has_above = slope_above * half_width_ >= least_opening;
        const bool has_below = slope_below * half_width_ >= least_opening;
        if (!has_above && !has_below) return empty_region();
        return RegionOf(std::span(&p, 1), n, has_below ? -half_width_ : 0,
                        has_above ? half_width_ : 0)
            .around(0, std::max(slope_above, slope_below))
            .get();
    }

    /// From the vertex of corner `c` to the other two of its triangle.
    std::pair<Vec3d, Vec3d> edges_at(std::uint32_t c) const {
        const std::size_t t = c / 3;
        const int k = static_cast<int>(c % 3);
        const Vec3d& p = corner(t, k);
        return {corner(t, k + 1) - p, corner(t, k + 2) - p};
    }

    const Mesh& mesh_;
    const MeshTopology& topology_;
    double half_width_;
    // Of the triangles, apart from the sites, so that their neighbours find them in the caches.
    std::vector<Vec3d> normals_;
    std::vector<double> noise_; // of the normals
    std::vector<char> is_open_; // fans that do not close around their vertex
    Sites sites_;
};

} // namespace

Sites voronoi_sites(const Mesh& mesh, const MeshTopology& topology, double half_width_voxels) {
    return SiteFinder(mesh, topology, half_width_voxels).run();
}

} // namespace isocast
