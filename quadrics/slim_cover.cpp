// SPDX-License-Identifier: MPL-2.0
#include "quadrics/slim_cover.h"

#include "quadrics/scrambled.h"
#include "quadrics/slim_fit.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace isocast {

namespace {

/// Of the error, the least radius that is tried.
constexpr double least_radius_errors = 3.0 / 16;

/// A part of a triangle, to be covered as a whole.
struct Part {
    int triangle;
    Mat3d corners_barycentric;           // columns
    std::array<Vec3d, 6> points_world{}; // corners, then middles of edges
    std::uint64_t order;
};

Part part_of(const SlimMesh& mesh, int triangle, const Mat3d& corners_barycentric,
             std::uint64_t order) {
    Part part{.triangle = triangle, .corners_barycentric = corners_barycentric, .order = order};
    const auto i = static_cast<std::size_t>(triangle);
    for (int k = 0; k < 3; ++k) {
        const Vec3d corner = corners_barycentric.col(k);
        const Vec3d next = corners_barycentric.col((k + 1) % 3);
        part.points_world[static_cast<std::size_t>(k)] = mesh.point(i, corner);
        part.points_world[static_cast<std::size_t>(k + 3)] = mesh.point(i, (corner + next) / 2);
    }
    return part;
}

bool covers(const SlimPatch& patch, const Part& part, double max_error_world) {
    const double reach =
        std::min(slim_covered_share * patch.radius_world,
                 patch.radius_world - spare_of(patch.radius_world, max_error_world));
    return std::ranges::all_of(part.points_world, [&](const Vec3d& p) {
        return (p - patch.centre_world).squaredNorm() <= reach * reach;
    });
}

class Cover {
public:
    Cover(const SlimMesh& mesh, double max_error_world)
        : mesh_(mesh), max_error_world_(max_error_world), pieces_of_(mesh.size()),
          fitters_([&] { return SlimFitter(mesh_); }),
          least_radius_(least_radius_errors * max_error_world) {}

    void run(const Progress& progress);
    SlimLevel level(SlimReport& report);

private:
    bool is_covered(const Part& part) const {
        return std::ranges::any_of(pieces_of_[static_cast<std::size_t>(part.triangle)], [&](int i) {
            return covers(piece(i).patch, part, max_error_world_);
        });
    }
    const SlimPiece& piece(int i) const { return pieces_[static_cast<std::size_t>(i)]; }
    SlimPiece grown(const Part& part);
    void split(const Part& part);

    const SlimMesh& mesh_;
    double max_error_world_;
    std::vector<std::vector<int>> pieces_of_; // by triangle
    tbb::enumerable_thread_specific<SlimFitter> fitters_;
    double least_radius_;
    std::vector<SlimPiece> pieces_;
    std::vector<Part> waiting_; // the last first
    std::vector<Part> done_;
};

SlimPiece Cover::grown(const Part& part) {
    SlimFitter& fitter = fitters_.local();
    const Vec3d centre = mesh_.point(static_cast<std::size_t>(part.triangle),
                                     part.corners_barycentric.rowwise().mean());
    const double error = max_error_world_;
    double size = 0;
    for (const Vec3d& p : part.points_world) size = std::max(size, (p - centre).norm());
    std::optional<SlimPiece> best;
    // From about what the part takes, up while it goes well, or down until it does.
    double good = 0;
    double bad = 0;
    const double greatest =
        std::max(slim_greatest_radius_share * mesh_.diagonal_world(), least_radius_);
    double radius = std::clamp(4 * size, least_radius_, greatest);
    while (good == 0 || bad == 0 || bad > good * slim_radius_precision) {
        auto piece = fitter.fit(part.triangle, centre, radius, error);
        if (piece) {
            best = std::move(piece);
            good = radius;
            if (radius == greatest) break;
            radius = bad == 0 ? std::min(2 * radius, greatest) : std::sqrt(good * bad);
        } else {
            bad = radius;
            if (radius == least_radius_) break;
            radius = good == 0 ? std::max(radius / 2, least_radius_) : std::sqrt(good * bad);
        }
    }
    return best ? std::move(*best)
                : fitter.fall_back(part.triangle, centre, slim_fall_back_errors * max_error_world_);
}

void Cover::split(const Part& part) {
    const Mat3d& l = part.corners_barycentric;
    Mat3d middles;
    for (int k = 0; k < 3; ++k) middles.col(k) = (l.col(k) + l.col((k + 1) % 3)) / 2;
    std::uint64_t order = part.order;
    for (int k = 0; k < 4; ++k) {
        Mat3d corners = middles;
        if (k < 3) corners << middles.col(k), l.col((k + 1) % 3), middles.col((k + 1) % 3);
        waiting_.push_back(part_of(mesh_, part.triangle, corners, order = scrambled(order)));
    }
}

void Cover::run(const Progress& progress) {
    for (std::size_t i = 0; i < mesh_.size(); ++i)
        waiting_.push_back(part_of(mesh_, static_cast<int>(i), Mat3d::Identity(), scrambled(i)));
    std::ranges::sort(waiting_, {}, &Part::order);
    while (!waiting_.empty()) {
        // Some at a time, whose spheres seldom meet while there are few: the same for any threads.
        const std::size_t count =
            std::min(waiting_.size(), std::max<std::size_t>(32, pieces_.size() / 8));
        std::vector<Part> batch;
        while (!waiting_.empty() && batch.size() < count) {
            const Part part = waiting_.back();
            waiting_.pop_back();
            (is_covered(part) ? done_ : batch).push_back(part);
        }
        std::vector<SlimPiece> made(batch.size());
        tbb::parallel_for(std::size_t{0}, batch.size(),
                          [&](std::size_t i) { made[i] = grown(batch[i]); });
        for (std::size_t i = 0; i < batch.size(); ++i) {
            if (is_covered(batch[i])) {
                done_.push_back(batch[i]);
                continue;
            }
            const int number = static_cast<int>(pieces_.size());
            for (const int triangle : made[i].triangles)
                pieces_of_[static_cast<std::size_t>(triangle)].push_back(number);
            pieces_.push_back(std::move(made[i]));
            if (is_covered(batch[i]))
                done_.push_back(batch[i]);
            else
                split(batch[i]);
        }
        if (progress)
            progress("covering", static_cast<double>(done_.size()) /
                                     static_cast<double>(done_.size() + waiting_.size()));
    }
}

SlimLevel Cover::level(SlimReport& report) {
    std::vector<std::vector<int>> of_part(done_.size());
    tbb::parallel_for(std::size_t{0}, done_.size(), [&](std::size_t i) {
        for (const int p : pieces_of_[static_cast<std::size_t>(done_[i].triangle)])
            if (covers(piece(p).patch, done_[i], max_error_world_)) of_part[i].push_back(p);
    });
    std::vector<double> radii(pieces_.size());
    for (std::size_t p = 0; p < pieces_.size(); ++p) radii[p] = pieces_[p].patch.radius_world;
    const std::vector<bool> stays = needed_patches(of_part, radii);
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
