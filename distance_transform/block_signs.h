// Signs of a block's samples, as sets of bits.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/winding_number.h"
#include "volume/sparse_field.h"

#include <bit>

namespace isocast {

/// A set of a block's samples: bit x + 8 y of word z.
struct SampleBits {
    std::array<std::uint64_t, block_size> words{};

    bool operator[](int i) const { return words[i / 64] >> i % 64 & 1; }
    void set(int i) { words[i / 64] |= std::uint64_t{1} << i % 64; }
};

/// rows  bit x of row y + 8 z
SampleBits bits_of_rows(const std::uint8_t (&rows)[64]);
void set_rows(const SampleBits& bits, std::uint8_t (&rows)[64]);
SampleBits active_bits(const FieldBlock& block);
SampleBits negative_bits(const FieldBlock& block);

template<class Visit>
void for_each_bit(const SampleBits& bits, const Visit& visit) {
    for (int z = 0; z < block_size; ++z)
        for (std::uint64_t word = bits.words[z]; word != 0; word &= word - 1)
            visit(64 * z + std::countr_zero(word));
}

inline Index3 sample_of(int i) {
    return {i % block_size, i / block_size % block_size, i / (block_size * block_size)};
}

/// Gives every sample that is not `known` the sign of a known one next to it, and so on. Right
/// since distance is 1-Lipschitz and the half width at least one voxel: neighbours with different
/// signs are both within one voxel of the surface.
void spread(const SampleBits& known, SampleBits& negative);

/// The active samples that the winding number calls inside.
///
/// distances  >= 0 [world] where active
/// winding    in voxels
/// origin     of the block's first sample [voxels]
///
/// Of a mesh without boundary the number changes only at the surface. Two neighbours with
/// distances of more than one voxel together are then on the same side of it, and one number
/// serves all samples that hang together so.
SampleBits winding_signs(std::span<const float> distances, const SampleBits& active,
                         double voxel_size_world, const WindingNumber& winding,
                         const Vec3d& origin);

/// Makes active samples negative as told, and the others ± background.
void apply_signs(FieldBlock& block, const SampleBits& active, const SampleBits& negative,
                 float background_world);

} // namespace isocast
