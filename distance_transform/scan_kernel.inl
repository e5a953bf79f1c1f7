// The kernels of scan_kernel.h, in the namespace of one instruction set.
//
// A site is scanned by columns of samples along the axis nearest to its region's direction. The
// nearest point q of a sample p obeys, with w = p - q: if q is inside a face, w is along its
// normal; if q is inside an edge, w is across it and leads into none of its triangles; if q is a
// vertex, w leads along none of its edges. These are the tower, the wedge and the cone, so that p
// lies in the region of the site that holds q, and every distance that another site offers is to a
// point of the mesh too: the least is exact.

namespace {

/// A face's samples may lie this far outside its tower [voxels]: far above rounding, and of no
/// consequence, since the distance to the plane there is wrong by 1e-18 over the distance.
constexpr double tower_slack = 1e-9;

/// The band's border is this much wider than asked [voxels], far above rounding: samples exactly on
/// it are all active, and the neighbours of an inactive sample are surely not on the surface.
constexpr double border_slack = 1e-9;

ISOCAST_INLINE double squared_reach(double half_width) {
    return (half_width + border_slack) * (half_width + border_slack);
}

/// The least integer >= x, and the greatest <= x, of those from 0 to tile_size - 1, or just beyond.
ISOCAST_INLINE int ceiling(double x) {
    if (!(x > 0)) return 0;
    if (x > tile_size - 1) return tile_size;
    const int i = int(x);
    return i + (double(i) < x);
}
ISOCAST_INLINE int floor_of(double x) {
    return x < 0 ? -1 : x >= tile_size - 1 ? tile_size - 1 : int(x);
}

ISOCAST_INLINE double least(double a, double b) { return a < b ? a : b; }
ISOCAST_INLINE double greatest(double a, double b) { return a < b ? b : a; }

enum class Kind { Face, Edge, Fan };

/// Calls visit(seen, regions, next, count) for the sites next … next + count - 1 of the list, of
/// one kind and eight or fewer at a time; `next` begins at a site of the kind, and ends behind
/// the last one.
template<class Sites, class Visit>
ISOCAST_INLINE void for_kind(const TileInput& input, std::int64_t& next, std::int32_t first,
                             std::int32_t end, const Visit& visit) {
    while (next < input.count && input.list[next] < end) {
        int count = 1;
        while (count < lanes && next + count < input.count && input.list[next + count] < end)
            ++count;
        const Sites sites(*input.sites, Numbers(input.list + next, count, first));
        SeenSites seen;
        const Regions regions = see(sites, *input.sites, input.first_sample, seen);
        visit(seen, regions, next, count);
        next += count;
    }
}

/// Calls visit.template operator()<Kind>(…) so, for all sites of a tile.
template<class Visit>
ISOCAST_INLINE void for_all_sites(const TileInput& input, const Visit& visit) {
    const std::int32_t first_edge = input.sites->face_count;
    const std::int32_t first_fan = first_edge + input.sites->edge_count;
    const std::int32_t end = first_fan + input.sites->fan_count;
    std::int64_t next = 0;
    for_kind<Faces>(input, next, 0, first_edge, [&](auto&... args) {
        visit.template operator()<Kind::Face>(args...);
    });
    for_kind<Edges>(input, next, first_edge, first_fan, [&](auto&... args) {
        visit.template operator()<Kind::Edge>(args...);
    });
    for_kind<Fans>(input, next, first_fan, end, [&](auto&... args) {
        visit.template operator()<Kind::Fan>(args...);
    });
}

template<bool with_sites>
class Scan {
public:
    Scan(const TileInput& input, TileColumns& columns)
        : input_(input), columns_(columns), beyond_(squared_reach(input.sites->half_width)) {
        for (int k = 0; k < 3; ++k) columns_.is_used[k] = false;
        for (int i = 0; i < lanes; ++i) steps_[i] = i;
    }

