// Fields in time: numbered files, and between which two a time lies.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace isocast {

/// A file and its time, the number in its name.
struct TimedFile {
    std::int64_t time;
    std::filesystem::path path;
    bool operator==(const TimedFile&) const = default;
};

/// True for a file name with a place for a number: field_####.vdb, field_%04d.vdb or field_%d.vdb.
bool is_series(const std::string& pattern);

/// The files of a pattern, by time; nothing is read. As many # as there are digits, or %0Nd, or %d
/// for any number of them.
/// throws  InputError if the pattern has no place for a number or more than one, or if no file
///         matches
std::vector<TimedFile> field_series(const std::string& pattern);

/// The files next to a time, and how far it lies from the first to the second.
struct TimeNeighbours {
    TimedFile before;
    TimedFile after; // `before` at its own time
    double fraction = 0;
};
/// throws  InputError for a time before the first or after the last
TimeNeighbours neighbours_of(const std::vector<TimedFile>& series, double time);

} // namespace isocast
