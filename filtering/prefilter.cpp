// Coefficients with which the cubic B-spline passes through the samples.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/prefilter.h"

#include "volume/errors.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <vector>

namespace isocast {

namespace {

/// Lines solved side by side, so that the recursion runs in vectors.
constexpr int lanes = 16;

/// Solves (c[i-1] + 4 c[i] + c[i+1])/6 = f[i], 0 <= i < n, with c[-1] = c[0] and c[n] = c[n-1].
class LineSolver {
public:
    explicit LineSolver(int n) : inverse_pivots_(static_cast<std::size_t>(n)) {
        // Rows of the system: 5 1 | 1 4 1 | … | 1 5; a line of one sample is 6.
        double pivot = 0;
        for (int i = 0; i < n; ++i) {
            const double diagonal = 4 + (i == 0 ? 1 : 0) + (i == n - 1 ? 1 : 0);
            pivot = i == 0 ? diagonal : diagonal - 1 / pivot;
            inverse_pivots_[static_cast<std::size_t>(i)] = 1 / pivot;
        }
    }

    /// In place, `count` lines at `first` + lane * lane_stride.
    void solve(float* first, std::ptrdiff_t stride, std::ptrdiff_t lane_stride, int count) const {
        const std::size_t n = inverse_pivots_.size();
        // In double: what is rounded to float are results only.
        std::vector<std::array<double, lanes>> rows(n);
        for (std::size_t i = 0; i < n; ++i) {
            const float* from = first + static_cast<std::ptrdiff_t>(i) * stride;
            for (int lane = 0; lane < count; ++lane) {
                rows[i][static_cast<std::size_t>(lane)] = 6.0 * from[lane * lane_stride];
            }
        }
        for (std::size_t i = 1; i < n; ++i) {
            for (std::size_t lane = 0; lane < lanes; ++lane) {
                rows[i][lane] -= inverse_pivots_[i - 1] * rows[i - 1][lane];
            }
        }
        std::array<double, lanes> next{};
        for (std::size_t i = n; i-- > 0;) {
            for (std::size_t lane = 0; lane < lanes; ++lane) {
                next[lane] = (rows[i][lane] - next[lane]) * inverse_pivots_[i];
            }
            float* to = first + static_cast<std::ptrdiff_t>(i) * stride;
            for (int lane = 0; lane < count; ++lane) {
                to[lane * lane_stride] = static_cast<float>(next[static_cast<std::size_t>(lane)]);
            }
        }
    }

private:
    std::vector<double> inverse_pivots_;
};

} // namespace

std::shared_ptr<const DenseField>
spline_coefficients(const FieldSource& field, const Progress& progress, double memory_bytes) {
    if (field.half_width_world()) {
        throw InputError(
            "the filter 'exact' needs samples that are not cut off at a band's half width; this "
            "field has a band: use 'interpolating', which is local and as accurate near the "
            "surface");
    }
    const IndexBox extent = field.extent();
    const Index3 n = extent.size();
    const double bytes = static_cast<double>(extent.sample_count()) * sizeof(float);
    if (bytes > memory_bytes) {
        throw ResourceError(fmt::format(
            "the filter 'exact' stores {} x {} x {} coefficients, {:.3g} GiB, more than the limit "
            "of {:.3g} GiB: use 'interpolating', which stores none",
            n.x(), n.y(), n.z(), bytes / 0x1p30, memory_bytes / 0x1p30));
    }

    std::vector<float> values(static_cast<std::size_t>(extent.sample_count()));
    const std::ptrdiff_t stride_y = n.x();
    const std::ptrdiff_t stride_z = stride_y * n.y();
    std::atomic<int> planes = 0;
    const auto plane_done = [&] {
        const int done = ++planes;
        if (progress && done % 16 == 0) progress("prefilter", done / (2.0 * n.z() + n.y()));
    };
    const LineSolver solver_x(n.x());
    const LineSolver solver_y(n.y());
    const LineSolver solver_z(n.z());
    // Planes of constant z: read, then solved along x and y; planes of constant y along z.
    tbb::parallel_for(0, n.z(), [&](int z) {
        float* plane = values.data() + z * stride_z;
        field.copy_box({{extent.lo.x(), extent.lo.y(), extent.lo.z() + z},
                        {extent.hi.x(), extent.hi.y(), extent.lo.z() + z + 1}},
                       0, {plane, static_cast<std::size_t>(stride_z)});
        plane_done();
        for (int y = 0; y < n.y(); y += lanes) {
            solver_x.solve(plane + y * stride_y, 1, stride_y, std::min(lanes, n.y() - y));
        }
        for (int x = 0; x < n.x(); x += lanes) {
            solver_y.solve(plane + x, stride_y, 1, std::min(lanes, n.x() - x));
        }
        plane_done();
    });
    tbb::parallel_for(0, n.y(), [&](int y) {
        for (int x = 0; x < n.x(); x += lanes) {
            solver_z.solve(values.data() + y * stride_y + x, stride_z, 1,
                           std::min(lanes, n.x() - x));
        }
        plane_done();
    });
    return std::make_shared<DenseField>(field.space(), extent, std::move(values));
}

} // namespace isocast
