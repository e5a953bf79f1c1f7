// The kernels of scan_kernel.h for the instruction set baseline.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/scan_kernel.h"
#if defined(__AVX__)
#include <immintrin.h>
#endif

namespace isocast::baseline {
#include "distance_transform/lanes.inl"

#include "distance_transform/vector_lanes.inl"

#include "distance_transform/site_lanes.inl"

#include "distance_transform/seen_sites.inl"

#include "distance_transform/fan_lanes.inl"

#include "distance_transform/scan_kernel.inl"
} // namespace isocast::baseline
