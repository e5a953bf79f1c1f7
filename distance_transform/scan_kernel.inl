// The kernel of scan_kernel.h, in the namespace of one instruction set.
//
// A site is scanned by columns of eight samples along the axis nearest to its region's direction.
// The nearest point q of a sample p obeys, with w = p - q: if q is inside a face, w is along its
// normal; if q is inside an edge, w is across it and leads into none of its triangles; if q is a
// vertex, w leads along none of its edges. These are the tower, the wedge and the cone, so that p
// lies in the region of the site that holds q, and every distance that another site offers is to a
// point of the mesh too: the least is exact.

namespace {

using Doubles = Lanes<double>;
using Floats = Lanes<float>;

/// A face's samples may lie this far outside its tower [voxels]: far above rounding, and of no
/// consequence, since the distance to the plane there is wrong by 1e-18 over the distance.
constexpr double tower_slack = 1e-9;

/// The band's border is this much wider than asked [voxels], far above rounding: samples exactly on
/// it are all active, and the neighbours of an inactive sample are surely not on the surface.
constexpr double border_slack = 1e-9;

/// The squared distances of one orientation of columns, signed: index k + 8 u + 64 v, where k is
/// the column's axis and u, v the two after it.
struct Columns {
    double signed_square[512];
    double site[512];
};

/// A linear function of a block's samples: along a column, and from column to column.
struct Linear {
    double first;
    double along_k;
    double along_u;
    double along_v;

    /// dot(axis, p - origin) of the samples p.
    static ISOCAST_INLINE Linear of(const double* axis, const double* origin, const double* sample,
                                    int k, int u, int v) {
        return {axis[0] * (sample[0] - origin[0]) + axis[1] * (sample[1] - origin[1]) +
                    axis[2] * (sample[2] - origin[2]),
                axis[k], axis[u], axis[v]};
    }
    ISOCAST_INLINE Doubles column(int u, int v, const Doubles& steps) const {
        return steps * along_k + (first + u * along_u + v * along_v);
    }
};

ISOCAST_INLINE Linear combined(double a, const Linear& f, double b, const Linear& g, double c) {
    return {a * f.first + b * g.first + c, a * f.along_k + b * g.along_k,
            a * f.along_u + b * g.along_u, a * f.along_v + b * g.along_v};
}

ISOCAST_INLINE Doubles absolute(const Doubles& x) {
    return max(x, Doubles(0.0) - x);
}

ISOCAST_INLINE float least(float a, float b) { return a < b ? a : b; }
ISOCAST_INLINE float greatest(float a, float b) { return a < b ? b : a; }

/// The least integer >= x and the greatest <= x, within 0 … 8 and -1 … 7.
ISOCAST_INLINE int ceiling(float x) {
    if (!(x > 0)) return 0;
    if (x > 7) return 8;
    const int i = int(x);
    return i + (float(i) < x);
}
ISOCAST_INLINE int floor_of(float x) { return x < 0 ? -1 : x >= 7 ? 7 : int(x); }

template<bool with_sites>
class Scan {
public:
    explicit Scan(const ScanInput& input)
        : input_(input), beyond_((input.half_width + border_slack) * (input.half_width + border_slack)) {
        alignas(64) double steps[8];
        for (int i = 0; i < 8; ++i) steps[i] = i;
        steps_ = load(steps);
        for (int i = 0; i < 8; ++i) row_steps_[i] = float(i);
    }

    std::int64_t run(ScanOutput& output) {
        const SiteArrays& sites = *input_.sites;
        for (int i = 0; i < input_.count; ++i) {
            if (i + 6 < input_.count) prefetch_site(input_.list[i + 6]);
            const std::int32_t site = input_.list[i];
            const SiteRegion& region = sites.regions[site];
            if (site < sites.face_count)
                scan_face(region, sites.faces[site], site);
            else if (site < sites.face_count + sites.edge_count)
                scan_edge(region, sites.edges[site - sites.face_count], site);
            else
                scan_vertex(region, sites.vertices[site - sites.face_count - sites.edge_count],
                            site);
        }
        finish(output);
        return evaluations_;
    }

private:
    template<class T>
    static void prefetch(const T& item) {
        const char* first = reinterpret_cast<const char*>(&item);
        for (unsigned long i = 0; i < sizeof item; i += 64) __builtin_prefetch(first + i);
    }
    /// A block's sites lie about in memory.
    void prefetch_site(std::int32_t site) const {
        const SiteArrays& sites = *input_.sites;
        prefetch(sites.regions[site]);
        if (site < sites.face_count)
            prefetch(sites.faces[site]);
        else if (site < sites.face_count + sites.edge_count)
            prefetch(sites.edges[site - sites.face_count]);
        else
            prefetch(sites.vertices[site - sites.face_count - sites.edge_count]);
    }

