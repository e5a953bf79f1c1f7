// SPDX-License-Identifier: MPL-2.0
#include "quadrics/slim_cover.h"

#include "quadrics/scrambled.h"
#include "quadrics/slim_fit.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>

namespace isocast {

namespace {

/// Of the error, the least radius that is tried.
constexpr double least_radius_errors = 3.0 / 16;

/// Of the radii of the pieces about, how far parts may reach from their middle: else much is
/// covered twice, since a little of a large part is left over.
constexpr double part_share = 0.3;
/// Of the pieces so far, how many more at a time: spheres that grow together seldom meet.
constexpr std::size_t pieces_by_batch = 16;
constexpr std::size_t least_batch = 32;
/// A search that starts where another piece ended.
constexpr double small_step = 1.2;

/// A part of a triangle, to be covered as a whole.
struct Part {
    int triangle;
    Mat3d corners_barycentric; // columns
    std::uint64_t order;
    double radius_world = 0; // of a piece there, where the next may start from; 0: none yet
};

/// Where a part lies.
struct Place {
    Place(const SlimMesh& mesh, const Part& part) {
        const auto i = static_cast<std::size_t>(part.triangle);
        const Mat3d& l = part.corners_barycentric;
        middle_world = mesh.point(i, l.rowwise().mean());
        for (int k = 0; k < 3; ++k) {
            const Vec3d corner = l.col(k);
            const Vec3d next = l.col((k + 1) % 3);
            points_world[static_cast<std::size_t>(k)] = mesh.point(i, corner);
            points_world[static_cast<std::size_t>(k + 3)] = mesh.point(i, (corner + next) / 2);
        }
        for (const Vec3d& p : points_world)
            size_world = std::max(size_world, (p - middle_world).norm());
    }
    std::array<Vec3d, 6> points_world{}; // corners, then middles of edges
    Vec3d middle_world;
    double size_world = 0; // how far these are from the middle
};

/// Coarse: a piece reaches into the part, by whose radius it is too large.
enum class State { Open, Coarse, Covered };

class Cover {
public:
    Cover(const SlimMesh& mesh, double max_error_world)
        : mesh_(mesh), max_error_world_(max_error_world), pieces_of_(mesh.size()),
          fitters_([&] { return SlimFitter(mesh_); }),
          least_radius_(least_radius_errors * max_error_world) {}

    void run(const Progress& progress);
    SlimLevel level(SlimReport& report);

private:
    struct Sphere { // of a piece, and how much of it covers
        Vec3d centre_world;
        double radius_world, reach_world;

        bool covers(const Place& place) const {
            return std::ranges::all_of(place.points_world, [&](const Vec3d& p) {
                return (p - centre_world).squaredNorm() <= reach_world * reach_world;
            });
        }
    };
    State state_of(Part& part) const;
    void add(SlimPiece piece);
    SlimPiece grown(const Part& part);
    void cover(std::vector<Part> waiting, const std::function<void(double)>& progress);

