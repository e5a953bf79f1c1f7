// Signs of a block's samples, as sets of bits.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/block_signs.h"

#include <cmath>
#include <cstring>

namespace isocast {

namespace {

constexpr std::uint64_t first_column = 0x0101010101010101;

/// Bits of a slice that a shift by `s` along x has not brought from another row.
constexpr std::uint64_t columns_from(int s) {
    return first_column * (0xffu << s & 0xffu);
}

struct Slice {
    std::uint64_t known;
    std::uint64_t negative;

    void take(std::uint64_t other_known, std::uint64_t other_negative) {
        const std::uint64_t added = other_known & ~known;
        known |= added;
        negative = (negative & ~added) | (other_negative & added);
    }
};

/// Within a slice, along x and then y, by doubling.
void spread_within(Slice& slice) {
    for (const int s : {1, 2, 4}) {
        slice.take(slice.known << s & columns_from(s), slice.negative << s);
        slice.take(slice.known >> s & (columns_from(s) >> s), slice.negative >> s);
    }
    for (const int s : {8, 16, 32}) {
        slice.take(slice.known << s, slice.negative << s);
        slice.take(slice.known >> s, slice.negative >> s);
    }
}

} // namespace

SampleBits bits_of_rows(const std::uint8_t (&rows)[64]) {
    SampleBits bits;
    static_assert(std::endian::native == std::endian::little && sizeof bits.words == sizeof rows);
    std::memcpy(bits.words.data(), rows, sizeof rows);
    return bits;
}

void set_rows(const SampleBits& bits, std::uint8_t (&rows)[64]) {
    static_assert(std::endian::native == std::endian::little && sizeof bits.words == sizeof rows);
    std::memcpy(rows, bits.words.data(), sizeof rows);
}

SampleBits active_bits(const FieldBlock& block) {
    SampleBits bits;
    for (int i = 0; i < samples_per_block; ++i)
        bits.words[i / 64] |= std::uint64_t{block.active[i]} << i % 64;
    return bits;
}

SampleBits negative_bits(const FieldBlock& block) {
    SampleBits bits;
    for (int i = 0; i < samples_per_block; ++i)
        bits.words[i / 64] |= std::uint64_t{block.values[i] < 0} << i % 64;
    return bits;
}

void spread(const SampleBits& known, SampleBits& negative) {
    std::array<Slice, block_size> slices;
    for (int z = 0; z < block_size; ++z) {
        slices[z] = {known.words[z], negative.words[z] & known.words[z]};
        if (slices[z].known != 0 && ~slices[z].known != 0) spread_within(slices[z]);
    }
    for (int z = 1; z < block_size; ++z)
        slices[z].take(slices[z - 1].known, slices[z - 1].negative);
    for (int z = block_size - 2; z >= 0; --z)
        slices[z].take(slices[z + 1].known, slices[z + 1].negative);
    for (int z = 0; z < block_size; ++z) negative.words[z] = slices[z].negative;
}

SampleBits winding_signs(std::span<const float> distances, const SampleBits& active,
                         double voxel_size_world, const WindingNumber& winding,
                         const Vec3d& origin) {
    const auto is_inside = [&](int i) {
        return winding.is_inside(origin + sample_of(i).cast<double>());
    };
    SampleBits negative;
    if (!winding.changes_only_at_the_surface()) {
        for_each_bit(active, [&](int i) {
            if (is_inside(i)) negative.set(i);
        });
        return negative;
    }
    const double least_sum = voxel_size_world * (1 + 1e-5); // 1e-5: rounding to float
    SampleBits seen;
    std::array<std::int16_t, samples_per_block> reached;
    for_each_bit(active, [&](int seed) {
        if (seen[seed]) return;
        const bool inside = is_inside(seed);
        int count = 0;
        const auto reach = [&](int i) {
            seen.set(i);
            if (inside) negative.set(i);
            reached[count++] = static_cast<std::int16_t>(i);
        };
        reach(seed);
        for (int next = 0; next < count; ++next) {
            const int i = reached[next];
            for (const int stride : {1, block_size, block_size * block_size}) {
                const int place = i / stride % block_size;
                for (const int step : {-1, 1}) {
                    if (place + step < 0 || place + step == block_size) continue;
                    const int neighbour = i + step * stride;
                    if (active[neighbour] && !seen[neighbour] &&
                        double{distances[i]} + distances[neighbour] > least_sum)
                        reach(neighbour);
                }
            }
        }
    });
    return negative;
}

void apply_signs(FieldBlock& block, const SampleBits& active, const SampleBits& negative,
                 float background_world) {
    static_assert(sizeof block.active == sizeof active.words);
    std::memcpy(static_cast<void*>(&block.active), active.words.data(), sizeof active.words);
    for (int i = 0; i < samples_per_block; ++i) {
        const float distance = active[i] ? std::abs(block.values[i]) : background_world;
        block.values[i] = negative[i] ? -distance : distance;
    }
}

} // namespace isocast
