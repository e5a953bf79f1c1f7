// NRRD files: read with any header, written with an attached one.
// SPDX-License-Identifier: MPL-2.0
#include "volume/dense_file.h"
#include "volume/files.h"
#include "volume/volume_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace isocast {

namespace {

// ---------------------------------------------------------------------------------------- reading

/// The fields of the format's definition, without "datafile" and the like that are other spellings.
constexpr std::array known_fields = {"axis maxs",
                                     "axis mins",
                                     "block size",
                                     "byte skip",
                                     "centers",
                                     "centerings",
                                     "content",
                                     "data file",
                                     "dimension",
                                     "encoding",
                                     "endian",
                                     "kinds",
                                     "labels",
                                     "line skip",
                                     "max",
                                     "measurement frame",
                                     "min",
                                     "number",
                                     "old max",
                                     "old min",
                                     "sample units",
                                     "sizes",
                                     "space",
                                     "space dimension",
                                     "space directions",
                                     "space origin",
                                     "space units",
                                     "spacings",
                                     "thicknesses",
                                     "type",
                                     "units"};

using Fields = std::map<std::string, std::string>;

std::string field_name(std::string_view written) {
    const std::string name = lower_case(trimmed(written));
    for (const auto& [spelling, field] :
         {std::pair("datafile", "data file"), std::pair("lineskip", "line skip"),
          std::pair("byteskip", "byte skip"), std::pair("oldmin", "old min"),
          std::pair("oldmax", "old max"), std::pair("axismins", "axis mins"),
          std::pair("axismaxs", "axis maxs"), std::pair("sampleunits", "sample units"),
          std::pair("blocksize", "block size")})
        if (name == spelling) return field;
    return name;
}

struct NrrdText {
    Fields fields;
    /// Where the samples begin in a file that holds them; absent if the header fills the file.
    std::optional<std::size_t> end;
};

NrrdText parsed(std::string_view text, const std::filesystem::path& path) {
    const std::size_t all = text.size();
    const std::string_view magic = next_line(text);
    if (!magic.starts_with("NRRD")) cannot_read(path, "not an NRRD file");
    if (magic.size() != 8 || magic.substr(4) < "0001" || magic.substr(4) > "0005")
        cannot_read(path, fmt::format("NRRD of an unknown version: '{}' (known: NRRD0001 to "
                                      "NRRD0005)",
                                      shown(magic)));
    NrrdText header;
    while (!text.empty()) {
        const std::string_view line = next_line(text);
        if (line.empty()) {
            header.end = all - text.size();
            break;
        }
        if (line.starts_with('#')) continue;
        const std::size_t colon = line.find(':');
        if (colon == std::string_view::npos)
            cannot_read(path,
                        fmt::format("line '{}' is neither a field nor a comment", shown(line)));
        if (line.substr(colon).starts_with(":=")) continue; // a key and value of the user's
        const std::string name = field_name(line.substr(0, colon));
        if (std::ranges::find(known_fields, name) == known_fields.end())
            cannot_read(path, fmt::format("unknown field '{}' (known: {})", shown(name),
                                          fmt::join(known_fields, ", ")));
        if (!header.fields.emplace(name, trimmed(line.substr(colon + 1))).second)
            cannot_read(path, fmt::format("field '{}' occurs twice", name));
    }
    return header;
}

SampleType sample_type(const std::string& written, const std::filesystem::path& path) {
    struct Names {
        SampleType type;
        std::vector<std::string_view> names;
    };
    const std::array known = {
        Names{SampleType::Int8, {"signed char", "char", "int8", "int8_t"}},
        Names{SampleType::UInt8, {"uchar", "unsigned char", "uint8", "uint8_t"}},
        Names{SampleType::Int16,
              {"short", "short int", "signed short", "signed short int", "int16", "int16_t"}},
        Names{SampleType::UInt16,
              {"ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"}},
        Names{SampleType::Int32, {"int", "signed int", "int32", "int32_t"}},
        Names{SampleType::UInt32, {"uint", "unsigned int", "uint32", "uint32_t"}},
        Names{SampleType::Float, {"float"}},
        Names{SampleType::Double, {"double"}}};
    const std::string name = lower_case(written);
    for (const Names& names : known)
        if (std::ranges::find(names.names, name) != names.names.end()) return names.type;
    cannot_read(path, fmt::format("type: '{}' cannot be read (known: int8, uint8, int16, uint16, "
                                  "int32, uint32, float, double)",
                                  written));
}

/// The vectors "(x,y,z) (x,y,z) …" of the field `name`.
std::vector<Vec3d> vectors_of(std::string text, std::size_t count,
                              const std::filesystem::path& path, std::string_view name) {
    std::vector<Vec3d> vectors;
    for (std::string_view rest = trimmed(text); !rest.empty(); rest = trimmed(rest)) {
        const std::size_t close = rest.find(')');
        if (!rest.starts_with('(') || close == std::string_view::npos)
            cannot_read(path, fmt::format("{}: '{}' is not a vector (x,y,z)", name, rest));
        std::string inner(rest.substr(1, close - 1));
        std::ranges::replace(inner, ',', ' ');
        vectors.emplace_back(numbers_of(inner, 3, path, name).data());
        rest.remove_prefix(close + 1);
    }
    if (vectors.size() != count)
        cannot_read(path, fmt::format("{}: {} vectors, not {}", name, vectors.size(), count));
    return vectors;
}

GridSpace space_of(const Fields& fields, const std::filesystem::path& path) {
    GridSpace space;
    if (const auto directions = fields.find("space directions"); directions != fields.end()) {
        const auto axes = vectors_of(directions->second, 3, path, "space directions");
        for (int axis = 0; axis < 3; ++axis)
            space.world_from_index.linear().col(axis) = axes[static_cast<std::size_t>(axis)];
    } else if (const auto spacings = fields.find("spacings"); spacings != fields.end()) {
        const std::vector<std::string_view> words = words_of(spacings->second);
        if (words.size() != 3)
            cannot_read(path, fmt::format("spacings: {} numbers, not 3", words.size()));
        for (int axis = 0; axis < 3; ++axis) {
            const std::string_view word = words[static_cast<std::size_t>(axis)];
            const std::optional<double> spacing = number_of(word);
            // NaN is the format's word for a spacing that is not known; 1 is that of no field.
            if (spacing && std::isnan(*spacing)) continue;
            space.world_from_index.linear()(axis, axis) = numbers_of(word, 1, path, "spacings")[0];
        }
    }
    if (const auto origin = fields.find("space origin"); origin != fields.end())
        space.world_from_index.translation() =
            vectors_of(origin->second, 1, path, "space origin")[0];
    return space;
}

/// The file of the samples where the header stands alone.
std::filesystem::path data_path(const std::string& written, const std::filesystem::path& path) {
    if (written.starts_with("LIST") || written.find('%') != std::string::npos)
        cannot_read(path, "data file: several files for one volume cannot be read");
    if (written.empty()) cannot_read(path, "data file: no name");
    return path.parent_path() / written; // an absolute name stays as it is
}

/// Bytes of the first `count` lines.
std::size_t size_of_lines(std::string_view text, std::int64_t count,
                          const std::filesystem::path& path) {
    const std::size_t all = text.size();
    for (std::int64_t i = 0; i < count; ++i) {
        if (text.empty()) cannot_read(path, fmt::format("line skip: no {} lines there", count));
        next_line(text);
    }
    return all - text.size();
}

std::string_view text_of(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

} // namespace

VolumeHeader nrrd_header(const std::filesystem::path& path) {
    const MappedFile file(path);
    const NrrdText text = parsed(header_text(file), path);
    const Fields& fields = text.fields;
    for (const char* name : {"dimension", "type", "encoding", "sizes"})
        if (!fields.contains(name)) cannot_read(path, fmt::format("no field '{}'", name));
    if (fields.at("dimension") != "3")
        cannot_read(path, fmt::format("dimension: {}; only volumes of 3 can be read",
                                      fields.at("dimension")));
    VolumeHeader header;
    header.type = sample_type(fields.at("type"), path);
    header.size = size_of(fields.at("sizes"), path, "sizes");
    header.space = space_of(fields, path);
    const std::string encoding = lower_case(fields.at("encoding"));
    if (encoding != "raw" && encoding != "gzip" && encoding != "gz")
        cannot_read(path,
                    fmt::format("encoding: '{}' cannot be read (known: raw, gzip)", encoding));
    header.is_compressed = encoding != "raw";
    if (const auto endian = fields.find("endian"); endian != fields.end()) {
        const std::string order = lower_case(endian->second);
        if (order != "little" && order != "big")
            cannot_read(path, fmt::format("endian: '{}' (known: little, big)", order));
        header.byte_order = order == "little" ? std::endian::little : std::endian::big;
    } else if (byte_count(header.type) > 1) {
        cannot_read(path, fmt::format("no field 'endian' for samples of {}", name_of(header.type)));
    }

    const auto number = [&](const char* name) {
        const auto found = fields.find(name);
        return found == fields.end() ? 0 : integer_of(found->second, path, name);
    };
    const std::int64_t lines = number("line skip");
    const std::int64_t bytes = number("byte skip");
    if (lines < 0) cannot_read(path, fmt::format("line skip: {} is negative", lines));
    if (bytes < (header.is_compressed ? 0 : -1))
        cannot_read(path, fmt::format("byte skip: {} is negative", bytes));
    if (const auto name = fields.find("data file"); name != fields.end()) {
        header.data_path = data_path(name->second, path);
        header.is_beside = true;
    } else {
        if (!text.end) cannot_read(path, "no blank line ends its header: truncated");
        header.data_path = path;
        header.skip = static_cast<std::int64_t>(*text.end);
    }
    if (lines > 0) {
        const auto data = map_samples(header, path);
        header.skip += static_cast<std::int64_t>(size_of_lines(
            text_of(data->bytes().subspan(static_cast<std::size_t>(header.skip))), lines, path));
    }
    if (header.is_compressed)
        header.skip_decompressed = static_cast<std::uint64_t>(bytes);
    else
        header.skip = bytes < 0 ? -1 : header.skip + bytes;

    header.metadata["format"] = "NRRD, " + encoding;
    for (const char* name : {"content", "space", "space units", "units", "sample units"})
        if (const auto found = fields.find(name); found != fields.end())
            header.metadata[name] = found->second;
    return header;
}

// ---------------------------------------------------------------------------------------- writing

void write_nrrd(const FieldSource& field, const std::filesystem::path& path,
                const Progress& progress) {
    const IndexBox box = field.extent();
    DenseFile file(path, dense_byte_count(field, path));
    const auto vector = [](const Vec3d& v) {
        return fmt::format("({},{},{})", v.x(), v.y(), v.z());
    };
    const Mat3d axes = field.space().world_from_index.linear();
    // Doubles print as the shortest text that reads back as the same double.
    file.write(fmt::format("NRRD0004\n"
                           "# isocast\n"
                           "type: float\n"
                           "dimension: 3\n"
                           "space dimension: 3\n"
                           "sizes: {} {} {}\n"
                           "space directions: {} {} {}\n"
                           "kinds: domain domain domain\n"
                           "endian: little\n"
                           "encoding: raw\n"
                           "space origin: {}\n"
                           "\n",
                           box.size().x(), box.size().y(), box.size().z(), vector(axes.col(0)),
                           vector(axes.col(1)), vector(axes.col(2)),
                           vector(field.space().to_world(box.lo.cast<double>()))));
    file.write_samples(field, progress);
    file.commit();
}

} // namespace isocast
