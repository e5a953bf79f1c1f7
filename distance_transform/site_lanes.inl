// Eight sites of one kind side by side, and their regions.
//
// Included in the namespace of one instruction set, after vector_lanes.inl.

namespace {

/// Samples that a region misses by rounding are caught by the next, if they overlap [voxels].
constexpr double least_overlap = 1e-6;
/// What double leaves of coordinates that are up to 2^28 voxels from the anchor, and of sums.
constexpr double coordinate_rounding = 1e-14;
/// A bend over which the half width opens no further than this [voxels] needs no wedge or cone: the
/// towers overlap by more (scan_kernel.h, tower_slack).
constexpr double least_opening = 1e-10;
/// Of two normals together [radians]; beyond it the edge's wedge is not told.
constexpr double greatest_noise = 0.1;
/// Half the width of a wedge or cone over its height, from which on a cylinder or ball serves.
constexpr double greatest_slope = 3;
constexpr double huge = 1e300;

/// SiteRegion of eight sites.
struct Regions {
    Vector base_min;
    Vector base_max;
    Vector direction;
    Doubles low;
    Doubles high;
    Doubles lateral = 0.0;
    Doubles slope = 0.0;
    Vector factor = {0.0, 0.0, 0.0};
    Doubles axis;

    /// Over the box of the base; `low` and `high` bound the heights along `along`, a unit vector.
    ISOCAST_INLINE Regions(const Vector& least, const Vector& greatest, const Vector& along,
                           const Doubles& low_height, const Doubles& high_height) {
        const Vector size = absolute(along);
        const Doubles of_two = max(size.x, size.y);
        axis = select(of_two < size.z, Doubles(2.0),
                      select(size.x < size.y, Doubles(1.0), Doubles(0.0)));
        const auto is_turned = at_axis(along) < 0.0;
        const Doubles zero = 0.0;
        direction =
            select(is_turned, Vector{zero - along.x, zero - along.y, zero - along.z}, along);
        low = select(is_turned, zero - high_height, low_height);
        high = select(is_turned, zero - low_height, high_height);
        const Vector largest = max(absolute(least), absolute(greatest));
        const Doubles pad =
            (max(max(largest.x, largest.y), max(largest.z, max(zero - low, high)))) *
                coordinate_rounding +
            least_overlap;
        base_min = least - Vector{pad, pad, pad};
        base_max = greatest + Vector{pad, pad, pad};
    }
    /// Offsets in all directions across the region's.
    ISOCAST_INLINE void around(const Doubles& lateral_offset, const Doubles& lateral_slope) {
        lateral = lateral_offset;
        slope = lateral_slope;
        const auto across = [](const Doubles& w) __attribute__((always_inline)) {
            return sqrt(max(Doubles(0.0), Doubles(1.0) - w * w));
        };
        factor = {across(direction.x), across(direction.y), across(direction.z)};
    }
    /// Offsets along `across` only.
    ISOCAST_INLINE void aside(const Doubles& lateral_offset, const Doubles& lateral_slope,
                              const Vector& across) {
        lateral = lateral_offset;
        slope = lateral_slope;
        factor = absolute(across);
    }
    ISOCAST_INLINE void clear(const Mask<double>& is_empty) {
        low = select(is_empty, Doubles(1.0), low);
        high = select(is_empty, Doubles(0.0), high);
    }

    /// The components along k, the region's axis, and along the two after it.
    ISOCAST_INLINE Doubles at_axis(const Vector& a) const {
        return select(axis == 0.0, a.x, select(axis == 1.0, a.y, a.z));
    }
    ISOCAST_INLINE Doubles after_axis(const Vector& a) const {
        return select(axis == 0.0, a.y, select(axis == 1.0, a.z, a.x));
    }
    ISOCAST_INLINE Doubles before_axis(const Vector& a) const {
        return select(axis == 0.0, a.z, select(axis == 1.0, a.x, a.y));
    }
    /// As along k, u and v.
    ISOCAST_INLINE Vector in_columns(const Vector& a) const {
        return {at_axis(a), after_axis(a), before_axis(a)};
    }

