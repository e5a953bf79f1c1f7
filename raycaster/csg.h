// Solids composed of objects by union, intersection and difference (thesis section 6.4.3).
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/errors.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace isocast {

/// As many objects as a scene can have: the shaders' arrays, and 2^8 cases in a table.
inline constexpr int max_object_count = 8;

enum class CsgOperation { Object, Union, Intersection, Difference };

/// One step of a tree in post-order.
struct CsgStep {
    CsgOperation operation = CsgOperation::Object;
    int object = 0; // CsgOperation::Object: its place in Scene::objects
};

/// A tree, operands before their operation; none can have a cycle. (A or B) - C is
/// {{Object, 0}, {Object, 1}, {Union}, {Object, 2}, {Difference}}. Objects may be named repeatedly.
using CsgTree = std::vector<CsgStep>;

/// All objects as one.
CsgTree union_of_all(int object_count);

/// throws  InputError with all that is wrong: an operation without two operands, steps that are
///         left over, an object that there is not or that is not named
void check_tree(const CsgTree& tree, int object_count);

/// The value of a checked tree for values of its objects, which `unite(a, b)`, `intersect(a, b)`
/// and `subtract(a, b)` combine.
template<class Value, class Unite, class Intersect, class Subtract>
Value evaluate(const CsgTree& tree, std::span<const Value> objects, Unite unite,
               Intersect intersect, Subtract subtract) {
    std::vector<Value> stack;
    for (const CsgStep& step : tree) {
        if (step.operation == CsgOperation::Object) {
            stack.push_back(objects[static_cast<std::size_t>(step.object)]);
            continue;
        }
        const Value b = stack.back();
        stack.pop_back();
        Value& a = stack.back();
        a = step.operation == CsgOperation::Union          ? unite(a, b)
            : step.operation == CsgOperation::Intersection ? intersect(a, b)
                                                           : subtract(a, b);
    }
    return stack.back();
}

/// The composed function of the objects' values, negative inside.
/// source  FORMULAS.md, Ray casting: min(a, b), max(a, b), max(a, -b); thesis section 6.4.3 prints
///         those of fields that are positive inside
inline double composed_value(const CsgTree& tree, std::span<const double> values) {
    return evaluate(
        tree, values, [](double a, double b) { return std::min(a, b); },
        [](double a, double b) { return std::max(a, b); },
        [](double a, double b) { return std::max(a, -b); });
}

/// Whether a point is inside, for each set of objects that it may be inside.
///
/// twin  shaders/raycast/compose.frag: is_inside()
struct InsideTable {
    /// Bit `set` of the words, 32 in each: `set` has the bit i if the point is inside object i.
    std::array<std::uint32_t, (1 << max_object_count) / 32> words{};

    bool is_inside(unsigned set) const { return (words[set / 32] >> set % 32 & 1) != 0; }
};
/// tree  checked
InsideTable inside_table(const CsgTree& tree, int object_count);

} // namespace isocast