    Columns& columns_of(int axis) {
        Columns& columns = columns_[axis];
        if (!is_used_[axis]) {
            is_used_[axis] = true;
            for (double& x : columns.signed_square) x = beyond_;
        }
        return columns;
    }

    /// Calls visit(u, v) for every column of the block that meets the region.
    template<class Visit>
    ISOCAST_INLINE void for_each_column(const SiteRegion& region, const Visit& visit) const {
        const int k = region.axis;
        const int u = (k + 1) % 3;
        const int v = (k + 2) % 3;
        const float* w = region.direction;
        const float bk = float(input_.first_sample[k]);
        const float bu = float(input_.first_sample[u]);
        const float bv = float(input_.first_sample[v]);
        const float reach =
            region.lateral + region.lateral_slope * greatest(-region.low, region.high);
        const float aside = reach * region.lateral_factor[k];
        const float inverse_w = 1 / w[k];
        const float low = greatest(region.low, (bk - region.base_max[k] - aside) * inverse_w);
        const float high = least(region.high, (bk + 7 - region.base_min[k] + aside) * inverse_w);
        if (!(low <= high)) return;
        const float lateral = region.lateral + region.lateral_slope * greatest(-low, high);
        const auto first_of = [&](int axis, float b) __attribute__((always_inline)) {
            return ceiling(region.base_min[axis] - b + least(low * w[axis], high * w[axis]) -
                           lateral * region.lateral_factor[axis]);
        };
        const auto last_of = [&](int axis, float b) __attribute__((always_inline)) {
            return floor_of(region.base_max[axis] - b + greatest(low * w[axis], high * w[axis]) +
                            lateral * region.lateral_factor[axis]);
        };
        const int v_first = first_of(v, bv);
        const int v_last = last_of(v, bv);
        if (v_first > v_last) return;
        Floats u_low = region.base_min[u] - bu + least(low * w[u], high * w[u]) -
                       lateral * region.lateral_factor[u];
        Floats u_high = region.base_max[u] - bu + greatest(low * w[u], high * w[u]) +
                        lateral * region.lateral_factor[u];
        // Where the strips cut the rows of columns.
        const Floats rows = load(row_steps_);
        for (int i = 0; i < region.strip_count; ++i) {
            const SiteRegion::Strip& strip = region.strips[i];
            // Nearly along a row it would cut far off.
            if (__builtin_fabsf(strip.across[0]) < 0.02f) continue;
            const float shift = strip.across[0] * bu + strip.across[1] * bv;
            const float side = lateral * strip.factor;
            const float from =
                strip.low - shift + least(low * strip.lean, high * strip.lean) - side;
            const float to =
                strip.high - shift + greatest(low * strip.lean, high * strip.lean) + side;
            const float inverse = 1 / strip.across[0];
            const Floats slope = rows * (strip.across[1] * inverse);
            u_low = max(u_low, Floats(least(from * inverse, to * inverse)) - slope);
            u_high = min(u_high, Floats(greatest(from * inverse, to * inverse)) - slope);
        }
        alignas(32) float u_from[8];
        alignas(32) float u_to[8];
        store(u_from, u_low);
        store(u_to, u_high);
        for (int j = v_first; j <= v_last; ++j) {
            const int u_last = floor_of(u_to[j]);
            for (int i = ceiling(u_from[j]); i <= u_last; ++i) visit(i, j);
        }
    }

    /// Keeps the lesser of what a column holds and `square`, with the sign of `side`.
    ISOCAST_INLINE void offer(Columns& columns, int u, int v, const Mask<double>& is_valid,
                              const Doubles& square, const Doubles& side, std::int32_t site) {
        const int at = 8 * u + 64 * v;
        const Doubles held = load(columns.signed_square + at);
        const auto is_nearer = is_valid & (square < absolute(held));
        const Doubles with_side = select(side < 0.0, Doubles(0.0) - square, square);
        store(columns.signed_square + at, select(is_nearer, with_side, held));
        if constexpr (with_sites)
            store(columns.site + at,
                  select(is_nearer, double(site), load(columns.site + at)));
        evaluations_ += lanes;
    }

    ISOCAST_INLINE Linear linear(const double* axis, const double* origin, int k) const {
        return Linear::of(axis, origin, input_.first_sample, k, (k + 1) % 3, (k + 2) % 3);
    }

