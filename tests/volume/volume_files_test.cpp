// Volumes of other programs: NRRD, MetaImage and NIfTI, written here from known values.
// SPDX-License-Identifier: MPL-2.0
#include "volume/errors.h"
#include "volume/files.h"
#include "volume/histogram.h"
#include "volume_writers.h"

#include <gmock/gmock.h>

#ifdef ISOCAST_WITH_LIBNIFTI
#include <nifti1_io.h>
#endif

#include <chrono>

namespace isocast::test {
namespace {

using ::testing::HasSubstr;

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
    EXPECT_EQ(field_file_extensions(), ".vdb .hoct .nrrd .nhdr .mhd .mha .nii .nii.gz");
    EXPECT_THAT(message_of<InputError>([] { read_field("a.tif"); }), HasSubstr(".nii.gz"));
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

// ----------------------------------------------------------------------------- larger than memory

std::int64_t resident_bytes() {
    std::ifstream file("/proc/self/statm");
    std::int64_t size = 0;
    std::int64_t resident = 0;
    file >> size >> resident;
    return resident * ::sysconf(_SC_PAGESIZE);
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

// -------------------------------------------------------------------------------------------- MRI

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
