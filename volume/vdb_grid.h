// Fields as OpenVDB grids. For sources that know OpenVDB: no header of ours includes this one.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/sparse_field.h"

#include <openvdb/openvdb.h>

namespace isocast {

/// The grid that write_vdb stores.
openvdb::FloatGrid::Ptr to_vdb_grid(const SparseField& field);

} // namespace isocast
