// The control samples of the active blocks on the GPU, in bricks of equal size, and what certifies
// steps through each block (thesis section 6.2.2).
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "filtering/filter.h"
#include "gl/program.h"
#include "raycaster/block_table.h"
#include "volume/progress.h"

namespace isocast {

/// How shaders read the samples; shaders/filtering/tricubic.glsl.
enum class Fetch {
    Rows,    // a texel holds the four samples of its cell along x
    Samples, // a texel holds one sample: a quarter of the memory
};

/// How samples are stored.
enum class SampleFormat {
    Float32,
    Float16, // error 2^-11 of the value: no error to speak of at the surface, most at the far ones
    Norm16,  // in 2^16 even steps over a power of two that holds all: the same error everywhere
};

struct StorageOptions {
    Fetch fetch = Fetch::Rows;
    SampleFormat format = SampleFormat::Float32;
    int brick_size = 8; // cells along an edge: 8, 16 or 32
};

/// The active blocks of a field at one iso value, uploaded.
class BrickPool {
public:
    BrickPool() = default;
    /// control  the control samples of `kernel`
    /// throws   ResourceError if they do not fit
    BrickPool(const FieldSource& control, Kernel kernel, const BlockRanges& ranges,
              const std::vector<ActivePage>& active, const BlockTable& table, float iso,
              const StorageOptions& options, const Progress& progress = {});

    int brick_count() const { return brick_count_; }
    std::int64_t byte_count() const { return samples_.byte_count() + records_.byte_count(); }
    /// Greatest |value - iso| of a stored sample [world].
    float greatest_value() const { return greatest_value_; }
    /// Greatest error of a stored sample [world].
    float storage_error() const { return storage_error_; }

    /// World units of what shaders read; they reckon in stored units.
    float world_from_stored() const { return world_from_stored_; }

    /// Binds the textures of shaders/filtering/tricubic.glsl and raycast/blocks.glsl.
    void bind() const;
    /// The defines of shaders that read the pool.
    std::map<std::string, std::string> defines() const;

private:
    StorageOptions options_;
    Kernel kernel_ = Kernel::BSpline;
    gl::Buffer samples_;
    gl::BufferTexture samples_texture_;
    gl::Buffer records_;
    gl::BufferTexture records_texture_;
    int brick_count_ = 0;
    float greatest_value_ = 0;
    float storage_error_ = 0;
    float world_from_stored_ = 1;
};

} // namespace isocast
