// The kernels of block_descent.h, in the namespace of one instruction set.
//
// The cube of 8^3 samples is halved twice, to cubes of 2^3 samples. At a cube's eight children the
// distances d_i and directions u_i = grad d_i of the kept triangles are computed in eight lanes,
// and a child keeps those triangles that can be nearest to a sample within its radius R. Let j be
// the nearest at the child's centre and o, |o| <= R, lead from there to a sample s:
//   d_i(s) >= d_i + u_i·o              (distance to a convex set is convex, u_i its gradient),
//   d_j(s) <= |d_j u_j + o| <= d_j + u_j·o + |o|^2 / 2 d_j   (to the point of j nearest to c),
// so i can be nearest only if d_i - d_j - R^2 / 2 d_j <= (u_j - u_i)·o <= R |u_j - u_i|, and only
// if d_i <= d_j + 2 R, since distance is 1-Lipschitz. In a cube of 2^3 the lanes are its samples;
// a triangle whose lower bound d_i + u_i·o is above what every lane already has is not evaluated.
//
// Bounds are computed in float, in coordinates about the cube's centre, and loosened by their
// rounding; the samples' distances in double.

namespace {

using Doubles = Lanes<double>;
using Floats = Lanes<float>;

/// A TriangleFrame about a cube's centre.
struct LocalFrame {
    float origin[3];
    float r[3];
    float s[3];
    float t[3];
    struct Side {
        float base;
        float cosine;
        float sine;
        float length;
    };
    Side right;
    Side left;
    float middle[3]; // of a ball around the triangle
    float radius;
};

template<class L>
struct Evaluation {
    L squared_distance;
    L height;
    L planar_r; // offset of the point from its nearest one, along r and s
    L planar_s;
};

/// Distances of eight points to one triangle.
/// source  thesis listing 4.1, with its second frame corrected and scaled to unit length
template<class L, class Frame>
ISOCAST_INLINE Evaluation<L> evaluate(const Frame& f, const L& px, const L& py, const L& pz) {
    const L zero = 0;
    const L x = px - f.origin[0];
    const L y = py - f.origin[1];
    const L z = pz - f.origin[2];
    const L r = x * f.r[0] + y * f.r[1] + z * f.r[2];
    const L s = x * f.s[0] + y * f.s[1] + z * f.s[2];
    const L t = x * f.t[0] + y * f.t[1] + z * f.t[2];
    // Reflected to r >= 0, only the right half of the triangle matters.
    const auto is_left = r < zero;
    const L base = select(is_left, L(f.left.base), L(f.right.base));
    const L cosine = select(is_left, L(f.left.cosine), L(f.right.cosine));
    const L sine = select(is_left, L(f.left.sine), L(f.right.sine));
    const L length = select(is_left, L(f.left.length), L(f.right.length));
    const L beyond = max(r, zero - r) - base;
    // Along the side from (base, 0) to the apex, and across it, outwards.
    const L u = s * sine - beyond * cosine;
    const L v = beyond * sine + s * cosine;
    const L along = u - min(max(u, zero), length);
    const auto is_over_face = v <= zero;
    const L side_r = select(is_over_face, zero, v * sine - along * cosine);
    const L side_s = select(is_over_face, zero, v * cosine + along * sine);
    const auto is_below = s < zero;
    const L planar_r = select(is_below, max(beyond, zero), side_r);
    const L planar_s = select(is_below, s, side_s);
    return {planar_r * planar_r + planar_s * planar_s + t * t, t,
            select(is_left, zero - planar_r, planar_r), planar_s};
}

/// Distances and directions of one candidate at the centres of a cube's eight children.
struct ChildLanes {
    float distance[lanes];
    float x[lanes];
    float y[lanes];
    float z[lanes];
    float turn_error[lanes]; // of the direction, times the child's radius
    int candidate;
};

/// The candidates of a cube's children.
struct Children {
    ChildLanes* at;
    int* list[8]; // places in `at`
    int count[8];
    int nearest[8]; // places in `at`
};

class Descent {
public:
    Descent(const DescentInput& input, int size, DescentOutput* output, char* memory)
        : input_(input), output_(output) {
        const long n = input.candidate_count;
        local_ = reinterpret_cast<LocalFrame*>(memory);
        memory += n * sizeof(LocalFrame);
        for (int level = 0; level < 2; ++level) {
            Children& children = level == 0 ? of_block_ : of_quarter_;
            children.at = reinterpret_cast<ChildLanes*>(memory);
            memory += n * sizeof(ChildLanes);
            for (int k = 0; k < 8; ++k) {
                children.list[k] = reinterpret_cast<int*>(memory);
                memory += (n + 1) * sizeof(int);
            }
        }
        for (int k = 0; k < 3; ++k) centre_[k] = input.first_sample[k] + (size - 1) / 2.0;
        localise(size);
    }

