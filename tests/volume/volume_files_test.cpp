// Volumes of other programs: NRRD, MetaImage and NIfTI, written here from known values.
// SPDX-License-Identifier: MPL-2.0
#include "random_fields.h"
#include "temporary_folder.h"
#include "typed_bytes.h"
#include "volume/errors.h"
#include "volume/files.h"
#include "volume/histogram.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <unistd.h>
#include <zlib.h>

#ifdef ISOCAST_WITH_LIBNIFTI
#include <nifti1_io.h>
#endif

#include <chrono>
#include <fstream>
#include <sstream>

namespace isocast::test {
namespace {

using ::testing::HasSubstr;

constexpr std::endian both_orders[] = {std::endian::little, std::endian::big};

std::string contents_of(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream bytes;
    bytes << file.rdbuf();
    return bytes.str();
}

void write_bytes(const std::filesystem::path& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
}

/// `bytes` as gzip or zlib compress them.
std::string compressed(const std::string& bytes, bool gzip) {
    z_stream stream{};
    EXPECT_EQ(deflateInit2(&stream, 6, Z_DEFLATED, gzip ? 15 + 16 : 15, 8, Z_DEFAULT_STRATEGY),
              Z_OK);
    std::string out(deflateBound(&stream, bytes.size()) + 64, '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = static_cast<uInt>(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = static_cast<uInt>(out.size());
    EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
    out.resize(stream.total_out);
    deflateEnd(&stream);
    return out;
}

struct Volume {
    SampleType type = SampleType::Int16;
    std::endian order = std::endian::little;
    Index3 size{5, 4, 3};
    std::vector<double> values;

    std::string bytes() const { return bytes_of(values, type, order); }
    std::vector<float> floats() const { return {values.begin(), values.end()}; }
    std::string size_text() const {
        std::ostringstream text;
        text << size.transpose();
        return text.str();
    }
};

Volume random_volume(Random& random, SampleType type = SampleType::Int16,
                     std::endian order = std::endian::little) {
    Volume volume{.type = type, .order = order, .size = random_box(random, 0, 0, 9).size()};
    volume.values =
        random_values(random, type, static_cast<std::size_t>(volume.size.cast<int>().prod()));
    return volume;
}

// ------------------------------------------------------------------------ writers of these formats

constexpr const char* nrrd_types[] = {"signed char", "uchar", "short", "unsigned short",
                                      "int",         "uint",  "float", "double"};
constexpr const char* mhd_types[] = {"MET_CHAR", "MET_UCHAR", "MET_SHORT", "MET_USHORT",
                                     "MET_INT",  "MET_UINT",  "MET_FLOAT", "MET_DOUBLE"};
constexpr int nifti_types[] = {256, 2, 4, 512, 8, 768, 16, 64};
constexpr int nifti_bits[] = {8, 8, 16, 16, 32, 32, 32, 64};

std::string nrrd_text(const Volume& volume, const std::string& encoding, const std::string& more) {
    std::ostringstream text;
    text << "NRRD0004\n# made by a test\ntype: " << nrrd_types[static_cast<int>(volume.type)]
         << "\ndimension: 3\nsizes: " << volume.size_text() << "\nencoding: " << encoding
         << "\nendian: " << (volume.order == std::endian::little ? "little" : "big") << "\n"
         << more << "key:=value: with colon\n";
    return text.str();
}

std::string mhd_text(const Volume& volume, const std::string& more, const std::string& data) {
    std::ostringstream text;
    text << "ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = " << volume.size_text()
         << "\nElementType = " << mhd_types[static_cast<int>(volume.type)]
         << "\nElementByteOrderMSB = " << (volume.order == std::endian::little ? "False" : "True")
         << "\n"
         << more << "ElementDataFile = " << data << "\n";
    return text.str();
}

/// What of a NIfTI header the tests set.
struct Nifti {
    double spacing[4] = {1, 1, 1, 1}; // pixdim[0] is the sign of the third axis
    int qform_code = 0;
    double quaternion[3] = {0, 0, 0};
    double offset[3] = {0, 0, 0};
    int sform_code = 0;
    double rows[12] = {};
    double slope = 0;
    double intercept = 0;
    int dimensions = 3;
    int volumes = 1;
    double data_offset = 352;
    std::string magic = std::string("n+1\0", 4);
};

std::string nifti_bytes(const Volume& volume, const Nifti& nifti = {}) {
    std::string header(352, '\0');
    const auto put = [&]<class Number>(std::size_t at, Number number) {
        std::string bytes;
        append<Number>(bytes, static_cast<double>(number), volume.order);
        header.replace(at, bytes.size(), bytes);
    };
    const auto floats = [&](std::size_t at, std::span<const double> numbers) {
        for (std::size_t i = 0; i < numbers.size(); ++i)
            put(at + 4 * i, static_cast<float>(numbers[i]));
    };
    put(0, std::int32_t{348});
    put(40, static_cast<std::int16_t>(nifti.dimensions));
    for (int i = 0; i < 3; ++i)
        put(static_cast<std::size_t>(42 + 2 * i), static_cast<std::int16_t>(volume.size[i]));
    for (int i = 3; i < 7; ++i)
        put(static_cast<std::size_t>(42 + 2 * i),
            static_cast<std::int16_t>(i == 3 ? nifti.volumes : 1));
    put(70, static_cast<std::int16_t>(nifti_types[static_cast<int>(volume.type)]));
    put(72, static_cast<std::int16_t>(nifti_bits[static_cast<int>(volume.type)]));
    floats(76, nifti.spacing);
    floats(108, {&nifti.data_offset, 1});
    floats(112, {&nifti.slope, 1});
    floats(116, {&nifti.intercept, 1});
    header[123] = 2; // mm
    header.replace(148, 6, "a test");
    put(252, static_cast<std::int16_t>(nifti.qform_code));
    put(254, static_cast<std::int16_t>(nifti.sform_code));
    floats(256, nifti.quaternion);
    floats(268, nifti.offset);
    floats(280, nifti.rows);
    header.replace(344, 4, nifti.magic);
    return header + volume.bytes();
}

/// The file to open for each way to store `volume`; all files lie in `folder`.
std::vector<std::filesystem::path> write_all(const Volume& volume, const TemporaryFolder& folder) {
    const std::string bytes = volume.bytes();
    write_bytes(folder / "a.raw", bytes);
    write_bytes(folder / "a.raw.gz", compressed(bytes, true));
    write_bytes(folder / "a.zraw", compressed(bytes, false));
    write_bytes(folder / "skip.raw", "a line\nanother\nxyz" + bytes);

    write_bytes(folder / "raw.nrrd", nrrd_text(volume, "raw", "") + "\n" + bytes);
    write_bytes(folder / "gzip.nrrd",
                nrrd_text(volume, "gzip", "") + "\n" + compressed(bytes, true));
    write_bytes(folder / "raw.nhdr", nrrd_text(volume, "raw", "data file: a.raw\n"));
    write_bytes(folder / "gzip.nhdr", nrrd_text(volume, "gz", "datafile: ./a.raw.gz\n"));
    write_bytes(folder / "skip.nhdr", nrrd_text(volume, "Raw",
                                                "line skip: 2\nbyte skip: 3\ndata file: " +
                                                    (folder / "skip.raw").string() + "\n"));
    write_bytes(folder / "last.nhdr",
                nrrd_text(volume, "raw", "byte skip: -1\ndata file: skip.raw\n"));
    std::string windows = nrrd_text(volume, "raw", "data file: a.raw\n");
    for (std::size_t at = 0; (at = windows.find('\n', at)) != std::string::npos; at += 2)
        windows.insert(at, 1, '\r');
    write_bytes(folder / "windows.nhdr", windows);

    write_bytes(folder / "raw.mhd", mhd_text(volume, "", "a.raw"));
    write_bytes(folder / "zlib.mhd", mhd_text(volume, "CompressedData = True\n", "a.zraw"));
    write_bytes(folder / "skip.mhd", mhd_text(volume, "HeaderSize = 18\n", "skip.raw"));
    write_bytes(folder / "last.mhd", mhd_text(volume, "HeaderSize = -1\n", "skip.raw"));
    write_bytes(folder / "raw.mha", mhd_text(volume, "", "LOCAL") + bytes);
    write_bytes(folder / "zlib.mha",
                mhd_text(volume, "CompressedData = True\n", "LOCAL") + compressed(bytes, false));

    write_bytes(folder / "raw.nii", nifti_bytes(volume));
    write_bytes(folder / "gzip.nii.gz", compressed(nifti_bytes(volume), true));
    // Two members of gzip, one after the other, are one file.
    const std::string whole = nifti_bytes(volume);
    write_bytes(folder / "two.nii.gz",
                compressed(whole.substr(0, 353), true) + compressed(whole.substr(353), true));
    std::vector<std::filesystem::path> paths;
    for (const char* name :
         {"raw.nrrd", "gzip.nrrd", "raw.nhdr", "gzip.nhdr", "skip.nhdr", "last.nhdr",
          "windows.nhdr", "raw.mhd", "zlib.mhd", "skip.mhd", "last.mhd", "raw.mha", "zlib.mha",
          "raw.nii", "gzip.nii.gz", "two.nii.gz"})
        paths.push_back(folder / name);
    return paths;
}

// ---------------------------------------------------------------------------------- what is read

TEST(VolumeFiles, EveryFormatHoldsEveryTypeInBothByteOrders) {
    Random random(1);
    for (const SampleType type : all_sample_types)
        for (const std::endian order : both_orders) {
            const TemporaryFolder folder;
            const Volume volume = random_volume(random, type, order);
            for (const auto& path : write_all(volume, folder)) {
                const auto field = read_field(path);
                ASSERT_EQ(field->extent(), (IndexBox{Index3::Zero(), volume.size})) << path;
                EXPECT_EQ(copied(*field, field->extent()), volume.floats())
                    << path << " " << name_of(type);
                EXPECT_FALSE(field->half_width_world());
                const std::vector<GridDescription> grids = describe_field_file(path);
                ASSERT_EQ(grids.size(), 1u);
                EXPECT_EQ(grids[0].name, path.filename());
                EXPECT_EQ(grids[0].grid_class, "dense");
                EXPECT_EQ(grids[0].value_type, name_of(type));
                EXPECT_EQ(grids[0].active_box, field->extent());
                EXPECT_EQ(grids[0].active_voxels, field->extent().sample_count());
                EXPECT_EQ(grids[0].world_from_index.matrix(),
                          field->space().world_from_index.matrix());
            }
        }
}

TEST(VolumeFiles, ExtensionsAreKnownInAnyCase) {
    for (const char* name : {"a.vdb", "b.NRRD", "a.nhdr", "c.Mhd", "a.mha", "a.nii", "a.b.NII.GZ"})
        EXPECT_TRUE(is_field_file(name)) << name;
    for (const char* name : {"a.raw", "a.gz", "a.tar.gz", "nrrd", "a.vti", "a.obj"})
        EXPECT_FALSE(is_field_file(name)) << name;
    EXPECT_EQ(field_file_extensions(), ".vdb .nrrd .nhdr .mhd .mha .nii .nii.gz");
    EXPECT_THAT(message_of<InputError>([] { read_field("a.tif"); }), HasSubstr(".nii.gz"));
}

/// A turned grid with three spacings, and numbers that need all their digits.
GridSpace turned_space() {
    GridSpace space;
    const Mat3d turn = Eigen::AngleAxisd(0.4, Vec3d(1, 2, 3).normalized()).toRotationMatrix();
    space.world_from_index.linear() = turn * Vec3d(0.1, 1.0 / 3, 2.7e-5).asDiagonal();
    space.world_from_index.translation() = Vec3d(1e6 / 3, -0.1, 7e-9);
    return space;
}

TEST(VolumeFiles, OurOwnFilesReadBackBitForBit) {
    Random random(2);
    const IndexBox extent{Index3(-3, 5, -70), Index3(10, 8, -59)};
    const DenseField noise = random_dense(random, extent);
    GridSpace sheared;
    sheared.world_from_index.linear() << 1, 0.2, 0, 0, 1, 0, 0, 0, 2;
    for (const GridSpace& space : {GridSpace::uniform(0.1), turned_space(), sheared}) {
        const TemporaryFolder folder;
        const DenseField field(space, extent, {noise.values().begin(), noise.values().end()});
        write_nrrd(field, folder / "a.nrrd");
        const auto nrrd = read_field(folder / "a.nrrd");
        EXPECT_EQ(copied(*nrrd, nrrd->extent()), copied(field, extent));
        const Eigen::Affine3d& map = nrrd->space().world_from_index;
        EXPECT_EQ(map.linear(), space.world_from_index.linear());
        // Sample 0 of the file is the extent's first.
        EXPECT_EQ(Vec3d(map.translation()), space.to_world(Vec3d(-3, 5, -70)));
        if (&space == &sheared || space.world_from_index.linear()(0, 1) == 0.2) continue;
        write_mhd(field, folder / "a.mhd");
        const auto mhd = read_field(folder / "a.mhd");
        EXPECT_EQ(copied(*mhd, mhd->extent()), copied(field, extent));
        // A spacing and a direction for each axis: norm, division and product round once each.
        const Eigen::Affine3d& mhd_map = mhd->space().world_from_index;
        EXPECT_LT((mhd_map.linear() - space.world_from_index.linear()).cwiseAbs().maxCoeff(),
                  1e-15 * space.world_from_index.linear().cwiseAbs().maxCoeff());
        EXPECT_EQ(Vec3d(mhd_map.translation()), space.to_world(Vec3d(-3, 5, -70)));
    }
}

Eigen::Matrix4d map_of(const std::filesystem::path& path) {
    return read_field(path)->space().world_from_index.matrix();
}

Eigen::Matrix4d rows(std::initializer_list<double> numbers) {
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    for (int i = 0; i < 12; ++i) matrix(i / 4, i % 4) = numbers.begin()[i];
    return matrix;
}

TEST(VolumeFiles, NrrdPlacesItsSamples) {
    const TemporaryFolder folder;
    Random random(3);
    const Volume volume = random_volume(random);
    const auto map_with = [&](const std::string& fields) {
        write_bytes(folder / "a.nrrd", nrrd_text(volume, "raw", fields) + "\n" + volume.bytes());
        return map_of(folder / "a.nrrd");
    };
    EXPECT_EQ(map_with(""), Eigen::Matrix4d::Identity());
    EXPECT_EQ(map_with("spacings: 0.5 nan 3\n"), rows({.5, 0, 0, 0, 0, 1, 0, 0, 0, 0, 3, 0}));
    EXPECT_EQ(map_with("space: left-posterior-superior\n"
                       "space directions: (1,2,3) (-4, 5e-1 ,6) (7,8,+9)\n"
                       "space origin: (10,20,30)\n"),
              rows({1, -4, 7, 10, 2, .5, 8, 20, 3, 6, 9, 30}));
}

TEST(VolumeFiles, MetaImagePlacesItsSamples) {
    const TemporaryFolder folder;
    Random random(4);
    const Volume volume = random_volume(random);
    const auto map_with = [&](const std::string& keys) {
        write_bytes(folder / "a.mha", mhd_text(volume, keys, "LOCAL") + volume.bytes());
        return map_of(folder / "a.mha");
    };
    EXPECT_EQ(map_with(""), Eigen::Matrix4d::Identity());
    for (const char* spacing : {"ElementSpacing", "ElementSize"})
        for (const char* offset : {"Offset", "Position", "Origin"})
            EXPECT_EQ(map_with(std::string(spacing) + " = 2 3 4\n" + offset + " = 10 20 30\n"),
                      rows({2, 0, 0, 10, 0, 3, 0, 20, 0, 0, 4, 30}));
    // Axis x points along the world's y, y along -x.
    EXPECT_EQ(map_with("TransformMatrix = 0 1 0 -1 0 0 0 0 1\nElementSpacing = 2 3 4\n"),
              rows({0, -3, 0, 0, 2, 0, 0, 0, 0, 0, 4, 0}));
}

TEST(VolumeFiles, NiftiPlacesItsSamplesByHand) {
    const TemporaryFolder folder;
    Random random(5);
    for (const std::endian order : both_orders) {
        const Volume volume = random_volume(random, SampleType::UInt8, order);
        const auto map_with = [&](const Nifti& nifti) {
            write_bytes(folder / "a.nii", nifti_bytes(volume, nifti));
            return map_of(folder / "a.nii");
        };
        // Neither form: the spacing, and offsets do not count.
        EXPECT_EQ(map_with({.spacing = {-1, 2, 3, 4}, .offset = {10, 20, 30}}),
                  rows({2, 0, 0, 0, 0, 3, 0, 0, 0, 0, 4, 0}));
        // A quarter turn about z takes x to y and y to -x; the third axis is mirrored.
        const double half = std::sqrt(0.5);
        const Nifti turned{.spacing = {-1, 2, 3, 4},
                           .qform_code = 1,
                           .quaternion = {0, 0, half},
                           .offset = {10, 20, 30}};
        // 1e-6: the quaternion is float32.
        EXPECT_LT((map_with(turned) - rows({0, -3, 0, 10, 2, 0, 0, 20, 0, 0, -4, 30})).norm(),
                  1e-6);
        // A half turn about y, as scanners write; b^2 + c^2 + d^2 is 1, and pixdim[0] of 0 means 1.
        EXPECT_EQ(map_with({.spacing = {0, 2, 3, 4},
                            .qform_code = 2,
                            .quaternion = {0, 1, 0},
                            .offset = {10, 20, 30}}),
                  rows({-2, 0, 0, 10, 0, 3, 0, 20, 0, 0, -4, 30}));
        // A third of a turn about (1, 1, 1) takes x to y, y to z and z to x.
        EXPECT_LT(
            (map_with({.spacing = {1, 2, 3, 4}, .qform_code = 1, .quaternion = {0.5, 0.5, 0.5}}) -
             rows({0, 0, 4, 0, 2, 0, 0, 0, 0, 3, 0, 0}))
                .norm(),
            1e-6);
        // The sform is any map, and goes before the qform.
        Nifti both = turned;
        both.sform_code = 4;
        for (int i = 0; i < 12; ++i) both.rows[i] = i == 6 ? 60 : i;
        EXPECT_EQ(map_with(both), rows({0, 1, 2, 3, 4, 5, 60, 7, 8, 9, 10, 11}));
    }
}

TEST(VolumeFiles, NiftiScalesItsSamples) {
    const TemporaryFolder folder;
    Volume volume{.type = SampleType::UInt8, .size = {3, 1, 1}, .values = {0, 100, 255}};
    const auto samples_with = [&](const Nifti& nifti) {
        write_bytes(folder / "a.nii", nifti_bytes(volume, nifti));
        const auto field = read_field(folder / "a.nii");
        return copied(*field, field->extent());
    };
    EXPECT_EQ(samples_with({.slope = 2, .intercept = -1024}),
              (std::vector<float>{-1024, -824, -514}));
    const std::vector<float> plain{0, 100, 255};
    EXPECT_EQ(samples_with({.slope = 0, .intercept = 7}), plain); // no slope, no intercept
    EXPECT_EQ(samples_with({.slope = std::numeric_limits<double>::quiet_NaN()}), plain);
    // A fourth dimension of one volume is none; extensions move the samples.
    EXPECT_EQ(samples_with({.dimensions = 4}), plain);
    write_bytes(folder / "b.nii",
                nifti_bytes(volume, {.data_offset = 368}).insert(352, std::string(16, 'x')));
    EXPECT_EQ(copied(*read_field(folder / "b.nii"), {{0, 0, 0}, {3, 1, 1}}), plain);
}

#ifdef ISOCAST_WITH_LIBNIFTI
// The format's own library agrees on random headers.
TEST(VolumeFiles, NiftiIsWhereItsLibraryPutsIt) {
    const TemporaryFolder folder;
    Random random(6);
    for (int i = 0; i < 100; ++i) {
        const Volume volume = random_volume(random, SampleType::Int16, both_orders[i % 2]);
        const Eigen::Quaterniond turn =
            Eigen::Quaterniond(random_real(random, 0, 1), random_real(random, -1, 1),
                               random_real(random, -1, 1), random_real(random, -1, 1))
                .normalized();
        Nifti nifti{.spacing = {i % 3 == 0 ? -1.0 : 1.0, random_real(random, 0.1, 3),
                                random_real(random, 0.1, 3), random_real(random, 0.1, 3)},
                    .qform_code = 1,
                    .quaternion = {turn.x(), turn.y(), turn.z()},
                    .offset = {random_real(random, -100, 100), 0, random_real(random, -9, 9)},
                    .sform_code = i % 2};
        for (double& number : nifti.rows) number = random_real(random, -3, 3);
        const std::string path = (folder / "a.nii").string();
        write_bytes(path, nifti_bytes(volume, nifti));
        nifti_image* const image = nifti_image_read(path.c_str(), 1);
        ASSERT_NE(image, nullptr);
        Eigen::Matrix4d expected;
        for (int row = 0; row < 4; ++row)
            for (int column = 0; column < 4; ++column)
                expected(row, column) = nifti.sform_code > 0 ? image->sto_xyz.m[row][column]
                                                             : image->qto_xyz.m[row][column];
        // float32: numbers of up to 100, and a root that loses half the digits near a = 0
        EXPECT_LT((map_of(path) - expected).norm(), 1e-3);
        const auto* const samples = static_cast<const std::int16_t*>(image->data);
        const std::vector<float> floats(samples, samples + image->nvox);
        EXPECT_EQ(copied(*read_field(path), {Index3::Zero(), volume.size}), floats);
        nifti_image_free(image);
    }
}
#endif

// -------------------------------------------------------------------------------- larger than
// memory

std::int64_t resident_bytes() {
    std::ifstream file("/proc/self/statm");
    std::int64_t size = 0;
    std::int64_t resident = 0;
    file >> size >> resident;
    return resident * ::sysconf(_SC_PAGESIZE);
}

/// Makes `path` a file of `size` bytes, all holes but for `bytes` at `at`.
void write_sparse(const std::filesystem::path& path, std::int64_t size, std::int64_t at,
                  const std::string& bytes) {
    const int file = ::open(path.c_str(), O_CREAT | O_RDWR, 0600);
    ASSERT_GE(file, 0);
    ASSERT_EQ(::ftruncate(file, size), 0);
    ASSERT_EQ(::pwrite(file, bytes.data(), bytes.size(), at), std::ssize(bytes));
    ::close(file);
}

// 8 GiB, most of them holes of the file: neither opening nor reading a box of it touches the rest.
TEST(VolumeFiles, LargerThanMemoryIsReadWhereItIsAskedFor) {
    const TemporaryFolder folder;
    const std::int64_t size = std::int64_t{8} << 30;
    const Index3 last(2046, 2045, 1023);
    const std::int64_t at =
        last.x() + std::int64_t{2048} * (last.y() + std::int64_t{2048} * last.z());
    write_sparse(folder / "a.raw", size, 2 * at, std::string("\x01\x02\x03\x04", 4));
    for (const bool is_big : {false, true}) {
        write_bytes(folder / "a.mhd",
                    std::string("NDims = 3\nDimSize = 2048 2048 1024\nElementType = MET_USHORT\n") +
                        "ElementByteOrderMSB = " + (is_big ? "True" : "False") +
                        "\nElementDataFile = a.raw\n");
        const std::int64_t resident_before = resident_bytes();
        const auto start = std::chrono::steady_clock::now();
        EXPECT_EQ(describe_field_file(folder / "a.mhd").at(0).active_voxels, size / 2);
        const auto field = read_field(folder / "a.mhd");
        EXPECT_EQ(copied(*field, {last, last + Index3(2, 1, 1)}),
                  is_big ? (std::vector<float>{0x0102, 0x0304})
                         : (std::vector<float>{0x0201, 0x0403}));
        EXPECT_EQ(copied(*field, {{0, 0, 0}, {4, 1, 1}}), std::vector<float>(4, 0.0F));
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        // Reading all would take seconds and 8 GiB; the limits leave room for a busy machine.
        EXPECT_LT(seconds.count(), 1);
        EXPECT_LT(resident_bytes() - resident_before, 64 << 20);
    }
}

// -------------------------------------------------------------------------------------------
// errors

/// The message of the InputError on reading `path` and all its samples; describing alone may pass.
std::string reading_error(const std::filesystem::path& path) {
    return message_of<InputError>([&] {
        const auto field = read_field(path);
        copied(*field, field->extent());
    });
}

TEST(VolumeFilesErrors, TruncatedFilesAreNamedAtEveryLength) {
    Random random(7);
    Volume volume = random_volume(random);
    const TemporaryFolder folder;
    for (const auto& path : write_all(volume, folder)) {
        const std::string whole = contents_of(path);
        const bool is_header = path.extension() == ".nhdr" || path.extension() == ".mhd";
        for (std::size_t length = 0; length < whole.size(); ++length) {
            // A detached header without its last field or its last line's end may be a whole one.
            const std::string cut = whole.substr(0, length);
            if (is_header && (length + 2 >= whole.size() || cut.find("a file:") != cut.npos ||
                              cut.find("datafile:") != cut.npos))
                continue;
            write_bytes(path, cut);
            const std::string message = reading_error(path);
            EXPECT_THAT(message, HasSubstr(path.filename())) << length << " of " << whole.size();
            EXPECT_EQ(message.find('\n'), std::string::npos) << message;
        }
        write_bytes(path, whole);
        EXPECT_EQ(reading_error(path), "") << path;
    }
    for (const char* data : {"a.raw", "a.raw.gz", "a.zraw"}) {
        const std::string whole = contents_of(folder / data);
        write_bytes(folder / data, whole.substr(0, whole.size() - 1));
    }
    for (const char* name : {"raw.nhdr", "gzip.nhdr", "raw.mhd", "zlib.mhd"})
        EXPECT_THAT(reading_error(folder / name), HasSubstr("truncated")) << name;
    EXPECT_THROW(describe_field_file(folder / "raw.mhd"), InputError);
}

TEST(VolumeFilesErrors, MoreSamplesBesideThanTheHeaderSaysAreAWrongSize) {
    Random random(8);
    const TemporaryFolder folder;
    Volume volume = random_volume(random);
    write_all(volume, folder);
    write_bytes(folder / "a.raw", volume.bytes() + "x");
    write_bytes(folder / "a.raw.gz", compressed(volume.bytes() + "x", true));
    write_bytes(folder / "a.zraw", compressed(volume.bytes() + "x", false));
    for (const char* name : {"raw.nhdr", "gzip.nhdr", "raw.mhd", "zlib.mhd"})
        EXPECT_THAT(reading_error(folder / name), HasSubstr("wrong size")) << name;
}

TEST(VolumeFilesErrors, DamagedCompressedSamplesAreNamed) {
    Random random(9);
    const TemporaryFolder folder;
    Volume volume{.size = {40, 40, 10}, .values = random_values(random, SampleType::Int16, 16000)};
    write_all(volume, folder);
    for (const char* name : {"gzip.nrrd", "zlib.mha", "gzip.nii.gz"}) {
        std::string bytes = contents_of(folder / name);
        bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 0x55);
        write_bytes(folder / name, bytes);
        const std::string message = reading_error(folder / name);
        EXPECT_THAT(message, HasSubstr(name));
        EXPECT_TRUE(message.find("damaged") != message.npos ||
                    message.find("truncated") != message.npos)
            << message;
    }
    // More than deflate can make of so few bytes: refused before memory is asked for.
    const Volume huge{.size = {3000, 3000, 3000}, .values = {}};
    write_bytes(folder / "huge.nrrd",
                nrrd_text(huge, "gzip", "") + "\n" + compressed(volume.bytes(), true));
    EXPECT_THAT(reading_error(folder / "huge.nrrd"), HasSubstr("cannot hold"));
    EXPECT_THROW(describe_field_file(folder / "huge.nrrd"), InputError);
    // Text where compressed samples should be.
    write_bytes(folder / "a.zraw", std::string(40000, 'x'));
    EXPECT_THAT(reading_error(folder / "zlib.mhd"), HasSubstr("damaged"));
}

struct BadHeader {
    std::string from, to; // the first text `from` of the good header becomes `to`
    std::vector<std::string> words;
};

void expect_refused(const std::filesystem::path& path, const std::vector<BadHeader>& cases) {
    const std::string good = contents_of(path);
    ASSERT_EQ(reading_error(path), "");
    for (const BadHeader& bad : cases) {
        std::string bytes = good;
        const std::size_t at = bytes.find(bad.from);
        ASSERT_NE(at, std::string::npos) << bad.from;
        write_bytes(path, bytes.replace(at, bad.from.size(), bad.to));
        const std::string message = reading_error(path);
        EXPECT_THAT(message, HasSubstr(path.filename())) << bad.to;
        for (const std::string& word : bad.words) EXPECT_THAT(message, HasSubstr(word)) << bad.to;
    }
    write_bytes(path, good);
}

TEST(VolumeFilesErrors, NrrdHeadersAreRefusedByCause) {
    const TemporaryFolder folder;
    const Volume volume{.size = {5, 4, 3}, .values = std::vector<double>(60, 1)};
    const auto path = folder / "a.nrrd";
    write_bytes(path, nrrd_text(volume, "raw", "spacings: 1 2 3\nspace origin: (1,2,3)\n") + "\n" +
                          volume.bytes());
    expect_refused(
        path, {{"NRRD0004", "NRRD0009", {"version", "NRRD0005"}},
               {"NRRD0004", "no image", {"not an NRRD file"}},
               {"short", "long long int", {"type", "'long long int'", "float"}},
               {"short", "block", {"type", "'block'"}},
               {"dimension: 3", "dimension: 4", {"dimension", "4"}},
               {"5 4 3", "5 4", {"sizes", "2 numbers"}},
               {"5 4 3", "5 4 0", {"sizes", "0"}},
               {"5 4 3", "5 4 -3", {"sizes", "-3"}},
               {"5 4 3", "5 4 3.5", {"sizes", "3.5"}},
               {"5 4 3", "5 4 three", {"sizes", "'three'"}},
               {"5 4 3", "5 4 4", {"truncated", "160 bytes"}},
               {"5 4 3", "5 4 99999999999", {"sizes", "2^28"}},
               {"5 4 3", "268435456 268435456 268435456", {"too many"}},
               {"5 4 3", "100000 100000 100000", {"truncated"}},
               {"raw", "ascii", {"encoding", "'ascii'", "raw, gzip"}},
               {"raw", "bzip2", {"encoding", "'bzip2'"}},
               {"raw", "gzip", {"damaged"}},
               {"little", "middle", {"endian", "'middle'"}},
               {"endian: little\n", "", {"no field 'endian'"}},
               {"type: short\n", "", {"no field 'type'"}},
               {"type: short", "tpye: short", {"unknown field 'tpye'", "type"}},
               {"type: short", "type: short\ntype: short", {"'type' occurs twice"}},
               {"type: short", "type short", {"'type short'"}},
               {"spacings: 1 2 3", "spacings: 1 2", {"spacings", "2 numbers"}},
               {"spacings: 1 2 3", "spacings: 1 0 3", {"no inverse"}},
               {"spacings: 1 2 3", "spacings: 1 inf 3", {"spacings", "'inf'"}},
               {"spacings: 1 2 3",
                "space directions: none (1,0,0) (0,1,0)",
                {"space directions", "none"}},
               {"spacings: 1 2 3", "space directions: (1,0,0) (0,1,0)", {"2 vectors"}},
               {"spacings: 1 2 3", "space directions: (1,0,0) (2,0,0) (0,0,1)", {"no inverse"}},
               {"(1,2,3)", "(1,2,3", {"space origin"}},
               {"(1,2,3)", "(1,2)", {"space origin", "2 numbers"}},
               {"spacings: 1 2 3", "data file: none.raw", {"none.raw", "No such file"}},
               {"spacings: 1 2 3", "data file: LIST", {"several files"}},
               {"spacings: 1 2 3", "data file: x%03d.raw 1 9 1", {"several files"}},
               {"spacings: 1 2 3", "data file: .", {"folder"}},
               {"spacings: 1 2 3", "byte skip: -2", {"byte skip"}},
               {"spacings: 1 2 3", "byte skip: 1e18", {"byte skip"}},
               {"spacings: 1 2 3", "byte skip: 100", {"truncated"}},
               {"spacings: 1 2 3", "line skip: -1", {"line skip"}},
               {"spacings: 1 2 3", "line skip: 500", {"line skip"}}});
}

TEST(VolumeFilesErrors, MetaImageHeadersAreRefusedByCause) {
    const TemporaryFolder folder;
    const Volume volume{.size = {5, 4, 3}, .values = std::vector<double>(60, 1)};
    const auto path = folder / "a.mha";
    write_bytes(path, mhd_text(volume, "ElementSpacing = 1 2 3\n", "LOCAL") + volume.bytes());
    expect_refused(path,
                   {{"ObjectType = Image", "ObjectType = Tube", {"'Tube'"}},
                    {"ObjectType = Image", "just text", {"not a MetaImage header"}},
                    {"NDims = 3", "NDims = 2", {"NDims", "2"}},
                    {"NDims = 3\n", "", {"no NDims"}},
                    {"NDims = 3", "NDims = 3\nNDims = 3", {"twice"}},
                    {"BinaryData = True", "BinaryData = False", {"BinaryData"}},
                    {"MSB = False", "MSB = Perhaps", {"'Perhaps'"}},
                    {"5 4 3", "5 4 0", {"DimSize", "0"}},
                    {"5 4 3", "5 4", {"DimSize", "2 numbers"}},
                    {"5 4 3", "5 4 400", {"truncated"}},
                    {"5 4 3", "5 4 1e30", {"2^28"}},
                    {"MET_SHORT", "MET_LONG", {"'MET_LONG'", "MET_DOUBLE"}},
                    {"1 2 3", "1 2 nan", {"ElementSpacing", "'nan'"}},
                    {"1 2 3", "1 0 3", {"no inverse"}},
                    {"ElementSpacing = 1 2 3", "TransformMatrix = 1 0 0", {"TransformMatrix", "9"}},
                    {"ElementSpacing = 1 2 3", "ElementNumberOfChannels = 3", {"3"}},
                    {"ElementSpacing = 1 2 3", "HeaderSize = -2", {"HeaderSize"}},
                    {"ElementSpacing = 1 2 3", "HeaderSize = 1000000", {"truncated"}},
                    {"ElementSpacing = 1 2 3", "CompressedData = True", {"damaged"}},
                    {"LOCAL", "none.raw", {"none.raw", "No such file"}},
                    {"LOCAL", "LIST", {"several files"}},
                    {"LOCAL", "x.%03d 1 3 1", {"several files"}},
                    {"ElementDataFile = LOCAL", "X = Y", {""}}});
}

TEST(VolumeFilesErrors, NiftiHeadersAreRefusedByCause) {
    const TemporaryFolder folder;
    const Volume good{
        .type = SampleType::UInt8, .size = {3, 2, 2}, .values = std::vector<double>(12, 1)};
    const auto path = folder / "a.nii";
    const auto expect = [&](const std::string& bytes, const std::vector<std::string>& words) {
        for (const bool is_compressed : {false, true}) {
            const auto file = is_compressed ? folder / "a.nii.gz" : path;
            write_bytes(file, is_compressed ? compressed(bytes, true) : bytes);
            const std::string message = reading_error(file);
            EXPECT_THAT(message, HasSubstr(file.filename()));
            for (const std::string& word : words) EXPECT_THAT(message, HasSubstr(word));
        }
    };
    const auto with = [&](const Nifti& nifti) { return nifti_bytes(good, nifti); };
    const double nan = std::numeric_limits<double>::quiet_NaN();
    expect(with({.magic = std::string("ni1\0", 4)}), {"another file"});
    expect(with({.magic = "abcd"}), {"not a NIfTI file"});
    expect(std::string(400, 'x'), {"not a NIfTI file"});
    std::string second = with({});
    second.replace(0, 4, std::string("\x1c\x02\0\0", 4));
    expect(second, {"NIfTI-2"});
    expect(with({.dimensions = 2}), {"2 dimensions"});
    expect(with({.dimensions = 9}), {"9 dimensions"});
    expect(with({.dimensions = 4, .volumes = 5}), {"5 volumes"});
    expect(with({.data_offset = 0}), {"vox_offset"});
    expect(with({.data_offset = 352.5}), {"vox_offset"});
    expect(with({.data_offset = nan}), {"vox_offset"});
    expect(with({.data_offset = 353}), {"truncated"});
    expect(with({.spacing = {1, 1, 0, 1}}), {"pixdim"});
    expect(with({.spacing = {1, 1, -1, 1}}), {"pixdim"});
    expect(with({.qform_code = 1, .quaternion = {1, 1, 0}}), {"quaternion"});
    expect(with({.qform_code = 1, .quaternion = {nan, 0, 0}}), {"quaternion"});
    expect(with({.sform_code = 1}), {"no inverse"});
    expect(with({.slope = 1, .intercept = nan}), {"scl_inter"});
    std::string type = with({});
    type[70] = static_cast<char>(128); // RGB
    expect(type, {"datatype", "128", "int16"});
    std::string size = with({});
    size[42] = 0;
    expect(size, {"dim[1]"});
}

TEST(VolumeFilesErrors, ASampleThatIsNoNumberIsFoundWhenAskedFor) {
    const TemporaryFolder folder;
    Volume volume{
        .type = SampleType::Float, .size = {4, 5, 6}, .values = std::vector<double>(120, 1)};
    volume.values[3 + 4 * (2 + 5 * 1)] = std::numeric_limits<double>::quiet_NaN();
    for (const auto& path : write_all(volume, folder)) {
        const std::string message = reading_error(path);
        EXPECT_THAT(message, HasSubstr(path.filename()));
        EXPECT_THAT(message, HasSubstr("sample (3, 2, 1) is nan"));
    }
}

TEST(VolumeFilesErrors, GridNamesAreForVdbFilesOnly) {
    const TemporaryFolder folder;
    Random random(10);
    write_all(random_volume(random), folder);
    EXPECT_THAT(message_of<InputError>([&] { read_field(folder / "raw.nii", "density"); }),
                HasSubstr("'density'"));
    // Of a file without a line's end only the first part is looked at.
    for (const char* name : {"zero.nrrd", "zero.mha", "zero.nii"})
        write_sparse(folder / name, std::int64_t{8} << 30, 0, "NRRD0004");
    EXPECT_THAT(reading_error(folder / "zero.nrrd"), HasSubstr("unknown version"));
    EXPECT_THAT(reading_error(folder / "zero.mha"), HasSubstr("not a MetaImage header"));
    EXPECT_THAT(reading_error(folder / "zero.nii"), HasSubstr("not a NIfTI file"));
    std::filesystem::create_directory(folder / "folder.nii");
    EXPECT_THAT(reading_error(folder / "folder.nii"), HasSubstr("is a folder"));
    EXPECT_THAT(reading_error(folder / "none.nrrd"), HasSubstr("No such file"));
    for (const char* name : {"e.nrrd", "e.mhd", "e.nii", "e.nii.gz"}) {
        write_bytes(folder / name, "");
        EXPECT_THAT(reading_error(folder / name), HasSubstr(name));
    }
}

// Nothing but a field or an InputError comes of any header; it only checks that nothing crashes.
TEST(VolumeFilesErrors, MutatedFilesAreFieldsOrErrorsAndNeverACrash) {
    Random random(11);
    const TemporaryFolder folder;
    const Volume volume{.type = SampleType::Float,
                        .size = {7, 6, 5},
                        .values = random_values(random, SampleType::Float, 210)};
    int fields = 0;
    int errors = 0;
    for (const auto& path : write_all(volume, folder)) {
        const std::string good = contents_of(path);
        for (int i = 0; i < 150; ++i) {
            std::string bytes = good;
            for (int flips = random_int(random, 1, 3); flips > 0; --flips) {
                const auto at = static_cast<std::size_t>(
                    random_int(random, 0, std::min<int>(400, static_cast<int>(bytes.size()) - 1)));
                bytes[at] =
                    static_cast<char>(i % 2 == 0 ? random_int(random, 0, 255)
                                                 : bytes[at] ^ 1 << random_int(random, 0, 7));
            }
            write_bytes(path, bytes);
            try {
                for (const GridDescription& grid : describe_field_file(path))
                    EXPECT_GT(grid.active_voxels, 0);
                const auto field = read_field(path);
                const IndexBox extent = field->extent();
                copied(*field, intersection(extent, {Index3::Zero(), Index3::Constant(9)}));
                copied(*field, {extent.hi, extent.hi + Index3::Constant(2)});
                suggested_iso(*field);
                ++fields;
            } catch (const InputError& error) {
                const std::string message = error.what();
                EXPECT_THAT(message, HasSubstr(folder.path().string()));
                EXPECT_TRUE(std::ranges::none_of(message, [](unsigned char c) { return c < 0x20; }))
                    << message;
                ++errors;
            }
        }
        write_bytes(path, good);
    }
    EXPECT_GT(fields, 200); // flips in samples, comments, keys that nobody reads
    EXPECT_GT(errors, 200);
}

// ----------------------------------------------------------------------------------------------
// MRI

// Debian's package mricron-data: a head, 181 x 217 x 181 samples of 8 bits, a millimetre apart.
TEST(VolumeFiles, AHeadIsReadAndItsSkinSuggested) {
    const std::filesystem::path path = "/usr/share/mricron/templates/ch2.nii.gz";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << path << " (mricron-data)";
    const auto field = read_field(path);
    EXPECT_EQ(field->extent().size(), Index3(181, 217, 181));
    EXPECT_EQ(describe_field_file(path).at(0).value_type, "uint8");
    EXPECT_DOUBLE_EQ(field->space().voxel_size_world(), 1);
    const SuggestedIso suggested = suggested_iso(*field);
    // Between air (below 10) and tissue (80 and above).
    EXPECT_GT(suggested.iso, 20);
    EXPECT_LT(suggested.iso, 90);
}

} // namespace
} // namespace isocast::test
