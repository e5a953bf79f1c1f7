// MetaImage files: read whole or in two, written as a header and the samples in a file beside it.
// SPDX-License-Identifier: MPL-2.0
#include "volume/dense_file.h"
#include "volume/files.h"
#include "volume/volume_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>

namespace isocast {

namespace {

// ---------------------------------------------------------------------------------------- reading

/// A header: "Key = value" lines, the last of which names the file of the samples.
class MhdText {
public:
    explicit MhdText(const std::filesystem::path& path) : path_(path) {
        const MappedFile file(path);
        std::string_view text = header_text(file);
        const std::size_t all = text.size();
        while (!text.empty()) {
            const std::string_view line = next_line(text);
            if (trimmed(line).empty()) continue;
            const std::size_t equals = line.find('=');
            if (equals == std::string_view::npos)
                cannot_read(path,
                            fmt::format("not a MetaImage header: line '{}' is not KEY = VALUE",
                                        shown(line)));
            const std::string key(trimmed(line.substr(0, equals)));
            if (!values_.emplace(key, trimmed(line.substr(equals + 1))).second)
                cannot_read(path, fmt::format("{} occurs twice", key));
            if (key == "ElementDataFile") {
                end_ = static_cast<std::int64_t>(all - text.size());
                return;
            }
        }
        cannot_read(path, "not a MetaImage header: no ElementDataFile");
    }

