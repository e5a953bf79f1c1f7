// A field's blocks and bricks on the GPU, and where in a picture to look for them.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/brick_pool.h"
#include "raycaster/scene.h"
#include "raycaster/tile_lists.h"

namespace isocast {

/// A scene's field on the GPU.
class FieldOnGpu {
public:
    FieldOnGpu() = default;
    /// coarse  what coarsen gave, if it did
    /// throws  ResourceError if it does not fit
    FieldOnGpu(const FieldSource& samples, const FieldSource& control, Kernel kernel,
               const BlockRanges& ranges, const std::vector<ActivePage>& active, float iso,
               const StorageOptions& storage, const Progress& progress = {},
               Traversal traversal = Traversal::TileLists, const CoarseBricks* coarse = nullptr);

    /// Local coordinates are index coordinates minus this, a corner of a page near the middle of
    /// the active ones, so that float coordinates stay small.
    const Index3& local_origin_index() const { return local_origin_index_; }
    const BrickPool& pool() const { return pool_; }
    std::int64_t byte_count() const {
        return table_.byte_count() + faces_.byte_count() + pool_.byte_count();
    }
    int block_count() const { return block_count_; }
    /// With Traversal::BoundingFaces the faces around active blocks, else none.
    int face_count() const { return static_cast<int>(faces_.byte_count() / 8); }
    void bind_faces(unsigned unit) const { faces_texture_.bind_to_unit(unit); }

    BrickPool& pool() { return pool_; }

    /// Binds the textures and sets the uniforms of shaders/raycast/blocks.glsl.
    void bind(const gl::Program& program) const;
    /// Those that fetch_block needs alone.
    void bind_blocks(const gl::Program& program) const;

private:
    Index3 local_origin_index_ = Index3::Zero();
    Index3 table_lo_ = Index3::Zero();
    Index3 table_pages_ = Index3::Ones();
    int block_count_ = 0;
    gl::Buffer table_;
    gl::BufferTexture table_texture_;
    gl::Buffer faces_; // two integers each
    gl::BufferTexture faces_texture_;
    BrickPool pool_;
};

/// Numbers that shaders read as an array of texels.
struct NumbersOnGpu {
    NumbersOnGpu() = default;
    NumbersOnGpu(std::span<const std::byte> numbers, gl::Format format, std::string_view label)
        : buffer(numbers, label), texture(buffer, format, label) {}

    gl::Buffer buffer;
    gl::BufferTexture texture;
};

/// Where a frame looks for the field: tiles of the picture, and what its traversal needs.
struct PlacesOnGpu {
    PlacesOnGpu() = default;
    /// Finds them for a camera and a part of its picture, all of it if empty.
    PlacesOnGpu(Traversal traversal, const BlockRanges& ranges,
                const std::vector<ActivePage>& active, const GridSpace& space, const Camera& camera,
                int width, int height, const std::optional<PicturePart>& part = {});

    void set_runs(std::vector<Eigen::Vector4i> of_tiles);

    std::vector<Eigen::Vector4i> tile_runs; // of tiles that can show something, along x
    NumbersOnGpu runs;                      // the same
    int run_count = 0;
    // Traversal::TileLists
    int columns = 0;
    NumbersOnGpu lists;
    NumbersOnGpu blocks;
    // Traversal::DrawnBlocks
    NumbersOnGpu order;
    std::vector<std::int32_t> layers; // where each starts in `order`, and their end
};

} // namespace isocast
