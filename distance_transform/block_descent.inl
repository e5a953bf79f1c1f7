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
};

struct Candidate {
    float distance; // of the cube's centre
    float direction[3];
    int triangle; // place among the input's candidates
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

/// Candidates of the eight children of a cube.
struct Children {
    Candidate* list[8];
    int count[8];
    int nearest[8]; // place in the list
};

/// Distances and directions of one candidate at the children's centres.
struct ChildLanes {
    Floats distance;
    Floats x, y, z;
    Floats turn_error; // of the direction, times the child's radius
};

class Descent {
public:
    Descent(const DescentInput& input, int size, DescentOutput* output, char* memory)
        : input_(input), output_(output) {
        const long n = input.candidate_count;
        at_children_ = reinterpret_cast<ChildLanes*>(memory);
        memory += n * sizeof(ChildLanes);
        local_ = reinterpret_cast<LocalFrame*>(memory);
        memory += n * sizeof(LocalFrame);
        for (int k = 0; k < 16; ++k) {
            Children& children = k < 8 ? of_block_ : of_quarter_;
            children.list[k % 8] = reinterpret_cast<Candidate*>(memory);
            memory += n * sizeof(Candidate);
        }
        for (int k = 0; k < 3; ++k) centre_[k] = input.first_sample[k] + (size - 1) / 2.0;
        localise(size);
    }

    static unsigned long bytes(long candidate_count) {
        return candidate_count *
               (sizeof(ChildLanes) + sizeof(LocalFrame) + 16 * sizeof(Candidate));
    }

    /// The children of a cube far larger than a block; the lists take the place of candidates.
    std::int64_t run_split(int child_size, SplitOutput& children) {
        const float middle[3] = {0, 0, 0};
        split(middle, child_size, [](int i) { return i; }, input_.candidate_count, of_block_);
        for (int k = 0; k < 8; ++k) {
            children.count[k] = of_block_.count[k];
            children.list[k] = reinterpret_cast<int*>(of_quarter_.list[k]);
            for (int i = 0; i < children.count[k]; ++i)
                children.list[k][i] = input_.candidates[of_block_.list[k][i].triangle];
        }
        return evaluations_;
    }

