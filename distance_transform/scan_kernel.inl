// The kernels of scan_kernel.h, in the namespace of one instruction set.
//
// A site is scanned by columns of samples along the axis nearest to its region's direction. The
// nearest point q of a sample p obeys, with w = p - q: if q is inside a face, w is along its
// normal; if q is inside an edge, w is across it and leads into none of its triangles; if q is a
// vertex, w leads along none of its edges. These are the tower, the wedge and the cone, so that p
// lies in the region of the site that holds q, and every distance that another site offers is to a
// point of the mesh too: the least is exact.

namespace {

ISOCAST_INLINE double squared_reach(double half_width) {
    return (half_width + border_slack) * (half_width + border_slack);
}

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
    for_kind<Faces>(input, next, 0, first_edge,
                    [&](auto&... args) { visit.template operator()<Kind::Face>(args...); });
    for_kind<Edges>(input, next, first_edge, first_fan,
                    [&](auto&... args) { visit.template operator()<Kind::Edge>(args...); });
    for_kind<Fans>(input, next, first_fan, end,
                   [&](auto&... args) { visit.template operator()<Kind::Fan>(args...); });
}

template<bool with_sites>
class Scan {
public:
    Scan(const TileInput& input, TileColumns& columns)
        : input_(input), columns_(columns), beyond_(squared_reach(input.sites->half_width)) {
        for (int k = 0; k < 3; ++k) columns_.is_used[k] = false;
        for (int i = 0; i < tile_size; ++i) steps_[i] = i;
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
        const int column_count = int(seen.column_count[lane]);
        if (column_count == 0) return;
        const int axis = int(seen.axis[lane]);
        use(axis);
        double* const squares = columns_.signed_square[axis];
        double* const numbers = with_sites ? columns_.site[axis] : nullptr;
        const Doubles along0 = seen.functions[0][1][lane];
        const Doubles along1 = seen.functions[1][1][lane];
        const Doubles along2 = seen.functions[2][1][lane];
        const Doubles along3 = seen.functions[3][1][lane];
        constexpr bool is_edge = kind == Kind::Edge;
        const Doubles end = is_edge ? seen.length[lane] + tower_slack : 0;
        const Doubles normal_x = is_edge ? seen.normal_x[lane] : 0;
        const Doubles normal_y = is_edge ? seen.normal_y[lane] : 0;
        ColumnBatch batch;
        for (int first_column = 0; first_column < column_count; first_column += lanes) {
            for (unsigned rest = find_columns<kind>(seen, lane, first_column, batch); rest != 0;
                 rest &= rest - 1) {
                const int column = __builtin_ctz(rest);
                const int last = batch.last[column];
                const Doubles at0 = batch.at[0][column];
                const Doubles at1 = batch.at[1][column];
                const Doubles at2 = batch.at[2][column];
                const Doubles at3 = batch.at[3][column];
                for (int first = batch.first[column]; first <= last; first += lanes) {
                    const int k = first < tile_size - lanes ? first : tile_size - lanes;
                    const int at = batch.place[column] + k;
                    const Doubles steps = load(steps_ + k);
                    const Doubles c0 = steps * along0 + at0;
                    if constexpr (kind == Kind::Face) {
                        const Doubles slack = tower_slack;
                        const auto is_over_face = (steps * along1 + at1 <= slack) &
                                                  (steps * along2 + at2 <= slack) &
                                                  (steps * along3 + at3 <= slack);
                        offer(squares, numbers, at, is_over_face, c0 * c0, c0, site);
                    } else if constexpr (is_edge) {
                        const Doubles c1 = steps * along1 + at1;
                        const Doubles along = steps * along2 + at2;
                        const auto is_beside = (Doubles(-tower_slack) <= along) & (along <= end);
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

    /// Eight columns side by side.
    struct ColumnBatch {
        alignas(64) double at[4][lanes]; // of the site's functions, at k = 0
        int first[lanes];                // samples along k
        int last[lanes];
        int place[lanes]; // of sample 0 among all
    };

    /// A site's columns from `first_column` on. returns  a bit for each that has a sample
    template<Kind kind>
    ISOCAST_INLINE unsigned find_columns(const SeenSites& seen, int lane, int first_column,
                                         ColumnBatch& batch) const {
        const Doubles number = load(steps_) + double(first_column);
        const Doubles width = seen.width[lane];
        // Half a column away from where the next row begins.
        const Doubles row = rounded((number + 0.5) / width - 0.5);
        const Doubles v = row + seen.v_first[lane];
        const Doubles start = ceiling(Doubles(seen.row_start[lane]) - v * seen.row_slope[lane]);
        const Doubles u = start + (number - row * width);
        Doubles low = 0.0;
        Doubles high = tile_size - 1.0;
        constexpr int bound_count = kind == Kind::Fan ? 5 : 4;
        for (int i = 0; i < bound_count; ++i) {
            const SeenSites::Bound& bound = seen.bounds[i];
            const Doubles shift = u * bound.slope_u[lane] + v * bound.slope_v[lane];
            low = max(low, shift + bound.low[lane]);
            high = min(high, shift + bound.high[lane]);
        }
        const Doubles first = ceiling(min(low, tile_size));
        const Doubles last = floor_of(max(high, -1.0));
        store_integers(batch.first, first);
        store_integers(batch.last, last);
        store_integers(batch.place,
                       u * double(TileColumns::stride_u) + v * double(TileColumns::stride_v));
        for (int i = 0; i < 4; ++i) {
            const auto& f = seen.functions[i];
            store(batch.at[i], Doubles(f[0][lane]) + v * f[3][lane] + u * f[2][lane]);
        }
        return bits((first <= last) & (number < seen.column_count[lane]) &
                    (Doubles(seen.u_first[lane]) <= u) & (u <= Doubles(seen.u_last[lane])));
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
    alignas(64) double steps_[tile_size];
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
            store_floats(block.distance + 8 * row, min(sqrt(squared_distance), half_width) * scale);
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
            normals[first + i] = {{lane(faces.t.x, i), lane(faces.t.y, i), lane(faces.t.z, i)},
                                  lane(faces.noise, i)};
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

void find_regions(const SiteArrays& sites, std::int32_t begin, std::int32_t end, SampleBox* boxes,
                  SiteRegion* regions) {
    for_sites(sites, begin, end, [&](const Regions& eight, std::int32_t first, std::int32_t count) {
        SampleBox* const box = boxes + (first - begin);
        eight.write_boxes(box, count);
        eight.write(regions + (first - begin), count, [&](int lane) {
            bool is_several = false;
            for (int k = 0; k < 3; ++k)
                is_several |= tile_of(box[lane].first[k]) != tile_of(box[lane].last[k]);
            return is_several;
        });
    });
}

void see_sites(const TileInput& input, TileSite* to) {
    for_all_sites(input, [&]<Kind kind>(const SeenSites& seen, const Regions& regions,
                                        std::int64_t next, int count) {
        SiteRegion from_anchor[lanes];
        regions.write(from_anchor, count, [](int) { return true; });
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