    std::int64_t run() {
        for_all_sites(input_, [&]<Kind kind>(const SeenSites& seen, const Regions&,
                                             std::int64_t next, int count) {
            for (int lane = 0; lane < count; ++lane)
                scan_site<kind>(seen, lane, input_.list[next + lane]);
        });
        return evaluations_;
    }

private:
    void use(int axis) {
        if (columns_.is_used[axis]) return;
        columns_.is_used[axis] = true;
        double* squares = columns_.signed_square[axis];
        const Doubles beyond = beyond_;
        for (int i = 0; i < TileColumns::count; i += lanes) store(squares + i, beyond);
    }

    template<Kind kind>
    ISOCAST_INLINE void scan_site(const SeenSites& seen, int lane, std::int32_t site) {
        const int v_first = ceiling(seen.v_low[lane]);
        const int v_last = floor_of(seen.v_high[lane]);
        if (v_first > v_last) return;
        const int axis = int(seen.axis[lane]);
        use(axis);
        double* const squares = columns_.signed_square[axis];
        double* const numbers = with_sites ? columns_.site[axis] : nullptr;
        const auto function = [&](int i) __attribute__((always_inline)) -> SampleFunction {
            return {seen.functions[i][0][lane], seen.functions[i][1][lane],
                    seen.functions[i][2][lane], seen.functions[i][3][lane]};
        };
        const SampleFunction f0 = function(0);
        const SampleFunction f1 = function(1);
        const SampleFunction f2 = function(2);
        const SampleFunction f3 = function(3);
        const double end = seen.length[lane] + tower_slack;
        const double normal_x = seen.normal_x[lane];
        const double normal_y = seen.normal_y[lane];

        for (int v = v_first; v <= v_last; ++v) {
            const double lean = v * seen.lean_slope[lane];
            const double u_low = greatest(seen.u_low[lane], seen.lean_low[lane] - lean);
            const double u_high = least(seen.u_high[lane], seen.lean_high[lane] - lean);
            const int u_last = floor_of(u_high);
            const double row0 = f0.first + v * f0.along_v;
            const double row1 = f1.first + v * f1.along_v;
            const double row2 = f2.first + v * f2.along_v;
            const double row3 = f3.first + v * f3.along_v;
            for (int u_first = ceiling(u_low); u_first <= u_last; u_first += lanes) {
                alignas(64) double from[lanes];
                alignas(64) double to[lanes];
                unsigned which = bound_columns(seen, lane, u_first, v, from, to);
                if (u_last - u_first < lanes - 1) which &= (2u << (u_last - u_first)) - 1;
                for (; which != 0; which &= which - 1) {
                    const int column = __builtin_ctz(which);
                    const int u = u_first + column;
                    const int k_last = int(to[column]);
                    const double at0 = row0 + u * f0.along_u;
                    const double at1 = row1 + u * f1.along_u;
                    const double at2 = row2 + u * f2.along_u;
                    const double at3 = row3 + u * f3.along_u;
                    for (int first = int(from[column]); first <= k_last; first += lanes) {
                        const int k = first < tile_size - lanes ? first : tile_size - lanes;
                        const Doubles steps = load(steps_) + double(k);
                        const Doubles c0 = steps * f0.along_k + at0;
                        const int at = k + TileColumns::stride_u * u + TileColumns::stride_v * v;
                        if constexpr (kind == Kind::Face) {
                            const Doubles slack = tower_slack;
                            const auto is_over_face = (steps * f1.along_k + at1 <= slack) &
                                                      (steps * f2.along_k + at2 <= slack) &
                                                      (steps * f3.along_k + at3 <= slack);
                            offer(squares, numbers, at, is_over_face, c0 * c0, c0, site);
                        } else if constexpr (kind == Kind::Edge) {
                            const Doubles c1 = steps * f1.along_k + at1;
                            const Doubles along = steps * f2.along_k + at2;
                            const auto is_beside =
                                (Doubles(-tower_slack) <= along) & (along <= Doubles(end));
                            offer(squares, numbers, at, is_beside, c0 * c0 + c1 * c1,
                                  c0 * normal_x + c1 * normal_y, site);
                        } else {
                            const Doubles dk = steps + at1;
                            const Doubles square = dk * dk + (at2 * at2 + at3 * at3);
                            offer(squares, numbers, at, square < beyond_, square, c0, site);
                        }
                    }
                }
            }
        }
    }

