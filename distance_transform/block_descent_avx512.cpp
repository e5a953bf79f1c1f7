// The kernel of block_descent.h for the instruction set avx512.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/block_descent.h"
#if defined(__AVX__)
#include <immintrin.h>
#endif

namespace isocast::avx512 {
#include "distance_transform/lanes.inl"

#include "distance_transform/block_descent.inl"
} // namespace isocast::avx512
