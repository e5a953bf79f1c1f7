// SPDX-License-Identifier: MPL-2.0
#include "quadrics/slim_fit.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace isocast {

namespace {

/// Of leaves' edges, by the radius: a dozen leaves a sphere, where triangles are larger than it.
constexpr double leaf_share = 0.7;
/// Of what lies between the samples, in the least squares: it decides only what they leave open.
constexpr double between_weight = 0.1;
/// Twice as many as a patch has coefficients leave nothing open.
constexpr std::size_t enough_samples = 12;
/// Of the error, what is forgiven between the samples at most.
constexpr double most_spare_errors = 2;
/// By how much more patches are off between the places that are looked at: of knot, torus and bunny
/// at one place of 10,000 by up to a tenth.
constexpr double between_places = 1.1;
/// Steps along an edge towards the rim.
constexpr int rim_rounds = 2;
/// Rounds of Lawson's weights, and from where these are not worth it: the greatest height of a fit
/// by least squares is seldom twice that of the best fit.
constexpr int rounds = 4;
constexpr double hopeless = 2;
/// Chains of ends turn by less than 45 degrees at a vertex.
constexpr double least_turn_cosine = std::numbers::sqrt2 / 2;

/// The part of a segment in a sphere about 0; nothing if it passes by.
std::optional<std::array<Vec3d, 2>> within_sphere(const Vec3d& a, const Vec3d& b, double radius) {
    const Vec3d d = b - a;
    const double length2 = d.squaredNorm();
    const double middle = -a.dot(d) / length2;
    const double spare = radius * radius - (a + middle * d).squaredNorm();
    if (!(spare > 0)) return std::nullopt;
    const double half = std::sqrt(spare / length2);
    const double from = std::max(middle - half, 0.0);
    const double to = std::min(middle + half, 1.0);
    if (!(from < to)) return std::nullopt;
    return std::array<Vec3d, 2>{a + from * d, a + to * d};
}

/// Of a triangle that turns left, to its inside as well.
double distance(const Eigen::Vector2d& p, const std::array<Eigen::Vector2d, 3>& corners) {
    bool is_inside = true;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 3; ++k) {
        const Eigen::Vector2d side = corners[(k + 1) % 3] - corners[k];
        const Eigen::Vector2d from = p - corners[k];
        is_inside = is_inside && side.x() * from.y() >= side.y() * from.x();
        const double length2 = side.squaredNorm();
        const double share = length2 > 0 ? std::clamp(from.dot(side) / length2, 0.0, 1.0) : 0;
        least = std::min(least, (from - share * side).norm());
    }
    return is_inside ? 0 : least;
}

/// Of a point from the patch's centre.
double height_over(const SlimPatch& patch, const Mat3d& axes, const Vec3d& p) {
    const Vec3d q = axes.transpose() * p;
    return q.z() - height_at(patch, q.x(), q.y());
}

} // namespace

SlimFitter::SlimFitter(const SlimMesh& mesh)
    : mesh_(mesh), visits_(mesh.size(), 0), vertex_visits_(mesh.vertex_count(), 0) {}

void SlimFitter::add_leaves(std::size_t triangle, const Mat3d& corners_barycentric,
                            const std::array<Vec3d, 3>& corners, double bow_world,
                            const Vec3d& centre_world, double radius_world) {
    const Vec3d middle = (corners[0] + corners[1] + corners[2]) / 3;
    double longest2 = 0;
    double reach2 = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        reach2 = std::max(reach2, (corners[k] - middle).squaredNorm());
        longest2 = std::max(longest2, (corners[(k + 1) % 3] - corners[k]).squaredNorm());
    }
    if (middle.norm() - std::sqrt(reach2) - bow_world >= radius_world) return;
    const Mat3d& l = corners_barycentric;
    Mat3d middles;
    std::array<Vec3d, 3> middles_here;
    for (int k = 0; k < 3; ++k) {
        middles.col(k) = (l.col(k) + l.col((k + 1) % 3)) / 2;
        middles_here[static_cast<std::size_t>(k)] =
            mesh_.point(triangle, middles.col(k)) - centre_world;
    }
    if (longest2 <= leaf_share * leaf_share * radius_world * radius_world) {
        leaves_.push_back({corners, middles_here, mesh_.spare_world(triangle)});
        return;
    }
    for (std::size_t k = 0; k < 3; ++k) {
        const auto i = static_cast<int>(k);
        const std::size_t next = (k + 1) % 3;
        Mat3d part; // turning as the whole does
        part << middles.col(i), l.col((i + 1) % 3), middles.col((i + 1) % 3);
        add_leaves(triangle, part, {middles_here[k], corners[next], middles_here[next]},
                   bow_world / 4, centre_world, radius_world);
    }
    add_leaves(triangle, middles, middles_here, bow_world / 4, centre_world, radius_world);
}