    const SlimMesh& mesh_;
    double max_error_world_;
    std::vector<std::vector<int>> pieces_of_; // by triangle
    tbb::enumerable_thread_specific<SlimFitter> fitters_;
    double least_radius_;
    std::vector<SlimPiece> pieces_;
    std::vector<Sphere> spheres_; // of pieces
    int first_ = 0;               // piece of this round
    std::vector<Part> done_;
};

/// By the pieces of this round. What is covered learns by which radius.
State Cover::state_of(Part& part) const {
    const Place place(mesh_, part);
    bool is_coarse = false;
    const auto& pieces = pieces_of_[static_cast<std::size_t>(part.triangle)];
    for (auto i = pieces.rbegin(); i != pieces.rend() && *i >= first_; ++i) {
        const Sphere& sphere = spheres_[static_cast<std::size_t>(*i)];
        const bool is_fine = place.size_world <= part_share * sphere.radius_world;
        if (is_fine && sphere.covers(place)) {
            part.radius_world = sphere.radius_world;
            return State::Covered;
        }
        is_coarse = is_coarse || (!is_fine && (sphere.centre_world - place.middle_world).norm() <
                                                  sphere.radius_world + place.size_world);
    }
    return is_coarse ? State::Coarse : State::Open;
}

void Cover::add(SlimPiece piece) {
    const double radius = piece.patch.radius_world;
    for (const int triangle : piece.triangles)
        pieces_of_[static_cast<std::size_t>(triangle)].push_back(static_cast<int>(pieces_.size()));
    spheres_.push_back(
        {piece.patch.centre_world, radius,
         std::min(slim_covered_share * radius, radius - spare_of(radius, max_error_world_))});
    pieces_.push_back(std::move(piece));
}

SlimPiece Cover::grown(const Part& part) {
    SlimFitter& fitter = fitters_.local();
    const Place place(mesh_, part);
    const double error = max_error_world_;
    std::optional<SlimPiece> best;
    // From another piece's radius, or from about what the part takes, up while it goes well, or
    // down until it does.
    const bool is_hinted = part.radius_world > 0;
    const double step = is_hinted ? small_step : 2;
    double good = 0;
    double bad = 0;
    const double greatest =
        std::max(slim_greatest_radius_share * mesh_.diagonal_world(), least_radius_);
    double radius =
        std::clamp(is_hinted ? part.radius_world : 4 * place.size_world, least_radius_, greatest);
    while (good == 0 || bad == 0 || bad > good * slim_radius_precision) {
        auto piece = fitter.fit(part.triangle, place.middle_world, radius, error);
        if (piece) {
            best = std::move(piece);
            good = radius;
            if (radius == greatest) break;
            radius = bad == 0 ? std::min(step * radius, greatest) : std::sqrt(good * bad);
        } else {
            bad = radius;
            if (radius == least_radius_) break;
            radius = good == 0 ? std::max(radius / step, least_radius_) : std::sqrt(good * bad);
        }
    }
    return best ? std::move(*best)
                : fitter.fall_back(part.triangle, place.middle_world, max_error_world_);
}

/// Its longest edge, by way of its middle: so slivers do not become ever more slivers, nor edges
/// that bow out and back ever more of those.
void halve(const SlimMesh& mesh, const Part& part, std::vector<Part>& into) {
    const Place place(mesh, part);
    std::array<double, 3> lengths{};
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3d& middle = place.points_world[k + 3];
        lengths[k] = (middle - place.points_world[k]).norm() +
                     (place.points_world[(k + 1) % 3] - middle).norm();
    }
    const auto longest = std::ranges::max_element(lengths) - lengths.begin();
    const auto from = static_cast<int>(longest);
    const int to = (from + 1) % 3;
    const Mat3d& l = part.corners_barycentric;
    Part half = part;
    for (const int moved : {from, to}) {
        half.corners_barycentric = l;
        half.corners_barycentric.col(moved) = (l.col(from) + l.col(to)) / 2;
        half.order = scrambled(half.order);
        into.push_back(half);
    }
}

/// With pieces of their own for all parts, which become ever smaller. Of open ones on a triangle or
/// its neighbours one alone gets a piece at a time: it may cover the others.
void Cover::cover(std::vector<Part> waiting, const std::function<void(double)>& progress) {
    first_ = static_cast<int>(pieces_.size());
    done_.clear();
    std::vector<std::size_t> taken(mesh_.size(), 0); // by triangle: the batch
    std::size_t batch_number = 0;
    while (!waiting.empty()) {
        std::ranges::sort(waiting, {}, &Part::order);
        std::vector<Part> next;
        for (std::size_t at = 0; at < waiting.size();) {
            const std::size_t made_so_far = pieces_.size() - static_cast<std::size_t>(first_);
            const std::size_t count =
                std::min(waiting.size() - at, std::max(least_batch, made_so_far / pieces_by_batch));
            const std::span<Part> some(waiting.data() + at, count);
            at += count;
            std::vector<State> states(count);
            tbb::parallel_for(std::size_t{0}, count,
                              [&](std::size_t i) { states[i] = state_of(some[i]); });
            std::vector<Part> open;
            ++batch_number;
            for (std::size_t i = 0; i < count; ++i) {
                if (states[i] == State::Covered) done_.push_back(some[i]);
                if (states[i] == State::Coarse) halve(mesh_, some[i], next);
                if (states[i] != State::Open) continue;
                const auto triangle = static_cast<std::size_t>(some[i].triangle);
                const bool is_alone = taken[triangle] != batch_number;
                (is_alone ? open : next).push_back(some[i]);
                if (!is_alone) continue;
                taken[triangle] = batch_number;
                for (std::size_t k = 0; k < 3; ++k)
                    if (const int n = mesh_.side(triangle, k).neighbour; n >= 0)
                        taken[static_cast<std::size_t>(n)] = batch_number;
            }
            std::vector<SlimPiece> made(open.size());
            tbb::parallel_for(std::size_t{0}, open.size(),
                              [&](std::size_t i) { made[i] = grown(open[i]); });
            for (std::size_t i = 0; i < open.size(); ++i) {
                open[i].radius_world = made[i].patch.radius_world;
                add(std::move(made[i]));
            }
            for (Part& part : open)
                if (state_of(part) == State::Covered)
                    done_.push_back(part);
                else
                    halve(mesh_, part, next);
            if (progress)
                progress(static_cast<double>(done_.size()) /
                         static_cast<double>(done_.size() + waiting.size() - at + next.size()));
        }
        waiting = std::move(next);
    }
}

void Cover::run(const Progress& progress) {
    std::vector<Part> parts;
    for (std::size_t i = 0; i < mesh_.size(); ++i)
        parts.push_back({.triangle = static_cast<int>(i),
                         .corners_barycentric = Mat3d::Identity(),
                         .order = scrambled(i)});
    for (int round = 0; round < slim_rounds; ++round) {
        cover(std::move(parts), [&](double share) {
            if (progress) progress("covering", (round + share) / slim_rounds);
        });
        parts = done_;
        for (Part& part : parts) part.order = scrambled(part.order);
    }
}

SlimLevel Cover::level(SlimReport& report) {
    std::vector<std::vector<int>> of_part(done_.size());
    tbb::parallel_for(std::size_t{0}, done_.size(), [&](std::size_t i) {
        const Place place(mesh_, done_[i]);
        for (const int p : pieces_of_[static_cast<std::size_t>(done_[i].triangle)])
            if (spheres_[static_cast<std::size_t>(p)].covers(place)) of_part[i].push_back(p);
    });
    const std::vector<bool> stays = needed_patches(of_part, pieces_.size());
    tbb::parallel_for(std::size_t{0}, pieces_.size(), [&](std::size_t p) {
        if (stays[p])
            pieces_[p].patch.errors = fitters_.local().errors_of(pieces_[p], max_error_world_);
    });
    SlimLevel out{.patches = {}, .max_error_world = max_error_world_};
    for (std::size_t p = 0; p < pieces_.size(); ++p) {
        if (!stays[p]) continue;
        out.patches.push_back(pieces_[p].patch);
        report.with_planes += pieces_[p].patch.plane_count > 0 ? 1 : 0;
        report.over_bound += pieces_[p].residual_world > max_error_world_ ? 1 : 0;
        report.greatest_error_world =
            std::max(report.greatest_error_world, pieces_[p].residual_world);
    }
    return out;
}

} // namespace

SlimSurface slim_of(const TriangleMesh& mesh, const SlimOptions& options,
                    std::vector<SlimReport>& reports, const Progress& progress) {
    const SlimMesh with_sides(mesh, options.crease_degrees);
    SlimSurface out =
        with_levels(options.max_error_world, options.max_levels, with_sides.diagonal_world(),
                    reports, [&](double max_error_world, SlimReport& report) {
                        Cover cover(with_sides, max_error_world);
                        cover.run(progress);
                        return cover.level(report);
                    });
    out.is_closed = with_sides.is_closed();
    return out;
}

} // namespace isocast