    /// Where the columns u_first … of row v begin and end along k. returns  a bit for each that has
    /// a sample
    ISOCAST_INLINE unsigned bound_columns(const SeenSites& seen, int lane, int u_first, int v,
                                          double* from, double* to) const {
        const Doubles us = load(steps_) + double(u_first);
        Doubles low = 0.0;
        Doubles high = tile_size - 1.0;
        for (const SeenSites::Bound& bound : seen.bounds) {
            const Doubles shift = us * bound.slope_u[lane] + v * bound.slope_v[lane];
            low = max(low, shift + bound.low[lane]);
            high = min(high, shift + bound.high[lane]);
        }
        // Their integers: 1.5 * 2^52 leaves no fraction to what is added to it.
        constexpr double magic = 0x1.8p52;
        low = min(low, Doubles(tile_size));
        high = max(high, -1.0);
        const Doubles near_low = low + magic - magic;
        const Doubles near_high = high + magic - magic;
        const Doubles first = near_low + select(near_low < low, Doubles(1.0), Doubles(0.0));
        const Doubles last = near_high - select(high < near_high, Doubles(1.0), Doubles(0.0));
        store(from, first);
        store(to, last);
        return bits(first <= last);
    }

    /// Keeps the lesser of what a column holds and `square`, with the sign of `side`.
    ISOCAST_INLINE void offer(double* squares, double* numbers, int at,
                              const Mask<double>& is_valid, const Doubles& square,
                              const Doubles& side, std::int32_t site) {
        const Doubles held = load(squares + at);
        const auto is_nearer = is_valid & (square < absolute(held));
        const Doubles with_side = select(side < 0.0, Doubles(0.0) - square, square);
        store(squares + at, select(is_nearer, with_side, held));
        if constexpr (with_sites)
            store(numbers + at, select(is_nearer, Doubles(double(site)), load(numbers + at)));
        evaluations_ += lanes;
    }

    const TileInput& input_;
    TileColumns& columns_;
    double beyond_;
    alignas(64) double steps_[lanes];
    std::int64_t evaluations_ = 0;
};

/// The least of the three orientations, row by row along x.
template<bool with_sites>
class Finish {
public:
    Finish(const TileColumns& columns, double half_width, int x, int y, int z)
        : columns_(columns), place_{8 * x, 8 * y, 8 * z} {
        const double beyond = squared_reach(half_width);
        for (Doubles& row : least_) row = beyond;
        if constexpr (with_sites)
            for (Doubles& row : site_) row = -1.0;
        for (int axis = 0; axis < 3; ++axis)
            if (columns.is_used[axis]) merge(axis);
    }

    bool write(double half_width, double scale, ScannedBlock& block) const {
        const double beyond = squared_reach(half_width);
        unsigned any = 0;
        for (int row = 0; row < 64; ++row) {
            const Doubles squared_distance = absolute(least_[row]);
            const unsigned active = bits(squared_distance < beyond);
            block.active[row] = std::uint8_t(active);
            block.negative[row] = std::uint8_t(bits(least_[row] < 0.0) & active);
            any |= active;
            if (active == 0) {
                for (int x = 0; x < 8; ++x) block.distance[8 * row + x] = float(half_width * scale);
                continue;
            }
            store_floats(block.distance + 8 * row,
                         min(sqrt(squared_distance), half_width) * scale);
            if constexpr (with_sites)
                for (int x = 0; x < 8; ++x) block.site[8 * row + x] = int(lane(site_[row], x));
        }
        return any != 0;
    }

private:
    void merge(int axis) {
        // Along x the columns are the rows. Of the other axes, eight columns side by side along x
        // are turned into eight rows.
        for (int slice = 0; slice < 8; ++slice) {
            Doubles squares[8];
            Doubles sites[8];
            for (int i = 0; i < 8; ++i) {
                // Axis 0: k = x, u = y, v = z; axis 1: k = y, u = z, v = x; axis 2: z, x, y.
                const int u = axis == 1 ? slice : i;
                const int v = axis == 1 ? i : slice;
                const int at = place_[axis] + TileColumns::stride_u * (place_[(axis + 1) % 3] + u) +
                               TileColumns::stride_v * (place_[(axis + 2) % 3] + v);
                squares[i] = load(columns_.signed_square[axis] + at);
                if constexpr (with_sites) sites[i] = load(columns_.site[axis] + at);
            }
            if (axis != 0) {
                transpose(squares);
                if constexpr (with_sites) transpose(sites);
            }
            for (int i = 0; i < 8; ++i) {
                const int row = axis == 2 ? slice + 8 * i : i + 8 * slice;
                const auto is_nearer = absolute(squares[i]) < absolute(least_[row]);
                least_[row] = select(is_nearer, squares[i], least_[row]);
                if constexpr (with_sites) site_[row] = select(is_nearer, sites[i], site_[row]);
            }
        }
    }