    void write_boxes(SampleBox* to, int count) const {
        const Doubles zero = 0.0;
        const Doubles reach = lateral + slope * max(zero - low, high);
        const auto is_empty = high < low;
        int rows[6][lanes];
        const auto bound = [&](int k, const Doubles& least, const Doubles& greatest,
                               const Doubles& w, const Doubles& f) __attribute__((always_inline)) {
            const Doubles aside = reach * f;
            const Doubles first = ceiling(least + min(low * w, high * w) - aside);
            store_integers(rows[k], select(is_empty, Doubles(1.0), first));
            const Doubles last = floor_of(greatest + max(low * w, high * w) + aside);
            store_integers(rows[3 + k], select(is_empty, zero, last));
        };
        bound(0, base_min.x, base_max.x, direction.x, factor.x);
        bound(1, base_min.y, base_max.y, direction.y, factor.y);
        bound(2, base_min.z, base_max.z, direction.z, factor.z);
        for (int lane = 0; lane < count; ++lane) {
            for (int k = 0; k < 3; ++k) {
                to[lane].first[k] = rows[k][lane];
                to[lane].last[k] = rows[3 + k][lane];
            }
        }
    }

    /// Those of which is_wanted(lane).
    template<class Where>
    ISOCAST_INLINE void write(SiteRegion* to, int count, const Where& is_wanted) const {
        alignas(64) double rows[17][lanes];
        const Doubles* const from[17] = {
            &base_min.x,  &base_min.y,  &base_min.z,  &base_max.x, &base_max.y, &base_max.z,
            &direction.x, &direction.y, &direction.z, &low,        &high,       &lateral,
            &slope,       &factor.x,    &factor.y,    &factor.z,   &axis};
        for (int i = 0; i < 17; ++i) store(rows[i], *from[i]);
        for (int lane = 0; lane < count; ++lane) {
            if (!is_wanted(lane)) continue;
            SiteRegion& region = to[lane];
            for (int k = 0; k < 3; ++k) {
                region.base_min[k] = rows[k][lane];
                region.base_max[k] = rows[3 + k][lane];
                region.direction[k] = rows[6 + k][lane];
                region.lateral_factor[k] = rows[13 + k][lane];
            }
            region.low = rows[9][lane];
            region.high = rows[10][lane];
            region.lateral = rows[11][lane];
            region.lateral_slope = rows[12][lane];
            region.axis = int(rows[16][lane]);
        }
    }
};

/// Numbers of up to eight sites of one kind, from the first of that kind; the last is repeated.
struct Numbers {
    std::int32_t of[lanes];

    ISOCAST_INLINE Numbers(const std::int32_t* list, int count, std::int32_t first) {
        for (int lane = 0; lane < lanes; ++lane)
            of[lane] = list[lane < count ? lane : count - 1] - first;
    }
    ISOCAST_INLINE Numbers(std::int32_t first, int count) {
        for (int lane = 0; lane < lanes; ++lane)
            of[lane] = first + (lane < count ? lane : count - 1);
    }
};

/// Faces in the orthonormal frame of the thesis's figure 4.9: r runs along the longest side, s to
/// the apex, t along the normal; the corners are (-b, 0), (a, 0) and (0, h), all of a, b, h >= 0.
struct Faces {
    Vector corners[3];
    Vector origin; // foot of the apex on the longest side
    Vector r;
    Vector s;
    Vector t;
    Doubles noise;
    /// Of the side from (base, 0) to the apex: the distance outwards is
    /// sine * (|r| - base) + cosine * s.
    struct Side {
        Doubles base;
        Doubles cosine;
        Doubles sine;
    };
    Side right;
    Side left;

