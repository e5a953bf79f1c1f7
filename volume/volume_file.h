// What the readers of dense files share: a header's words, and the samples that it describes.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/files.h"
#include "volume/mapped_file.h"
#include "volume/typed_field.h"

#include <string>
#include <string_view>
#include <vector>

namespace isocast {

/// Where a dense file's samples lie and what they are.
struct VolumeHeader {
    SampleType type = SampleType::Float;
    std::endian byte_order = std::endian::native;
    Index3 size = Index3::Zero();
    GridSpace space;
    double slope = 1; // value = slope * sample + intercept
    double intercept = 0;

    /// The file of the samples: the header's own, or one beside it that holds nothing else.
    std::filesystem::path data_path;
    bool is_beside = false;
    bool is_compressed = false; // gzip or zlib
    /// Bytes to skip at the file's begin; or, if negative, the samples are its last bytes.
    std::int64_t skip = 0;
    /// Bytes to skip of what was compressed, after decompression.
    std::uint64_t skip_decompressed = 0;

    std::map<std::string, std::string> metadata;
};

// One of each format reads the header alone. All throw InputError that names the file and the
// cause.

/// NRRD, samples in the file or beside it.
///
/// Without `space directions` the axes are the world's, `spacings` apart. The world is the space of
/// the file, whatever its name (left-posterior-superior, …).
/// source  teem.sourceforge.net/nrrd/format.html, NRRD0001 to NRRD0005
VolumeHeader nrrd_header(const std::filesystem::path& path);
/// MetaImage, samples in the file (LOCAL) or beside it.
/// source  itk.org/Wiki/MetaIO/Documentation, and MetaIO's metaImage.cxx where that is silent
VolumeHeader mhd_header(const std::filesystem::path& path);
/// NIfTI-1 in one file, compressed or not.
///
/// The map to the world is the sform, without one the qform, without either the spacing.
/// source  nifti.nimh.nih.gov/pub/dist/src/niftilib/nifti1.h, "3D IMAGE (VOLUME) ORIENTATION AND
///         LOCATION IN SPACE", methods 3, 2, 1
VolumeHeader nifti_header(const std::filesystem::path& path);

/// The field of a header's samples, in their type. Uncompressed ones are mapped, not loaded;
/// compressed ones are kept in memory, beyond memory_bytes in a scratch file.
/// throws  InputError if the file does not hold as many bytes as the header says
std::unique_ptr<TypedField> open_volume(const VolumeHeader& header,
                                        const std::filesystem::path& path, double memory_bytes);
/// The header as a grid's description; checks the size of uncompressed samples.
GridDescription describe_volume(const VolumeHeader& header, const std::filesystem::path& path);

/// The file of the samples.
/// throws  InputError that names the header at `path`, too
std::shared_ptr<const MappedFile> map_samples(const VolumeHeader& header,
                                              const std::filesystem::path& path);

/// throws  InputError "cannot read PATH: CAUSE"
[[noreturn]] void cannot_read(const std::filesystem::path& path, const std::string& cause);

// Words of text headers.

/// The part of a file that may be its header: the first 2^24 bytes. A file of zeros has no lines.
std::string_view header_text(const MappedFile& file);

/// Text of a file as messages show it: the first 60 bytes, '?' for control characters.
std::string shown(std::string_view text);
std::string_view trimmed(std::string_view text);
std::string lower_case(std::string_view text);
/// The parts of `text` between white space.
std::vector<std::string_view> words_of(std::string_view text);
/// A number that is all of `word`; nan and inf count. Absent if it is none.
std::optional<double> number_of(std::string_view word);
/// The numbers between white space in the value of the field `name`.
/// throws  InputError that names the file and the field unless they are `count` finite numbers
std::vector<double> numbers_of(std::string_view text, std::size_t count,
                               const std::filesystem::path& path, std::string_view name);
/// The same of one integer that a double holds exactly.
std::int64_t integer_of(std::string_view text, const std::filesystem::path& path,
                        std::string_view name);
/// Three counts of samples in 1 … 2^28.
Index3 size_of(std::string_view text, const std::filesystem::path& path, std::string_view name);
/// The text before the next line's end, without it; `text` becomes what follows.
std::string_view next_line(std::string_view& text);

} // namespace isocast
