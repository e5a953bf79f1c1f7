// SPDX-License-Identifier: MPL-2.0
#include "quadrics/quadratic_spline.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <unordered_map>

namespace isocast {

namespace {

/// A value and the gradient by indices.
struct Tangent {
    double value = 0;
    Vec3d gradient = Vec3d::Zero();
};

/// The samples of a field, all in memory.
class Samples {
public:
    explicit Samples(const FieldSource& field) : box_(field.extent()) {
        values_.resize(static_cast<std::size_t>(box_.sample_count()));
        field.copy_box(box_, 0, values_);
    }
    const IndexBox& box() const { return box_; }

    double at(const Index3& p) const {
        const Index3 q = p - box_.lo;
        const Index3 n = box_.size();
        return static_cast<double>(values_[static_cast<std::size_t>(
            q.x() + std::int64_t{n.x()} * (q.y() + std::int64_t{n.y()} * q.z()))]);
    }
    /// By central differences; one-sided at the border.
    double slope(const Index3& p, int axis) const {
        const Index3 below = box_.contains(p - Index3::Unit(axis)) ? p - Index3::Unit(axis) : p;
        const Index3 above = box_.contains(p + Index3::Unit(axis)) ? p + Index3::Unit(axis) : p;
        return (at(above) - at(below)) / (above - below)[axis];
    }
    /// The second difference; 0 at the border.
    double bend(const Index3& p, int axis) const {
        const Index3 below = p - Index3::Unit(axis);
        const Index3 above = p + Index3::Unit(axis);
        if (!box_.contains(below) || !box_.contains(above)) return 0;
        return at(above) - 2 * at(p) + at(below);
    }

    /// At a place by half indices: a sample, or the middle of an edge, a face or a cell.
    Tangent tangent(const Index3& halves) const {
        const Index3 is_odd = halves.unaryExpr([](int h) { return h & 1; });
        const Index3 low = (halves - is_odd) / 2;
        const double share = 1.0 / (1 << is_odd.sum());
        Tangent out;
        for (int k = 0; k < 8; ++k) {
            const Index3 step(k & 1, k >> 1 & 1, k >> 2 & 1);
            if ((step.array() > is_odd.array()).any()) continue;
            const Index3 p = low + step;
            double value = at(p);
            for (int axis = 0; axis < 3; ++axis) {
                if (is_odd[axis] == 0) {
                    out.gradient[axis] += share * slope(p, axis);
                    continue;
                }
                value -= bend(p, axis) / 8; // what a parabola's middle lies below its ends' mean
                out.gradient[axis] += 2 * share * (2 * step[axis] - 1) * at(p);
            }
            out.value += share * value;
        }
        return out;
    }

    /// Of a place by half indices: each has its own.
    std::int64_t key(const Index3& halves) const {
        const Index3 n = (2 * box_.size().array() + 1).matrix();
        const Index3 at = halves - 2 * box_.lo;
        return at.x() + std::int64_t{n.x()} * (at.y() + std::int64_t{n.y()} * at.z());
    }

    bool is_at_border(const Index3& cell) const {
        return (cell.array() == box_.lo.array()).any() ||
               (cell.array() + 2 == box_.hi.array()).any();
    }

    /// Whether the function may be `iso` in a cell. Coefficients lie within 1.5 times the range of
    /// the samples around: three bends of it, and a tangent's way along three axes.
    bool may_cross(const Index3& cell, double iso) const {
        double least = at(cell);
        double greatest = least;
        const Index3 lo = (cell.array() - 1).max(box_.lo.array());
        const Index3 hi = (cell.array() + 3).min(box_.hi.array());
        for (int z = lo.z(); z < hi.z(); ++z)
            for (int y = lo.y(); y < hi.y(); ++y)
                for (int x = lo.x(); x < hi.x(); ++x) {
                    const double value = at({x, y, z});
                    least = std::min(least, value);
                    greatest = std::max(greatest, value);
                }
        const double spare = 1.5 * (greatest - least);
        return iso >= least - spare && iso <= greatest + spare;
    }

private:
    IndexBox box_;
    std::vector<float> values_;
};

/// Collects the tetrahedra of a layer of cells, whose vertices are numbered as they come up.
class Layer {
public:
    struct Piece {
        std::array<int, 4> corners;
        std::array<float, 10> coefficients;
    };

    Layer(const Samples& samples, double iso) : samples_(samples), iso_(iso) {}

    void add_cells(int z) {
        const IndexBox& box = samples_.box();
        for (int y = box.lo.y(); y + 1 < box.hi.y(); ++y)
            for (int x = box.lo.x(); x + 1 < box.hi.x(); ++x) add_cell({x, y, z});
    }
    const std::vector<Index3>& vertices() const { return vertices_; } // by half indices
    const std::vector<Piece>& pieces() const { return pieces_; }

