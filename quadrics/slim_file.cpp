// SPDX-License-Identifier: MPL-2.0
#include "quadrics/slim_file.h"

#include "volume/atomic_file.h"
#include "volume/checksum.h"
#include "volume/errors.h"
#include "volume/mapped_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace isocast {

namespace {

constexpr std::string_view magic = "isoSLIM\n"; // a transfer as text would change its end
constexpr std::uint32_t version = 1;

struct Header {
    char magic[8];
    std::uint32_t version;
    std::uint32_t is_closed; // 0 or 1
    std::uint64_t patches;
    double max_error_world;
};
static_assert(sizeof(Header) == 32 && std::endian::native == std::endian::little);

struct Record {
    double centre[3];
    double radius;
    double normal[3];
    double height[6];
    double planes[2][4]; // normal, offset; 0 where there is none
    std::uint32_t plane_count;
    std::uint32_t is_any; // 0 or 1
};
static_assert(sizeof(Record) == 176);

template<class Value>
Value value_at(std::string_view bytes, std::size_t at) {
    Value value;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

} // namespace

bool is_slim_file(const std::filesystem::path& path) {
    return path.extension() == ".slim";
}

void write_slim(const SlimSurface& surface, const std::filesystem::path& path) {
    check(surface);
    Header header{
        {}, version, surface.is_closed ? 1U : 0U, surface.patches.size(), surface.max_error_world};
    std::memcpy(header.magic, magic.data(), magic.size());
    std::string text;
    text += bytes_of(header);
    for (const SlimPatch& patch : surface.patches) {
        Record record{};
        const auto put_vector = [](double* to, const Vec3d& v) { std::copy_n(v.data(), 3, to); };
        put_vector(record.centre, patch.centre_world);
        record.radius = patch.radius_world;
        put_vector(record.normal, patch.normal);
        std::ranges::copy(patch.height, record.height);
        for (std::size_t k = 0; k < static_cast<std::size_t>(patch.plane_count); ++k) {
            put_vector(record.planes[k], patch.planes[k].normal);
            record.planes[k][3] = patch.planes[k].offset_world;
        }
        record.plane_count = static_cast<std::uint32_t>(patch.plane_count);
        record.is_any = patch.is_any ? 1 : 0;
        text += bytes_of(record);
    }
    text += bytes_of(checksum(text));
    write_text_file(text, path);
}

SlimSurface read_slim(const std::filesystem::path& path) {
    const MappedFile file(path);
    const std::string_view bytes(reinterpret_cast<const char*>(file.bytes().data()),
                                 file.bytes().size());
    const auto fail = [&](const std::string& what) {
        throw InputError(fmt::format("cannot read {}: {}", path.string(), what));
    };
    if (!bytes.starts_with(magic)) fail("it is no SLIM file");
    constexpr std::size_t sum_size = sizeof(std::uint32_t);
    if (bytes.size() < sizeof(Header) + sum_size) fail("it ends within its header");
    const auto header = value_at<Header>(bytes, 0);
    if (header.version != version)
        fail(fmt::format("it is of version {}, not {}", header.version, version));
    const std::size_t rest = bytes.size() - sizeof(Header) - sum_size;
    // By a division, since the product may wrap around.
    if (rest % sizeof(Record) != 0 || rest / sizeof(Record) != header.patches)
        fail(fmt::format("its length is not that of {} patches", header.patches));
    const std::string_view summed = bytes.substr(0, bytes.size() - sum_size);
    if (bytes.substr(summed.size()) != bytes_of(checksum(summed)))
        fail("it is damaged: the checksum differs");
    if (header.is_closed > 1) fail("a flag of it is neither 0 nor 1");
    SlimSurface surface{.patches = {},
                        .max_error_world = header.max_error_world,
                        .is_closed = header.is_closed == 1};
    surface.patches.reserve(header.patches);
    for (std::size_t i = 0; i < header.patches; ++i) {
        const auto record = value_at<Record>(bytes, sizeof(Header) + i * sizeof(Record));
        if (record.plane_count > 2 || record.is_any > 1)
            fail(fmt::format("patch {} has a number that is too great", i));
        SlimPatch& patch = surface.patches.emplace_back();
        patch.centre_world = Eigen::Map<const Vec3d>(record.centre);
        patch.radius_world = record.radius;
        patch.normal = Eigen::Map<const Vec3d>(record.normal);
        std::ranges::copy(record.height, patch.height.begin());
        patch.plane_count = static_cast<int>(record.plane_count);
        patch.is_any = record.is_any == 1;
        for (std::size_t k = 0; k < record.plane_count; ++k)
            patch.planes[k] = {Eigen::Map<const Vec3d>(record.planes[k]), record.planes[k][3]};
    }
    try {
        check(surface);
    } catch (const InputError& error) {
        fail(error.what());
    }
    return surface;
}

} // namespace isocast
