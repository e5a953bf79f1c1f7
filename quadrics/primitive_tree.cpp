// SPDX-License-Identifier: MPL-2.0
#include "quadrics/primitive_tree.h"

#include "quadrics/in_parallel.h"
#include "quadrics/patch_splats.h"
#include "quadrics/slim_splats.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <span>

namespace isocast {

namespace {

using Box = Eigen::AlignedBox3f;

struct Item {
    Box box; // from the eye; empty if it is cut away
    std::uint32_t number;
    SplatKind kind;
};

struct Node {
    Box box;
    int subtree = 1; // nodes
    // of leaves
    int count = 0;
    const Item* first = nullptr;
};

/// With room for roundings: of the corners, and of the bodies' own numbers.
Box rounded(const Eigen::AlignedBox3d& box) {
    const double spare = 0x1p-21 * box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).norm();
    return {(box.min().array() - spare).cast<float>(), (box.max().array() + spare).cast<float>()};
}

template<class Primitive>
bool is_nothing(const Primitive&) {
    return false;
}
bool is_nothing(const Triangle& triangle) {
    return area_normal(triangle).isZero(0);
}
bool is_nothing(const Patch& patch) {
    return is_without_area(patch);
}
bool is_nothing(const Tetrahedron& tetrahedron) {
    return is_without_volume(tetrahedron);
}

/// The elements of meshes: how many, one of them, and its kind.
std::size_t size_of(const TriangleMesh& mesh) {
    return mesh.triangles.size();
}
std::size_t size_of(const PatchMesh& mesh) {
    return mesh.quads.size();
}
std::size_t size_of(const TetrahedralMesh& mesh) {
    return mesh.tetrahedra.size();
}
std::size_t size_of(const SlimSurface& surface) {
    return surface.levels.front().patches.size();
}
Triangle element_of(const TriangleMesh& mesh, std::size_t i) {
    return triangle_of(mesh, i);
}
Patch element_of(const PatchMesh& mesh, std::size_t i) {
    return patch_of(mesh, i);
}
Tetrahedron element_of(const TetrahedralMesh& mesh, std::size_t i) {
    return tetrahedron_of(mesh, i);
}
SlimPiece element_of(const SlimSurface& surface, std::size_t i) {
    const SlimLevel& finest = surface.levels.front();
    return {finest.patches[i], finest.max_error_world};
}
SplatKind kind_of(const TriangleMesh&) {
    return SplatKind::Triangle;
}
SplatKind kind_of(const PatchMesh&) {
    return SplatKind::Patch;
}
SplatKind kind_of(const TetrahedralMesh&) {
    return SplatKind::Tetrahedron;
}

SplatKind kind_of(const SlimSurface&) {
    return SplatKind::Slim;
}

/// From the eye; empty if nothing of it is to be met.
template<class Primitive>
Box box_of(const Primitive& primitive, const Vec3d& eye_world,
           const std::vector<CutPlane>& planes) {
    if (is_cut_away(primitive, planes)) return {};
    if (is_nothing(primitive)) return {};
    Eigen::AlignedBox3d box;
    for (int axis = 0; axis < 3; ++axis) {
        const Reach reach = reach_along(primitive, Vec3d(Vec3d::Unit(axis)));
        box.min()[axis] = reach.least - eye_world[axis];
        box.max()[axis] = reach.greatest - eye_world[axis];
    }
    return rounded(box);
}

std::vector<Item> items_of(const Primitives& primitives, const Vec3d& eye_world,
                           const std::vector<CutPlane>& planes) {
    std::vector<Item> items(primitives.count()); // of which none are dots
    in_parallel(primitives.solid_count(), [&](std::size_t i) {
        visit_solid(primitives, i, [&](const auto& one) {
            items[i] = {box_of(one, eye_world, planes), static_cast<std::uint32_t>(i),
                        splat_kind_of(one)};
        });
    });
    std::size_t first = primitives.solid_count();
    for_each_mesh(primitives, [&](const auto& mesh) {
        in_parallel(size_of(mesh), [&](std::size_t i) {
            items[first + i] = {box_of(element_of(mesh, i), eye_world, planes),
                                static_cast<std::uint32_t>(first + i), kind_of(mesh)};
        });
        first += size_of(mesh);
    });
    std::erase_if(items, [](const Item& item) { return item.box.isEmpty(); });
    return items;
}

float half_area(const Box& box) {
    const Eigen::Vector3f size = box.sizes();
    return size.x() * size.y() + size.y() * size.z() + size.z() * size.x();
}

/// How many items the first half has, which it moves to the front.
std::size_t split(std::span<Item> items) {
    Box middles;
    for (const Item& item : items) middles.extend(item.box.center());
    int axis = 0;
    const float length = middles.sizes().maxCoeff(&axis);
    constexpr int bin_count = 16;
    const auto bin_of = [&](const Item& item) {
        const float share = (item.box.center()[axis] - middles.min()[axis]) / length;
        return std::clamp(static_cast<int>(bin_count * share), 0, bin_count - 1);
    };
    std::size_t in_front = 0;
    if (length > 0) {
        std::array<Box, bin_count> boxes;
        std::array<int, bin_count> counts{};
        for (const Item& item : items) {
            const auto bin = static_cast<std::size_t>(bin_of(item));
            boxes[bin].extend(item.box);
            ++counts[bin];
        }
        std::array<float, bin_count> costs_behind{}; // of the bins from each on
        Box box;
        for (int bin = bin_count - 1, count = 0; bin > 0; --bin) {
            const auto b = static_cast<std::size_t>(bin);
            box.extend(boxes[b]);
            count += counts[b];
            costs_behind[b] = count > 0 ? half_area(box) * static_cast<float>(count) : 0;
        }
        float least = std::numeric_limits<float>::infinity();
        int best = 1;
        box = {};
        for (int bin = 1, count = 0; bin < bin_count; ++bin) {
            const auto b = static_cast<std::size_t>(bin);
            box.extend(boxes[b - 1]);
            count += counts[b - 1];
            const float cost = half_area(box) * static_cast<float>(count) + costs_behind[b];
            if (count > 0 && cost < least) {
                least = cost;
                best = bin;
            }
        }
        const auto behind =
            std::ranges::partition(items, [&](const Item& item) { return bin_of(item) < best; });
        in_front = items.size() - behind.size();
    }
    // All at one place.
    return in_front > 0 && in_front < items.size() ? in_front : items.size() / 2;
}

void build(std::span<Item> items, std::vector<Node>& nodes) {
    Node node;
    for (const Item& item : items) node.box.extend(item.box);
    std::size_t in_front = 0;
    if (items.size() <= static_cast<std::size_t>(most_in_leaf)) {
        const auto others = std::ranges::partition(
            items, [kind = items.front().kind](const Item& item) { return item.kind == kind; });
        if (others.empty()) {
            node.count = static_cast<int>(items.size());
            node.first = items.data();
            nodes.push_back(node);
            return;
        }
        in_front = items.size() - others.size();
    } else {
        in_front = split(items);
    }
    constexpr std::size_t few = 2048; // take less time than to share them
    std::vector<Node> behind;
    const std::size_t at = nodes.size();
    nodes.push_back(node);
    if (items.size() < few) {
        build(items.first(in_front), nodes);
        build(items.subspan(in_front), nodes);
    } else {
        tbb::parallel_invoke([&] { build(items.first(in_front), nodes); },
                             [&] { build(items.subspan(in_front), behind); });
        nodes.insert(nodes.end(), behind.begin(), behind.end());
    }
    nodes[at].subtree = static_cast<int>(nodes.size() - at);
}

/// Along the world's axes.
void put_body(const Triangle& triangle, const PictureSpace& space, float* to) {
    const Vec3d& eye_world = space.eye_world;
    const auto put = [&](const Vec3d& v, double w) {
        for (const double value : {v.x(), v.y(), v.z(), w}) *to++ = static_cast<float>(value);
    };
    for (const Vec3d& corner : triangle.corners_world) put(corner - eye_world, 0);
    const Vec3d normal = area_normal(triangle).stableNormalized();
    put(normal, normal.dot(triangle.corners_world[0] - eye_world));
}

void put_item(const Primitives& primitives, const Item& item, const Vec3d& eye_world, float* to) {
    const PictureSpace space{.eye_world = eye_world, .view_from_world = Mat3d::Identity()};
    std::size_t number = item.number;
    if (number < primitives.solid_count()) {
        visit_solid(primitives, number, [&](const auto& one) { put_body(one, space, to); });
        return;
    }
    number -= primitives.solid_count();
    for_each_mesh(primitives, [&](const auto& mesh) {
        if (number < size_of(mesh)) put_body(element_of(mesh, number), space, to);
        number -= size_of(mesh); // the meshes after it are not as large as what that wraps to
    });
}

Eigen::Vector4i packed(const Eigen::Vector3f& corner, int more) {
    return {std::bit_cast<int>(corner.x()), std::bit_cast<int>(corner.y()),
            std::bit_cast<int>(corner.z()), more};
}

} // namespace

