// Files by their numbers, and between which two a time lies.
// SPDX-License-Identifier: MPL-2.0
#include "apps/field_series.h"

#include "../volume/temporary_folder.h"
#include "program.h"
#include "volume/errors.h"

#include <gtest/gtest.h>

#include <cmath>

namespace isocast::test {
namespace {

std::vector<std::int64_t> times(const std::vector<TimedFile>& series) {
    std::vector<std::int64_t> all;
    for (const TimedFile& file : series) all.push_back(file.time);
    return all;
}

using Times = std::vector<std::int64_t>;

TEST(FieldSeries, AreTheFilesOfThePatternByTheirNumbers) {
    const TemporaryFolder folder;
    for (const char* name :
         {"f_0010.vdb", "f_0002.vdb", "f_0300.vdb", "f_12345.vdb", "f_7.vdb", "f_07.vdb",
          "f_0001.nrrd", "g_0001.vdb", "f_00x1.vdb", "f_.vdb", "f_0002.vdb.bak", "f_-001.vdb"})
        write_text(folder / name, "");
    for (const char* pattern : {"f_####.vdb", "f_%04d.vdb"}) {
        const auto series = field_series(folder / pattern);
        EXPECT_EQ(times(series), (Times{2, 10, 300, 12345})) << pattern;
        EXPECT_EQ(series[0].path, folder / "f_0002.vdb");
    }
    EXPECT_EQ(times(field_series(folder / "f_%d.vdb")), (Times{7, 12345}));
}

TEST(FieldSeries, SaysWhatIsWrong) {
    const TemporaryFolder folder;
    write_text(folder / "f_1.vdb", "");
    for (const char* pattern : {"f.vdb", "f_#_#.vdb", "f_%x.vdb", "f_%4d.vdb", "f_%d_%d.vdb"}) {
        EXPECT_FALSE(is_series(pattern)) << pattern;
        EXPECT_NE(message_of<InputError>([&] {
                      field_series(folder / pattern);
                  }).find("one place for a number"),
                  std::string::npos);
    }
    EXPECT_TRUE(is_series("f_##.vdb"));
    EXPECT_NE(
        message_of<InputError>([&] { field_series(folder / "g_#.vdb"); }).find("no such files"),
        std::string::npos);
    EXPECT_THROW(field_series((folder / "none").string() + "/f_#.vdb"), InputError);
}

const std::vector<TimedFile> uneven{{0, "a"}, {1, "b"}, {4, "c"}, {5, "d"}};

TEST(FieldSeries, HasTwoNeighboursAtATime) {
    const auto expect = [](double time, std::size_t before, std::size_t after, double fraction) {
        const TimeNeighbours next = neighbours_of(uneven, time);
        EXPECT_EQ(next.before, uneven[before]) << time;
        EXPECT_EQ(next.after, uneven[after]) << time;
        EXPECT_DOUBLE_EQ(next.fraction, fraction) << time;
    };
    expect(0, 0, 0, 0);
    expect(0.25, 0, 1, 0.25);
    expect(1, 1, 1, 0);
    expect(2.5, 1, 2, 0.5);
    expect(4.75, 2, 3, 0.75);
    expect(5, 3, 3, 0);
    for (const double time : {-0.1, 5.1, std::nan("")})
        EXPECT_THROW(neighbours_of(uneven, time), InputError);
}

} // namespace
} // namespace isocast::test