void SlimFitter::add_triangle(std::size_t triangle, const std::array<Vec3d, 3>& corners,
                              const Vec3d& centre_world, double radius_world) {
    const double spare = mesh_.spare_world(triangle);
    if (mesh_.longest_world(triangle) <= leaf_share * radius_world) {
        const auto middle = [&](std::size_t k) -> Vec3d {
            return (corners[k] + corners[(k + 1) % 3]) / 2 + mesh_.bow(triangle, k);
        };
        leaves_.push_back({corners, {middle(0), middle(1), middle(2)}, spare});
    } else {
        add_leaves(triangle, Mat3d::Identity(), corners, spare, centre_world, radius_world);
    }
}

void SlimFitter::collect(int triangle, const Vec3d& centre_world, double radius_world,
                         bool crosses_creases) {
    part_.assign(1, triangle);
    ends_.clear();
    leaves_.clear();
    samples_.clear();
    has_creases_ = false;
    visits_[static_cast<std::size_t>(triangle)] = ++visit_;
    for (std::size_t at = 0; at < part_.size(); ++at) {
        const auto i = static_cast<std::size_t>(part_[at]);
        const std::array<int, 3>& corners = mesh_.corners_of(i);
        std::array<Vec3d, 3> p;
        for (std::size_t k = 0; k < 3; ++k) p[k] = mesh_.vertex(corners[k]) - centre_world;
        add_triangle(i, p, centre_world, radius_world);
        std::array<bool, 3> is_in;
        for (std::size_t k = 0; k < 3; ++k) {
            is_in[k] = p[k].squaredNorm() < radius_world * radius_world;
            auto& visit = vertex_visits_[static_cast<std::size_t>(corners[k])];
            if (visit == visit_ || !is_in[k]) continue;
            visit = visit_;
            samples_.push_back({p[k], mesh_.area_of_vertex(corners[k])});
        }
        for (std::size_t k = 0; k < 3; ++k) {
            const SlimMesh::Side& side = mesh_.side(i, k);
            const std::size_t next = (k + 1) % 3;
            const bool is_end = side.neighbour < 0 || (side.is_crease && !crosses_creases);
            if (!is_end && visits_[static_cast<std::size_t>(side.neighbour)] == visit_ &&
                !side.is_crease)
                continue;
            const auto go_on = [&] {
                if (auto& visit = visits_[static_cast<std::size_t>(side.neighbour)];
                    visit != visit_) {
                    visit = visit_;
                    part_.push_back(side.neighbour);
                }
            };
            if (!is_end && (is_in[k] || is_in[next])) {
                has_creases_ = has_creases_ || side.is_crease;
                go_on();
                continue;
            }
            const Vec3d middle = (p[k] + p[next]) / 2 + mesh_.bow(i, k);
            const std::array halves{within_sphere(p[k], middle, radius_world),
                                    within_sphere(middle, p[next], radius_world)};
            if (!halves[0] && !halves[1]) continue;
            has_creases_ = has_creases_ || side.is_crease;
            if (is_end) {
                const Vec3d& n = mesh_.normal(i);
                const Vec3d beyond = side.neighbour < 0
                                         ? Vec3d(Vec3d::Zero())
                                         : mesh_.normal(static_cast<std::size_t>(side.neighbour));
                for (const auto& half : halves)
                    if (half)
                        ends_.push_back({(*half)[0], (*half)[1], corners[k], corners[next],
                                         n.cross((p[next] - p[k]).normalized()), n, beyond});
            } else {
                go_on();
            }
        }
    }
}

bool SlimFitter::is_graph(const Vec3d& normal, double cosine) const {
    return std::ranges::all_of(part_, [&](int i) {
        return mesh_.normal(static_cast<std::size_t>(i)).dot(normal) >= cosine;
    });
}