    ISOCAST_INLINE Faces(const SiteArrays& sites, const Numbers& numbers) {
        Gathered<9> in;
        for (int lane = 0; lane < lanes; ++lane)
            for (int k = 0; k < 3; ++k)
                in.set(3 * k, lane, sites.vertices[sites.triangles[numbers.of[lane]][k]]);
        for (int k = 0; k < 3; ++k) corners[k] = in.vector(3 * k);

        Doubles squared_length = -1.0;
        Vector first = corners[0];
        Vector second = corners[1];
        Vector apex = corners[2];
        for (int k = 0; k < 3; ++k) {
            const Vector& p = corners[k];
            const Vector& q = corners[(k + 1) % 3];
            const Doubles squared = dot(q - p, q - p);
            const auto is_longer = squared_length < squared;
            squared_length = select(is_longer, squared, squared_length);
            first = select(is_longer, p, first);
            second = select(is_longer, q, second);
            apex = select(is_longer, corners[(k + 2) % 3], apex);
        }
        const Doubles length = sqrt(squared_length);
        // Corners that differ in the world can be one in voxels about a distant anchor.
        r = select(Doubles(0.0) < length, (Doubles(1.0) / length) * (second - first),
                   Vector{1.0, 0.0, 0.0});
        // The foot lies between the ends, but for rounding.
        const Doubles to_foot = clamp(dot(apex - first, r), 0.0, length);
        origin = first + to_foot * r;
        // Twice made orthogonal: what is left of a sliver's height after the first time may lean.
        s = apex - origin;
        s = s - dot(s, r) * r;
        const Doubles h = norm(s);
        s = select(Doubles(0.0) < h, (Doubles(1.0) / h) * s, unit_orthogonal(r));
        s = normalized(s - dot(s, r) * r);
        t = cross(r, s);
        constexpr double rounding = 1e-15;
        noise = select(length * rounding < h, min(1.0, length * rounding / h), Doubles(1.0));
        right = side(length - to_foot, h);
        left = side(to_foot, h);
    }
    static ISOCAST_INLINE Side side(const Doubles& base, const Doubles& h) {
        const Doubles length = sqrt(base * base + h * h);
        const auto has_length = Doubles(0.0) < length;
        // Without length the side is the apex itself, at a right angle to the longest side.
        return {base, select(has_length, base / length, Doubles(0.0)),
                select(has_length, h / length, Doubles(1.0))};
    }
    ISOCAST_INLINE Regions regions(double half_width) const {
        return {min(corners[0], min(corners[1], corners[2])),
                max(corners[0], max(corners[1], corners[2])), t, -half_width, half_width};
    }
};

struct Edges {
    Vector ends[2];
    Vector e; // along
    Vector x; // across, along the middle of the wedge
    Vector y;
    Doubles length;
    Doubles normal_x; // of the pseudonormal
    Doubles normal_y;
    Doubles low;
    Doubles lateral;
    Doubles slope;
    Mask<double> is_empty;

