// The kernel of block_descent.h, in the namespace of one instruction set.
//
// The cube of 8^3 samples is halved twice, to cubes of 2^3 samples. At a cube's eight children the
// distances d_i and directions u_i = grad d_i of the kept triangles are computed in eight lanes,
// and a child keeps those triangles that can be nearest to a sample within its radius R. Let j be
// the nearest at the child's centre c and s = c + o a sample, |o| <= R:
//   d_i(s) >= d_i + u_i·o              (distance to a convex set is convex, u_i its gradient),
//   d_j(s) <= |d_j u_j + o| <= d_j + u_j·o + |o|^2 / 2 d_j   (to the point of j nearest to c),
// so i can be nearest only if d_i - d_j - R^2 / 2 d_j <= (u_j - u_i)·o <= R |u_j - u_i|, and only
// if d_i <= d_j + 2 R, since distance is 1-Lipschitz. In a cube of 2^3 the lanes are its samples;
// a triangle whose lower bound d_i + u_i·o is above what every lane already has is not evaluated.

namespace {

/// Rounding of the bounds [voxels]: coordinates below 2^28 leave 1e-7.
constexpr double slack = 1e-6;

struct Candidate {
    double distance; // of the cube's centre
    double direction[3];
    int triangle;
};

struct Evaluation {
    Lanes squared_distance;
    Lanes height;
    Lanes planar_r; // offset of the point from its nearest one, along r and s
    Lanes planar_s;
};

/// Distances of eight points to one triangle.
/// source  thesis listing 4.1, with its second frame corrected and scaled to unit length
ISOCAST_INLINE Evaluation evaluate(const TriangleFrame& f, const Lanes& px, const Lanes& py,
                                   const Lanes& pz) {
    const Lanes x = px - f.origin[0];
    const Lanes y = py - f.origin[1];
    const Lanes z = pz - f.origin[2];
    const Lanes r = x * f.r[0] + y * f.r[1] + z * f.r[2];
    const Lanes s = x * f.s[0] + y * f.s[1] + z * f.s[2];
    const Lanes t = x * f.t[0] + y * f.t[1] + z * f.t[2];
    // Reflected to r >= 0, only the right half of the triangle matters.
    const Mask is_left = r < 0.0;
    const Lanes base = select(is_left, f.left.base, f.right.base);
    const Lanes cosine = select(is_left, f.left.cosine, f.right.cosine);
    const Lanes sine = select(is_left, f.left.sine, f.right.sine);
    const Lanes length = select(is_left, f.left.length, f.right.length);
    const Lanes beyond = max(r, Lanes(0.0) - r) - base;
    // Along the side from (base, 0) to the apex, and across it, outwards.
    const Lanes u = s * sine - beyond * cosine;
    const Lanes v = beyond * sine + s * cosine;
    const Lanes along = u - min(max(u, 0.0), length);
    const Lanes across = max(v, 0.0);
    const Mask is_below = s < 0.0;
    const Mask is_over_face = v <= 0.0;
    const Lanes side_r = select(is_over_face, 0.0, across * sine - along * cosine);
    const Lanes side_s = select(is_over_face, 0.0, across * cosine + along * sine);
    const Lanes planar_r = select(is_below, max(beyond, 0.0), side_r);
    const Lanes planar_s = select(is_below, s, side_s);
    return {planar_r * planar_r + planar_s * planar_s + t * t, t,
            select(is_left, Lanes(0.0) - planar_r, planar_r), planar_s};
}

/// Candidates of the eight children of a cube.
struct Children {
    Candidate* list[8];
    int count[8];
    int nearest[8]; // place in the list
};

/// Distances and directions of one candidate at the children's centres.
struct ChildLanes {
    Lanes distance;
    Lanes x, y, z;
};

class Descent {
public:
    Descent(const DescentInput& input, DescentOutput* output, char* memory)
        : frames_(input.frames), half_width_(input.half_width), output_(output) {
        const long n = input.candidate_count;
        at_children_ = reinterpret_cast<ChildLanes*>(memory);
        memory += n * sizeof(ChildLanes);
        for (int k = 0; k < 16; ++k) {
            Children& children = k < 8 ? of_block_ : of_quarter_;
            children.list[k % 8] = reinterpret_cast<Candidate*>(memory);
            memory += n * sizeof(Candidate);
        }
    }