SlimPatch SlimFitter::fitted(const Vec3d& centre_world, double radius_world) const {
    SlimPatch patch{.centre_world = centre_world, .radius_world = radius_world};
    Vec3d normal = Vec3d::Zero();
    for (const Leaf& leaf : leaves_)
        normal += (leaf.corners[1] - leaf.corners[0]).cross(leaf.corners[2] - leaf.corners[0]);
    if (normal.isZero(0)) normal = mesh_.normal(static_cast<std::size_t>(part_.front()));
    patch.normal = normal.stableNormalized();
    const Mat3d axes_by_radius = slim_axes(patch.normal) / radius_world;
    HeightFit fit;
    const auto add = [&](const Vec3d& p, double weight) {
        fit.add(axes_by_radius.transpose() * p, weight);
    };
    for (const Leaf& leaf : leaves_) {
        if (samples_.size() >= enough_samples) break;
        const auto& [a, b, c] = leaf.corners;
        const double weight = between_weight * (b - a).cross(c - a).norm();
        for (const Vec3d& p : leaf.middles) add(p, weight);
    }
    for (const Sample& sample : samples_) add(sample.p, sample.weight);
    patch.height = HeightFit::height_of(fit.solved(), radius_world);
    return patch;
}

double SlimFitter::residual(const SlimPatch& patch, double most_spare_world) const {
    const Mat3d axes = slim_axes(patch.normal);
    const auto off = [&](const Vec3d& p) { return height_over(patch, axes, p); };
    double greatest = 0;
    for (const Sample& sample : samples_) greatest = std::max(greatest, std::abs(off(sample.p)));
    for (const Leaf& leaf : leaves_) {
        const double spare = std::min(leaf.spare_world, most_spare_world);
        for (const auto* points : {&leaf.corners, &leaf.middles})
            for (const Vec3d& p : *points)
                if (p.squaredNorm() < patch.radius_world * patch.radius_world)
                    greatest = std::max(greatest, std::abs(off(p)) - spare);
    }
    return greatest;
}

void SlimFitter::even_out(SlimPiece& piece, double bound_world, double most_spare_world) {
    if (samples_.size() < enough_samples || piece.residual_world > hopeless * bound_world) return;
    SlimPatch patch = piece.patch;
    for (int round = 0; round < rounds && piece.residual_world > bound_world; ++round) {
        double sum = 0;
        for (const Sample& sample : samples_) sum += sample.weight;
        const Mat3d axes = slim_axes(patch.normal);
        double next = 0;
        for (Sample& sample : samples_) {
            sample.weight *= std::abs(height_over(patch, axes, sample.p)) / bound_world;
            next += sample.weight;
        }
        for (Sample& sample : samples_) sample.weight *= sum / next;
        patch = fitted(patch.centre_world, patch.radius_world);
        const double greatest = residual(patch, most_spare_world);
        if (greatest < piece.residual_world) {
            piece.patch = patch;
            piece.residual_world = greatest;
        }
    }
}

int SlimFitter::group_ends() {
    for (End& end : ends_) end.chain = -1;
    int count = 0;
    for (std::size_t first = 0; first < ends_.size(); ++first) {
        if (ends_[first].chain >= 0) continue;
        ends_[first].chain = count;
        std::vector<std::size_t> open{first};
        while (!open.empty()) {
            const End one = ends_[open.back()];
            open.pop_back();
            for (std::size_t j = 0; j < ends_.size(); ++j) {
                End& other = ends_[j];
                if (other.chain >= 0) continue;
                const bool follows = other.from == one.to || other.to == one.from ||
                                     (other.from == one.from && other.to == one.to);
                const Vec3d d = (one.b - one.a).normalized();
                if (!follows || d.dot((other.b - other.a).normalized()) < least_turn_cosine)
                    continue;
                other.chain = count;
                open.push_back(j);
            }
        }
        ++count;
    }
    return count;
}