    static unsigned long bytes(long candidate_count) {
        return candidate_count * (sizeof(LocalFrame) + 2 * sizeof(ChildLanes)) +
               16 * (candidate_count + 1) * sizeof(int);
    }

    /// The children of a cube far larger than a block; the lists take the place of candidates.
    std::int64_t run_split(int child_size, SplitOutput& children) {
        const float middle[3] = {0, 0, 0};
        split(middle, child_size, all_candidates(), of_block_);
        for (int k = 0; k < 8; ++k) {
            children.count[k] = of_block_.count[k];
            children.list[k] = of_block_.list[k];
            for (int i = 0; i < children.count[k]; ++i)
                children.list[k][i] =
                    input_.candidates[of_block_.at[of_block_.list[k][i]].candidate];
        }
        return evaluations_;
    }

    std::int64_t run() {
        const float middle[3] = {0, 0, 0};
        split(middle, 4, all_candidates(), of_block_);
        for (int k = 0; k < 8; ++k) {
            if (of_block_.count[k] == 0) continue;
            const float quarter[3] = {k & 1 ? 2.f : -2.f, k & 2 ? 2.f : -2.f, k & 4 ? 2.f : -2.f};
            const KeptCandidates kept(of_block_, k, quarter);
            split(quarter, 2, kept, of_quarter_);
            const int first = 4 * ((k & 1) + 8 * (k >> 1 & 1) + 64 * (k >> 2));
            for (int j = 0; j < 8; ++j) {
                if (of_quarter_.count[j] == 0) continue;
                const double cube[3] = {centre_[0] + quarter[0] + (j & 1 ? 1 : -1),
                                        centre_[1] + quarter[1] + (j & 2 ? 1 : -1),
                                        centre_[2] + quarter[2] + (j & 4 ? 1 : -1)};
                visit_samples(cube, first + 2 * ((j & 1) + 8 * (j >> 1 & 1) + 64 * (j >> 2)),
                              j);
            }
        }
        return evaluations_;
    }

private:
    const TriangleFrame& frame(int candidate) const {
        return input_.frames[input_.candidates[candidate]];
    }

    /// The candidates' frames in float about the centre, and what rounding does to them.
    void localise(int size) {
        double greatest = size;
        float least = 1e30f;
        for (int i = 0; i < input_.candidate_count; ++i) {
            const TriangleFrame& f = frame(i);
            LocalFrame& local = local_[i];
            double reach = f.right.length + f.left.length;
            if (i + 4 < input_.candidate_count) {
                // The mesh's frames lie about in memory.
                const char* next = reinterpret_cast<const char*>(&frame(i + 4));
                __builtin_prefetch(next);
                __builtin_prefetch(next + 64);
                __builtin_prefetch(next + 128);
            }
            for (int k = 0; k < 3; ++k) {
                const double origin = f.origin[k] - centre_[k];
                reach += origin < 0 ? -origin : origin;
                local.origin[k] = float(origin);
                local.r[k] = float(f.r[k]);
                local.s[k] = float(f.s[k]);
                local.t[k] = float(f.t[k]);
            }
            local.right = {float(f.right.base), float(f.right.cosine), float(f.right.sine),
                           float(f.right.length)};
            local.left = {float(f.left.base), float(f.left.cosine), float(f.left.sine),
                          float(f.left.length)};
            enclose(f, local);
            greatest = reach > greatest ? reach : greatest;
            const float squared = local.middle[0] * local.middle[0] +
                                  local.middle[1] * local.middle[1] +
                                  local.middle[2] * local.middle[2];
            if (squared < least) {
                least = squared;
                nearest_ball_ = i;
            }
        }
        // About 20 roundings of numbers no greater than that meet in a distance.
        error_ = float(20 * 6e-8 * greatest);
    }

