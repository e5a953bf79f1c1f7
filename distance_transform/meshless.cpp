// Signed distance to oriented points: planes blended by weights of the nearest points.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/meshless.h"

#include "volume/errors.h"

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace isocast {

namespace {

using Matrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;

struct MethodName {
    std::string_view name;
    PointMethod method;
};

constexpr std::array method_names = {MethodName{"partition", PointMethod::Partition},
                                     MethodName{"printed", PointMethod::Printed},
                                     MethodName{"shepard", PointMethod::Shepard},
                                     MethodName{"modified-shepard", PointMethod::ModifiedShepard},
                                     MethodName{"rbf", PointMethod::Rbf},
                                     MethodName{"mls", PointMethod::Mls}};

/// 1 for normals less than 60 degrees apart, 0 from 90 degrees on.
double agreement(const Vec3d& a, const Vec3d& b) {
    const double t = std::clamp(2 * a.dot(b), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

/// (4.10) of r / cutoff
double printed_weight(double r) {
    const double t = std::max(1 - r * r, 0.0);
    return t * t * t;
}

/// Wendland's function of smoothness C2, positive definite in three dimensions.
double wendland(double r) {
    const double t = std::max(1 - r, 0.0);
    return t * t * t * t * (4 * r + 1);
}

/// Solves a x = b so that no equation is off by more than `greatest_residual`.
Eigen::VectorXd solved(const Matrix& a, const Eigen::VectorXd& b, double greatest_residual) {
    Eigen::BiCGSTAB<Matrix, Eigen::IncompleteLUT<double>> solver;
    solver.preconditioner().setDroptol(1e-3); // with both, two or three steps are enough
    solver.preconditioner().setFillfactor(4);
    solver.setTolerance(1e-8); // of a round; what it leaves is the next round's right side
    solver.setMaxIterations(100);
    solver.compute(a);
    Eigen::VectorXd x = Eigen::VectorXd::Zero(b.size());
    Eigen::VectorXd residual = b;
    constexpr int rounds = 4;
    for (int i = 0; i < rounds; ++i) {
        if (residual.cwiseAbs().maxCoeff() <= greatest_residual) return x;
        x += solver.solve(residual);
        residual = b - a * x;
    }
    throw InputError("the points cannot be interpolated: their system of equations is too near to "
                     "singular; let the surface pass by them (an approximation above 0)");
}

} // namespace

PointMethod point_method_from_name(std::string_view name) {
    std::string known;
    for (const MethodName& entry : method_names) {
        if (entry.name == name) return entry.method;
        known += fmt::format("{}{}", known.empty() ? "" : ", ", entry.name);
    }
    throw InputError(fmt::format("unknown point method '{}' (known: {})", name, known));
}

std::string_view name_of(PointMethod method) {
    return std::ranges::find(method_names, method, &MethodName::method)->name;
}

double relative_deviation(std::span<const double> distances) {
    const auto count = static_cast<double>(distances.size());
    double mean = 0;
    for (const double r : distances) mean += r / count;
    // Deviations from the mean, since the mean of squares less its square cancels far away.
    double variance = 0;
    for (const double r : distances) variance += (r - mean) * (r - mean) / count;
    return mean > 0 ? std::sqrt(variance) / mean : 0;
}

double near_weight(std::span<const double> distances) {
    const double deviation = relative_deviation(distances);
    if (deviation == 0) return 0;
    const double t = std::clamp((1 / deviation - std::sqrt(8.0)) / 25, 0.0, 1.0);
    return (1 - t) * (1 - t) * (1 - t);
}

double Meshless::Value::blended(bool negative) const {
    const double signed_far = negative ? -far : far;
    if (near_weight == 1 || far == 0) return near;
    const double flatness = std::pow(std::min(std::abs(near) / far, 1.0), near_weight);
    return near + (1 - near_weight) * flatness * (signed_far - near);
}

Meshless::Meshless(std::vector<Vec3d> points, std::vector<Vec3d> normals,
                   const MeshlessOptions& options)
    : options_(options), points_(std::move(points)), normals_(std::move(normals)), tree_(points_),
      constants_(points_.size(), 0.0), centres_({}) {
    if (options.neighbours < 4)
        throw InputError(fmt::format("{} neighbours are too few: a surface needs 4 at least",
                                     options.neighbours));
    if (!(options.approximation >= 0) || !std::isfinite(options.approximation))
        throw InputError(fmt::format("an approximation of {} is not 0 or a positive number",
                                     options.approximation));
    if (points_.size() < seen_points())
        throw InputError(fmt::format("{} points are too few: {} neighbours need {} at least",
                                     points_.size(), options.neighbours, seen_points()));
    if (options.method == PointMethod::Partition || options.method == PointMethod::Printed)
        solve_constants();
    if (options.method == PointMethod::Rbf) solve_radial();
}

bool Meshless::weights(std::span<const Neighbour> seen, std::span<const double> distances,
                       std::span<double> out) const {
    // The last of them is the first that no longer counts.
    const double cutoff = distances.back();
    const Vec3d& facing = normals_[seen[0].point];
    bool all_agree = true;
    double sum = 0;
    for (std::size_t i = 0; i < seen.size(); ++i) {
        const double r = distances[i];
        double weight = 0;
        switch (options_.method) {
        case PointMethod::Partition:
        case PointMethod::Mls:
        case PointMethod::Rbf:
            weight = wendland(r / cutoff);
            break;
        case PointMethod::Printed:
            weight = printed_weight(r / cutoff);
            break;
        case PointMethod::Shepard:
            weight = 1 / (r * r);
            break;
        case PointMethod::ModifiedShepard:
            weight = std::pow((cutoff - r) / r, 2);
            break;
        }
        if (std::isinf(weight)) { // others are nothing beside it
            std::ranges::fill(out, 0.0);
            out[i] = 1;
            return true;
        }
        const double agrees = agreement(facing, normals_[seen[i].point]);
        all_agree = all_agree && agrees == 1;
        if (options_.same_side) weight *= agrees;
        out[i] = weight;
        sum += weight;
    }
    if (sum > 0) {
        for (double& weight : out) weight /= sum;
    } else { // all are as far as the cutoff
        std::ranges::fill(out, 0.0);
        out[0] = 1;
    }
    return all_agree;
}

Meshless::Value Meshless::at(const Vec3d& p) const {
    thread_local std::vector<Neighbour> seen;
    tree_.nearest(p, seen_points(), seen);
    return at(p, seen);
}

Meshless::Value Meshless::at(const Vec3d& p, std::span<const Neighbour> seen) const {
    thread_local std::vector<double> distances;
    thread_local std::vector<double> weight;
    distances.resize(seen.size());
    weight.resize(seen.size());
    for (std::size_t i = 0; i < seen.size(); ++i)
        distances[i] = std::sqrt(seen[i].squared_distance);
    Value value{.near = 0,
                .far = distances[0],
                .near_weight = isocast::near_weight(std::span(distances).first(seen.size() - 1)),
                .nearest = seen[0].point,
                .all_agree = weights(seen, distances, weight)};
    if (options_.method == PointMethod::Mls) {
        value.near = projected(p, seen);
    } else if (options_.method == PointMethod::Rbf) {
        value.near = radial(p);
    } else {
        for (std::size_t i = 0; i < seen.size(); ++i)
            if (weight[i] > 0) value.near += weight[i] * plane(seen[i].point, p);
    }
    return value;
}

/// The plane whose normal is the mean of the normals has the least squared distance (4.3) to the
/// points where it holds their mean; p is moved onto it, and again from where it came to.
double Meshless::projected(const Vec3d& p, std::span<const Neighbour> seen) const {
    constexpr int rounds = 3; // the last moves the foot by less than a hundredth of a spacing
    std::vector<Neighbour> around_foot(seen.begin(), seen.end());
    std::vector<double> distances(seen.size());
    std::vector<double> weight(seen.size());
    Vec3d foot = p;
    double distance = 0;
    for (int i = 0; i < rounds; ++i) {
        for (Neighbour& n : around_foot)
            n.squared_distance = (points_[n.point] - foot).squaredNorm();
        std::ranges::sort(around_foot);
        for (std::size_t k = 0; k < seen.size(); ++k)
            distances[k] = std::sqrt(around_foot[k].squared_distance);
        weights(around_foot, distances, weight);
        Vec3d normal = Vec3d::Zero();
        Vec3d middle = Vec3d::Zero();
        for (std::size_t k = 0; k < around_foot.size(); ++k) {
            normal += weight[k] * normals_[around_foot[k].point];
            middle += weight[k] * (points_[around_foot[k].point] - p);
        }
        normal.stableNormalize();
        distance = -normal.dot(middle);
        foot = p - distance * normal;
    }
    return distance;
}

double Meshless::radial(const Vec3d& p) const {
    thread_local std::vector<Neighbour> centres;
    centres_.within(p, radius_, centres);
    double sum = 0;
    for (const Neighbour& n : centres)
        sum += centre_weights_[n.point] * wendland(std::sqrt(n.squared_distance) / radius_);
    return sum;
}

/// f_near(x_j) = 0 at every point: row j holds the weights at x_j. With an approximation a, added
/// to the diagonal, the constants are damped and f_near(x_j) = -a c_j.
void Meshless::solve_constants() {
    const std::size_t count = points_.size();
    const std::size_t width = seen_points();
    std::vector<Neighbour> neighbours(count * width);
    std::vector<double> row_weights(count * width);
    Eigen::VectorXd right_side(count);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 256), [&](const auto& range) {
        std::vector<Neighbour> seen;
        std::vector<double> distances(width);
        for (std::size_t j = range.begin(); j < range.end(); ++j) {
            tree_.nearest(points_[j], width, seen);
            const std::span<double> row(row_weights.data() + j * width, width);
            for (std::size_t i = 0; i < width; ++i)
                distances[i] = std::sqrt(seen[i].squared_distance);
            weights(seen, distances, row);
            std::ranges::copy(seen, neighbours.begin() + static_cast<std::ptrdiff_t>(j * width));
            double planes = 0;
            for (std::size_t i = 0; i < width; ++i)
                planes += row[i] * plane(seen[i].point, points_[j]);
            right_side[static_cast<Eigen::Index>(j)] = -planes;
        }
    });
    Matrix matrix(count, count);
    matrix.reserve(
        Eigen::VectorXi::Constant(static_cast<Eigen::Index>(count), options_.neighbours));
    double spacing = 0; // mean distance to the nearest other point
    for (std::size_t j = 0; j < count; ++j) {
        for (std::size_t i = 0; i < width; ++i) {
            const double weight = row_weights[j * width + i];
            if (weight > 0)
                matrix.insert(static_cast<Eigen::Index>(j), neighbours[j * width + i].point) =
                    weight + (i == 0 ? options_.approximation : 0);
        }
        spacing +=
            std::sqrt(neighbours[j * width + 1].squared_distance) / static_cast<double>(count);
    }
    matrix.makeCompressed();
    const Eigen::VectorXd solution = solved(matrix, right_side, 1e-11 * spacing);
    std::ranges::copy(solution, constants_.begin());
}

/// After Carr et al. 2001 (thesis, 4.3.4): 0 at the points, ± an offset at two more of each.
void Meshless::solve_radial() {
    const std::size_t count = points_.size();
    double spacing = 0;
    std::vector<Neighbour> seen;
    for (const Vec3d& p : points_) {
        tree_.nearest(p, 5, seen);
        spacing += std::sqrt(seen.back().squared_distance) / static_cast<double>(count);
    }
    radius_ = 3 * spacing;
    std::vector<Vec3d> centres = points_;
    std::vector<double> values(count, 0.0);
    for (const double side : {1.0, -1.0}) {
        for (std::size_t i = 0; i < count; ++i) {
            // Halved where it comes nearer to another point than to its own.
            double offset = spacing;
            Vec3d centre;
            for (int halvings = 0; halvings < 4; ++halvings, offset /= 2) {
                centre = points_[i] + side * offset * normals_[i];
                tree_.nearest(centre, 1, seen);
                if (seen[0].point == static_cast<std::int32_t>(i)) break;
            }
            centres.push_back(centre);
            values.push_back((centre - points_[i]).dot(normals_[i]));
        }
    }
    const Eigen::Map<const Eigen::VectorXd> right_side(values.data(),
                                                       static_cast<Eigen::Index>(values.size()));
    centres_ = PointTree(centres);
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t j = 0; j < centres.size(); ++j) {
        centres_.within(centres[j], radius_, seen);
        for (const Neighbour& n : seen)
            entries.emplace_back(static_cast<int>(j), n.point,
                                 wendland(std::sqrt(n.squared_distance) / radius_));
        entries.emplace_back(static_cast<int>(j), static_cast<int>(j), options_.approximation);
    }
    Matrix matrix(static_cast<Eigen::Index>(centres.size()),
                  static_cast<Eigen::Index>(centres.size()));
    matrix.setFromTriplets(entries.begin(), entries.end());
    const Eigen::VectorXd solution = solved(matrix, right_side, 1e-9 * spacing);
    centre_weights_.assign(solution.begin(), solution.end());
}

} // namespace isocast