bool SlimFitter::clip(SlimPatch& patch, double max_error_world) {
    const int count = group_ends();
    if (count > 2) return false;
    const double spare = max_error_world / 2;
    for (int chain = 0; chain < count; ++chain) {
        Vec3d inwards = Vec3d::Zero();
        Vec3d normal = Vec3d::Zero();
        Vec3d beyond = Vec3d::Zero();
        Vec3d middle = Vec3d::Zero();
        double length = 0;
        for (const End& end : ends_) {
            if (end.chain != chain) continue;
            const double part = (end.b - end.a).norm();
            length += part;
            middle += part / 2 * (end.a + end.b);
            inwards += part * end.inwards;
            normal += part * end.normal;
            beyond += part * end.beyond;
        }
        if (!(length > 0) || normal.isZero(0) || inwards.isZero(0)) return false;
        middle /= length;
        normal.normalize();
        beyond /= length;
        Mat3d spread = Mat3d::Zero();
        for (const End& end : ends_) {
            if (end.chain != chain) continue;
            for (const Vec3d& p : {end.a, end.b})
                spread += (end.b - end.a).norm() * (p - middle) * (p - middle).transpose();
        }
        const Eigen::SelfAdjointEigenSolver<Mat3d> solver(spread);
        const Vec3d along = solver.eigenvectors().col(2);
        // Halfway between the two faces; in the face beyond; through an arc.
        double least = spare / 2;
        SlimPlane& plane = patch.planes[static_cast<std::size_t>(chain)];
        bool is_found = false;
        for (Vec3d m :
             {Vec3d(along.cross(normal + beyond)), beyond, Vec3d(solver.eigenvectors().col(0))}) {
            if (!(m.norm() > 1e-3)) continue; // along the crease, to its roundings, or none
            m.normalize();
            if (m.dot(inwards) < 0) m = -m;
            const double across = normal.cross(m).norm(); // of the angle with the face
            if (across < 0.4) continue; // as a face that is seen edge-on by 24 degrees
            double lowest = 0;
            double off = 0;
            for (const End& end : ends_)
                if (end.chain == chain)
                    for (const Vec3d& p : {end.a, end.b}) {
                        lowest = std::min(lowest, m.dot(p - middle));
                        off = std::max(off, std::abs(m.dot(p - middle)) / across);
                    }
            if (!(off <= least)) continue;
            least = off;
            is_found = true;
            plane = {m, -m.dot(middle) - lowest + spare * across};
        }
        if (!is_found) return false;
    }
    patch.plane_count = count;
    const auto keeps_all = [&] {
        return std::ranges::all_of(leaves_, [&](const Leaf& leaf) {
            return std::ranges::all_of(leaf.corners, [&](const Vec3d& p) {
                return p.norm() >= patch.radius_world || is_kept(patch, p);
            });
        });
    };
    if (keeps_all()) return true;
    if (count < 2) return false;
    patch.is_any = true;
    // Each plane's own end must be one: what the other keeps is no farther.
    return keeps_all() && std::ranges::all_of(ends_, [&](const End& end) {
               const SlimPlane& other = patch.planes[end.chain == 0 ? 1 : 0];
               return other.side_of(end.a) <= 2 * spare && other.side_of(end.b) <= 2 * spare;
           });
}

/// Whether the part reaches wherever the planes let the patch reach its sphere. Two planes along a
/// sliver of a part keep a needle beyond its short end, which lies within the error of both.
bool SlimFitter::ends_with_part(const SlimPatch& patch, double max_error_world) const {
    const Mat3d axes = slim_axes(patch.normal);
    std::vector<std::array<Eigen::Vector2d, 3>> part;
    for (const Leaf& leaf : leaves_) {
        auto& corners = part.emplace_back();
        for (std::size_t k = 0; k < 3; ++k)
            corners[k] = (axes.transpose() * leaf.corners[k]).head<2>();
    }
    const auto rim = [&](double turn) {
        const double angle = 2 * std::numbers::pi * turn;
        Vec3d q;
        double rho = patch.radius_world;
        for (int round = 0; round < 3; ++round) { // towards the sphere
            const double u = rho * std::cos(angle);
            const double v = rho * std::sin(angle);
            q = {u, v, height_at(patch, u, v)};
            rho *= patch.radius_world / q.norm();
        }
        return q;
    };
    const auto is_covered = [&](double turn) {
        const Vec3d q = rim(turn);
        return !is_kept(patch, axes * q) || std::ranges::any_of(part, [&](const auto& corners) {
            return distance(q.head<2>(), corners) <= 2 * max_error_world;
        });
    };
    // The arcs between planes, however short.
    constexpr int steps = 48;
    std::vector<double> turns;
    for (int i = 0; i < steps; ++i) turns.push_back(double(i) / steps);
    for (std::size_t k = 0; k < static_cast<std::size_t>(patch.plane_count); ++k) {
        const auto side = [&](double turn) { return patch.planes[k].side_of(axes * rim(turn)); };
        for (int i = 0; i < steps; ++i) {
            double lo = double(i) / steps;
            double hi = double(i + 1) / steps;
            const bool is_in = side(lo) >= 0;
            if (is_in == (side(hi) >= 0)) continue;
            for (int round = 0; round < 40; ++round)
                (((side((lo + hi) / 2) >= 0) == is_in) ? lo : hi) = (lo + hi) / 2;
            turns.push_back(lo);
        }
    }
    std::ranges::sort(turns);
    for (std::size_t i = 0; i < turns.size(); ++i) {
        const double next = i + 1 < turns.size() ? turns[i + 1] : 1;
        if (!is_covered((turns[i] + next) / 2)) return false;
    }
    return true;
}

