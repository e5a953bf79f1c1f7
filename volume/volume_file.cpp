// What the readers of dense files share.
// SPDX-License-Identifier: MPL-2.0
#include "volume/volume_file.h"

#include "volume/errors.h"
#include "volume/inflater.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

namespace isocast {

namespace {

using Bytes = std::span<const std::byte>;

std::string text_of(const Index3& size) {
    return fmt::format("{} x {} x {}", size.x(), size.y(), size.z());
}

/// Size of the samples in bytes.
/// throws  InputError if 64 bits do not hold it
std::uint64_t bytes_needed(const VolumeHeader& header, const std::filesystem::path& path) {
    const double count = header.size.cast<double>().prod();
    if (count * 8 > 0x1p60) // more than any disk
        cannot_read(path, fmt::format("{} samples are too many", text_of(header.size)));
    return static_cast<std::uint64_t>(count) * byte_count(header.type);
}

/// The part of the file that holds the samples, as it lies there.
Bytes stored_samples(const VolumeHeader& header, const std::filesystem::path& path, Bytes file) {
    const std::uint64_t needed = bytes_needed(header, path);
    const std::string samples =
        fmt::format("{} samples of {}", text_of(header.size), name_of(header.type));
    const std::string in = header.is_beside ? " in " + header.data_path.string() : "";
    if (header.skip > std::ssize(file))
        cannot_read(path, fmt::format("truncated: its samples begin at byte {} of {}{}",
                                      header.skip, file.size(), in));
    const Bytes rest = file.subspan(header.skip < 0 ? 0 : static_cast<std::size_t>(header.skip));
    if (header.is_compressed) {
        const double most = Inflater::most_bytes_from(rest.size());
        if (static_cast<double>(needed) + static_cast<double>(header.skip_decompressed) > most)
            cannot_read(path, fmt::format("truncated: {} are {} bytes, which {} compressed ones "
                                          "cannot hold{}",
                                          samples, needed, rest.size(), in));
        return rest;
    }
    if (rest.size() < needed)
        cannot_read(path, fmt::format("truncated: {} are {} bytes, but only {} are there{}",
                                      samples, needed, rest.size(), in));
    if (header.skip < 0) return rest.last(needed);
    if (header.is_beside && rest.size() > needed)
        cannot_read(path, fmt::format("wrong size: {} are {} bytes, but {} are there{}", samples,
                                      needed, rest.size(), in));
    return rest.first(needed);
}

/// Messages quote headers, which may hold anything.
std::string printable(std::string_view text) {
    std::string clean(text);
    std::ranges::replace_if(
        clean, [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
    return clean;
}

} // namespace

void cannot_read(const std::filesystem::path& path, const std::string& cause) {
    throw InputError(fmt::format("cannot read {}: {}", path.string(), printable(cause)));
}

std::shared_ptr<const MappedFile> map_samples(const VolumeHeader& header,
                                              const std::filesystem::path& path) {
    try {
        return std::make_shared<const MappedFile>(header.data_path);
    } catch (const InputError& error) {
        if (!header.is_beside) throw;
        throw InputError(
            fmt::format("while reading {}: {}", path.string(), printable(error.what())));
    }
}

std::unique_ptr<TypedField> open_volume(const VolumeHeader& header,
                                        const std::filesystem::path& path, double memory_bytes) {
    const auto file = map_samples(header, path);
    const Bytes stored = stored_samples(header, path, file->bytes());
    TypedSamples samples{.type = header.type,
                         .byte_order = header.byte_order,
                         .slope = header.slope,
                         .intercept = header.intercept,
                         .bytes = stored,
                         .owner = file};
    if (header.is_compressed) {
        try {
            const std::uint64_t needed = bytes_needed(header, path);
            const FreshMemory<std::byte> memory(medium_for(needed, memory_bytes));
            const auto buffer =
                std::make_shared<std::vector<std::byte, FreshMemory<std::byte>>>(needed, memory);
            Inflater inflater(stored, header.data_path.string());
            inflater.skip(header.skip_decompressed);
            inflater.read(*buffer);
            if (!inflater.is_at_end() && header.is_beside)
                cannot_read(path, fmt::format("wrong size: more than {} bytes for {} samples in {}",
                                              buffer->size(), text_of(header.size),
                                              header.data_path.string()));
            samples.bytes = *buffer;
            samples.owner = buffer;
        } catch (const ResourceError& error) {
            throw ResourceError(fmt::format("cannot read {}: {}", path.string(), error.what()));
        } catch (const std::bad_alloc&) {
            throw ResourceError(fmt::format("cannot read {}: no memory for {} samples of {}",
                                            path.string(), text_of(header.size),
                                            name_of(header.type)));
        }
    }
    return std::make_unique<TypedField>(path.string(), header.space, header.size,
                                        std::move(samples));
}

GridDescription describe_volume(const VolumeHeader& header, const std::filesystem::path& path) {
    stored_samples(header, path, map_samples(header, path)->bytes());
    return {.name = path.filename().string(),
            .grid_class = "dense",
            .value_type = std::string(name_of(header.type)),
            .world_from_index = header.space.world_from_index,
            .active_voxels = IndexBox{Index3::Zero(), header.size}.sample_count(),
            .active_box = {Index3::Zero(), header.size},
            .metadata = header.metadata};
}

std::string_view header_text(const MappedFile& file) {
    const Bytes bytes = file.bytes().first(std::min(file.bytes().size(), std::size_t{1} << 24));
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string shown(std::string_view text) {
    return printable(text.substr(0, 60));
}

std::string_view trimmed(std::string_view text) {
    constexpr std::string_view white = " \t\r\n\v\f";
    const std::size_t first = text.find_first_not_of(white);
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(white) - first + 1);
}

std::string lower_case(std::string_view text) {
    std::string lower(text);
    std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return std::tolower(c); });
    return lower;
}

std::vector<std::string_view> words_of(std::string_view text) {
    std::vector<std::string_view> words;
    for (text = trimmed(text); !text.empty(); text = trimmed(text)) {
        const std::size_t end = std::min(text.find_first_of(" \t\r\n\v\f"), text.size());
        words.push_back(text.substr(0, end));
        text.remove_prefix(end);
    }
    return words;
}

std::optional<double> number_of(std::string_view word) {
    if (word.starts_with('+')) word.remove_prefix(1);
    double value = 0;
    const char* const last = word.data() + word.size();
    const auto [end, error] = std::from_chars(word.data(), last, value);
    if (error != std::errc{} || end != last) return std::nullopt;
    return value;
}

std::vector<double> numbers_of(std::string_view text, std::size_t count,
                               const std::filesystem::path& path, std::string_view name) {
    std::vector<double> numbers;
    for (const std::string_view word : words_of(text)) {
        const std::optional<double> number = number_of(word);
        if (!number || !std::isfinite(*number))
            cannot_read(path, fmt::format("{}: '{}' is not a finite number", name, shown(word)));
        numbers.push_back(*number);
    }
    if (numbers.size() != count)
        cannot_read(path, fmt::format("{}: {} numbers, not {}", name, numbers.size(), count));
    return numbers;
}

std::int64_t integer_of(std::string_view text, const std::filesystem::path& path,
                        std::string_view name) {
    const double number = numbers_of(text, 1, path, name)[0];
    if (number != std::floor(number) || std::abs(number) > 0x1p53)
        cannot_read(path, fmt::format("{}: {} is not an integer in range", name, number));
    return static_cast<std::int64_t>(number);
}

Index3 size_of(std::string_view text, const std::filesystem::path& path, std::string_view name) {
    const std::vector<double> numbers = numbers_of(text, 3, path, name);
    for (const double number : numbers)
        // 2^28: what index arithmetic with aprons and groups has room for.
        if (number != std::floor(number) || number < 1 || number > 0x1p28)
            cannot_read(path,
                        fmt::format("{}: {} is not a number of samples in 1 … 2^28", name, number));
    return Vec3d(numbers.data()).cast<int>();
}

std::string_view next_line(std::string_view& text) {
    const std::size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
}

} // namespace isocast
