// What splats of meshes share: where the hull of some points is in a picture, and records that keep
// the order of the mesh.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/splats.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <initializer_list>
#include <optional>
#include <span>

namespace isocast {

/// A margin in every direction; pixels' positions are rounded to a 64th at least.
inline constexpr double margin_pixels = 1.0 / 16;

/// A point of the picture as (x, y, 1) times its depth: behind the eye, too.
using Pixel = Vec3d;
Pixel pixel_of(const Vec3d& p_world, const SplatView& view);

/// The box of the part of the polygon that is within the picture; empty if none is.
Eigen::AlignedBox2d clipped(std::vector<Pixel> polygon, const SplatView& view);

/// Of a box in the picture [pixels], with the margin.
/// returns  none if it holds no middle of a pixel
std::optional<PixelBox> cover_of(const Eigen::AlignedBox2d& box, const SplatView& view);
/// Of the picture of a tetrahedron, with the margin.
/// returns  none if it holds no middle of a pixel
std::optional<PixelBox> cover_of(std::span<const Vec3d, 4> corners_world, const SplatView& view);

/// A splat's floats, one after the other.
class Record {
public:
    explicit Record(float* next) : next_(next) {}
    void put(std::initializer_list<double> values) {
        for (const double value : values) *next_++ = static_cast<float>(value);
    }
    void put(const Vec3d& v, double w) { put({v.x(), v.y(), v.z(), w}); }
    /// Where it is drawn.
    void put(const PixelBox& box, double number) {
        put({box.x_lo, box.y_lo, box.x_hi - box.x_lo, 0});
        put({0, box.y_hi - box.y_lo, number, 0});
    }

private:
    float* next_;
};

/// Appends the splats of a mesh's elements, in their order: elements that share an edge are hit at
/// one depth there and the first one drawn shows, which must not depend on what else is in the
/// part.
///
/// write  (i, to): writes down element i, unless it is not seen, and returns its box
template<class Write>
void append_in_order(SplatKind kind, std::size_t count, Splats& splats, Write write) {
    constexpr std::size_t block = 4096; // elements, that one thread writes down
    struct Written {
        std::vector<float> records;
        std::vector<PixelBox> boxes;
    };
    const auto floats = static_cast<std::size_t>(splat_floats[static_cast<std::size_t>(kind)]);
    std::vector<Written> blocks((count + block - 1) / block);
    tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t b) {
        Written& out = blocks[b];
        std::vector<float> record(floats);
        for (std::size_t i = b * block; i < std::min((b + 1) * block, count); ++i) {
            const std::optional<PixelBox> box = write(i, record.data());
            if (!box) continue;
            out.boxes.push_back(*box);
            out.records.insert(out.records.end(), record.begin(), record.end());
        }
    });
    std::vector<float>& records = splats.records[static_cast<std::size_t>(kind)];
    std::size_t float_count = records.size();
    for (const Written& written : blocks) float_count += written.records.size();
    records.reserve(float_count);
    for (Written& written : blocks) {
        records.insert(records.end(), written.records.begin(), written.records.end());
        splats.boxes.insert(splats.boxes.end(), written.boxes.begin(), written.boxes.end());
        written = {};
    }
}

/// Appends the splats of a mesh of bodies with four corners.
///
/// element_of  (i): the body
/// is_unseen   (body): nothing is drawn of it
/// put         (body, record): what follows its place
template<class ElementOf, class IsUnseen, class Put>
void append_hulls(SplatKind kind, std::size_t count, std::size_t number, const SplatView& view,
                  Splats& splats, ElementOf element_of, IsUnseen is_unseen, Put put) {
    append_in_order(kind, count, splats, [&](std::size_t i, float* to) -> std::optional<PixelBox> {
        const auto body = element_of(i);
        if (is_unseen(body) || is_cut_away(body, view.planes)) return std::nullopt;
        const auto box = cover_of(body.corners_world, view);
        if (!box) return std::nullopt;
        Record record(to);
        record.put(*box, static_cast<double>(number));
        put(body, record);
        return box;
    });
}

} // namespace isocast
