// SPDX-License-Identifier: MPL-2.0
#include "apps/picture.h"

#include "gl/objects.h"
#include "raycaster/effects/flow.h"

#include <algorithm>
#include <cmath>

namespace isocast {

namespace {

/// One frame, drawn `repeat` times: the median of each pass's times.
FrameReport draw_frame(const PictureSource& source, const PictureView& view,
                       const PictureRequest& request, const ImageSet& wanted,
                       const PicturePart& part) {
    FrameReport report;
    std::vector<std::vector<double>> times;
    for (int frame = 0; frame < request.repeat; ++frame) {
        report = source.draw(view.camera, view.picture_width, request.height, wanted, part);
        times.resize(report.passes.size());
        for (std::size_t i = 0; i < times.size(); ++i)
            times[i].push_back(report.passes[i].milliseconds);
    }
    for (std::size_t i = 0; i < times.size(); ++i) {
        auto middle = times[i].begin() + request.repeat / 2;
        std::nth_element(times[i].begin(), middle, times[i].end());
        report.passes[i].milliseconds = *middle;
    }
    return report;
}

/// Adds a frame's costs to those before it.
void add(FrameReport& sum, FrameReport frame) {
    if (sum.passes.empty()) {
        sum = std::move(frame);
        return;
    }
    for (std::size_t i = 0; i < sum.passes.size(); ++i) {
        PassReport& pass = sum.passes[i];
        PassReport& other = frame.passes[i];
        other.milliseconds += pass.milliseconds;
        other.texture_bytes = std::max(other.texture_bytes, pass.texture_bytes);
        if (!other.ran || (pass.ran && pass.asked_by.size() > other.asked_by.size())) {
            other.ran = pass.ran;
            other.asked_by = pass.asked_by;
            other.drawn_by = pass.drawn_by;
        }
    }
    frame.image_bytes = std::max(frame.image_bytes, sum.image_bytes);
    frame.scratch_bytes = std::max(frame.scratch_bytes, sum.scratch_bytes);
    for (const std::string& note : sum.notes)
        if (std::ranges::find(frame.notes, note) == frame.notes.end()) frame.notes.push_back(note);
    sum = std::move(frame);
}

/// Adds `weight` times the pixels of a part, out of `drawn` which has them from (x, y) on, to their
/// place in rows that start at the part's.
void add_pixels(Image& rows, const Image& drawn, const PicturePart& part, int x, int y_first,
                float weight) {
    for (int y = 0; y < part.height; ++y) {
        const float* from = drawn.pixel(x, y_first + y);
        float* to = const_cast<float*>(rows.pixel(part.x, y));
        for (int i = 0; i < 4 * part.width; ++i) to[i] += weight * from[i];
    }
}

/// Each image that was asked for.
FrameImages black_rows(const PictureRequest& request, int height) {
    const Image black{request.width, height,
                      std::vector<float>(std::size_t{4} * static_cast<std::size_t>(request.width) *
                                         static_cast<std::size_t>(height))};
    FrameImages rows;
    for (const FrameImage image : request.others) rows[image] = black;
    if (request.has_beauty) rows[FrameImage::Beauty] = black;
    return rows;
}

} // namespace

std::vector<Eigen::Vector2d> sample_shifts(int samples, PixelFilter filter) {
    const auto moved = [filter](double u) {
        if (filter == PixelFilter::Tent)
            u = u < 0.5 ? std::sqrt(2 * u) - 0.5 : 1.5 - std::sqrt(2 - 2 * u);
        return std::round(128 * (u - 0.5)) / 128;
    };
    std::vector<Eigen::Vector2d> shifts;
    for (int i = 0; i < samples; ++i) {
        double reversed = 0;
        for (int bit = 1, place = samples / 2; bit < samples; bit *= 2, place /= 2)
            if (i & bit) reversed += place;
        shifts.emplace_back(moved((i + 0.5) / samples), moved((reversed + 0.5) / samples));
    }
    return shifts;
}

int reach_pixels(const Look& look) {
    const Effects& effects = look.effects;
    int reach = 0;
    // Differences between the pixels of a quad; Sobel's stencil.
    if (effects.reflection.strength > 0 || effects.refraction.strength > 0 ||
        effects.outlines.strength > 0)
        reach = 1;
    // Along a line, and between four pixels there.
    if (effects.flow.strength > 0) reach = std::max(reach, step_count(effects.flow) + 1);
    return reach;
}

PicturePart with_reach(const PicturePart& part, int reach, int width, int height) {
    if (reach == 0) return part;
    const auto below = [&](int i) { return std::max(0, i - reach) / 2 * 2; };
    const auto above = [&](int i, int size) { return std::min(size, (i + reach + 1) / 2 * 2); };
    const int bottom = below(height - part.y - part.height);
    const int top = above(height - part.y, height);
    PicturePart out{.x = below(part.x), .y = height - top, .height = top - bottom};
    out.width = above(part.x + part.width, width) - out.x;
    return out;
}

std::vector<PicturePart> parts_of(int width, int height, int edge, int limit) {
    // 2^24 pixels: 256 MiB of each image of floats. Rows of wide tiles need little memory.
    int tile_width = std::min(4096, limit);
    int tile_height = std::min(256, limit);
    if (edge > 0)
        tile_width = tile_height = std::min(edge, limit);
    else if (width <= limit && height <= limit && std::int64_t{width} * height <= 1 << 24) {
        tile_width = width;
        tile_height = height;
    }
    std::vector<PicturePart> parts;
    for (int y = 0; y < height; y += tile_height)
        for (int x = 0; x < width; x += tile_width)
            parts.push_back({.x = x,
                             .y = y,
                             .width = std::min(tile_width, width - x),
                             .height = std::min(tile_height, height - y)});
    return parts;
}

PictureSource source_of(Renderer& renderer) {
    return {
        gl::max_image_extent(), reach_pixels(renderer.look()),
        [&](const Camera& camera, int width, int height, const ImageSet& wanted,
            const PicturePart& part) { return renderer.draw(camera, width, height, wanted, part); },
        [&](FrameImage image) { return renderer.read(image); }};
}

FrameReport draw_picture(const PictureSource& source, const std::vector<PictureView>& views,
                         const PictureRequest& request,
                         const std::function<void(const std::vector<FrameImages>&)>& write,
                         const Progress& progress) {
    ImageSet others;
    for (const FrameImage image : request.others) others.insert(image);
    const std::vector<Eigen::Vector2d> shifts =
        sample_shifts(request.samples, request.pixel_filter);
    const std::vector<PicturePart> parts =
        parts_of(request.width, request.height, request.tile_pixels,
                 source.greatest_extent - 2 * (source.reach + 1));
    FrameReport report;
    std::vector<FrameImages> rows(views.size());
    // One frame for all where it shows the pixels' middles.
    const bool is_one_frame = request.has_beauty && request.samples == 1;
    const std::size_t frames_of_part = (is_one_frame || !request.others.empty()) +
                                       (request.has_beauty && !is_one_frame ? shifts.size() : 0);
    int drawn = 0;
    const auto draw_part = [&](const PictureView& view, const PicturePart& part,
                               FrameImages& rows_of_view) {
        const double first = std::floor(view.first_pixel);
        PicturePart in_picture = part;
        in_picture.x += static_cast<int>(first);
        PicturePart around =
            with_reach(in_picture, source.reach, view.picture_width, request.height);
        const Eigen::Vector2d middle(view.first_pixel - first, 0);
        const auto draw = [&](const ImageSet& wanted, const Eigen::Vector2d& shift) {
            if (progress)
                progress("drawing",
                         double(drawn++) / double(parts.size() * views.size() * frames_of_part));
            around.shift = middle + shift;
            add(report, draw_frame(source, view, request, wanted, around));
        };
        const auto add_to_rows = [&](FrameImage image, float weight) {
            add_pixels(rows_of_view.at(image), source.read(image), part, in_picture.x - around.x,
                       in_picture.y - around.y, weight);
        };
        if (is_one_frame || !request.others.empty()) {
            ImageSet wanted = others;
            if (is_one_frame) wanted.insert(FrameImage::Beauty);
            draw(wanted, {0, 0});
            for (const FrameImage image : request.others) add_to_rows(image, 1);
            if (is_one_frame) add_to_rows(FrameImage::Beauty, 1);
        }
        if (request.has_beauty && !is_one_frame) {
            for (const Eigen::Vector2d& shift : shifts) {
                draw({FrameImage::Beauty}, shift);
                add_to_rows(FrameImage::Beauty, 1.0F / static_cast<float>(request.samples));
            }
        }
    };
    for (auto begin = parts.begin(); begin != parts.end();) {
        const auto end = std::find_if(begin, parts.end(),
                                      [&](const PicturePart& part) { return part.y != begin->y; });
        for (std::size_t v = 0; v < views.size(); ++v) {
            rows[v] = black_rows(request, begin->height);
            for (auto part = begin; part != end; ++part) draw_part(views[v], *part, rows[v]);
        }
        write(rows);
        begin = end;
    }
    return report;
}

} // namespace isocast