    const TileColumns& columns_;
    int place_[3];
    Doubles least_[64];
    Doubles site_[with_sites ? 64 : 1];
};

/// atan of 0 … infinity as y / x, both >= 0 and not both 0; S. L. Moshier's Cephes, atan.c, with
/// the greatest argument tan(pi / 8) instead of 0.66.
ISOCAST_INLINE Doubles arc_tangent(const Doubles& y, const Doubles& x) {
    const auto is_steep = x < y;
    const Doubles q = min(x, y) / max(x, y);
    const auto is_large = Doubles(0.4142135623730950488) < q;
    const Doubles t = select(is_large, (q - 1.0) / (q + 1.0), q);
    const Doubles z = t * t;
    const Doubles p = (((z * -8.750608600031904122785E-1 - 1.615753718733365076637E1) * z -
                        7.500855792314704667340E1) *
                           z -
                       1.228866684490136173410E2) *
                          z -
                      6.485021904942025371773E1;
    const Doubles r = ((((z + 2.485846490142306297962E1) * z + 1.650270098316988542046E2) * z +
                        4.328810604912902668951E2) *
                           z +
                       4.853903996359136964868E2) *
                          z +
                      1.945506571482613964425E2;
    constexpr double half_pi = 1.57079632679489661923;
    const Doubles angle = t + t * z * p / r + select(is_large, Doubles(half_pi / 2), Doubles(0.0));
    return select(is_steep, Doubles(half_pi) - angle, angle);
}

ISOCAST_INLINE Doubles angle_between(const Vector& a, const Vector& b) {
    const Doubles sine = norm(cross(a, b));
    const Doubles cosine = dot(a, b);
    const Doubles angle = arc_tangent(sine, absolute(cosine));
    constexpr double pi = 3.14159265358979323846;
    return select(cosine < 0.0, Doubles(pi) - angle, angle);
}

/// Eight fans: their normals, and how wide their cones open.
///
/// With n the fan's normal and unit edges e_j = c_j n + s_j u_j, u_j across n, an offset h n + l
/// leads along no edge if l·u_j <= k_j h, k_j = - c_j / s_j. A direction of l lies between two
/// neighbouring u_j, within half of their angle of one of them, so that |l| <= h max(k_j) /
/// cos(half the angle), the greatest over all pairs; for h < 0 the k_j change their sign.
class FanFinder {
public:
    FanFinder(const SiteArrays& sites, const std::uint32_t* corners,
              const std::uint32_t* corner_begin, std::int32_t first, int count)
        : sites_(sites), corners_(corners), numbers_(first, count) {
        for (int lane = 0; lane < lanes; ++lane) {
            const std::int32_t fan = numbers_.of[lane];
            begin_[lane] = corner_begin[fan];
            valence_[lane] = corner_begin[fan + 1] - corner_begin[fan];
            if (valence_[lane] > most_) most_ = valence_[lane];
        }
    }

