// Many more damaged files of points: minutes.
// SPDX-License-Identifier: MPL-2.0
#include "damaged_points.h"

namespace isocast::test {
namespace {

// Five files: a million copies.
TEST(PointErrors, ManyDamagedFilesAreReadOrRefused) {
    expect_points_read_or_refused(200'000, 2);
}

} // namespace
} // namespace isocast::test
