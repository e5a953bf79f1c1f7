// SPDX-License-Identifier: MPL-2.0
#include "raycaster/csg.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <functional>
#include <string>

namespace isocast {

CsgTree union_of_all(int object_count) {
    CsgTree tree;
    for (int object = 0; object < object_count; ++object) {
        tree.push_back({CsgOperation::Object, object});
        if (object > 0) tree.push_back({CsgOperation::Union});
    }
    return tree;
}

void check_tree(const CsgTree& tree, int object_count) {
    std::vector<std::string> problems;
    std::array<bool, max_object_count> is_named{};
    int operands = 0;
    for (std::size_t i = 0; i < tree.size(); ++i) {
        const CsgStep& step = tree[i];
        if (step.operation == CsgOperation::Object) {
            ++operands;
            if (step.object < 0 || step.object >= object_count)
                problems.push_back(fmt::format("step {} names object {}, and there are {}", i,
                                               step.object, object_count));
            else
                is_named[static_cast<std::size_t>(step.object)] = true;
        } else if (--operands < 1) {
            problems.push_back(fmt::format("step {} has less than two operands", i));
            operands = 1;
        }
    }
    if (operands != 1) problems.push_back(fmt::format("{} operands are left, not one", operands));
    for (int object = 0; object < object_count; ++object)
        if (!is_named[static_cast<std::size_t>(object)])
            problems.push_back(fmt::format("object {} is not named", object));
    if (!problems.empty()) throw InputError(fmt::format("CSG tree: {}", fmt::join(problems, "; ")));
}

InsideTable inside_table(const CsgTree& tree, int object_count) {
    InsideTable table;
    for (unsigned set = 0; set < 1U << object_count; ++set) {
        std::vector<std::uint8_t> objects;
        for (int object = 0; object < object_count; ++object) objects.push_back(set >> object & 1);
        const std::uint32_t inside =
            evaluate(tree, std::span<const std::uint8_t>(objects), std::bit_or<std::uint8_t>(),
                     std::bit_and<std::uint8_t>(),
                     [](std::uint8_t a, std::uint8_t b) -> std::uint8_t { return a & ~b; });
        table.words[set / 32] |= inside << set % 32;
    }
    return table;
}

} // namespace isocast
