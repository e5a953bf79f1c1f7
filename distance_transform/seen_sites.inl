// Eight sites of one kind as the samples of a tile see them.
//
// Included in the namespace of one instruction set, after site_lanes.inl.

namespace {

/// Eight values of SampleFunction.
struct SampleFunctions {
    Doubles first;
    Vector along; // k, u and v

    /// dot(axis, p - origin) of the samples p.
    ISOCAST_INLINE SampleFunctions(const Regions& regions, const Vector& axis, const Vector& origin,
                                   const double* first_sample)
        : first(dot(axis, splat(first_sample) - origin)), along(regions.in_columns(axis)) {}
    ISOCAST_INLINE SampleFunctions(const Doubles& value, const Vector& gradient)
        : first(value), along(gradient) {}

    friend ISOCAST_INLINE SampleFunctions combined(const Doubles& a, const SampleFunctions& f,
                                                   const Doubles& b, const SampleFunctions& g,
                                                   const Doubles& c) {
        return {a * f.first + b * g.first + c, a * f.along + b * g.along};
    }
};

/// Eight sites of one kind as a tile's samples see them, and the columns that meet them.
struct SeenSites {
    alignas(64) double axis[lanes];
    double functions[4][4][lanes]; // as TileSite: first, along k, u and v
    double length[lanes];
    double normal_x[lanes];
    double normal_y[lanes];
    /// The columns, column_count in rows of `width` each, of which row v begins at the first whole
    /// number from row_start - v * row_slope; those from u_first to u_last count.
    double v_first[lanes];
    double width[lanes];
    double row_start[lanes];
    double row_slope[lanes];
    double u_first[lanes];
    double u_last[lanes];
    double column_count[lanes];
    /// The samples of column (u, v) lie, for each of these,
    /// low <= k - (u * slope_u + v * slope_v) <= high.
    struct Bound {
        double low[lanes];
        double high[lanes];
        double slope_u[lanes];
        double slope_v[lanes];
    };
    Bound bounds[5]; // 4 of faces and edges

    ISOCAST_INLINE void set(int i, const SampleFunctions& f) {
        store(functions[i][0], f.first);
        store(functions[i][1], f.along.x);
        store(functions[i][2], f.along.y);
        store(functions[i][3], f.along.z);
    }

    /// low <= f <= high in the region.
    ISOCAST_INLINE void set_bound(int i, const SampleFunctions& f, const Doubles& low,
                                  const Doubles& high) {
        // Nearly across the columns it would cut them far off: at 1e-3 a thirtieth of a voxel is the
        // length of a tile.
        const auto is_told = Doubles(1e-3) < absolute(f.along.x);
        const Doubles zero = 0.0;
        const Doubles inverse = Doubles(1.0) / f.along.x;
        const Doubles from = (low - 2 * least_overlap - f.first) * inverse;
        const Doubles to = (high + 2 * least_overlap - f.first) * inverse;
        Bound& bound = bounds[i];
        store(bound.low, select(is_told, min(from, to), Doubles(-huge)));
        store(bound.high, select(is_told, max(from, to), Doubles(huge)));
        store(bound.slope_u, select(is_told, zero - f.along.y * inverse, zero));
        store(bound.slope_v, select(is_told, zero - f.along.z * inverse, zero));
    }

