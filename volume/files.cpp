// Which reader a field file's extension calls for.
// SPDX-License-Identifier: MPL-2.0
#include "volume/files.h"

#include "volume/errors.h"
#include "volume/vdb_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

namespace isocast {

namespace {

void require_field_file(const std::filesystem::path& path) {
    if (is_field_file(path)) return;
    throw InputError(fmt::format("{}: not a field file by its extension (known: {})", path.string(),
                                 field_file_extensions()));
}

} // namespace

bool is_field_file(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    std::ranges::transform(extension, extension.begin(),
                           [](unsigned char c) { return std::tolower(c); });
    return extension == ".vdb";
}

std::string field_file_extensions() {
    return ".vdb";
}

std::unique_ptr<FieldSource> read_field(const std::filesystem::path& path,
                                        const std::string& grid_name) {
    require_field_file(path);
    return std::make_unique<SparseField>(read_vdb(path, grid_name));
}

std::vector<GridDescription> describe_field_file(const std::filesystem::path& path) {
    require_field_file(path);
    return describe_vdb(path);
}

} // namespace isocast