    /// The surface does not reach the cells at the border, and these are outside it.
    bool is_closed() const { return is_closed_; }

private:
    void add_cell(const Index3& cell) {
        const bool is_at_border = samples_.is_at_border(cell);
        if (!samples_.may_cross(cell, iso_)) {
            if (is_at_border && samples_.at(cell) <= iso_) is_closed_ = false;
            return;
        }
        const Index3 middle = (2 * cell.array() + 1).matrix();
        std::array<Tangent, 27> tangents; // of halves from the middle, by 1 + offset
        for (int k = 0; k < 27; ++k) {
            const Index3 offset(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
            const int axes = offset.cwiseAbs().sum(); // 2: of edges, which are no corners
            if (axes != 2)
                tangents[static_cast<std::size_t>(k)] = samples_.tangent(middle + offset);
        }
        for (int axis = 0; axis < 3; ++axis)
            for (const int side : {-1, 1}) {
                const Index3 face = side * Index3::Unit(axis);
                const Index3 a = Index3::Unit((axis + 1) % 3);
                const Index3 b = Index3::Unit((axis + 2) % 3);
                const std::array<Index3, 4> ring{face - a - b, face + a - b, face + a + b,
                                                 face - a + b};
                for (std::size_t i = 0; i < 4; ++i)
                    if (add_tetrahedron(middle, {Index3::Zero(), face, ring[i], ring[(i + 1) % 4]},
                                        tangents) <= 0 &&
                        is_at_border)
                        is_closed_ = false;
            }
    }
    /// returns  the least coefficient: the function is no less
    float add_tetrahedron(const Index3& middle, const std::array<Index3, 4>& offsets,
                          const std::array<Tangent, 27>& tangents) {
        const auto tangent = [&](std::size_t k) -> const Tangent& {
            const Index3 at = (offsets[k].array() + 1).matrix();
            return tangents[static_cast<std::size_t>(at.x() + 3 * at.y() + 9 * at.z())];
        };
        std::array<float, 10> coefficients;
        for (std::size_t k = 0; k < 4; ++k)
            coefficients[k] = static_cast<float>(tangent(k).value - iso_);
        for (std::size_t e = 0; e < 6; ++e) {
            const auto k = static_cast<std::size_t>(tetrahedron_edges[e][0]);
            const auto l = static_cast<std::size_t>(tetrahedron_edges[e][1]);
            const Vec3d half = (offsets[l] - offsets[k]).cast<double>() / 4; // of the way
            const double from_k = tangent(k).value + tangent(k).gradient.dot(half);
            const double from_l = tangent(l).value - tangent(l).gradient.dot(half);
            coefficients[4 + e] = static_cast<float>((from_k + from_l) / 2 - iso_);
        }
        const auto [least, greatest] = std::ranges::minmax(coefficients);
        if (least > 0 || greatest < 0) return least; // its corners need no number
        std::array<int, 4> corners{};
        for (std::size_t k = 0; k < 4; ++k) corners[k] = vertex(middle + offsets[k]);
        pieces_.push_back({corners, coefficients});
        return least;
    }

    int vertex(const Index3& halves) {
        const auto [place, is_new] =
            numbers_.try_emplace(samples_.key(halves), static_cast<int>(vertices_.size()));
        if (is_new) vertices_.push_back(halves);
        return place->second;
    }

    const Samples& samples_;
    double iso_;
    bool is_closed_ = true;
    std::vector<Index3> vertices_;
    std::vector<Piece> pieces_;
    std::unordered_map<std::int64_t, int> numbers_; // of vertices, by their key
};

/// Joins layers from the lowest on: only the vertices between two layers are looked up.
class Spline {
public:
    Spline(const GridSpace& space, const Samples& samples) : space_(space), samples_(samples) {
        mesh_.is_closed = true;
    }

    void add(const Layer& layer, int z) {
        std::vector<int> numbers; // in the mesh, of the layer's vertices
        numbers.reserve(layer.vertices().size());
        std::unordered_map<std::int64_t, int> above;
        for (const Index3& halves : layer.vertices()) {
            const auto known = below_.find(samples_.key(halves));
            const bool is_new = known == below_.end();
            numbers.push_back(is_new ? static_cast<int>(mesh_.vertices_world.size())
                                     : known->second);
            if (is_new) mesh_.vertices_world.push_back(space_.to_world(halves.cast<double>() / 2));
            if (halves.z() == 2 * z + 2) above.emplace(samples_.key(halves), numbers.back());
        }
        below_ = std::move(above);
        for (const Layer::Piece& piece : layer.pieces()) {
            std::array<int, 4> corners{};
            std::ranges::transform(piece.corners, corners.begin(),
                                   [&](int k) { return numbers[static_cast<std::size_t>(k)]; });
            append(mesh_, corners, piece.coefficients);
        }
        mesh_.is_closed = mesh_.is_closed && layer.is_closed();
    }
    TetrahedralMesh take() { return std::move(mesh_); }

private:
    GridSpace space_;
    const Samples& samples_;
    TetrahedralMesh mesh_;
    std::unordered_map<std::int64_t, int> below_; // numbers of the last layer's upper vertices
};

} // namespace

TetrahedralMesh quadratic_spline(const FieldSource& field, double iso_world,
                                 const Progress& progress) {
    const Samples samples(field);
    Spline spline(field.space(), samples);
    const int first = samples.box().lo.z();
    const int count = samples.box().size().z() - 1;
    constexpr int batch = 16; // layers held beside the mesh
    for (int done = 0; done < count; done += batch) {
        if (progress) progress("spline", double(done) / count);
        std::vector<Layer> layers(static_cast<std::size_t>(std::min(batch, count - done)),
                                  Layer(samples, iso_world));
        tbb::parallel_for(std::size_t{0}, layers.size(), [&](std::size_t i) {
            layers[i].add_cells(first + done + static_cast<int>(i));
        });
        for (std::size_t i = 0; i < layers.size(); ++i)
            spline.add(layers[i], first + done + static_cast<int>(i));
    }
    return spline.take();
}

} // namespace isocast
