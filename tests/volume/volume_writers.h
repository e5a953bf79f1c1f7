// Volumes as other programs write them, made from known values without the code under test.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "temporary_folder.h"
#include "typed_bytes.h"

#include <fcntl.h>
#include <unistd.h>
#include <zlib.h>

#include <fstream>
#include <sstream>

namespace isocast::test {

inline constexpr std::endian both_orders[] = {std::endian::little, std::endian::big};

inline std::string contents_of(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream bytes;
    bytes << file.rdbuf();
    return bytes.str();
}

inline void write_bytes(const std::filesystem::path& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
}

/// `bytes` as gzip or zlib compress them.
inline std::string compressed(const std::string& bytes, bool gzip) {
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

inline Volume random_volume(Random& random, SampleType type = SampleType::Int16,
                            std::endian order = std::endian::little) {
    Volume volume{.type = type, .order = order, .size = random_box(random, 0, 0, 9).size()};
    volume.values =
        random_values(random, type, static_cast<std::size_t>(volume.size.cast<int>().prod()));
    return volume;
}

// ------------------------------------------------------------------------ writers of these formats

inline constexpr const char* nrrd_types[] = {"signed char", "uchar", "short", "unsigned short",
                                             "int",         "uint",  "float", "double"};
inline constexpr const char* mhd_types[] = {"MET_CHAR", "MET_UCHAR", "MET_SHORT", "MET_USHORT",
                                            "MET_INT",  "MET_UINT",  "MET_FLOAT", "MET_DOUBLE"};
inline constexpr int nifti_types[] = {256, 2, 4, 512, 8, 768, 16, 64};
inline constexpr int nifti_bits[] = {8, 8, 16, 16, 32, 32, 32, 64};

inline std::string nrrd_text(const Volume& volume, const std::string& encoding,
                             const std::string& more) {
    std::ostringstream text;
    text << "NRRD0004\n# made by a test\ntype: " << nrrd_types[static_cast<int>(volume.type)]
         << "\ndimension: 3\nsizes: " << volume.size_text() << "\nencoding: " << encoding
         << "\nendian: " << (volume.order == std::endian::little ? "little" : "big") << "\n"
         << more << "key:=value: with colon\n";
    return text.str();
}

inline std::string mhd_text(const Volume& volume, const std::string& more,
                            const std::string& data) {
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

inline std::string nifti_bytes(const Volume& volume, const Nifti& nifti = {}) {
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
inline std::vector<std::filesystem::path> write_all(const Volume& volume,
                                                    const TemporaryFolder& folder) {
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

/// Makes `path` a file of `size` bytes, all holes but for `bytes` at `at`.
inline void write_sparse(const std::filesystem::path& path, std::int64_t size, std::int64_t at,
                         const std::string& bytes) {
    const int file = ::open(path.c_str(), O_CREAT | O_RDWR, 0600);
    ASSERT_GE(file, 0);
    ASSERT_EQ(::ftruncate(file, size), 0);
    ASSERT_EQ(::pwrite(file, bytes.data(), bytes.size(), at), std::ssize(bytes));
    ::close(file);
}

} // namespace isocast::test
