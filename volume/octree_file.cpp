// Octree files; docs/octree.md describes the format.
// SPDX-License-Identifier: MPL-2.0
#include "volume/octree_file.h"

#include "volume/checksum.h"
#include "volume/dense_file.h"
#include "volume/errors.h"
#include "volume/mapped_file.h"
#include "volume/volume_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <new>

namespace isocast {

namespace {

constexpr std::string_view magic = "isoHOCT\n"; // a transfer as text would change its end
constexpr std::uint32_t version = 1;

/// The file's first bytes as they lie; then their checksum, as after each section.
struct Header {
    char magic[8];
    std::uint32_t version;
    std::uint8_t depth;
    std::uint8_t components; // floats a node
    std::uint16_t zero;
    double world_from_index[12]; // rows of 3 x 4
    std::uint64_t text_bytes;
    std::uint64_t divided_cells;
    std::uint64_t nodes;
};
static_assert(sizeof(Header) == 136 && std::endian::native == std::endian::little);

std::uint64_t bits_bytes(std::uint64_t nodes) {
    return (nodes + 7) / 8;
}

/// Sections of a file, one after the other; what is written of each is summed up.
class SectionWriter {
public:
    SectionWriter(const std::filesystem::path& path, std::uint64_t byte_count)
        : file_(path, byte_count) {}

    void write(std::string_view bytes) {
        checksum_ = checksum(bytes, checksum_);
        buffer_ += bytes;
        if (buffer_.size() >= std::size_t{1} << 20) flush(); // 1 MiB: calls cost nothing beside it
    }
    void end_section() {
        buffer_ += bytes_of(checksum_);
        checksum_ = 0;
    }
    void commit() {
        flush();
        file_.commit();
    }

private:
    void flush() {
        file_.write(buffer_);
        buffer_.clear();
    }
    DenseFile file_;
    std::string buffer_;
    std::uint32_t checksum_ = 0;
};

/// The tree's divided cells in visit_cells' order: which of each one's children are divided.
std::string structure_of(const HashedOctree& tree) {
    std::string masks;
    std::array<std::size_t, greatest_octree_depth + 1> latest{}; // divided cell of each level
    tree.visit_cells([&](const OctreeCell& cell, bool is_leaf) {
        if (is_leaf) return;
        if (cell.level < tree.depth())
            masks[latest[static_cast<std::size_t>(cell.level) + 1]] |=
                static_cast<char>(1 << child_index(cell.position, cell.level));
        latest[static_cast<std::size_t>(cell.level)] = masks.size();
        masks.push_back(0);
    });
    return masks;
}

/// Sections in the order of the file, from memory that another may have damaged.
class SectionReader {
public:
    explicit SectionReader(const std::filesystem::path& path)
        : path_(path), file_(path),
          rest_(reinterpret_cast<const char*>(file_.bytes().data()), file_.bytes().size()) {}

    [[noreturn]] void fail(const std::string& cause) const { cannot_read(path_, cause); }

