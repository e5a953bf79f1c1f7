// MetaImage files: a header, and the samples in a file beside it.
// SPDX-License-Identifier: MPL-2.0
#include "volume/dense_file.h"
#include "volume/files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace isocast {

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