    std::int64_t run() {
        const float middle[3] = {0, 0, 0};
        split(middle, 4, [](int i) { return i; }, input_.candidate_count, of_block_);
        for (int k = 0; k < 8; ++k) {
            if (of_block_.count[k] == 0) continue;
            const float quarter[3] = {k & 1 ? 2.f : -2.f, k & 2 ? 2.f : -2.f, k & 4 ? 2.f : -2.f};
            const Candidate* parents = of_block_.list[k];
            split(quarter, 2, [=](int i) { return parents[i].triangle; }, of_block_.count[k],
                  of_quarter_);
            const int first = 4 * ((k & 1) + 8 * (k >> 1 & 1) + 64 * (k >> 2));
            for (int j = 0; j < 8; ++j) {
                if (of_quarter_.count[j] == 0) continue;
                const double cube[3] = {centre_[0] + quarter[0] + (j & 1 ? 1 : -1),
                                        centre_[1] + quarter[1] + (j & 2 ? 1 : -1),
                                        centre_[2] + quarter[2] + (j & 4 ? 1 : -1)};
                visit_samples(cube, first + 2 * ((j & 1) + 8 * (j >> 1 & 1) + 64 * (j >> 2)),
                              of_quarter_.list[j], of_quarter_.count[j], of_quarter_.nearest[j]);
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
        for (int i = 0; i < input_.candidate_count; ++i) {
            const TriangleFrame& f = frame(i);
            LocalFrame& local = local_[i];
            double reach = f.right.length + f.left.length;
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
            greatest = reach > greatest ? reach : greatest;
        }
        // About 20 roundings of numbers no greater than that meet in a distance.
        error_ = float(20 * 6e-8 * greatest);
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

    /// Children of `size`^3 samples of the cube about `centre`, and who may be nearest there.
    template<class Parent>
    void split(const float* centre, int size, Parent parent, int parent_count,
               Children& children) {
        Floats x, y, z;
        corners(centre, size / 2.0f, x, y, z);
        const float radius = (size - 1) / 2.0f * 1.7320508f; // sqrt 3
        // Nearer than this the direction is lost in rounding, and the distance counts as 0.
        const float nearest_told = 100 * error_;
        Floats least = 1e30f;
        Floats least_x = 0.f, least_y = 0.f, least_z = 0.f, least_error = 0.f;
        for (int i = 0; i < parent_count; ++i) {
            const LocalFrame& f = local_[parent(i)];
            const Evaluation e = evaluate(f, x, y, z);
            const Floats root = sqrt(e.squared_distance);
            const auto is_told = Floats(nearest_told) < root;
            const Floats distance = select(is_told, root, 0.f);
            const Floats inverse = select(is_told, Floats(1.f) / root, 0.f);
            const Floats ur = e.planar_r * inverse;
            const Floats us = e.planar_s * inverse;
            const Floats ut = e.height * inverse;
            ChildLanes& at = at_children_[i];
            at.distance = distance;
            at.x = ur * f.r[0] + us * f.s[0] + ut * f.t[0];
            at.y = ur * f.r[1] + us * f.s[1] + ut * f.t[1];
            at.z = ur * f.r[2] + us * f.s[2] + ut * f.t[2];
            at.turn_error = inverse * (error_ * radius);
            const auto is_nearer = distance < least;
            least = select(is_nearer, distance, least);
            least_x = select(is_nearer, at.x, least_x);
            least_y = select(is_nearer, at.y, least_y);
            least_z = select(is_nearer, at.z, least_z);
            least_error = select(is_nearer, at.turn_error, least_error);
        }
        evaluations_ += lanes * parent_count;

        const float slack = nearest_told + 2 * error_;
        const Floats limit =
            min(least + 2 * radius, float(input_.half_width) + radius) + slack;
        const Floats bend =
            least + Floats(radius * radius / 2) / max(least, 1e-6f) + (least_error + slack);
        for (int k = 0; k < 8; ++k) children.count[k] = 0;
        float nearest[8];
        for (int i = 0; i < parent_count; ++i) {
            const ChildLanes& at = at_children_[i];
            const Floats excess = at.distance - bend - at.turn_error;
            const Floats cosine = at.x * least_x + at.y * least_y + at.z * least_z;
            // 1e-5: rounding of unit vectors' product, beside what turn_error holds.
            const Floats squared_turn = Floats(2.f + 1e-5f) - cosine - cosine;
            const auto can_turn =
                (excess <= 0.f) | (excess * excess <= squared_turn * (radius * radius));
            for (unsigned kept = bits((at.distance <= limit) & can_turn); kept != 0;
                 kept &= kept - 1) {
                const int k = __builtin_ctz(kept);
                const int place = children.count[k]++;
                const float distance = lane(at.distance, k);
                children.list[k][place] = {
                    distance, {lane(at.x, k), lane(at.y, k), lane(at.z, k)}, parent(i)};
                if (place == 0 || distance < nearest[k]) {
                    nearest[k] = distance;
                    children.nearest[k] = place;
                }
            }
        }
    }

    void visit_samples(const double* centre, int first, const Candidate* candidates, int count,
                       int nearest) {
        Doubles x, y, z;
        corners(centre, 0.5, x, y, z);
        const float origin[3] = {0, 0, 0};
        Floats ox, oy, oz;
        corners(origin, 0.5f, ox, oy, oz);
        Doubles least = input_.half_width * input_.half_width;
        Doubles height = 0.0;
        Doubles winner = -1.0; // the number of a candidate, exactly
        Floats least_rounded;  // up, by far more than the rounding of the bounds' square
        const auto visit = [&](const Candidate& candidate) __attribute__((always_inline)) {
            evaluations_ += lanes;
            const Evaluation e = evaluate(frame(candidate.triangle), x, y, z);
            const auto is_nearer = e.squared_distance <= least;
            least = select(is_nearer, e.squared_distance, least);
            height = select(is_nearer, e.height, height);
            winner = select(is_nearer, double(candidate.triangle), winner);
            for (int i = 0; i < lanes; ++i)
                least_rounded.part[i / Floats::native_lanes][i % Floats::native_lanes] =
                    float(least.part[i / Doubles::native_lanes][i % Doubles::native_lanes]);
            least_rounded = least_rounded * 1.000001f;
        };
        visit(candidates[nearest]);
        const float slack = 102 * error_; // as in split
        for (int i = 0; i < count; ++i) {
            if (i == nearest) continue;
            const Candidate& c = candidates[i];
            const float turn_error = c.distance > 0 ? error_ / c.distance : 0;
            const Floats bound = ox * c.direction[0] + oy * c.direction[1] + oz * c.direction[2] +
                                 (c.distance - slack - turn_error);
            if (bits((bound < 0.f) | (bound * bound < least_rounded)) == 0) continue;
            visit(c);
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
    ChildLanes* at_children_;
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