    /// The value of the first of `keys` that there is: the others are its older names.
    std::optional<std::string> find(std::initializer_list<const char*> keys) const {
        for (const char* key : keys)
            if (const auto found = values_.find(key); found != values_.end()) return found->second;
        return std::nullopt;
    }
    std::string at(const char* key) const {
        const auto value = find({key});
        if (!value) cannot_read(path_, fmt::format("no {}", key));
        return *value;
    }
    bool is_true(std::initializer_list<const char*> keys, bool otherwise) const {
        const auto value = find(keys);
        if (!value) return otherwise;
        // MetaIO looks at the first letter alone.
        if (value->starts_with('T') || value->starts_with('t') || *value == "1") return true;
        if (value->starts_with('F') || value->starts_with('f') || *value == "0") return false;
        cannot_read(path_,
                    fmt::format("{}: '{}' is neither True nor False", *keys.begin(), *value));
    }
    /// Numbers, or `otherwise` where no key is there.
    Vec3d vector(std::initializer_list<const char*> keys, const Vec3d& otherwise) const {
        const auto value = find(keys);
        return value ? Vec3d(numbers_of(*value, 3, path_, *keys.begin()).data()) : otherwise;
    }
    /// The first byte after the header.
    std::int64_t end() const { return end_; }

private:
    std::filesystem::path path_;
    std::map<std::string, std::string> values_;
    std::int64_t end_ = 0;
};

SampleType sample_type(const std::string& name, const std::filesystem::path& path) {
    constexpr std::array<std::pair<std::string_view, SampleType>, 8> known = {
        {{"MET_CHAR", SampleType::Int8},
         {"MET_UCHAR", SampleType::UInt8},
         {"MET_SHORT", SampleType::Int16},
         {"MET_USHORT", SampleType::UInt16},
         {"MET_INT", SampleType::Int32},
         {"MET_UINT", SampleType::UInt32},
         {"MET_FLOAT", SampleType::Float},
         {"MET_DOUBLE", SampleType::Double}}};
    std::vector<std::string_view> names;
    for (const auto& [known_name, type] : known) {
        if (known_name == name) return type;
        names.push_back(known_name);
    }
    cannot_read(path, fmt::format("ElementType: '{}' cannot be read (known: {})", name,
                                  fmt::join(names, ", ")));
}

} // namespace

VolumeHeader mhd_header(const std::filesystem::path& path) {
    const MhdText text(path);
    if (const auto kind = text.find({"ObjectType"}); kind && *kind != "Image")
        cannot_read(path, fmt::format("ObjectType: '{}', not Image", *kind));
    if (integer_of(text.at("NDims"), path, "NDims") != 3)
        cannot_read(path,
                    fmt::format("NDims: {}; only volumes of 3 can be read", text.at("NDims")));
    if (!text.is_true({"BinaryData"}, true))
        cannot_read(path, "BinaryData: samples as text cannot be read");
    if (const auto channels = text.find({"ElementNumberOfChannels"});
        channels && integer_of(*channels, path, "ElementNumberOfChannels") != 1)
        cannot_read(path,
                    fmt::format("ElementNumberOfChannels: {}; only one can be read", *channels));
    VolumeHeader header;
    header.size = size_of(text.at("DimSize"), path, "DimSize");
    header.type = sample_type(text.at("ElementType"), path);
    header.byte_order = text.is_true({"BinaryDataByteOrderMSB", "ElementByteOrderMSB"}, false)
                            ? std::endian::big
                            : std::endian::little;
    header.is_compressed = text.is_true({"CompressedData"}, false);

    // Rows of the matrix, in the file's order, are the directions of the axes.
    Mat3d directions = Mat3d::Identity();
    if (const auto matrix = text.find({"TransformMatrix", "Rotation", "Orientation"}))
        directions = Mat3d(numbers_of(*matrix, 9, path, "TransformMatrix").data());
    const Vec3d spacing = text.vector({"ElementSpacing", "ElementSize"}, Vec3d::Ones());
    header.space.world_from_index.linear() = directions * spacing.asDiagonal();
    header.space.world_from_index.translation() =
        text.vector({"Offset", "Position", "Origin"}, Vec3d::Zero());

    const std::string name = text.at("ElementDataFile");
    if (name.empty()) cannot_read(path, "ElementDataFile: no name");
    if (name.starts_with("LIST") || name.find('%') != std::string::npos)
        cannot_read(path, "ElementDataFile: several files for one volume cannot be read");
    const bool is_local = name == "LOCAL" || name == "Local" || name == "local";
    header.is_beside = !is_local;
    header.data_path = is_local ? path : path.parent_path() / name;
    header.skip = is_local ? text.end() : 0;
    if (const auto skip = text.find({"HeaderSize"})) {
        const std::int64_t bytes = integer_of(*skip, path, "HeaderSize");
        if (bytes < -1 || (bytes < 0 && header.is_compressed))
            cannot_read(path, fmt::format("HeaderSize: {} is negative", bytes));
        // Counted from the file's begin; 0 is the same as no such key.
        if (bytes != 0) header.skip = bytes;
    }
    header.metadata["format"] = header.is_compressed ? "MetaImage, zlib" : "MetaImage, raw";
    for (const char* key : {"Comment", "AnatomicalOrientation", "Modality"})
        if (const auto value = text.find({key})) header.metadata[key] = *value;
    return header;
}

// ---------------------------------------------------------------------------------------- writing

void write_mhd(const FieldSource& field, const std::filesystem::path& path,
               const Progress& progress) {
    const IndexBox box = field.extent();
    const RightAngledAxes axes = right_angled_axes(field.space(), path);
    const Vec3d origin = field.space().to_world(box.lo.cast<double>());
    const auto raw_path = std::filesystem::path(path).replace_extension(".raw");
    DenseFile header(path, 0);
    DenseFile samples(raw_path, dense_byte_count(field, path));
    const auto numbers = [](const auto& values) {
        return fmt::format("{}", fmt::join(values, " "));
    };
    header.write(fmt::format("ObjectType = Image\n"
                             "NDims = 3\n"
                             "BinaryData = True\n"
                             "BinaryDataByteOrderMSB = False\n"
                             "CompressedData = False\n"
                             "TransformMatrix = {}\n"
                             "Offset = {}\n"
                             "CenterOfRotation = 0 0 0\n"
                             "ElementSpacing = {}\n"
                             "DimSize = {}\n"
                             "ElementType = MET_FLOAT\n"
                             "ElementDataFile = {}\n",
                             numbers(axes.directions.reshaped()), numbers(origin),
                             numbers(axes.spacing_world), numbers(box.size()),
                             raw_path.filename().string()));
    samples.write_samples(field, progress);
    samples.commit();
    header.commit();
}

} // namespace isocast
