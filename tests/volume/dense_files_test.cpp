// Dense files, byte for byte, and as other programs read them.
// SPDX-License-Identifier: MPL-2.0
#include "random_fields.h"
#include "temporary_folder.h"
#include "volume/errors.h"
#include "volume/files.h"

#include <gmock/gmock.h>
#include <sys/resource.h>

#include <csignal>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>

namespace isocast::test {
namespace {

using ::testing::ElementsAreArray;
using ::testing::HasSubstr;

std::string bytes_of(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream bytes;
    bytes << file.rdbuf();
    return bytes.str();
}

std::vector<float> floats_of(std::string_view bytes) {
    std::vector<float> values(bytes.size() / sizeof(float));
    std::memcpy(values.data(), bytes.data(), values.size() * sizeof(float));
    return values;
}

/// The numbers in the text between `before` and the next `after`, whatever stands between them.
std::vector<double> numbers_after(const std::string& text, const std::string& before,
                                  char after = '\n') {
    const std::size_t begin = text.find(before);
    if (begin == std::string::npos) return {};
    const std::size_t from = begin + before.size();
    std::string part = text.substr(from, text.find(after, from) - from);
    std::ranges::replace_if(
        part, [](char c) { return c == '(' || c == ')' || c == ','; }, ' ');
    std::istringstream stream(part);
    return {std::istream_iterator<double>(stream), {}};
}

/// Every sample of the extent, as the format should have them.
std::vector<float> samples_of(const FieldSource& field) {
    return copied(field, field.extent());
}

GridSpace sheared_space() {
    GridSpace space;
    space.world_from_index.linear() << 1, 0.2, 0, 0, 1, 0, 0, 0, 2;
    return space;
}

DenseField dense_in(const GridSpace& space, unsigned seed) {
    Random random(seed);
    const IndexBox extent{Index3(-3, 5, -70), Index3(10, 8, -59)};
    const DenseField noise = random_dense(random, extent);
    return {space, extent, {noise.values().begin(), noise.values().end()}};
}

SparseField sparse_field(unsigned seed) {
    Random random(seed);
    return {GridSpace::uniform(0.25, Vec3d(1, 2, 3)), 0.75, Outside::SignedBackground,
            random_blocks(random, 3, 0.3, 0.75F)};
}

TEST(DenseFiles, NrrdHoldsEverySampleAndAnyAffineMap) {
    const TemporaryFolder folder;
    for (const GridSpace& space : {GridSpace::uniform(0.1), turned_space(), sheared_space()}) {
        const DenseField field = dense_in(space, 1);
        write_nrrd(field, folder / "a.nrrd");
        const std::string bytes = bytes_of(folder / "a.nrrd");
        const std::size_t end = bytes.find("\n\n");
        ASSERT_NE(end, std::string::npos);
        const std::string header = bytes.substr(0, end + 1);
        EXPECT_TRUE(header.starts_with("NRRD0004\n"));
        for (const std::string line : {"type: float", "dimension: 3", "space dimension: 3",
                                       "endian: little", "encoding: raw", "sizes: 13 3 11"})
            EXPECT_THAT(header, HasSubstr("\n" + line + "\n"));
        // To the last bit: the text reads back as the same double.
        EXPECT_THAT(numbers_after(header, "space directions: "),
                    ElementsAreArray(space.world_from_index.linear().reshaped()));
        EXPECT_THAT(numbers_after(header, "space origin: "),
                    ElementsAreArray(space.to_world(Vec3d(-3, 5, -70))));
        EXPECT_EQ(floats_of(std::string_view(bytes).substr(end + 2)), samples_of(field));
    }
}

TEST(DenseFiles, MetaImageHoldsEverySampleAndRotations) {
    const TemporaryFolder folder;
    for (const GridSpace& space : {GridSpace::uniform(0.1), turned_space()}) {
        const DenseField field = dense_in(space, 2);
        write_mhd(field, folder / "a.mhd");
        const std::string header = bytes_of(folder / "a.mhd");
        for (const std::string line : {"NDims = 3", "DimSize = 13 3 11", "ElementType = MET_FLOAT",
                                       "BinaryDataByteOrderMSB = False", "CompressedData = False"})
            EXPECT_THAT(header, HasSubstr("\n" + line + "\n"));
        EXPECT_TRUE(header.ends_with("\nElementDataFile = a.raw\n"));
        const std::vector<double> matrix = numbers_after(header, "TransformMatrix = ");
        const std::vector<double> spacing = numbers_after(header, "ElementSpacing = ");
        ASSERT_EQ(matrix.size(), 9u);
        ASSERT_EQ(spacing.size(), 3u);
        for (int axis = 0; axis < 3; ++axis)
            // Rows are the directions; norm and division round once each.
            EXPECT_TRUE((spacing[axis] * Vec3d(matrix.data() + 3 * axis))
                            .isApprox(space.world_from_index.linear().col(axis), 1e-15));
        EXPECT_THAT(numbers_after(header, "Offset = "),
                    ElementsAreArray(space.to_world(Vec3d(-3, 5, -70))));
        EXPECT_EQ(floats_of(bytes_of(folder / "a.raw")), samples_of(field));
    }
}

TEST(DenseFiles, VtkImageHoldsEverySampleItsIndicesAndRotations) {
    const TemporaryFolder folder;
    for (const GridSpace& space : {GridSpace::uniform(0.1), turned_space()}) {
        const DenseField field = dense_in(space, 3);
        write_vti(field, folder / "a.vti");
        const std::string bytes = bytes_of(folder / "a.vti");
        const std::size_t begin = bytes.find("<AppendedData encoding=\"raw\">");
        ASSERT_NE(begin, std::string::npos);
        const std::string header = bytes.substr(0, begin);
        for (const std::string text :
             {"type=\"ImageData\"", "byte_order=\"LittleEndian\"", "header_type=\"UInt64\"",
              "<DataArray type=\"Float32\" Name=\"field\" format=\"appended\" offset=\"0\"/>"})
            EXPECT_THAT(header, HasSubstr(text));
        const std::vector<double> extent = {-3, 9, 5, 7, -70, -60};
        EXPECT_EQ(numbers_after(header, "WholeExtent=\"", '"'), extent);
        EXPECT_EQ(numbers_after(header, "Piece Extent=\"", '"'), extent);
        EXPECT_THAT(numbers_after(header, "Origin=\"", '"'),
                    ElementsAreArray(Vec3d(space.world_from_index.translation())));
        const std::vector<double> matrix = numbers_after(header, "Direction=\"", '"');
        const std::vector<double> spacing = numbers_after(header, "Spacing=\"", '"');
        ASSERT_EQ(matrix.size(), 9u);
        ASSERT_EQ(spacing.size(), 3u);
        for (int axis = 0; axis < 3; ++axis)
            // Columns are the directions; norm and division round once each.
            EXPECT_TRUE((spacing[axis] * Vec3d(matrix[axis], matrix[3 + axis], matrix[6 + axis]))
                            .isApprox(space.world_from_index.linear().col(axis), 1e-15));
        // After the underscore: the size in bytes, then the samples.
        const std::string_view appended =
            std::string_view(bytes).substr(bytes.find('_', begin) + 1);
        std::uint64_t size = 0;
        std::memcpy(&size, appended.data(), sizeof size);
        ASSERT_EQ(size, 4u * 13 * 3 * 11);
        EXPECT_EQ(floats_of(appended.substr(8, size)), samples_of(field));
        EXPECT_EQ(appended.substr(8 + size), "\n</AppendedData>\n</VTKFile>\n");
    }
}

TEST(DenseFiles, SparseFieldsAreWrittenWithTheirBackground) {
    const TemporaryFolder folder;
    const SparseField field = sparse_field(4);
    write_dense(field, folder / "a.mhd");
    EXPECT_EQ(floats_of(bytes_of(folder / "a.raw")), samples_of(field));
}

// 210^3 samples are two slabs, 3000^2 of one layer are two in the layer. (A slab once ended before
// the end of its layers, so that rows came out of order.)
TEST(DenseFiles, ManySlabsAreOneFile) {
    const TemporaryFolder folder;
    for (const Index3& size : {Index3(210, 210, 210), Index3(3000, 3000, 1)}) {
        const IndexBox box{Index3(1, 2, 3), Index3(1, 2, 3) + size};
        std::vector<float> values(static_cast<std::size_t>(box.sample_count()));
        for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i % 8191);
        std::vector<double> fractions;
        write_dense(DenseField(GridSpace::uniform(1), box, values), folder / "a.mhd",
                    [&](std::string_view stage, double fraction) {
                        EXPECT_EQ(stage, "write");
                        fractions.push_back(fraction);
                    });
        EXPECT_TRUE(floats_of(bytes_of(folder / "a.raw")) == values) << size.transpose();
        EXPECT_EQ(fractions.size(), 2u);
        EXPECT_TRUE(std::ranges::is_sorted(fractions));
        EXPECT_EQ(fractions.back(), 1);
    }
}

TEST(DenseFiles, ExtensionChoosesTheFormat) {
    const TemporaryFolder folder;
    const DenseField field = dense_in(GridSpace::uniform(1), 5);
    write_dense(field, folder / "a.NRRD");
    EXPECT_TRUE(bytes_of(folder / "a.NRRD").starts_with("NRRD"));
    write_dense(field, folder / "a.vti");
    EXPECT_TRUE(bytes_of(folder / "a.vti").starts_with("<?xml"));
    EXPECT_TRUE(is_dense_file("x/y.Mhd"));
    EXPECT_FALSE(is_dense_file("x/y.raw"));
    EXPECT_FALSE(is_dense_file("x/y.vdb"));
    EXPECT_THAT(message_of<InputError>([&] { write_dense(field, folder / "a.tif"); }),
                HasSubstr("(known: .nrrd, .mhd, .vti)"));
}

TEST(DenseFiles, ShearedGridsAreRefusedWhereTheFormatHasNoPlaceForThem) {
    const TemporaryFolder folder;
    const DenseField field = dense_in(sheared_space(), 6);
    for (const std::string name : {"a.mhd", "a.vti"})
        EXPECT_THAT(message_of<InputError>([&] { write_dense(field, folder / name); }),
                    HasSubstr("not at right angles"));
    EXPECT_EQ(folder.entry_count(), 0);
}

TEST(DenseFiles, InterruptionLeavesTheOldFilesAndNothingElse) {
    const TemporaryFolder folder;
    const DenseField field = dense_in(GridSpace::uniform(1), 7);
    const Progress stop = [](std::string_view, double) { throw Interrupted(); };
    for (const std::string name : {"a.nrrd", "a.mhd", "a.vti", "a.raw"})
        std::ofstream(folder / name) << "old";
    for (const std::string name : {"a.nrrd", "a.mhd", "a.vti"})
        EXPECT_THROW(write_dense(field, folder / name, stop), Interrupted);
    for (const std::string name : {"a.nrrd", "a.mhd", "a.vti", "a.raw"})
        EXPECT_EQ(bytes_of(folder / name), "old");
    EXPECT_EQ(folder.entry_count(), 4);
}

/// A field of a great extent, whose samples nobody should ask for.
class Vast final : public FieldSource {
public:
    explicit Vast(int size) : extent_{Index3::Zero(), Index3::Constant(size)} {}
    const GridSpace& space() const override { return space_; }
    IndexBox extent() const override { return extent_; }
    std::optional<double> half_width_world() const override { return {}; }
    std::vector<IndexBox> active_boxes() const override { return {}; }
    int finest_level(const IndexBox&) const override { return 0; }
    ValueRange value_range(const IndexBox&) const override { return {0, 0}; }
    void copy_box(const IndexBox&, int, std::span<float>) const override {
        ADD_FAILURE() << "samples asked for";
    }

private:
    GridSpace space_;
    IndexBox extent_;
};

// 16,384^3 samples are 16 TiB; 2^28 to the third is more than 64 bits count.
TEST(DenseFiles, MoreThanTheDiskHoldsIsRefusedBeforeAnythingIsWritten) {
    const TemporaryFolder folder;
    for (const std::string name : {"a.nrrd", "a.mhd", "a.vti"}) {
        EXPECT_THAT(message_of<ResourceError>([&] { write_dense(Vast(1 << 16), folder / name); }),
                    HasSubstr("GiB free"));
        EXPECT_THAT(message_of<ResourceError>([&] { write_dense(Vast(1 << 28), folder / name); }),
                    HasSubstr("too many"));
        EXPECT_THAT(message_of<InputError>([&] { write_dense(Vast(0), folder / name); }),
                    HasSubstr("no samples"));
    }
    EXPECT_EQ(folder.entry_count(), 0);
    EXPECT_THAT(message_of<InputError>([&] {
                    write_dense(dense_in(GridSpace::uniform(1), 8), folder / "missing/a.vti");
                }),
                HasSubstr("does not exist"));
}

// A limit on the size of files stands for a disk that fills up: while samples are written, or,
// where all fit in the stream's buffer, when it is closed.
TEST(DenseFiles, WritingThatFailsIsAResourceErrorAndLeavesNothing) {
    const TemporaryFolder folder;
    rlimit limit{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &limit), 0);
    const rlimit small = {.rlim_cur = 1000, .rlim_max = limit.rlim_max};
    const auto old_handler = std::signal(SIGXFSZ, SIG_IGN); // then write() returns EFBIG
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    for (const int size : {8, 64})
        for (const std::string name : {"a.nrrd", "a.mhd", "a.vti"}) {
            const IndexBox box{Index3::Zero(), Index3::Constant(size)};
            const DenseField field(GridSpace::uniform(1), box,
                                   std::vector<float>(std::size_t(box.sample_count())));
            EXPECT_THAT(message_of<ResourceError>([&] { write_dense(field, folder / name); }),
                        HasSubstr("File too large"));
        }
    EXPECT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
    std::signal(SIGXFSZ, old_handler);
    EXPECT_EQ(folder.entry_count(), 0);
}

// Debian's package teem-apps calls the program teem-unu.
TEST(DenseFiles, TeemReadsTheSameSamplesAndPlaces) {
    if (std::system("command -v teem-unu > /dev/null") != 0) GTEST_SKIP() << "no teem-unu here";
    const TemporaryFolder folder;
    const DenseField field = dense_in(sheared_space(), 9);
    write_nrrd(field, folder / "a.nrrd");
    const auto output_of = [&](const std::string& verb) {
        const std::string output = (folder / verb).string();
        const std::string command =
            "teem-unu " + verb + " " + (folder / "a.nrrd").string() + " > " + output;
        EXPECT_EQ(std::system(command.c_str()), 0);
        return bytes_of(output);
    };
    EXPECT_EQ(floats_of(output_of("data")), samples_of(field));
    const std::string header = output_of("head");
    EXPECT_THAT(header, HasSubstr("\nsizes: 13 3 11\n"));
    EXPECT_THAT(numbers_after(header, "space directions: "),
                ElementsAreArray(field.space().world_from_index.linear().reshaped()));
    EXPECT_THAT(numbers_after(header, "space origin: "),
                ElementsAreArray(field.space().to_world(Vec3d(-3, 5, -70))));
}

} // namespace
} // namespace isocast::test
