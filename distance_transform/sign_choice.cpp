// How inside is told from outside for a mesh, and why so.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/sign_choice.h"

#include <fmt/format.h>

namespace isocast {

SignChoice chosen_sign(const MeshVerdict& verdict, SignMethod wanted) {
    const bool has_inside = verdict.is_closed() && verdict.is_oriented();
    if (wanted != SignMethod::Auto) {
        SignChoice choice{wanted, "as asked"};
        if (wanted == SignMethod::Normal && !has_inside)
            choice.warnings.push_back(
                fmt::format("Signs come from normals as asked, and can be wrong since the mesh is "
                            "not closed and oriented ({}).",
                            verdict.summary()));
        return choice;
    }
    if (!verdict.is_orientable)
        return {SignMethod::Unsigned,
                "the surface is not orientable",
                {"Distances carry no sign, since the surface has one side only: the result is no "
                 "level set."}};
    if (!has_inside)
        return {SignMethod::Winding,
                "the mesh is not closed",
                {fmt::format("Signs come from the winding number, since the mesh is not closed and "
                             "oriented ({}).",
                             verdict.summary())}};
    if (verdict.shells > 1)
        return {SignMethod::Winding, fmt::format("the mesh has {} shells", verdict.shells)};
    return {SignMethod::Normal, "the mesh is closed and oriented"};
}

SignChoice sign_by_band(const CheckedMesh& input, SignMethod wanted, double voxel_size_world,
                        double memory_bytes, const Progress& progress) {
    const SignChoice choice = chosen_sign(input.verdict, wanted);
    if (wanted != SignMethod::Auto || choice.method != SignMethod::Normal) return choice;
    ConvertResult band = convert(
        input, {.voxel_size_world = voxel_size_world, .memory_bytes = memory_bytes}, progress);
    return {band.sign_used, std::move(band.sign_reason), std::move(band.warnings)};
}

} // namespace isocast
