// Points as `convert --method points` reads and reports them.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/convert_report.h"
#include "apps/inputs.h"
#include "distance_transform/convert_points.h"

#include <CLI/CLI.hpp>

namespace isocast {

/// --neighbours, --point-method and --approximation.
void add_point_options(CLI::App& app, MeshlessOptions& options);

/// The points of a file (.xyz is XYZ text here, not a molecule) or the vertices of a built-in mesh.
/// throws  InputError that names the input and the cause
CheckedPoints read_checked_points(const Input& input, int neighbours);

ConvertReport::Points report_of(const CheckedPoints& points, const MeshlessOptions& options);

} // namespace isocast