    void run(const char* is_open, std::int32_t first, int count, FanData* fans) {
        Vector normal = {0.0, 0.0, 0.0};
        for (std::uint32_t i = 0; i < most_; ++i) {
            const Corner corner(*this, i);
            const Doubles weight =
                select(corner.is_missing, Doubles(0.0), angle_between(corner.a, corner.b));
            normal = normal + weight * corner.normal;
        }
        const Doubles length = norm(normal);
        const Vector n = (Doubles(1.0) / length) * normal;
        Doubles above = 0.0;
        Doubles below = 0.0;
        Mask<double> is_ring = Doubles(0.0) < length;
        for (std::uint32_t i = 0; i < most_; ++i) {
            const Corner corner(*this, i);
            const Doubles a_up = dot(corner.a, n);
            const Doubles b_up = dot(corner.b, n);
            const Vector a_flat = corner.a - a_up * n;
            const Vector b_flat = corner.b - b_up * n;
            const Doubles a_length = norm(a_flat);
            const Doubles b_length = norm(b_flat);
            const Doubles cosine = dot(a_flat, b_flat) / (a_length * b_length);
            const Doubles half_cosine = sqrt(max(Doubles(0.0), (cosine + 1.0) * 0.5));
            // Below 0.1 and 0.05 greatest_slope is passed by any slope that matters.
            const auto is_turn = (norm(corner.a) * 0.1 < a_length) &
                                 (norm(corner.b) * 0.1 < b_length) &
                                 (Doubles(0.05) < half_cosine) &
                                 (Doubles(0.0) < dot(cross(a_flat, b_flat), n));
            const Mask<double> is_missing = corner.is_missing;
            is_ring = is_ring & (is_turn | is_missing);
            const Doubles zero = 0.0;
            const Doubles a_slope =
                select(is_missing, zero, (zero - a_up) / (a_length * half_cosine));
            const Doubles b_slope =
                select(is_missing, zero, (zero - b_up) / (b_length * half_cosine));
            above = max(above, max(a_slope, b_slope));
            below = max(below, max(zero - a_slope, zero - b_slope));
        }
        // Closed, with all corners turning the same way: the edges surround the normal.
        const unsigned has_cone = bits(is_ring & (max(above, below) <= greatest_slope));
        for (int lane_number = 0; lane_number < count; ++lane_number) {
            FanData& fan = fans[first + lane_number];
            fan.normal[0] = lane(normal.x, lane_number);
            fan.normal[1] = lane(normal.y, lane_number);
            fan.normal[2] = lane(normal.z, lane_number);
            const bool is_cone = (has_cone >> lane_number & 1) && !is_open[first + lane_number];
            fan.slope_above = is_cone ? lane(above, lane_number) : -1.0;
            fan.slope_below = is_cone ? lane(below, lane_number) : -1.0;
            const std::uint32_t corner = corners_[begin_[lane_number]];
            fan.vertex = sites_.triangles[corner / 3][corner % 3];
        }
    }

private:
    /// Corner i of each fan: from its vertex to the other two of the triangle.
    struct Corner {
        Vector a;
        Vector b;
        Vector normal;
        Mask<double> is_missing;

        ISOCAST_INLINE Corner(const FanFinder& finder, std::uint32_t i) {
            Gathered<13> in;
            for (int lane = 0; lane < lanes; ++lane) {
                const bool has = i < finder.valence_[lane];
                const std::uint32_t c = finder.corners_[finder.begin_[lane] + (has ? i : 0)];
                const std::uint32_t triangle = c / 3;
                const std::uint32_t k = c % 3;
                const std::int32_t* t = finder.sites_.triangles[triangle];
                in.set(0, lane, finder.sites_.vertices[t[k]]);
                in.set(3, lane, finder.sites_.vertices[t[k == 2 ? 0 : k + 1]]);
                in.set(6, lane, finder.sites_.vertices[t[k == 0 ? 2 : k - 1]]);
                in.set(9, lane, finder.sites_.faces[triangle].normal);
                in.number[12][lane] = !has;
            }
            a = in.vector(3) - in.vector(0);
            b = in.vector(6) - in.vector(0);
            normal = in.vector(9);
            is_missing = Doubles(0.5) < in.at(12);
        }
    };

