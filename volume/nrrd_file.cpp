// NRRD files with attached header.
// SPDX-License-Identifier: MPL-2.0
#include "volume/dense_file.h"
#include "volume/files.h"

#include <fmt/format.h>

namespace isocast {

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
