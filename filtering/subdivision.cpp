// Cubic B-splines of lower resolution.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/subdivision.h"

#include "volume/assert.h"

#include <array>
#include <cmath>

namespace isocast {

namespace {

/// Subdivides along one axis: of samples `step` apart in `rows` lines of `from` samples each.
std::vector<double> subdivided_along(int axis, const std::vector<double>& coarse,
                                     const Index3& size, int lo, int coarse_lo, int count) {
    Index3 out_size = size;
    out_size[axis] = count;
    const std::ptrdiff_t step = axis == 0 ? 1 : axis == 1 ? size.x() : size.x() * size.y();
    const std::ptrdiff_t outer = std::ptrdiff_t{size.prod()} / (step * size[axis]);
    std::vector<double> fine(static_cast<std::size_t>(out_size.prod()));
    double* to = fine.data();
    for (std::ptrdiff_t slab = 0; slab < outer; ++slab) {
        const double* first = coarse.data() + slab * step * size[axis];
        for (int k = 0; k < count; ++k, to += step) {
            const int i = lo + k;
            const bool is_odd = (i & 1) != 0;
            const double* c = first + ((i >> 1) - coarse_lo) * step;
            for (std::ptrdiff_t j = 0; j < step; ++j)
                to[j] =
                    is_odd ? (c[j] + c[j + step]) / 2 : (c[j - step] + 6 * c[j] + c[j + step]) / 8;
        }
    }
    return fine;
}

} // namespace

IndexBox coarse_support(const IndexBox& box) {
    return {floor_div((box.lo.array() - 1).matrix(), 2),
            (floor_div((box.hi.array() - 1).matrix(), 2).array() + 2).matrix()};
}

std::vector<double> subdivided(std::vector<double> coarse, const IndexBox& box) {
    const IndexBox support = coarse_support(box);
    ISOCAST_ASSERT(std::ssize(coarse) == support.sample_count(), "%td samples for %td",
                   std::ssize(coarse), static_cast<std::ptrdiff_t>(support.sample_count()));
    Index3 size = support.size();
    for (int axis = 0; axis < 3; ++axis) {
        coarse =
            subdivided_along(axis, coarse, size, box.lo[axis], support.lo[axis], box.size()[axis]);
        size[axis] = box.size()[axis];
    }
    return coarse;
}

std::vector<double> coarse_samples(const FieldSource& control, const IndexBox& box, int level) {
    const int step = 1 << level;
    // Read at level 0: a view may have other samples at its own levels.
    const IndexBox read{step * (box.lo.array() - 1).matrix(), (step * box.hi.array() + 1).matrix()};
    std::vector<float> samples(static_cast<std::size_t>(read.sample_count()));
    control.copy_box(read, 0, samples);
    const std::ptrdiff_t row = read.size().x();
    const std::array<std::ptrdiff_t, 3> steps{step, step * row, step * row * read.size().y()};
    const double weight = (1 - std::exp2(-2 * level)) / 6;
    std::vector<double> out;
    out.reserve(static_cast<std::size_t>(box.sample_count()));
    const Index3 n = box.size();
    for (int z = 1; z <= n.z(); ++z) {
        for (int y = 1; y <= n.y(); ++y) {
            for (int x = 1; x <= n.x(); ++x) {
                const float* c = samples.data() + x * steps[0] + y * steps[1] + z * steps[2];
                double laplacian = 0;
                for (const std::ptrdiff_t s : steps)
                    laplacian += (double{c[-s]} - c[0]) + (double{c[s]} - c[0]);
                out.push_back(c[0] - weight * laplacian);
            }
        }
    }
    return out;
}

} // namespace isocast
