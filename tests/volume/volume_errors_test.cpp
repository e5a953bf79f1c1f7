// Volumes that cannot be read: the message names the file and the cause, and nothing crashes.
// SPDX-License-Identifier: MPL-2.0
#include "volume/errors.h"
#include "volume/files.h"
#include "volume/histogram.h"
#include "volume_writers.h"

#include <gmock/gmock.h>

namespace isocast::test {
namespace {

using ::testing::HasSubstr;

/// The message of the InputError on reading `path` and all its samples; describing alone may pass.
std::string reading_error(const std::filesystem::path& path) {
    return message_of<InputError>([&] {
        const auto field = read_field(path);
        copied(*field, field->extent());
    });
}

TEST(VolumeErrors, TruncatedFilesAreNamedAtEveryLength) {
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

TEST(VolumeErrors, MoreSamplesBesideThanTheHeaderSaysAreAWrongSize) {
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

TEST(VolumeErrors, DamagedCompressedSamplesAreNamed) {
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

TEST(VolumeErrors, NrrdHeadersAreRefusedByCause) {
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

TEST(VolumeErrors, MetaImageHeadersAreRefusedByCause) {
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

TEST(VolumeErrors, NiftiHeadersAreRefusedByCause) {
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

TEST(VolumeErrors, ASampleThatIsNoNumberIsFoundWhenAskedFor) {
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

TEST(VolumeErrors, GridNamesAreForVdbFilesOnly) {
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
TEST(VolumeErrors, MutatedFilesAreFieldsOrErrorsAndNeverACrash) {
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

} // namespace
} // namespace isocast::test