    static unsigned long bytes(long candidate_count) {
        return candidate_count * (sizeof(ChildLanes) + 16 * sizeof(Candidate));
    }

    /// The children of a cube far larger than a block; their lists take the place of the candidates.
    std::int64_t run_split(const DescentInput& input, int child_size, SplitOutput& children) {
        double centre[3];
        for (int k = 0; k < 3; ++k) centre[k] = input.first_sample[k] + (2 * child_size - 1) / 2.0;
        split(centre, child_size, input.candidates, input.candidate_count, of_block_);
        for (int k = 0; k < 8; ++k) {
            children.count[k] = of_block_.count[k];
            children.list[k] = reinterpret_cast<int*>(of_quarter_.list[k]);
            for (int i = 0; i < children.count[k]; ++i)
                children.list[k][i] = of_block_.list[k][i].triangle;
        }
        return evaluations_;
    }

    std::int64_t run(const DescentInput& input) {
        double centre[3];
        for (int k = 0; k < 3; ++k) centre[k] = input.first_sample[k] + 3.5;
        split(centre, 4, input.candidates, input.candidate_count, of_block_);
        for (int k = 0; k < 8; ++k) {
            if (of_block_.count[k] == 0) continue;
            const double quarter[3] = {centre[0] + (k & 1 ? 2 : -2), centre[1] + (k & 2 ? 2 : -2),
                                       centre[2] + (k & 4 ? 2 : -2)};
            split(quarter, 2, of_block_.list[k], of_block_.count[k], of_quarter_);
            const int first = 4 * ((k & 1) + 8 * (k >> 1 & 1) + 64 * (k >> 2));
            for (int j = 0; j < 8; ++j) {
                if (of_quarter_.count[j] == 0) continue;
                const double cube[3] = {quarter[0] + (j & 1 ? 1 : -1),
                                        quarter[1] + (j & 2 ? 1 : -1),
                                        quarter[2] + (j & 4 ? 1 : -1)};
                visit_samples(cube, first + 2 * ((j & 1) + 8 * (j >> 1 & 1) + 64 * (j >> 2)),
                              of_quarter_.list[j], of_quarter_.count[j], of_quarter_.nearest[j]);
            }
        }
        return evaluations_;
    }

private:
    static int triangle_of(int candidate) { return candidate; }
    static int triangle_of(const Candidate& candidate) { return candidate.triangle; }

    /// Offsets ± d on each axis, x fastest.
    static ISOCAST_INLINE void corners(const double* centre, double d, Lanes& x, Lanes& y,
                                       Lanes& z) {
        alignas(64) double at[3][8];
        for (int i = 0; i < 8; ++i)
            for (int k = 0; k < 3; ++k) at[k][i] = centre[k] + (i >> k & 1 ? d : -d);
        x = load(at[0]);
        y = load(at[1]);
        z = load(at[2]);
    }

