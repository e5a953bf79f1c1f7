// SPDX-License-Identifier: MPL-2.0
#include "stability/cases.h"

namespace isocast::stability {

void append(std::vector<Case>& cases, const DrawnCase& drawn) {
    for (const auto& [word, backend] :
         {std::pair{"osmesa", gl::Backend::Osmesa}, std::pair{"egl", gl::Backend::Egl}})
        cases.push_back(
            {drawn.name + "." + word, drawn.compares, drawn.bound, drawn.bound_from,
             [run = drawn.run, backend](Devices& devices) { return run(devices.at(backend)); }});
}

std::vector<Case> all_cases() {
    std::vector<Case> cases;
    append_filtering_cases(cases);
    append_certificate_cases(cases);
    append_curvature_cases(cases);
    append_triangle_cases(cases);
    append_mesh_cases(cases);
    append_octree_cases(cases);
    append_point_cases(cases);
    append_quadric_cases(cases);
    append_search_cases(cases);
    append_view_cases(cases);
    append_unit_cases(cases);
    append_solid_cases(cases);
    append_splat_cases(cases);
    return cases;
}

} // namespace isocast::stability