    /// The ball about the centroid.
    static void enclose(const TriangleFrame& f, LocalFrame& local) {
        const double r = (f.right.base - f.left.base) / 3;
        const double s = f.h / 3;
        for (int k = 0; k < 3; ++k)
            local.middle[k] = float(local.origin[k] + r * f.r[k] + s * f.s[k]);
        const double right = (f.right.base - r) * (f.right.base - r) + s * s;
        const double left = (f.left.base + r) * (f.left.base + r) + s * s;
        const double apex = r * r + 4 * s * s;
        const double ends = right > left ? right : left;
        local.radius = float(__builtin_sqrt(ends > apex ? ends : apex));
    }

    /// Offsets ± d on each axis, x fastest.
    template<class T>
    static ISOCAST_INLINE void corners(const T* centre, T d, Lanes<T>& x, Lanes<T>& y,
                                       Lanes<T>& z) {
        alignas(64) T at[3][8];
        for (int i = 0; i < 8; ++i)
            for (int k = 0; k < 3; ++k) at[k][i] = centre[k] + (i >> k & 1 ? d : -d);
        x = load(at[0]);
        y = load(at[1]);
        z = load(at[2]);
    }

    /// All candidates of the input as parents; balls tell which are far.
    struct AllCandidates {
        const LocalFrame* frames;
        int count;
        int nearest; // visited first, so that others are soon known to be too far
        int at(int i) const { return i; }
        int candidate(int i) const { return i; }
        ISOCAST_INLINE Floats lower_bound(int i, const Floats& x, const Floats& y,
                                          const Floats& z) const {
            const LocalFrame& f = frames[i];
            const Floats dx = x - f.middle[0];
            const Floats dy = y - f.middle[1];
            const Floats dz = z - f.middle[2];
            return sqrt(dx * dx + dy * dy + dz * dz) - f.radius;
        }
    };

    AllCandidates all_candidates() const {
        return {local_, input_.candidate_count, nearest_ball_};
    }

    /// The candidates of child k of a cube, with its centre; tangents tell which are far.
    struct KeptCandidates {
        KeptCandidates(const Children& children, int child, const float (&child_centre)[3])
            : of(children), k(child), centre(child_centre), count(children.count[child]),
              nearest(children.nearest[child]) {}
        const Children& of;
        int k;
        const float (&centre)[3];
        int count;
        int nearest;
        int at(int i) const { return of.list[k][i]; }
        int candidate(int i) const { return of.at[i].candidate; }
        ISOCAST_INLINE Floats lower_bound(int i, const Floats& x, const Floats& y,
                                          const Floats& z) const {
            const ChildLanes& c = of.at[i];
            return (x - centre[0]) * c.x[k] + (y - centre[1]) * c.y[k] + (z - centre[2]) * c.z[k] +
                   c.distance[k];
        }
    };