    /// corners  of the base
    ISOCAST_INLINE void set_columns(const Regions& regions, const Vector* corners, int corner_count,
                                    const double* first_sample) {
        store(axis, regions.axis);
        const Vector w = regions.in_columns(regions.direction);
        const Vector min_corner = regions.in_columns(regions.base_min - splat(first_sample));
        const Vector max_corner = regions.in_columns(regions.base_max - splat(first_sample));
        const Vector factor = regions.in_columns(regions.factor);
        const Doubles zero = 0.0;
        const Doubles inverse = Doubles(1.0) / w.x;
        const Doubles reach =
            regions.lateral + regions.slope * max(zero - regions.low, regions.high);
        const Doubles aside = reach * factor.x;
        const Doubles low = max(regions.low, (zero - max_corner.x - aside) * inverse);
        const Doubles high =
            min(regions.high, (Doubles(tile_size - 1.0) - min_corner.x + aside) * inverse);
        const Doubles lateral = regions.lateral + regions.slope * max(zero - low, high);
        const auto within_tile = [](const Doubles& x) __attribute__((always_inline)) {
            return clamp(x, -1.0, tile_size);
        };
        const Doubles u_low = ceiling(
            max(zero, within_tile(min_corner.y + min(low * w.y, high * w.y) - lateral * factor.y)));
        const Doubles u_high =
            floor_of(min(tile_size - 1.0, within_tile(max_corner.y + max(low * w.y, high * w.y) +
                                                      lateral * factor.y)));
        const Doubles v_low = ceiling(
            max(zero, within_tile(min_corner.z + min(low * w.z, high * w.z) - lateral * factor.z)));
        const Doubles v_high =
            floor_of(min(tile_size - 1.0, within_tile(max_corner.z + max(low * w.z, high * w.z) +
                                                      lateral * factor.z)));
        // Between two lines along the lean of the heights, m across it.
        const Doubles m_u = zero - w.z;
        const Doubles& m_v = w.y;
        Doubles least = huge;
        Doubles greatest = -huge;
        for (int i = 0; i < corner_count; ++i) {
            const Vector corner = regions.in_columns(corners[i] - splat(first_sample));
            const Doubles at = m_u * corner.y + m_v * corner.z;
            least = min(least, at);
            greatest = max(greatest, at);
        }
        const Doubles side = lateral + 3 * least_overlap +
                             (absolute(least) + absolute(greatest)) * coordinate_rounding;
        const Doubles by_u = Doubles(1.0) / m_u;
        const Doubles from = min((least - side) * by_u, (greatest + side) * by_u);
        const Doubles to = max((least - side) * by_u, (greatest + side) * by_u);
        const Doubles of_box = u_high - u_low + 1.0;
        // Nearly along the rows the lines would cut them far off: at 0.02 a triangle of one voxel
        // makes rows wider than the tile.
        const auto is_lean = (Doubles(0.02) < absolute(m_u)) & (to - from < of_box - 1.0);
        const Doubles row_width =
            select(is_lean, floor_of(min(to - from, tile_size)) + 1.0, of_box);
        store(width, row_width);
        store(row_start, select(is_lean, from, u_low));
        store(row_slope, select(is_lean, m_v * by_u, zero));
        store(u_first, u_low);
        store(u_last, u_high);
        store(v_first, v_low);
        const auto is_met = (low <= high) & (u_low <= u_high) & (v_low <= v_high);
        store(column_count, select(is_met, row_width * (v_high - v_low + 1.0), zero));
    }
};

ISOCAST_INLINE Regions see(const Faces& faces, const SiteArrays& sites, const double* first_sample,
                           SeenSites& seen) {
    const Regions regions = faces.regions(sites.half_width);
    const SampleFunctions r(regions, faces.r, faces.origin, first_sample);
    const SampleFunctions s(regions, faces.s, faces.origin, first_sample);
    const SampleFunctions t(regions, faces.t, faces.origin, first_sample);
    const Doubles zero = 0.0;
    const SampleFunctions outwards[3] = {
        {zero - s.first, {zero - s.along.x, zero - s.along.y, zero - s.along.z}},
        combined(faces.right.sine, r, faces.right.cosine, s,
                 zero - faces.right.sine * faces.right.base),
        combined(zero - faces.left.sine, r, faces.left.cosine, s,
                 zero - faces.left.sine * faces.left.base)};
    seen.set(0, t);
    seen.set_bound(0, t, -sites.half_width, sites.half_width);
    for (int i = 0; i < 3; ++i) {
        seen.set(1 + i, outwards[i]);
        seen.set_bound(1 + i, outwards[i], -huge, zero);
    }
    seen.set_columns(regions, faces.corners, 3, first_sample);
    return regions;
}

ISOCAST_INLINE Regions see(const Edges& edges, const SiteArrays& sites, const double* first_sample,
                           SeenSites& seen) {
    const Regions regions = edges.regions(sites.half_width);
    const SampleFunctions x(regions, edges.x, edges.ends[0], first_sample);
    const SampleFunctions y(regions, edges.y, edges.ends[0], first_sample);
    const SampleFunctions e(regions, edges.e, edges.ends[0], first_sample);
    const Doubles zero = 0.0;
    seen.set(0, x);
    seen.set(1, y);
    seen.set(2, e);
    seen.set(3, {zero, {zero, zero, zero}});
    store(seen.length, edges.length);
    store(seen.normal_x, edges.normal_x);
    store(seen.normal_y, edges.normal_y);
    seen.set_bound(0, x, edges.low, sites.half_width);
    seen.set_bound(1, e, zero, edges.length);
    // |y| <= lateral + slope * x, or to both sides what that is at most.
    const auto is_wedge = edges.low == zero;
    const Doubles slope = select(is_wedge, edges.slope, zero);
    const Doubles offset = edges.lateral + select(is_wedge, zero, edges.slope * sites.half_width);
    seen.set_bound(2, combined(1.0, y, zero - slope, x, zero), -huge, offset);
    seen.set_bound(3, combined(1.0, y, slope, x, zero), zero - offset, huge);
    seen.set_columns(regions, edges.ends, 2, first_sample);
    return regions;
}

ISOCAST_INLINE Regions see(const Fans& fans, const SiteArrays& sites, const double* first_sample,
                           SeenSites& seen) {
    const Regions regions = fans.regions();
    const Vector offset = regions.in_columns(splat(first_sample) - fans.point);
    const Doubles zero = 0.0;
    seen.set(0, {regions, fans.normal, fans.point, first_sample});
    seen.set(1, {offset.x, {1.0, 0.0, 0.0}});
    seen.set(2, {offset.y, {0.0, 1.0, 0.0}});
    seen.set(3, {offset.z, {0.0, 0.0, 1.0}});
    const SampleFunctions height(regions, fans.direction, fans.point, first_sample);
    seen.set_bound(0, height, fans.low, fans.high);
    // |l| <= slope * |height|, or to both sides what that is at most.
    const auto is_above = fans.low == zero;
    const auto is_below = fans.high == zero;
    const Doubles slope = select(is_above, fans.slope, select(is_below, zero - fans.slope, zero));
    const Doubles lateral =
        fans.lateral + select(is_above | is_below, zero, fans.slope * sites.half_width);
    const Vector across = unit_orthogonal(fans.direction);
    const SampleFunctions first(regions, across, fans.point, first_sample);
    const SampleFunctions second(regions, cross(fans.direction, across), fans.point, first_sample);
    seen.set_bound(1, combined(1.0, first, zero - slope, height, zero), -huge, lateral);
    seen.set_bound(2, combined(1.0, first, slope, height, zero), zero - lateral, huge);
    seen.set_bound(3, combined(1.0, second, zero - slope, height, zero), -huge, lateral);
    seen.set_bound(4, combined(1.0, second, slope, height, zero), zero - lateral, huge);
    seen.set_columns(regions, &fans.point, 1, first_sample);
    return regions;
}

} // namespace