    /// Children of `size`^3 samples of the cube about `centre`, and who may be nearest there.
    template<class Parent>
    void split(const double* centre, int size, const Parent* parents, int parent_count,
               Children& children) {
        Lanes x, y, z;
        corners(centre, size / 2.0, x, y, z);
        Lanes least = 1e300;
        Lanes least_x = 0.0, least_y = 0.0, least_z = 0.0;
        for (int i = 0; i < parent_count; ++i) {
            const TriangleFrame& f = frames_[triangle_of(parents[i])];
            const Evaluation e = evaluate(f, x, y, z);
            const Lanes distance = sqrt(e.squared_distance);
            const Lanes inverse = select(0.0 < distance, Lanes(1.0) / distance, 0.0);
            const Lanes ur = e.planar_r * inverse;
            const Lanes us = e.planar_s * inverse;
            const Lanes ut = e.height * inverse;
            ChildLanes& at = at_children_[i];
            at.distance = distance;
            at.x = ur * f.r[0] + us * f.s[0] + ut * f.t[0];
            at.y = ur * f.r[1] + us * f.s[1] + ut * f.t[1];
            at.z = ur * f.r[2] + us * f.s[2] + ut * f.t[2];
            const Mask is_nearer = distance < least;
            least = select(is_nearer, distance, least);
            least_x = select(is_nearer, at.x, least_x);
            least_y = select(is_nearer, at.y, least_y);
            least_z = select(is_nearer, at.z, least_z);
        }
        evaluations_ += lanes * parent_count;

        const double radius = (size - 1) / 2.0 * 1.7320508075688774; // sqrt 3
        const Lanes limit =
            min(least + 2 * radius, half_width_ + radius) + slack;
        const Lanes bend = least + Lanes(radius * radius / 2) / max(least, 1e-9) + slack;
        for (int k = 0; k < 8; ++k) children.count[k] = 0;
        double nearest[8];
        for (int i = 0; i < parent_count; ++i) {
            const ChildLanes& at = at_children_[i];
            const Lanes excess = at.distance - bend;
            const Lanes cosine = at.x * least_x + at.y * least_y + at.z * least_z;
            const Lanes squared_turn = Lanes(2.0 + slack) - cosine - cosine;
            const Mask can_turn =
                (excess <= 0.0) | (excess * excess <= squared_turn * (radius * radius));
            for (unsigned kept = bits((at.distance <= limit) & can_turn); kept != 0;
                 kept &= kept - 1) {
                const int k = __builtin_ctz(kept);
                const int place = children.count[k]++;
                const double distance = lane(at.distance, k);
                children.list[k][place] = {distance,
                                           {lane(at.x, k), lane(at.y, k), lane(at.z, k)},
                                           triangle_of(parents[i])};
                if (place == 0 || distance < nearest[k]) {
                    nearest[k] = distance;
                    children.nearest[k] = place;
                }
            }
        }
    }

    void visit_samples(const double* centre, int first, const Candidate* candidates, int count,
                       int nearest) {
        Lanes x, y, z;
        corners(centre, 0.5, x, y, z);
        const double origin[3] = {0, 0, 0};
        Lanes ox, oy, oz;
        corners(origin, 0.5, ox, oy, oz);
        Lanes least = half_width_ * half_width_;
        Lanes height = 0.0;
        Lanes winner = -1.0; // the number of a triangle, exactly
        const auto visit = [&](const Candidate& candidate) __attribute__((always_inline)) {
            evaluations_ += lanes;
            const Evaluation e = evaluate(frames_[candidate.triangle], x, y, z);
            const Mask is_nearer = e.squared_distance <= least;
            least = select(is_nearer, e.squared_distance, least);
            height = select(is_nearer, e.height, height);
            winner = select(is_nearer, double(candidate.triangle), winner);
        };
        visit(candidates[nearest]);
        for (int i = 0; i < count; ++i) {
            if (i == nearest) continue;
            const Candidate& c = candidates[i];
            const Lanes bound = ox * c.direction[0] + oy * c.direction[1] + oz * c.direction[2] +
                                (c.distance - slack);
            if (bits((bound < 0.0) | (bound * bound < least)) == 0) continue;
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

    const TriangleFrame* frames_;
    double half_width_;
    DescentOutput* output_;
    ChildLanes* at_children_;
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
    return Descent(input, &output, memory_for(input, workspace)).run(input);
}

std::int64_t split(const DescentInput& input, int child_size, DescentWorkspace& workspace,
                   SplitOutput& output) {
    return Descent(input, nullptr, memory_for(input, workspace))
        .run_split(input, child_size, output);
}

void finish(const DescentOutput& nearest, double half_width, double scale, float* distances,
            BlockBits& block) {
    for (int row = 0; row < 64; ++row) {
        const Lanes squared_distance = load(nearest.squared_distance + 8 * row);
        const Lanes height = load(nearest.height + 8 * row);
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
        const Lanes distance = min(sqrt(squared_distance), half_width) * scale;
        for (int i = 0; i < lanes; ++i) distances[8 * row + i] = float(lane(distance, i));
    }
}

} // namespace

extern const DescentKernels kernels;
const DescentKernels kernels = {descend, split, finish};