static_assert(splat_kind_count <= 16, "a leaf's kind has four bits");

PrimitiveTree tree_of(const Primitives& primitives, const Vec3d& eye_world,
                      const std::vector<CutPlane>& planes) {
    std::vector<Item> items = items_of(primitives, eye_world, planes);
    std::vector<Node> nodes;
    if (!items.empty()) build(items, nodes);
    PrimitiveTree tree;
    std::vector<std::size_t> starts; // of bodies, by items
    std::size_t float_count = 0;
    for (const Item& item : items) {
        starts.push_back(float_count);
        float_count += static_cast<std::size_t>(body_floats(item.kind));
        tree.kinds |= 1U << static_cast<unsigned>(item.kind);
    }
    tree.bodies.resize(float_count);
    in_parallel(items.size(), [&](std::size_t i) {
        put_item(primitives, items[i], eye_world, tree.bodies.data() + starts[i]);
    });
    tree.nodes.reserve(2 * nodes.size());
    for (const Node& node : nodes) {
        const bool is_leaf = node.count > 0;
        const int look = is_leaf ? -1 - (static_cast<int>(node.first->kind) + 16 * (node.count - 1))
                                 : node.subtree;
        const std::size_t start =
            is_leaf ? starts[static_cast<std::size_t>(node.first - items.data())] / 4 : 0;
        tree.nodes.push_back(packed(node.box.min(), look));
        tree.nodes.push_back(packed(node.box.max(), static_cast<int>(start)));
    }
    return tree;
}

} // namespace isocast
