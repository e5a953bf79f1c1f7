// Eight fans of triangles side by side: their normals and the slopes of their cones.
//
// Included in the namespace of one instruction set, after site_lanes.inl.

namespace {

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
                                 (norm(corner.b) * 0.1 < b_length) & (Doubles(0.05) < half_cosine) &
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

} // namespace