std::optional<SlimPiece> SlimFitter::fit_collected(const Vec3d& centre_world, double radius_world,
                                                   double max_error_world) {
    SlimPiece piece{.patch = fitted(centre_world, radius_world)};
    if (!is_graph(piece.patch.normal, slim_least_cosine)) return std::nullopt;
    const double between = most_spare_errors * max_error_world;
    piece.residual_world = residual(piece.patch, between);
    const double spare = spare_of(radius_world, max_error_world);
    const double bound = ends_.empty() ? spare : max_error_world / 2;
    even_out(piece, bound, between);
    if (!(piece.residual_world <= bound)) return std::nullopt;
    if (!ends_.empty() && spare < max_error_world) return std::nullopt; // it might not meet others
    if (!ends_.empty() &&
        !(clip(piece.patch, max_error_world) && ends_with_part(piece.patch, max_error_world)))
        return std::nullopt;
    if (!(rim_residual(piece.patch) <= (1 + most_spare_errors) * max_error_world))
        return std::nullopt;
    piece.triangles = part_;
    return piece;
}

/// Where edges of leaves leave the sphere.
double SlimFitter::rim_residual(const SlimPatch& patch) const {
    const Mat3d axes = slim_axes(patch.normal);
    const double radius2 = patch.radius_world * patch.radius_world;
    double greatest = 0;
    for (const Leaf& leaf : leaves_)
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3d& a = leaf.corners[k];
            const Vec3d& b = leaf.corners[(k + 1) % 3];
            const Vec3d& m = leaf.middles[k];
            const Vec3d slope = 4 * m - 3 * a - b;
            const Vec3d bend = 2 * (a + b - 2 * m);
            const std::array beyond{a.squaredNorm() - radius2, m.squaredNorm() - radius2,
                                    b.squaredNorm() - radius2};
            for (const std::size_t half : {0U, 1U}) {
                // By the false position: squared distances are nearly linear in between.
                double in = beyond[half] < 0 ? half / 2.0 : (half + 1) / 2.0;
                double out = beyond[half] < 0 ? (half + 1) / 2.0 : half / 2.0;
                double at_in = std::min(beyond[half], beyond[half + 1]);
                double at_out = std::max(beyond[half], beyond[half + 1]);
                if (at_in >= 0 || at_out < 0) continue;
                Vec3d p = Vec3d::Zero();
                for (int round = 0; round < rim_rounds; ++round) {
                    const double s = in + at_in / (at_in - at_out) * (out - in);
                    p = a + s * (slope + s * bend);
                    const double at = p.squaredNorm() - radius2;
                    (at < 0 ? in : out) = s;
                    (at < 0 ? at_in : at_out) = at;
                }
                greatest = std::max(greatest, std::abs(height_over(patch, axes, p)));
            }
        }
    return greatest;
}

std::optional<SlimPiece> SlimFitter::fit(int triangle, const Vec3d& centre_world,
                                         double radius_world, double max_error_world) {
    collect(triangle, centre_world, radius_world, true);
    auto piece = fit_collected(centre_world, radius_world, max_error_world);
    if (piece || !has_creases_) return piece;
    collect(triangle, centre_world, radius_world, false);
    return fit_collected(centre_world, radius_world, max_error_world);
}

SlimPiece SlimFitter::fall_back(int triangle, const Vec3d& centre_world, double max_error_world) {
    const double radius_world = slim_fall_back_errors * max_error_world;
    collect(triangle, centre_world, radius_world, false);
    SlimPiece piece{.patch = fitted(centre_world, radius_world)};
    piece.patch.height = {};
    piece.residual_world = residual(piece.patch, most_spare_errors * max_error_world);
    piece.triangles = part_;
    return piece;
}

double SlimFitter::errors_of(const SlimPiece& piece, double max_error_world) {
    const SlimPatch& patch = piece.patch;
    leaves_.clear();
    samples_.clear(); // they are corners of leaves
    for (const int triangle : piece.triangles) {
        const auto i = static_cast<std::size_t>(triangle);
        std::array<Vec3d, 3> p;
        for (std::size_t k = 0; k < 3; ++k)
            p[k] = mesh_.vertex(mesh_.corners_of(i)[k]) - patch.centre_world;
        add_triangle(i, p, patch.centre_world, patch.radius_world);
    }
    const double off = std::max(residual(patch, 0), rim_residual(patch));
    return std::max(1.0, between_places * off / max_error_world);
}

} // namespace isocast