    void scan_face(const SiteRegion& region, const FaceSite& face, std::int32_t site) {
        const int k = region.axis;
        const Linear r = linear(face.r, face.origin, k);
        const Linear s = linear(face.s, face.origin, k);
        const Linear t = linear(face.t, face.origin, k);
        // Distances outwards over the two sides that meet at the apex.
        const Linear right = combined(face.right.sine, r, face.right.cosine, s,
                                      -face.right.sine * face.right.base);
        const Linear left = combined(-face.left.sine, r, face.left.cosine, s,
                                     -face.left.sine * face.left.base);
        Columns& columns = columns_of(k);
        for_each_column(region, [&](int u, int v) __attribute__((always_inline)) {
            const Doubles height = t.column(u, v, steps_);
            const auto is_over_face = (Doubles(-tower_slack) <= s.column(u, v, steps_)) &
                                      (right.column(u, v, steps_) <= Doubles(tower_slack)) &
                                      (left.column(u, v, steps_) <= Doubles(tower_slack));
            offer(columns, u, v, is_over_face, height * height, height, site);
        });
    }

    void scan_edge(const SiteRegion& region, const EdgeSite& edge, std::int32_t site) {
        const int k = region.axis;
        const Linear e = linear(edge.e, edge.origin, k);
        const Linear x = linear(edge.x, edge.origin, k);
        const Linear y = linear(edge.y, edge.origin, k);
        const Doubles end = edge.length + tower_slack;
        Columns& columns = columns_of(k);
        for_each_column(region, [&](int u, int v) __attribute__((always_inline)) {
            const Doubles along = e.column(u, v, steps_);
            const Doubles dx = x.column(u, v, steps_);
            const Doubles dy = y.column(u, v, steps_);
            const auto is_beside = (Doubles(-tower_slack) <= along) & (along <= end);
            offer(columns, u, v, is_beside, dx * dx + dy * dy,
                  dx * edge.normal_x + dy * edge.normal_y, site);
        });
    }

    void scan_vertex(const SiteRegion& region, const VertexSite& vertex, std::int32_t site) {
        const int k = region.axis;
        const Linear side = linear(vertex.normal, vertex.origin, k);
        const int ku = (k + 1) % 3;
        const int kv = (k + 2) % 3;
        const Doubles dk = steps_ + (input_.first_sample[k] - vertex.origin[k]);
        const Doubles squared_dk = dk * dk;
        Columns& columns = columns_of(k);
        for_each_column(region, [&](int u, int v) __attribute__((always_inline)) {
            const double du = input_.first_sample[ku] + u - vertex.origin[ku];
            const double dv = input_.first_sample[kv] + v - vertex.origin[kv];
            const Doubles square = squared_dk + (du * du + dv * dv);
            offer(columns, u, v, square < beyond_, square, side.column(u, v, steps_), site);
        });
    }

    /// The least of the three orientations, as distances.
    void finish(ScanOutput& output) const {
        const Doubles scale = input_.scale;
        for (int z = 0; z < 8; ++z) {
            for (int y = 0; y < 8; ++y) {
                const int row = y + 8 * z;
                Doubles least_square = beyond_;
                Doubles site = -1.0;
                for (int axis = 0; axis < 3; ++axis) {
                    if (!is_used_[axis]) continue;
                    // Where sample x of this row stands.
                    const int first = axis == 0 ? 8 * row : axis == 1 ? y + 8 * z : z + 64 * y;
                    const int stride = axis == 0 ? 1 : axis == 1 ? 64 : 8;
                    alignas(64) double square[8];
                    for (int x = 0; x < 8; ++x)
                        square[x] = columns_[axis].signed_square[first + stride * x];
                    const Doubles other = load(square);
                    const auto is_nearer = absolute(other) < absolute(least_square);
                    least_square = select(is_nearer, other, least_square);
                    if constexpr (with_sites) {
                        for (int x = 0; x < 8; ++x)
                            square[x] = columns_[axis].site[first + stride * x];
                        site = select(is_nearer, load(square), site);
                    }
                }
                const Doubles squared_distance = absolute(least_square);
                output.active[row] = std::uint8_t(bits(squared_distance < beyond_));
                output.negative[row] =
                    std::uint8_t(bits(least_square < 0.0) & output.active[row]);
                const Doubles distance =
                    min(sqrt(squared_distance), input_.half_width) * scale;
                for (int x = 0; x < 8; ++x) {
                    output.distance[8 * row + x] = float(lane(distance, x));
                    if constexpr (with_sites) output.site[8 * row + x] = int(lane(site, x));
                }
            }
        }
    }

    const ScanInput& input_;
    double beyond_;
    Doubles steps_;
    alignas(32) float row_steps_[8];
    bool is_used_[3] = {false, false, false};
    std::int64_t evaluations_ = 0;
    alignas(64) Columns columns_[3];
};

} // namespace

std::int64_t scan(const ScanInput& input, ScanOutput& output) {
    if (input.with_sites) return Scan<true>(input).run(output);
    return Scan<false>(input).run(output);
}
