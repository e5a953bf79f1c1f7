// SPDX-License-Identifier: MPL-2.0
#include "raycaster/field_on_gpu.h"

namespace isocast {

FieldOnGpu::FieldOnGpu(const FieldSource& samples, const FieldSource& control, Kernel kernel,
                       const BlockRanges& ranges, const std::vector<ActivePage>& active, float iso,
                       const StorageOptions& storage, const Progress& progress, Traversal traversal,
                       const CoarseBricks* coarse) {
    const BlockTable table = make_block_table(samples, ranges, active, iso);
    local_origin_index_ = page_size * (table.first_page + table.pages / 2);
    table_lo_ = table.lo_index() - local_origin_index_;
    table_pages_ = table.pages;
    block_count_ = table.block_count;
    table_ = gl::Buffer(std::as_bytes(std::span(table.words)), "block table");
    table_texture_ = gl::BufferTexture(table_, gl::Format::R32ui, "block table");
    if (traversal == Traversal::BoundingFaces) {
        const std::vector<Eigen::Vector2i> faces = bounding_faces(table);
        faces_ = gl::Buffer(std::as_bytes(std::span(faces)), "bounding faces");
        faces_texture_ = gl::BufferTexture(faces_, gl::Format::Rg32i, "bounding faces");
    }
    pool_ = coarse != nullptr
                ? BrickPool(*coarse, ranges, active, table, iso, storage)
                : BrickPool(control, kernel, ranges, active, table, iso, storage, progress);
}

void FieldOnGpu::bind(const gl::Program& program) const {
    table_texture_.bind_to_unit(0);
    program.set("u_table_pages", Eigen::Vector3i(table_pages_));
    bind_blocks(program);
}

void FieldOnGpu::bind_blocks(const gl::Program& program) const {
    program.set("u_table_lo", Eigen::Vector3f(table_lo_.cast<float>()));
    pool_.bind();
}

void PlacesOnGpu::set_runs(std::vector<Eigen::Vector4i> of_tiles) {
    tile_runs = std::move(of_tiles);
    run_count = static_cast<int>(tile_runs.size());
    runs = {std::as_bytes(std::span(tile_runs)), gl::Format::Rgba32i, "tile runs"};
}

PlacesOnGpu::PlacesOnGpu(Traversal traversal, const BlockRanges& ranges,
                         const std::vector<ActivePage>& active, const GridSpace& space,
                         const Camera& camera, int width, int height,
                         const std::optional<PicturePart>& asked_part) {
    const PicturePart part = asked_part.value_or(PicturePart{.width = width, .height = height});
    if (traversal == Traversal::TileLists) {
        const TileLists tiles = list_blocks(ranges, active, space, camera, width, height, part);
        columns = tiles.width;
        lists = {std::as_bytes(std::span(tiles.lists)), gl::Format::Rg32i, "tiles"};
        blocks = {std::as_bytes(std::span(tiles.blocks)), gl::Format::R32i, "blocks of tiles"};
        set_runs(tiles.runs());
    } else {
        set_runs(whole_picture(part.width, part.height));
    }
    if (traversal == Traversal::DrawnBlocks) {
        BlockOrder nearest_first = order_blocks(ranges, active, space, camera);
        order = {std::as_bytes(std::span(nearest_first.blocks)), gl::Format::R32i, "block order"};
        layers = std::move(nearest_first.layers);
    }
}

} // namespace isocast