    /// Children of `size`^3 samples of the cube about `centre`, and who may be nearest there.
    template<class Parents>
    void split(const float* centre, int size, const Parents& parents, Children& children) {
        Floats x, y, z;
        corners(centre, size / 2.0f, x, y, z);
        const float radius = (size - 1) / 2.0f * 1.7320508f; // sqrt 3
        // Nearer than this the direction is lost in rounding, and the distance counts as 0.
        const float nearest_told = 100 * error_;
        const float slack = nearest_told + 2 * error_;
        Floats least = 1e30f;
        Floats least_x = 0.f, least_y = 0.f, least_z = 0.f, least_error = 0.f;
        Floats nearest = 0.f; // place in children.at, exact below 2^24
        const float widest = float(input_.half_width) + radius + slack;
        Floats limit = widest;
        int count = 0;
        const auto visit = [&](int i) __attribute__((always_inline)) {
            const int candidate = parents.candidate(i);
            const LocalFrame& f = local_[candidate];
            const Evaluation e = evaluate(f, x, y, z);
            const Floats root = sqrt(e.squared_distance);
            const auto is_told = Floats(nearest_told) < root;
            const Floats distance = select(is_told, root, 0.f);
            const Floats inverse = select(is_told, Floats(1.f) / root, 0.f);
            const Floats ur = e.planar_r * inverse;
            const Floats us = e.planar_s * inverse;
            const Floats ut = e.height * inverse;
            const Floats ux = ur * f.r[0] + us * f.s[0] + ut * f.t[0];
            const Floats uy = ur * f.r[1] + us * f.s[1] + ut * f.t[1];
            const Floats uz = ur * f.r[2] + us * f.s[2] + ut * f.t[2];
            const Floats turn_error = inverse * (error_ * radius);
            ChildLanes& at = children.at[count];
            at.candidate = candidate;
            store(at.distance, distance);
            store(at.x, ux);
            store(at.y, uy);
            store(at.z, uz);
            store(at.turn_error, turn_error);
            const auto is_nearer = distance < least;
            least = select(is_nearer, distance, least);
            least_x = select(is_nearer, ux, least_x);
            least_y = select(is_nearer, uy, least_y);
            least_z = select(is_nearer, uz, least_z);
            least_error = select(is_nearer, turn_error, least_error);
            nearest = select(is_nearer, float(count), nearest);
            limit = min(least + (2 * radius + slack), widest);
            ++count;
        };
        visit(parents.nearest);
        for (int k = 0; k < parents.count; ++k) {
            const int i = parents.at(k);
            if (i == parents.nearest) continue;
            if (bits(parents.lower_bound(i, x, y, z) <= limit) != 0) visit(i);
        }
        evaluations_ += lanes * count;

        const Floats bend =
            least + Floats(radius * radius / 2) / max(least, 1e-6f) + (least_error + slack);
        int kept_count[8] = {};
        for (int i = 0; i < count; ++i) {
            const ChildLanes& at = children.at[i];
            const Floats distance = load(at.distance);
            const Floats excess = distance - bend - load(at.turn_error);
            const Floats cosine =
                load(at.x) * least_x + load(at.y) * least_y + load(at.z) * least_z;
            // 1e-5: rounding of unit vectors' product, beside what turn_error holds.
            const Floats squared_turn = Floats(2.f + 1e-5f) - cosine - cosine;
            const auto can_turn =
                (excess <= 0.f) | (excess * excess <= squared_turn * (radius * radius));
            const unsigned kept = bits((distance <= limit) & can_turn);
            // Without a branch, which nothing could foresee.
            for (int k = 0; k < 8; ++k) {
                children.list[k][kept_count[k]] = i;
                kept_count[k] += kept >> k & 1;
            }
        }
        for (int k = 0; k < 8; ++k) {
            children.count[k] = kept_count[k];
            children.nearest[k] = int(lane(nearest, k));
        }
    }

