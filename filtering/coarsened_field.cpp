// A field some of whose blocks have a lower resolution, as one B-spline.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/coarsened_field.h"

#include "filtering/subdivision.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace isocast {

namespace {

std::size_t place_of(const Index3& block, const Index3& page) {
    const Index3 p = block - page_blocks * page;
    return static_cast<std::size_t>(place_in_page(p.x(), p.y(), p.z()));
}

/// Where sample `index` is in the array of `box`.
std::size_t in_box(const IndexBox& box, int x, int y, int z) {
    const Index3 n = box.size();
    return static_cast<std::size_t>(
        (x - box.lo.x()) +
        std::ptrdiff_t{n.x()} * ((y - box.lo.y()) + std::ptrdiff_t{n.y()} * (z - box.lo.z())));
}

/// Calls use(y, z) for the rows of a box.
template<class Use>
void for_rows(const IndexBox& box, Use use) {
    for (int z = box.lo.z(); z < box.hi.z(); ++z)
        for (int y = box.lo.y(); y < box.hi.y(); ++y) use(y, z);
}

} // namespace

std::size_t BlockLevels::Hash::operator()(const Index3& page) const {
    return (static_cast<std::size_t>(page.z()) * 73856093U) ^
           (static_cast<std::size_t>(page.y()) * 19349663U) ^
           (static_cast<std::size_t>(page.x()) * 83492791U); // Teschner et al. 2003
}

void BlockLevels::set(const Index3& block, int level) {
    const Index3 page = floor_div(block, page_blocks);
    pages_[page][place_of(block, page)] = static_cast<std::uint8_t>(level);
}

int BlockLevels::at(const Index3& block) const {
    const Index3 page = floor_div(block, page_blocks);
    const auto found = pages_.find(page);
    return found == pages_.end() ? 0 : found->second[place_of(block, page)];
}

std::vector<Index3> BlockLevels::coarse_blocks() const {
    std::vector<Index3> blocks;
    for (const auto& [page, levels] : pages_) {
        for (int place = 0; place < blocks_per_page; ++place) {
            if (levels[static_cast<std::size_t>(place)] > 0)
                blocks.push_back(page_blocks * page + block_in_page(place));
        }
    }
    return blocks;
}

CoarsenedField::CoarsenedField(std::shared_ptr<const FieldSource> control, BlockLevels levels,
                               bool is_adaptive)
    : control_(std::move(control)), levels_(std::move(levels)), is_adaptive_(is_adaptive) {}

std::vector<double> CoarsenedField::samples_at(const IndexBox& box, int level) const {
    const auto count = static_cast<std::size_t>(box.sample_count());
    const int cells = block_size >> level;
    // The samples that coarser blocks determine.
    std::vector<IndexBox> parts;
    IndexBox all_parts;
    if (level < coarsest_level) {
        const Index3 lo = floor_div((box.lo.array() - 2).matrix(), cells);
        const Index3 hi = floor_div(box.hi, cells);
        for_rows({lo, (hi.array() + 1).matrix()}, [&](int y, int z) {
            for (int x = lo.x(); x <= hi.x(); ++x) {
                const Index3 block(x, y, z);
                if (levels_.at(block) <= level) continue;
                const IndexBox closed{(cells * block.array() - 1).matrix(),
                                      (cells * (block.array() + 1) + 2).matrix()};
                const IndexBox part = intersection(closed, box);
                if (part.is_empty()) continue;
                parts.push_back(part);
                all_parts = bounding_box(all_parts, part);
            }
        });
    }
    std::vector<double> samples(count);
    std::vector<std::uint8_t> is_set(count);
    std::size_t set_count = 0;
    if (!parts.empty()) {
        const std::vector<double> fine =
            subdivided(samples_at(coarse_support(all_parts), level + 1), all_parts);
        for (const IndexBox& part : parts) {
            for_rows(part, [&](int y, int z) {
                std::size_t to = in_box(box, part.lo.x(), y, z);
                std::size_t from = in_box(all_parts, part.lo.x(), y, z);
                for (int x = part.lo.x(); x < part.hi.x(); ++x, ++to, ++from) {
                    samples[to] = static_cast<float>(fine[from]);
                    set_count += is_set[to] == 0 ? 1 : 0;
                    is_set[to] = 1;
                }
            });
        }
    }
    if (set_count == count) return samples;
    if (level == 0 || is_adaptive_) {
        std::vector<float> own(count);
        control_->copy_box(box, level, own);
        for (std::size_t i = 0; i < count; ++i)
            if (is_set[i] == 0) samples[i] = own[i];
    } else {
        const std::vector<double> own = coarse_samples(*control_, box, level);
        for (std::size_t i = 0; i < count; ++i)
            if (is_set[i] == 0) samples[i] = static_cast<float>(own[i]);
    }
    return samples;
}

std::vector<IndexBox> CoarsenedField::active_boxes() const {
    std::vector<IndexBox> boxes = control_->active_boxes();
    if (!half_width_world()) return boxes; // beyond the extent there is no field
    for (const Index3& block : levels_.coarse_blocks())
        boxes.push_back({(block_size * block.array() - 1).matrix(),
                         (block_size * (block.array() + 1) + 2).matrix()});
    return runs_of_blocks(boxes);
}

ValueRange CoarsenedField::value_range(const IndexBox& box) const {
    // A sample of the coarsest level reads 8 voxels to each side, and is itself less than 16 from
    // those that it makes; subdivision takes means.
    constexpr int reach = 24;
    const ValueRange range = control_->value_range(dilated(box, reach, reach));
    constexpr float infinity = std::numeric_limits<float>::infinity();
    const double width = double{range.max} - range.min;
    return {std::nextafter(static_cast<float>(range.min - width), -infinity),
            std::nextafter(static_cast<float>(range.max + width), infinity)};
}

void CoarsenedField::copy_box(const IndexBox& box, int level, std::span<float> out) const {
    if (box.is_empty()) return;
    const int step = 1 << level;
    const IndexBox read{step * box.lo, (step * (box.hi.array() - 1) + 1).matrix()};
    const std::vector<double> samples = samples_at(read, 0);
    std::size_t to = 0;
    for_rows(box, [&](int y, int z) {
        for (int x = box.lo.x(); x < box.hi.x(); ++x)
            out[to++] = static_cast<float>(samples[in_box(read, step * x, step * y, step * z)]);
    });
}

} // namespace isocast
