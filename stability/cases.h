// The hard cases by name: what each compares with what, and how far they may differ.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "stability/devices.h"

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace isocast::stability {

/// The greatest error of all that was compared.
struct Worst {
    std::int64_t checked = 0;
    double error = 0;

    void see(double e) {
        ++checked;
        // What is no number is no small error either.
        error = std::max(error, std::isnan(e) ? std::numeric_limits<double>::infinity() : e);
    }
    void see(const Worst& other) {
        checked += other.checked;
        error = std::max(error, other.error);
    }
    /// Of what is right or wrong: a pixel that is missed, bits that differ.
    void must(bool is_right) { see(is_right ? 0 : std::numeric_limits<double>::infinity()); }
};

struct Case {
    std::string name;       // "curvature.umbilic-1e-06"
    std::string compares;   // and in which unit
    double bound;           // of the greatest error
    std::string bound_from; // why that much
    /// throws  Skip
    std::function<Worst(Devices&)> run;
};

/// A case that compares nothing has not passed.
inline bool passes(const Case& a_case, const Worst& found) {
    return found.checked > 0 && found.error <= a_case.bound;
}

/// All of them, in the order of the table; names differ.
std::vector<Case> all_cases();

/// A case that draws stands twice, ".osmesa" and ".egl".
struct DrawnCase {
    std::string name, compares;
    double bound;
    std::string bound_from;
    std::function<Worst(Device&)> run;
};
void append(std::vector<Case>& cases, const DrawnCase& drawn);

// By subject; each appends its own.
void append_filtering_cases(std::vector<Case>& cases);
void append_certificate_cases(std::vector<Case>& cases);
void append_curvature_cases(std::vector<Case>& cases);
void append_triangle_cases(std::vector<Case>& cases);
void append_mesh_cases(std::vector<Case>& cases);
void append_octree_cases(std::vector<Case>& cases);
void append_point_cases(std::vector<Case>& cases);
void append_quadric_cases(std::vector<Case>& cases);
void append_search_cases(std::vector<Case>& cases);
void append_view_cases(std::vector<Case>& cases);
void append_unit_cases(std::vector<Case>& cases);
void append_solid_cases(std::vector<Case>& cases);
void append_splat_cases(std::vector<Case>& cases);

} // namespace isocast::stability
