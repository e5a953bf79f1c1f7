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
#include <vector>

namespace isocast {

namespace {

constexpr std::string_view magic = "isoSLIM\n"; // a transfer as text would change its end
constexpr std::uint32_t version = 3;

struct Header {
    char magic[8];
    std::uint32_t version;
    std::uint32_t is_closed; // 0 or 1
    std::uint64_t levels;
};
static_assert(sizeof(Header) == 24 && std::endian::native == std::endian::little);

struct LevelRecord {
    std::uint64_t patches;
    double max_error_world;
};
static_assert(sizeof(LevelRecord) == 16);

struct Record {
    double centre[3];
    double radius;
    double normal[3];
    double height[6];
    double errors;
    double planes[2][4]; // normal, offset; 0 where there is none
    std::uint32_t plane_count;
    std::uint32_t is_any; // 0 or 1
};
static_assert(sizeof(Record) == 184);

template<class Value>
Value value_at(std::string_view bytes, std::size_t at) {
    Value value;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

Record record_of(const SlimPatch& patch) {
    Record record{};
    const auto put_vector = [](double* to, const Vec3d& v) { std::copy_n(v.data(), 3, to); };
    put_vector(record.centre, patch.centre_world);
    record.radius = patch.radius_world;
    put_vector(record.normal, patch.normal);
    std::ranges::copy(patch.height, record.height);
    record.errors = patch.errors;
    for (std::size_t k = 0; k < static_cast<std::size_t>(patch.plane_count); ++k) {
        put_vector(record.planes[k], patch.planes[k].normal);
        record.planes[k][3] = patch.planes[k].offset_world;
    }
    record.plane_count = static_cast<std::uint32_t>(patch.plane_count);
    record.is_any = patch.is_any ? 1 : 0;
    return record;
}

SlimPatch patch_of(const Record& record) {
    SlimPatch patch{.centre_world = Eigen::Map<const Vec3d>(record.centre),
                    .radius_world = record.radius,
                    .normal = Eigen::Map<const Vec3d>(record.normal),
                    .plane_count = static_cast<int>(record.plane_count),
                    .is_any = record.is_any == 1,
                    .errors = record.errors};
    std::ranges::copy(record.height, patch.height.begin());
    for (std::size_t k = 0; k < record.plane_count; ++k)
        patch.planes[k] = {Eigen::Map<const Vec3d>(record.planes[k]), record.planes[k][3]};
    return patch;
}

} // namespace

bool is_slim_file(const std::filesystem::path& path) {
    return path.extension() == ".slim";
}

void write_slim(const SlimSurface& surface, const std::filesystem::path& path) {
    check(surface);
    Header header{{}, version, surface.is_closed ? 1U : 0U, surface.levels.size()};
    std::memcpy(header.magic, magic.data(), magic.size());
    std::string text;
    text += bytes_of(header);
    for (const SlimLevel& level : surface.levels)
        text += bytes_of(LevelRecord{level.patches.size(), level.max_error_world});
    for (const SlimLevel& level : surface.levels)
        for (const SlimPatch& patch : level.patches) text += bytes_of(record_of(patch));
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
    std::size_t at = sizeof(Header);
    std::size_t rest = bytes.size() - at - sum_size;
    // By divisions, since products may wrap around.
    if (rest / sizeof(LevelRecord) < header.levels)
        fail(fmt::format("it ends within the table of its {} levels", header.levels));
    std::vector<LevelRecord> levels;
    for (std::uint64_t i = 0; i < header.levels; ++i, at += sizeof(LevelRecord))
        levels.push_back(value_at<LevelRecord>(bytes, at));
    rest -= levels.size() * sizeof(LevelRecord);
    std::size_t patches = rest / sizeof(Record);
    for (const LevelRecord& level : levels) {
        if (level.patches > patches) fail("it ends within its patches");
        patches -= level.patches;
    }
    if (patches > 0 || rest % sizeof(Record) != 0) fail("it goes on after its last patch");
    const std::string_view summed = bytes.substr(0, bytes.size() - sum_size);
    if (bytes.substr(summed.size()) != bytes_of(checksum(summed)))
        fail("it is damaged: the checksum differs");
    if (header.is_closed > 1) fail("a flag of it is neither 0 nor 1");
    SlimSurface surface{.levels = {}, .is_closed = header.is_closed == 1};
    for (const LevelRecord& level : levels) {
        SlimLevel& to = surface.levels.emplace_back();
        to.max_error_world = level.max_error_world;
        to.patches.reserve(level.patches);
        for (std::uint64_t i = 0; i < level.patches; ++i, at += sizeof(Record)) {
            const auto record = value_at<Record>(bytes, at);
            if (record.plane_count > 2 || record.is_any > 1)
                fail(fmt::format("patch {} of level {} has a number that is too great", i,
                                 surface.levels.size() - 1));
            to.patches.push_back(patch_of(record));
        }
    }
    try {
        check(surface);
    } catch (const InputError& error) {
        fail(error.what());
    }
    return surface;
}

} // namespace isocast
