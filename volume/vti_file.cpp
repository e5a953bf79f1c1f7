// VTK ImageData files: XML, then the samples as they are.
// SPDX-License-Identifier: MPL-2.0
#include "volume/dense_file.h"
#include "volume/files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <bit>

namespace isocast {

void write_vti(const FieldSource& field, const std::filesystem::path& path,
               const Progress& progress) {
    const IndexBox box = field.extent();
    const RightAngledAxes axes = right_angled_axes(field.space(), path);
    const std::uint64_t byte_count = dense_byte_count(field, path);
    DenseFile file(path, byte_count);
    const std::string extent = fmt::format("{} {} {} {} {} {}", box.lo.x(), box.hi.x() - 1,
                                           box.lo.y(), box.hi.y() - 1, box.lo.z(), box.hi.z() - 1);
    const auto numbers = [](const auto& values) {
        return fmt::format("{}", fmt::join(values, " "));
    };
    // The origin is that of index 0, which the extent need not hold; directions go row by row.
    file.write(fmt::format(
        "<?xml version=\"1.0\"?>\n"
        "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" "
        "header_type=\"UInt64\">\n"
        "<ImageData WholeExtent=\"{0}\" Origin=\"{1}\" Spacing=\"{2}\" Direction=\"{3}\">\n"
        "<Piece Extent=\"{0}\">\n"
        "<PointData Scalars=\"field\">\n"
        "<DataArray type=\"Float32\" Name=\"field\" format=\"appended\" offset=\"0\"/>\n"
        "</PointData>\n"
        "</Piece>\n"
        "</ImageData>\n"
        "<AppendedData encoding=\"raw\">\n_",
        extent, numbers(Vec3d(field.space().world_from_index.translation())),
        numbers(axes.spacing_world), numbers(axes.directions.transpose().reshaped())));
    const auto header = std::bit_cast<std::array<char, sizeof byte_count>>(byte_count);
    file.write({header.data(), header.size()});
    file.write_samples(field, progress);
    file.write("\n</AppendedData>\n</VTKFile>\n");
    file.commit();
}

} // namespace isocast