    std::string_view section(const char* name, std::uint64_t size) {
        constexpr std::size_t sum_size = sizeof(std::uint32_t);
        if (rest_.size() < sum_size || rest_.size() - sum_size < size)
            fail(fmt::format("it ends within its {}", name));
        const std::string_view bytes = rest_.substr(0, size);
        if (rest_.substr(size, sum_size) != bytes_of(checksum(bytes)))
            fail(fmt::format("its {} is damaged: the checksum differs", name));
        rest_.remove_prefix(size + sum_size);
        return bytes;
    }
    std::string_view rest() const { return rest_; }

private:
    std::filesystem::path path_;
    MappedFile file_;
    std::string_view rest_;
};

/// The header, and that its counts are those of a file of this size.
Header read_header(SectionReader& reader) {
    Header header;
    if (!reader.rest().starts_with(magic)) reader.fail("it is no octree file");
    std::memcpy(&header, reader.section("header", sizeof header).data(), sizeof header);
    if (header.version != version)
        reader.fail(fmt::format("it is of version {}, not {}", header.version, version));
    if (header.depth > greatest_octree_depth)
        reader.fail(
            fmt::format("its depth is {}, more than {}", header.depth, greatest_octree_depth));
    if (header.zero != 0 || (header.components != 1 && header.components != 8))
        reader.fail(fmt::format("its filter of {} floats a node is unknown", header.components));
    const std::uint64_t rest = reader.rest().size();
    // Each against the size first, so that the sum does not wrap around.
    if (header.text_bytes > rest || header.divided_cells > rest || header.nodes > rest ||
        header.text_bytes + header.divided_cells +
                header.nodes * header.components * sizeof(float) + bits_bytes(header.nodes) +
                4 * sizeof(std::uint32_t) !=
            rest)
        reader.fail(fmt::format("its size is not that of {} bytes of text, {} divided cells and "
                                "{} nodes",
                                header.text_bytes, header.divided_cells, header.nodes));
    return header;
}

GridSpace space_of(const Header& header, const SectionReader& reader) {
    GridSpace space;
    space.world_from_index.affine() =
        Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(header.world_from_index);
    // Not a number, too: comparisons with it are false.
    const double volume = std::abs(space.world_from_index.linear().determinant());
    if (!space.world_from_index.matrix().allFinite() || !(volume > 0))
        reader.fail("its map to the world cannot be inverted");
    return space;
}

std::map<std::string, std::string> provenance_of(std::string_view text,
                                                 const SectionReader& reader) {
    std::map<std::string, std::string> provenance;
    while (!text.empty()) {
        const std::size_t end = text.find('\n');
        const std::string_view line = text.substr(0, end);
        const std::size_t equals = line.find(" = ");
        if (end == std::string_view::npos || equals == std::string_view::npos ||
            !provenance.emplace(line.substr(0, equals), line.substr(equals + 3)).second)
            reader.fail(fmt::format("its text is no list of keys and values: '{}'", shown(line)));
        text.remove_prefix(end + 1);
    }
    return provenance;
}

/// Divides the root and all cells below as the masks say.
void divide_as_told(HashedOctree& tree, std::string_view masks, const SectionReader& reader,
                    const HashedOctree::NodeSampler& sampler) {
    std::size_t next = 0;
    const auto descend = [&](const auto& self, const OctreeCell& cell) -> void {
        if (next == masks.size()) reader.fail("its structure ends within the tree");
        if (cell.level == 0) reader.fail("its structure divides a cell of level 0");
        const auto mask = static_cast<unsigned char>(masks[next++]);
        tree.divide(cell, sampler);
        for (int i = 0; i < 8; ++i)
            if (mask >> i & 1) self(self, child_of(cell, i));
    };
    if (!masks.empty()) descend(descend, tree.root());
    if (next != masks.size()) reader.fail("its structure goes on after the tree's end");
}

} // namespace

OctreeFile read_octree(const std::filesystem::path& path) {
    SectionReader reader(path);
    const Header header = read_header(reader);
    const GridSpace space = space_of(header, reader);
    const auto provenance = provenance_of(reader.section("text", header.text_bytes), reader);
    const std::string_view masks = reader.section("structure", header.divided_cells);
    const std::size_t node_bytes = header.components * sizeof(float);
    const std::string_view values = reader.section("values", header.nodes * node_bytes);
    const std::string_view bits = reader.section("list of constraints", bits_bytes(header.nodes));

    std::size_t next = 0;
    const HashedOctree::NodeSampler sampler = [&](const Index3&, std::span<float> out) {
        if (next == header.nodes) reader.fail("it has fewer nodes than its cells need");
        std::memcpy(out.data(), values.data() + next++ * node_bytes, node_bytes);
        if (!std::ranges::all_of(out, [](float value) { return std::isfinite(value); }))
            reader.fail(fmt::format("its node {} holds what is no finite number", next - 1));
    };
    try {
        const auto filter = header.components == 1 ? OctreeFilter::Linear : OctreeFilter::Cubic;
        OctreeFile file = {HashedOctree(header.depth, filter, sampler), space, provenance};
        file.tree.reserve(header.divided_cells);
        divide_as_told(file.tree, masks, reader, sampler);
        if (next != header.nodes) reader.fail("it has more nodes than its cells need");
        for (std::size_t node = 0; node < 8 * bits.size(); ++node) {
            if (!(static_cast<unsigned char>(bits[node / 8]) >> node % 8 & 1)) continue;
            if (node >= next) reader.fail("it constrains a node that is not there");
            file.tree.set_constrained(static_cast<HashedOctree::NodeNumber>(node), true);
        }
        return file;
    } catch (const std::bad_alloc&) {
        throw ResourceError(fmt::format("cannot read {}: no memory for {} divided cells",
                                        path.string(), header.divided_cells));
    }
}

void write_octree(const HashedOctree& tree, const GridSpace& space,
                  const std::map<std::string, std::string>& provenance,
                  const std::filesystem::path& path) {
    std::string text;
    for (const auto& [key, value] : provenance) {
        if ((key + value).find('\n') != std::string::npos || key.find(" = ") != std::string::npos)
            throw InputError(fmt::format("cannot write {}: '{}' is no key of one line",
                                         path.string(), shown(key)));
        text += fmt::format("{} = {}\n", key, value);
    }
    const std::string masks = structure_of(tree);
    Header header = {.version = version,
                     .depth = static_cast<std::uint8_t>(tree.depth()),
                     .components = static_cast<std::uint8_t>(components_of(tree.filter())),
                     .text_bytes = text.size(),
                     .divided_cells = masks.size(),
                     .nodes = tree.node_count()};
    magic.copy(header.magic, magic.size());
    Eigen::Map<Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(header.world_from_index) =
        space.world_from_index.affine();

    const std::uint64_t byte_count = sizeof header + text.size() + masks.size() +
                                     header.nodes * header.components * sizeof(float) +
                                     bits_bytes(header.nodes) + 5 * sizeof(std::uint32_t);
    SectionWriter writer(path, byte_count);
    for (const std::string_view section :
         {bytes_of(header), std::string_view(text), std::string_view(masks)}) {
        writer.write(section);
        writer.end_section();
    }
    std::string bits(bits_bytes(header.nodes), 0);
    std::size_t next = 0;
    tree.visit_nodes([&](const Index3&, HashedOctree::NodeNumber node) {
        const std::span<const float> data = tree.data_of(node);
        writer.write({reinterpret_cast<const char*>(data.data()), data.size_bytes()});
        if (tree.is_constrained(node)) bits[next / 8] |= static_cast<char>(1 << next % 8);
        ++next;
    });
    writer.end_section();
    writer.write(bits);
    writer.end_section();
    writer.commit();
}

} // namespace isocast
