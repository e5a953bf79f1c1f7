// SPDX-License-Identifier: MPL-2.0
#include "raycaster/certified_caster.h"

#include "filtering/blocks.h"
#include "filtering/reconstruct.h"
#include "raycaster/ray_span.h"
#include "volume/available_memory.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>

namespace isocast {

namespace {

constexpr int page_samples = page_size + filter_support_below + filter_support_above;

using Support = std::array<double, 64>; // x fastest

/// 21 bits an axis: no field is 2^26 samples long, so that no two of its pages have the same.
std::uint64_t key_of(const Index3& page) {
    const auto bits = [](int i) { return static_cast<std::uint64_t>(i) & 0x1fffff; };
    return bits(page.x()) | bits(page.y()) << 21 | bits(page.z()) << 42;
}

/// at  the cell's place in its page
std::size_t number_in_page(const Index3& at) {
    return static_cast<std::size_t>(at.x() + page_size * (at.y() + page_size * at.z()));
}

/// What the cell reads of its page's samples, less iso.
Support support_of(const std::vector<float>& samples, const Index3& at, double iso) {
    Support c;
    for (int k = 0; k < 4; ++k)
        for (int j = 0; j < 4; ++j) {
            const float* row = &samples[static_cast<std::size_t>(
                ((at.z() + k) * page_samples + at.y() + j) * page_samples + at.x())];
            for (int i = 0; i < 4; ++i)
                c[static_cast<std::size_t>(i + 4 * (j + 4 * k))] = row[i] - iso;
        }
    return c;
}

/// Four samples along an axis become the Bezier points of the cell between the middle two.
void to_bezier(double& c0, double& c1, double& c2, double& c3, Kernel kernel) {
    const std::array c{c0, c1, c2, c3};
    switch (kernel) {
    case Kernel::Linear: // raised to a cubic
        c0 = c[1];
        c1 = (2 * c[1] + c[2]) / 3;
        c2 = (c[1] + 2 * c[2]) / 3;
        c3 = c[2];
        break;
    case Kernel::BSpline:
        c0 = (c[0] + 4 * c[1] + c[2]) / 6;
        c1 = (2 * c[1] + c[2]) / 3;
        c2 = (c[1] + 2 * c[2]) / 3;
        c3 = (c[1] + 4 * c[2] + c[3]) / 6;
        break;
    case Kernel::CatmullRom: // a third of the way along the end slopes
        c0 = c[1];
        c1 = c[1] + (c[2] - c[0]) / 6;
        c2 = c[2] - (c[3] - c[1]) / 6;
        c3 = c[2];
        break;
    }
}

/// Calls f with the four numbers of each run along an axis.
template<class Function>
void for_each_run(Support& c, int axis, Function f) {
    const std::size_t stride = axis == 0 ? 1 : axis == 1 ? 4 : 16;
    for (std::size_t i = 0; i < 64; ++i)
        if (i / stride % 4 == 0) f(c[i], c[i + stride], c[i + 2 * stride], c[i + 3 * stride]);
}

/// Whether the function is on one side of zero for sure.
bool is_on_one_side(Support c, Kernel kernel) {
    // Some weights of Catmull-Rom's are negative; those of Bezier points are not.
    if (kernel == Kernel::CatmullRom)
        for (int axis = 0; axis < 3; ++axis)
            for_each_run(c, axis, [&](double& c0, double& c1, double& c2, double& c3) {
                to_bezier(c0, c1, c2, c3, kernel);
            });
    const auto inside = std::ranges::count_if(c, [](double value) { return value < 0; });
    return inside == 0 || inside == 64;
}

double mean(double a, double b, double share_of_b) {
    return (1 - share_of_b) * a + share_of_b * b;
}

/// The Bezier points of a cubic from a to b, which may be before a: its blossom at these.
void restrict_to(double& p0, double& p1, double& p2, double& p3, double a, double b) {
    const std::array at_a{mean(p0, p1, a), mean(p1, p2, a), mean(p2, p3, a)};
    const std::array at_b{mean(p0, p1, b), mean(p1, p2, b), mean(p2, p3, b)};
    const auto twice = [](const std::array<double, 3>& p, double u) {
        return std::array{mean(p[0], p[1], u), mean(p[1], p[2], u)};
    };
    const std::array aa = twice(at_a, a);
    const std::array ab = twice(at_a, b);
    const std::array bb = twice(at_b, b);
    p0 = mean(aa[0], aa[1], a);
    p1 = mean(aa[0], aa[1], b);
    p2 = mean(ab[0], ab[1], b);
    p3 = mean(bb[0], bb[1], b);
}

} // namespace

CertifiedCaster::CertifiedCaster(std::shared_ptr<const FieldSource> control, Kernel kernel,
                                 double iso, const Progress& progress)
    : control_(std::move(control)), kernel_(kernel), iso_(iso), extent_(control_->extent()) {
    const std::vector<BlockPage> listed = find_blocks(*control_).pages;
    const IndexBox cells{extent_.lo, (extent_.hi.array() - 1).max(extent_.lo.array() + 1).matrix()};
    const double limit = 0.5 * available_memory_bytes();
    std::mutex mutex;
    std::atomic<std::size_t> done = 0;
    tbb::parallel_for(std::size_t{0}, listed.size(), [&](std::size_t i) {
        const Index3 first = page_size * listed[i].coordinate;
        const Index3 lo = (first.array() - filter_support_below).matrix();
        Page page{std::vector<float>(std::size_t{page_samples} * page_samples * page_samples), {}};
        control_->copy_box({lo, (lo.array() + page_samples).matrix()}, 0, page.samples);
        const IndexBox in_page = intersection(cells, {first, (first.array() + page_size).matrix()});
        for (int z = in_page.lo.z(); z < in_page.hi.z(); ++z)
            for (int y = in_page.lo.y(); y < in_page.hi.y(); ++y)
                for (int x = in_page.lo.x(); x < in_page.hi.x(); ++x) {
                    const Index3 at = Index3(x, y, z) - first;
                    if (!is_on_one_side(support_of(page.samples, at, iso_), kernel_))
                        page.unknown.set(number_in_page(at));
                }
        if (page.unknown.any()) {
            const std::lock_guard lock(mutex);
            pages_.emplace(key_of(listed[i].coordinate), std::move(page));
            const double bytes = double(pages_.size()) *
                                 (double(sizeof(float)) * std::pow(page_samples, 3) + sizeof(Page));
            if (bytes > limit)
                throw ResourceError(fmt::format("what lies near the surface takes more than {:.1f} "
                                                "GiB in the reference",
                                                limit / 0x1p30));
        }
        if (progress) progress("preparing", double(++done) / double(listed.size()));
    });
}

std::optional<CertifiedCaster::InCell>
CertifiedCaster::in_cell(const Index3& cell, const Vec3d& from, const Vec3d& to) const {
    const Index3 page = floor_div(cell, page_size);
    const auto found = pages_.find(key_of(page));
    const Index3 at = cell - page_size * page;
    if (found == pages_.end() || !found->second.unknown.test(number_in_page(at))) return {};
    Support c = support_of(found->second.samples, at, iso_);
    InCell out{{}, 0};
    for (const double value : c) out.greatest = std::max(out.greatest, std::abs(value));
    for (int axis = 0; axis < 3; ++axis)
        for_each_run(c, axis, [&](double& p0, double& p1, double& p2, double& p3) {
            to_bezier(p0, p1, p2, p3, kernel_);
            restrict_to(p0, p1, p2, p3, from[axis], to[axis]);
        });
    constexpr std::array<double, 4> of_3{1, 3, 3, 1};
    constexpr std::array<double, 10> of_9{1, 9, 36, 84, 126, 126, 84, 36, 9, 1};
    for (std::size_t i = 0; i < 64; ++i) {
        const std::size_t x = i % 4;
        const std::size_t y = i / 4 % 4;
        const std::size_t z = i / 16;
        out.polynomial[x + y + z] += of_3[x] * of_3[y] * of_3[z] / of_9[x + y + z] * c[i];
    }
    return out;
}

void CertifiedCaster::find_changes(const Bernstein& polynomial, double noise, double s_lo,
                                   double s_hi, int depth, bool& is_inside,
                                   std::vector<double>& changes) {
    const auto count = std::ranges::count_if(polynomial, [](double c) { return c < 0; });
    if (count == 0 || count == 10) {
        if ((count == 10) != is_inside) changes.push_back(s_lo); // by rounding, at an end
        is_inside = count == 10;
        return;
    }
    constexpr int greatest_depth = 48; // sqrt 3 2^-48 voxel
    if (depth == greatest_depth ||
        std::ranges::all_of(polynomial, [&](double c) { return std::abs(c) <= noise; })) {
        if ((polynomial.back() < 0) != is_inside) changes.push_back(0.5 * (s_lo + s_hi));
        is_inside = polynomial.back() < 0;
        return;
    }
    Bernstein first; // de Casteljau's
    Bernstein second = polynomial;
    for (std::size_t k = 0; k < 10; ++k) {
        first[k] = second[0];
        for (std::size_t i = 0; i + k < 9; ++i) second[i] = 0.5 * (second[i] + second[i + 1]);
    }
    const double middle = 0.5 * (s_lo + s_hi);
    find_changes(first, noise, s_lo, middle, depth + 1, is_inside, changes);
    find_changes(second, noise, middle, s_hi, depth + 1, is_inside, changes);
}

CertifiedCaster::Walk::Walk(const CertifiedCaster& caster, const Ray& ray) : caster_(caster) {
    const GridSpace& space = caster.control_->space();
    const Vec3d origin = space.to_index(ray.origin_world);
    direction_ = space.world_from_index.linear().inverse() * ray.direction_world;
    const IndexBox& extent = caster.extent_;
    const RaySpan span = span_in_box(origin, direction_, extent.lo.cast<double>(),
                                     (extent.hi.array() - 1).matrix().cast<double>());
    if (span.is_empty()) return;
    t_entry_ = span.begin;
    length_ = span.end - span.begin;
    entry_ = (origin + t_entry_ * direction_)
                 .cwiseMax(extent.lo.cast<double>())
                 .cwiseMin((extent.hi.array() - 1).matrix().cast<double>());
    cell_ = entry_.array()
                .floor()
                .cast<int>()
                .min(extent.hi.array() - 2)
                .max(extent.lo.array())
                .matrix();
    is_done_ = false;
    const Vec3d at = entry_ - cell_.cast<double>();
    const auto first = caster.in_cell(cell_, at, at);
    starts_inside_ = first ? first->polynomial.front() < 0
                           : kernel_value(*caster.control_, entry_, caster.kernel_) < caster.iso_;
    is_inside_ = starts_inside_;
}

void CertifiedCaster::Walk::cross_cell() {
    double s_exit = length_;
    int axis_out = -1;
    for (int axis = 0; axis < 3; ++axis) {
        if (direction_[axis] == 0) continue;
        const double face = cell_[axis] + (direction_[axis] > 0 ? 1 : 0);
        const double s = (face - entry_[axis]) / direction_[axis];
        if (s < s_exit) {
            s_exit = s;
            axis_out = axis;
        }
    }
    s_exit = std::max(s_exit, s_);
    const auto in_cell = [&](double s) -> Vec3d {
        return (entry_ + s * direction_ - cell_.cast<double>()).cwiseMax(0).cwiseMin(1);
    };
    changes_.clear();
    seen_ = 0;
    if (const auto along = caster_.in_cell(cell_, in_cell(s_), in_cell(s_exit)))
        find_changes(along->polynomial, 0x1p-46 * along->greatest, s_, s_exit, 0, is_inside_,
                     changes_);
    s_ = s_exit;
    is_done_ = axis_out < 0;
    if (is_done_) return;
    cell_[axis_out] += direction_[axis_out] > 0 ? 1 : -1;
    is_done_ = cell_[axis_out] < caster_.extent_.lo[axis_out] ||
               cell_[axis_out] > caster_.extent_.hi[axis_out] - 2;
}

std::optional<double> CertifiedCaster::Walk::next() {
    while (seen_ == changes_.size()) {
        if (is_done_) return std::nullopt;
        cross_cell();
    }
    return t_entry_ + changes_[seen_++];
}

} // namespace isocast
