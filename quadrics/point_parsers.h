// One parser per point format, from bytes in memory; read_points() chooses by the extension.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/point_data.h"

#include <span>

namespace isocast {

/// Each parser takes the bytes of a whole file and the name that messages give it.
/// throws  InputError that names the line, element or byte and the cause
PointData parse_ply_points(std::string_view bytes, const std::string& name);
PointData parse_csv_points(std::string_view bytes, const std::string& name);

/// What the numbers of a column must be.
struct ColumnRange {
    bool is_checked = false; // primitives_of() knows the column
    double lo = 0;
    double hi = 0;
};
/// throws  InputError if names are missing or double, or only some of a group are there
std::vector<ColumnRange> ranges_of(std::span<const std::string> names, const std::string& file);
/// Why `value` cannot stand in a column; empty if it can.
std::string problem_of(const ColumnRange& range, double value);

} // namespace isocast
