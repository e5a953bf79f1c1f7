// SPDX-License-Identifier: MPL-2.0
#include "apps/field_series.h"

#include "volume/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

namespace isocast {

namespace {

/// A file name around its number.
struct Pattern {
    std::string head;
    std::string tail;
    std::size_t digits = 0; // 0: any number of them, none in front that is 0

    std::optional<std::int64_t> time_of(const std::string& name) const {
        if (name.size() <= head.size() + tail.size() || !name.starts_with(head) ||
            !name.ends_with(tail))
            return std::nullopt;
        const std::string number =
            name.substr(head.size(), name.size() - head.size() - tail.size());
        const bool is_padded = number.size() > 1 && number[0] == '0';
        // printf's %04d writes more digits where it needs them.
        if (number.size() < digits ||
            (number.size() > std::max<std::size_t>(digits, 1) && is_padded))
            return std::nullopt;
        std::int64_t time = 0;
        const auto [end, error] =
            std::from_chars(number.data(), number.data() + number.size(), time);
        if (error != std::errc{} || end != number.data() + number.size() || time < 0)
            return std::nullopt;
        return time;
    }
};

std::optional<Pattern> pattern_of(const std::string& name) {
    if (const auto first = name.find('#'); first != std::string::npos) {
        const auto past = std::min(name.find_first_not_of('#', first), name.size());
        if (name.find('#', past) != std::string::npos) return std::nullopt;
        return Pattern{name.substr(0, first), name.substr(past), past - first};
    }
    const auto percent = name.find('%');
    const auto d = percent == std::string::npos ? percent : name.find('d', percent);
    if (d == std::string::npos || name.find('%', d) != std::string::npos) return std::nullopt;
    Pattern pattern{name.substr(0, percent), name.substr(d + 1)};
    const std::string_view width = std::string_view(name).substr(percent + 1, d - percent - 1);
    if (width.empty()) return pattern;
    const auto [end, error] =
        std::from_chars(width.data(), width.data() + width.size(), pattern.digits);
    if (width[0] != '0' || error != std::errc{} || end != width.data() + width.size() ||
        pattern.digits == 0)
        return std::nullopt;
    return pattern;
}

} // namespace

bool is_series(const std::string& pattern) {
    return pattern_of(std::filesystem::path(pattern).filename().string()).has_value();
}

std::vector<TimedFile> field_series(const std::string& pattern) {
    const std::filesystem::path path(pattern);
    const auto name = pattern_of(path.filename().string());
    if (!name)
        throw InputError(fmt::format("{}: a series has one place for a number in its files' name: "
                                     "####, %04d or %d",
                                     pattern));
    const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
    std::vector<TimedFile> files;
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error))
        if (const auto time = name->time_of(entry.path().filename().string()))
            files.push_back({*time, path.parent_path() / entry.path().filename()});
    if (error) throw InputError(fmt::format("{}: {}", folder.string(), error.message()));
    if (files.empty()) throw InputError(fmt::format("{}: no such files", pattern));
    std::ranges::sort(files, {}, &TimedFile::time);
    return files;
}

TimeNeighbours neighbours_of(const std::vector<TimedFile>& series, double time) {
    const auto first = static_cast<double>(series.front().time);
    const auto last = static_cast<double>(series.back().time);
    if (!(time >= first && time <= last))
        throw InputError(fmt::format("time {} lies outside of {} ... {}", time, first, last));
    const auto after = std::ranges::lower_bound(
        series, time, {}, [](const TimedFile& file) { return static_cast<double>(file.time); });
    if (static_cast<double>(after->time) == time) return {*after, *after, 0};
    const auto before = after - 1;
    return {*before, *after,
            (time - static_cast<double>(before->time)) /
                static_cast<double>(after->time - before->time)};
}

} // namespace isocast