    const SiteArrays& sites_;
    const std::uint32_t* corners_;
    Numbers numbers_;
    std::uint32_t begin_[lanes];
    std::uint32_t valence_[lanes];
    std::uint32_t most_ = 0;
};

template<class Visit>
ISOCAST_INLINE void for_each_eight(std::int32_t begin, std::int32_t end, const Visit& visit) {
    for (std::int32_t i = begin; i < end; i += lanes)
        visit(i, end - i < lanes ? int(end - i) : lanes);
}

void find_normals(const SiteArrays& sites, std::int32_t begin, std::int32_t end,
                  FaceNormal* normals) {
    for_each_eight(begin, end, [&](std::int32_t first, int count) {
        const Faces faces(sites, Numbers(first, count));
        for (int i = 0; i < count; ++i)
            normals[first + i] = {
                {lane(faces.t.x, i), lane(faces.t.y, i), lane(faces.t.z, i)}, lane(faces.noise, i)};
    });
}

void find_fans(const SiteArrays& sites, const std::uint32_t* corners,
               const std::uint32_t* corner_begin, const char* is_open, std::int32_t begin,
               std::int32_t end, FanData* fans) {
    for_each_eight(begin, end, [&](std::int32_t first, int count) {
        FanFinder(sites, corners, corner_begin, first, count).run(is_open, first, count, fans);
    });
}

/// Calls visit(sites of one kind, number of the first, count) for eight or fewer sites at a time.
template<class Visit>
void for_sites(const SiteArrays& sites, std::int32_t begin, std::int32_t end, const Visit& visit) {
    const std::int32_t first_fan = sites.face_count + sites.edge_count;
    while (begin < end) {
        const std::int32_t first = begin < sites.face_count ? 0
                                   : begin < first_fan      ? sites.face_count
                                                            : first_fan;
        const std::int32_t kind_end = begin < sites.face_count ? sites.face_count
                                      : begin < first_fan      ? first_fan
                                                               : end;
        std::int32_t count = (kind_end < end ? kind_end : end) - begin;
        if (count > lanes) count = lanes;
        const Numbers numbers(begin - first, count);
        if (begin < sites.face_count)
            visit(Faces(sites, numbers).regions(sites.half_width), begin, count);
        else if (begin < first_fan)
            visit(Edges(sites, numbers).regions(sites.half_width), begin, count);
        else
            visit(Fans(sites, numbers).regions(), begin, count);
        begin += count;
    }
}

void find_regions(const SiteArrays& sites, std::int32_t begin, std::int32_t end,
                  SiteRegion* regions) {
    for_sites(sites, begin, end, [&](const Regions& eight, std::int32_t first, std::int32_t count) {
        eight.write(regions + (first - begin), count);
    });
}

void see_sites(const TileInput& input, TileSite* to) {
    for_all_sites(input, [&]<Kind kind>(const SeenSites& seen, const Regions& regions,
                                        std::int64_t next, int count) {
        SiteRegion from_anchor[lanes];
        regions.write(from_anchor, count);
        for (int lane = 0; lane < count; ++lane) {
            TileSite& site = to[next + lane];
            site.region = from_anchor[lane];
            for (int k = 0; k < 3; ++k) {
                site.region.base_min[k] -= input.first_sample[k];
                site.region.base_max[k] -= input.first_sample[k];
            }
            for (int i = 0; i < 4; ++i) {
                const auto& f = seen.functions[i];
                site.functions[i] = {f[0][lane], f[1][lane], f[2][lane], f[3][lane]};
            }
            site.length = kind == Kind::Edge ? seen.length[lane] : 0;
            site.normal_x = kind == Kind::Edge ? seen.normal_x[lane] : 0;
            site.normal_y = kind == Kind::Edge ? seen.normal_y[lane] : 0;
        }
    });
}

std::int64_t scan(const TileInput& input, TileColumns& columns) {
    if (columns.site[0]) return Scan<true>(input, columns).run();
    return Scan<false>(input, columns).run();
}

bool finish(const TileColumns& columns, double half_width, double scale, int x, int y, int z,
            ScannedBlock& block) {
    if (columns.site[0])
        return Finish<true>(columns, half_width, x, y, z).write(half_width, scale, block);
    return Finish<false>(columns, half_width, x, y, z).write(half_width, scale, block);
}

void apply_signs(const float (&distance)[512], const std::uint8_t (&negative)[64], float* to) {
    for (int row = 0; row < 64; ++row)
        store(to + 8 * row, negated(load(distance + 8 * row), negative[row]));
}

} // namespace

extern const ScanKernels kernels;
const ScanKernels kernels = {find_normals, find_fans, find_regions, see_sites,
                             scan,         finish,    apply_signs};