    /// The eight samples about `centre`, child k of a quarter.
    void visit_samples(const double* centre, int first, int k) {
        Doubles x, y, z;
        corners(centre, 0.5, x, y, z);
        const float origin[3] = {0, 0, 0};
        Floats ox, oy, oz;
        corners(origin, 0.5f, ox, oy, oz);
        Doubles least = input_.half_width * input_.half_width;
        Doubles height = 0.0;
        Doubles winner = -1.0; // the number of a candidate, exactly
        Floats least_rounded;  // up, by far more than the rounding of the bounds' square
        const auto visit = [&](int candidate) __attribute__((always_inline)) {
            evaluations_ += lanes;
            const Evaluation e = evaluate(frame(candidate), x, y, z);
            const auto is_nearer = e.squared_distance <= least;
            least = select(is_nearer, e.squared_distance, least);
            height = select(is_nearer, e.height, height);
            winner = select(is_nearer, double(candidate), winner);
            for (int i = 0; i < lanes; ++i)
                least_rounded.part[i / Floats::native_lanes][i % Floats::native_lanes] =
                    float(least.part[i / Doubles::native_lanes][i % Doubles::native_lanes]);
            least_rounded = least_rounded * 1.000001f;
        };
        const int nearest = of_quarter_.nearest[k];
        visit(of_quarter_.at[nearest].candidate);
        const float slack = 102 * error_; // as in split
        for (int i = 0; i < of_quarter_.count[k]; ++i) {
            const int place = of_quarter_.list[k][i];
            if (place == nearest) continue;
            const ChildLanes& c = of_quarter_.at[place];
            // The turn error is times the radius of these samples: sqrt 3 / 2.
            const Floats bound = ox * c.x[k] + oy * c.y[k] + oz * c.z[k] +
                                 (c.distance[k] - slack - c.turn_error[k]);
            if (bits((bound < 0.f) | (bound * bound < least_rounded)) == 0) continue;
            visit(c.candidate);
        }
        least = select(winner < 0.0, 1e300, least);
        for (int i = 0; i < 8; ++i) {
            const int sample = first + (i & 1) + 8 * (i >> 1 & 1) + 64 * (i >> 2);
            output_->squared_distance[sample] = lane(least, i);
            output_->height[sample] = lane(height, i);
            output_->triangle[sample] = int(lane(winner, i));
        }
    }

    const DescentInput& input_;
    DescentOutput* output_;
    double centre_[3];
    float error_; // of a local distance
    int nearest_ball_ = 0;
    LocalFrame* local_;
    Children of_block_;
    Children of_quarter_;
    std::int64_t evaluations_ = 0;
};

char* memory_for(const DescentInput& input, DescentWorkspace& workspace) {
    return static_cast<char*>(workspace.memory(Descent::bytes(input.candidate_count)));
}

std::int64_t descend(const DescentInput& input, DescentWorkspace& workspace,
                     DescentOutput& output) {
    for (double& squared_distance : output.squared_distance) squared_distance = 1e300;
    return Descent(input, 8, &output, memory_for(input, workspace)).run();
}

std::int64_t split(const DescentInput& input, int child_size, DescentWorkspace& workspace,
                   SplitOutput& output) {
    return Descent(input, 2 * child_size, nullptr, memory_for(input, workspace))
        .run_split(child_size, output);
}

void finish(const DescentOutput& nearest, double half_width, double scale, float* distances,
            BlockBits& block) {
    for (int row = 0; row < 64; ++row) {
        const Doubles squared_distance = load(nearest.squared_distance + 8 * row);
        const Doubles height = load(nearest.height + 8 * row);
        const unsigned active = bits(squared_distance < 1e300);
        block.active[row] = std::uint8_t(active);
        if (active == 0) {
            block.negative[row] = block.unsure[row] = 0;
            continue;
        }
        // A point over the inside of a face is as far from it as from the plane, to the last bit.
        const unsigned face = bits(height * height == squared_distance);
        block.negative[row] = std::uint8_t(bits(height < 0.0) & face & active);
        block.unsure[row] = std::uint8_t(active & ~face);
        const Doubles distance = min(sqrt(squared_distance), half_width) * scale;
        for (int i = 0; i < lanes; ++i) distances[8 * row + i] = float(lane(distance, i));
    }
}

} // namespace

extern const DescentKernels kernels;
const DescentKernels kernels = {descend, split, finish};