    ISOCAST_INLINE Edges(const SiteArrays& sites, const Numbers& numbers) {
        Gathered<16> in;
        alignas(64) double kinds[4][lanes];
        for (int lane = 0; lane < lanes; ++lane) {
            const EdgeData& edge = sites.edges[numbers.of[lane]];
            in.set(0, lane, sites.vertices[edge.ends[0]]);
            in.set(3, lane, sites.vertices[edge.ends[1]]);
            for (int kind = 0; kind < 4; ++kind) kinds[kind][lane] = edge.kind == kind;
            if (edge.kind == EdgeData::Junction) {
                constexpr double nothing[3] = {0, 0, 0};
                in.set(6, lane, sites.junctions[edge.faces[0]]);
                in.set(9, lane, nothing);
                in.number[12][lane] = 1;
                continue;
            }
            const FaceNormal& one = sites.faces[edge.faces[0]];
            const FaceNormal& other =
                sites.faces[edge.faces[edge.kind == EdgeData::Border ? 0 : 1]];
            in.set(6, lane, one.normal);
            in.set(9, lane, other.normal);
            in.number[12][lane] =
                edge.kind == EdgeData::Border ? one.noise : one.noise + other.noise;
        }
        const double w = sites.half_width;
        const auto is_border = Doubles(0.5) < load(kinds[EdgeData::Border]);
        const auto is_parallel = Doubles(0.5) < load(kinds[EdgeData::Parallel]);
        const auto is_pair = is_parallel | (Doubles(0.5) < load(kinds[EdgeData::Opposed]));
        ends[0] = in.vector(0);
        ends[1] = in.vector(3);
        const Vector first = in.vector(6);
        const Vector second = in.vector(9);
        const Doubles noise = in.at(12);
        length = norm(ends[1] - ends[0]);
        is_empty = length <= 0.0; // its ends are at the same place
        e = (Doubles(1.0) / length) * (ends[1] - ends[0]);

        // Directions across the edge into its triangles: a nearest point's offset leads into none.
        const Vector zero = {0.0, 0.0, 0.0};
        const Vector into_first = cross(first, e);
        const Vector into_second =
            select(is_parallel, cross(second, e), select(is_pair, cross(e, second), zero));
        const Vector into = into_first + into_second;
        const Vector pseudonormal = first + select(is_pair, second, zero);
        // A cylinder, unless more is known.
        x = unit_orthogonal(e);
        low = -w;
        lateral = w;
        slope = 0.0;
        const auto is_told = noise < greatest_noise;
        const auto is_half = is_border & is_told;
        const Doubles into_norm = norm(into);
        const Vector away = (Doubles(-1.0) / into_norm) * into;
        x = select(is_half, away, x);
        low = select(is_half, noise * -w, low); // one that leans reaches below its foot
        // The sum of two unit vectors: twice the sine of half the opening, away from it.
        const Doubles sine = into_norm * 0.5;
        const Doubles tangent =
            select(sine < 1.0, sine / sqrt(max(Doubles(1.0) - sine * sine, 1e-300)), Doubles(huge));
        const auto is_bent = is_pair & is_told;
        is_empty = is_empty | (is_bent & ((tangent + noise) * w < least_opening));
        // Where the edge is nearly flat, its direction is told better by the normals.
        const Vector between =
            normalized(select(dot(first, second) < 0.0, first - second, first + second));
        const Vector middle =
            select(Doubles(0.5) < sine, away,
                   select(Doubles(0.0) < dot(between, into), Doubles(-1.0) * between, between));
        const auto is_wedge = is_bent & (tangent <= greatest_slope);
        x = select(is_wedge, middle, x);
        // So flat that even the side may be in doubt.
        low = select(is_wedge, select(sine < noise + 1e-9, Doubles(-w), Doubles(0.0)), low);
        lateral = select(is_wedge, noise * w, lateral);
        slope = select(is_wedge, tangent, slope);
        x = normalized(x - dot(x, e) * e);
        y = cross(e, x);
        normal_x = dot(pseudonormal, x);
        normal_y = dot(pseudonormal, y);
    }
    ISOCAST_INLINE Regions regions(double half_width) const {
        Regions regions(min(ends[0], ends[1]), max(ends[0], ends[1]), x, low, half_width);
        regions.aside(lateral, slope, y);
        regions.clear(is_empty);
        return regions;
    }
};

struct Fans {
    Vector point;
    Vector normal;
    Vector direction; // of the cone
    Doubles low;
    Doubles high;
    Doubles lateral;
    Doubles slope;
    Mask<double> is_empty;

    ISOCAST_INLINE Fans(const SiteArrays& sites, const Numbers& numbers) {
        Gathered<8> in;
        for (int lane = 0; lane < lanes; ++lane) {
            const FanData& fan = sites.fans[numbers.of[lane]];
            in.set(0, lane, sites.vertices[fan.vertex]);
            in.set(3, lane, fan.normal);
            in.number[6][lane] = fan.slope_above;
            in.number[7][lane] = fan.slope_below;
        }
        const double w = sites.half_width;
        point = in.vector(0);
        normal = in.vector(3);
        const Doubles above = in.at(6);
        const Doubles below = in.at(7);
        const auto is_ball = above < 0.0;
        const auto has_above = Doubles(least_opening) <= above * w;
        const auto has_below = Doubles(least_opening) <= below * w;
        // Components may be tiny or huge: their squares need not be numbers.
        const Vector size = absolute(normal);
        const Vector scaled = (Doubles(1.0) / max(size.x, max(size.y, size.z))) * normal;
        direction = select(is_ball, Vector{1.0, 0.0, 0.0}, normalized(scaled));
        low = select(is_ball | has_below, Doubles(-w), Doubles(0.0));
        high = select(is_ball | has_above, Doubles(w), Doubles(0.0));
        lateral = select(is_ball, Doubles(w), Doubles(0.0));
        slope = select(is_ball, Doubles(0.0), max(above, below));
        // Neither a ball nor open to any side.
        is_empty = low == high;
    }
    ISOCAST_INLINE Regions regions() const {
        Regions regions(point, point, direction, low, high);
        regions.around(lateral, slope);
        regions.clear(is_empty);
        return regions;
    }
};

} // namespace
