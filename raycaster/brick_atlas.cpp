// SPDX-License-Identifier: MPL-2.0
#include "raycaster/brick_atlas.h"

#include "volume/errors.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace isocast {

namespace {

constexpr std::size_t floats_per_brick = std::size_t{brick_samples} * brick_samples * brick_samples;

/// Greatest |c[i+1] - c[i]| along each axis, as the length of the three together.
float greatest_slope_of(std::span<const float> brick) {
    const std::array<int, 3> stride = {1, brick_samples, brick_samples * brick_samples};
    float squared = 0;
    for (int axis = 0; axis < 3; ++axis) {
        float greatest = 0;
        for (int z = 0; z < brick_samples - (axis == 2); ++z)
            for (int y = 0; y < brick_samples - (axis == 1); ++y)
                for (int x = 0; x < brick_samples - (axis == 0); ++x) {
                    const int i = x + brick_samples * (y + brick_samples * z);
                    greatest = std::max(greatest,
                                        std::abs(brick[std::size_t(i + stride[std::size_t(axis)])] -
                                                 brick[std::size_t(i)]));
                }
        squared += greatest * greatest;
    }
    return std::sqrt(squared);
}

} // namespace

Index3 AtlasLayout::first_texel(int n) const {
    const Index3 place(n % bricks_per_row, n / bricks_per_row % bricks_per_row,
                       n / (bricks_per_row * bricks_per_row));
    return place * brick_samples;
}

AtlasLayout plan_atlas(int brick_count, int max_extent) {
    AtlasLayout layout;
    // Rows of 1, 3, 7, 14, … bricks: as many as fit into 64, 128, 256, … texels.
    for (int extent = std::bit_ceil(unsigned{brick_samples}); extent <= max_extent; extent *= 2) {
        layout.bricks_per_row = extent / brick_samples;
        const int per_layer = layout.bricks_per_row * layout.bricks_per_row;
        layout.layers = (brick_count + per_layer - 1) / per_layer;
        layout.texels = Index3(extent, extent, std::max(1, layout.layers) * brick_samples);
        if (layout.layers <= layout.bricks_per_row) return layout;
    }
    if (layout.texels.z() == 0 || layout.texels.z() > max_extent)
        throw ResourceError(fmt::format("the surface touches {} bricks of {}^3 samples, more than "
                                        "one texture of {}^3 holds; use a coarser voxel size",
                                        brick_count, brick_samples, max_extent));
    return layout;
}

BrickAtlas::BrickAtlas(const FieldSource& field, float iso, const ActiveBlocks& blocks,
                       const Progress& progress) {
    const std::vector<Index3> bricks = bricks_of(blocks);
    brick_count_ = static_cast<int>(bricks.size());
    const AtlasLayout layout = plan_atlas(brick_count_, gl::max_volume_extent());
    atlas_scale_ = layout.texels.cast<float>().cwiseInverse();
    atlas_ = gl::Texture::volume(gl::Format::R32f, layout.texels.x(), layout.texels.y(),
                                 layout.texels.z(), gl::Filter::Linear, "brick atlas");

    // One brick of margin on every side: the ray's first and last sample lie up to one step outside
    // the active blocks.
    Index3 lo = Index3::Zero();
    Index3 hi = Index3::Zero();
    if (!bricks.empty()) {
        lo = bricks.front();
        hi = bricks.front();
        for (const Index3& brick : bricks) {
            lo = lo.cwiseMin(brick);
            hi = hi.cwiseMax(brick);
        }
    }
    lo.array() -= 1;
    hi.array() += 2;
    const Index3 size = hi - lo;
    if (size.maxCoeff() > gl::max_volume_extent())
        throw ResourceError(fmt::format("the surface spans {} bricks along one axis, more than the "
                                        "{} that a texture holds",
                                        size.maxCoeff(), gl::max_volume_extent()));
    const Index3 origin_brick = lo + size / 2;
    local_origin_index_ = origin_brick * brick_size;
    first_brick_local_ = lo - origin_brick;
    extent_local_ = {field.extent().lo - local_origin_index_,
                     field.extent().hi - local_origin_index_};

    // Reference: xyz the texel of the brick's own corner sample, w 0; or, where no brick is stored,
    // w the constant that stands for the field: no surface is there, so only its sign matters.
    std::vector<Eigen::Vector4f> reference(static_cast<std::size_t>(size.prod()));
    const auto at = [&](const Index3& brick) -> Eigen::Vector4f& {
        const Index3 p = brick - lo;
        return reference[static_cast<std::size_t>(p.x() + size.x() * (p.y() + size.y() * p.z()))];
    };
    std::vector<bool> is_stored(reference.size(), false);
    for (int n = 0; n < brick_count_; ++n) {
        const Index3 corner = layout.first_texel(n) + Index3::Constant(filter_support_below);
        Eigen::Vector4f& entry = at(bricks[static_cast<std::size_t>(n)]);
        entry << corner.cast<float>(), 0.0f;
        is_stored[static_cast<std::size_t>(&entry - reference.data())] = true;
    }
    tbb::parallel_for(0, static_cast<int>(reference.size()), [&](int i) {
        if (is_stored[static_cast<std::size_t>(i)]) return;
        const Index3 brick =
            lo + Index3(i % size.x(), i / size.x() % size.y(), i / (size.x() * size.y()));
        const float value = sample(field, brick * brick_size) - iso;
        // Zero would mean "stored".
        reference[static_cast<std::size_t>(i)] =
            Eigen::Vector4f(0, 0, 0, value == 0 ? std::numeric_limits<float>::min() : value);
    });
    reference_ = gl::Texture::volume(gl::Format::Rgba32f, size.x(), size.y(), size.z(),
                                     gl::Filter::Nearest, "brick reference");
    reference_.upload_box(0, 0, 0, size.x(), size.y(), size.z(),
                          {reference.front().data(), reference.size() * 4});

    // Bricks are cut a batch at a time by all threads and uploaded by this one, which owns the GL.
    constexpr int batch = 64;
    std::vector<float> samples(batch * floats_per_brick);
    std::array<float, batch> slopes{};
    for (int first = 0; first < brick_count_; first += batch) {
        if (progress) progress("upload", double(first) / brick_count_);
        const int count = std::min(batch, brick_count_ - first);
        const auto brick_values = [&](int i) {
            return std::span<float>(samples).subspan(std::size_t(i) * floats_per_brick,
                                                     floats_per_brick);
        };
        tbb::parallel_for(0, count, [&](int i) {
            const std::span<float> values = brick_values(i);
            cut_brick(field, bricks[static_cast<std::size_t>(first + i)], values);
            for (float& value : values) value -= iso;
            slopes[static_cast<std::size_t>(i)] = greatest_slope_of(values);
        });
        for (int i = 0; i < count; ++i) {
            const Index3 texel = layout.first_texel(first + i);
            atlas_.upload_box(texel.x(), texel.y(), texel.z(), brick_samples, brick_samples,
                              brick_samples, brick_values(i));
            greatest_slope_ = std::max(greatest_slope_, slopes[static_cast<std::size_t>(i)]);
        }
    }
}

void BrickAtlas::bind(const gl::Program& program) const {
    atlas_.bind_to_unit(0);
    reference_.bind_to_unit(1);
    program.set("u_atlas_scale", atlas_scale_);
    program.set("u_first_brick_local", Eigen::Vector3i(first_brick_local_));
    program.set("u_extent_lo", Eigen::Vector3f(extent_local_.lo.cast<float>()));
    program.set("u_extent_hi", Eigen::Vector3f((extent_local_.hi - Index3::Ones()).cast<float>()));
}

} // namespace isocast
