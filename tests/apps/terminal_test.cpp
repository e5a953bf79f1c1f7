// Ctrl-C and progress, on a terminal.
// SPDX-License-Identifier: MPL-2.0
#include "../volume/temporary_folder.h"
#include "program.h"

#include <gtest/gtest.h>

namespace isocast::test {
namespace {

TEST(Interrupt, EndsALongConversionAndLeavesNothing) {
    const TemporaryFolder folder;
    // At this resolution one thread takes half a minute: it is at work when Ctrl-C arrives.
    const Outcome outcome = isocast_on_terminal({"convert", "mesh:sphere6", "-o", folder / "a.vdb",
                                                 "--resolution", "2000", "--threads", "1"},
                                                "transform ");
    EXPECT_EQ(outcome.code, 130) << outcome.err;
    // The terminal turns \n into \r\n. The line before was cleared.
    EXPECT_TRUE(outcome.err.ends_with("\r\x1b[Kisocast: interrupted\r\n")) << outcome.err;
    EXPECT_EQ(folder.entry_count(), 0);
    // It ended when told to, not when the work was done.
    const auto last = outcome.err.rfind("transform ");
    ASSERT_NE(last, std::string::npos) << outcome.err;
    EXPECT_LT(std::stoi(outcome.err.substr(last + 10)), 50) << outcome.err;
}

TEST(Progress, IsRewrittenInPlaceAndClearedBeforeTheReport) {
    const TemporaryFolder folder;
    const Outcome outcome =
        isocast_on_terminal({"convert", "mesh:knot", "-o", folder / "a.vdb", "--resolution", "64"});
    EXPECT_EQ(outcome.code, 0);
    EXPECT_TRUE(outcome.err.starts_with("\rreading 0 %\x1b[K")) << outcome.err;
    const auto cleared = outcome.err.rfind("\r\x1b[K");
    ASSERT_NE(cleared, std::string::npos) << outcome.err;
    EXPECT_TRUE(outcome.err.substr(cleared + 4).starts_with("mesh:knot: 2880 triangles"))
        << outcome.err;
    EXPECT_EQ(outcome.err.find('%', cleared), std::string::npos) << outcome.err;
}

TEST(Progress, IsNotShownWhereStderrIsNoTerminal) {
    const TemporaryFolder folder;
    EXPECT_EQ(isocast({"convert", "mesh:knot", "-o", folder / "a.vdb", "--resolution", "64"}).err,
              "");
}

} // namespace
} // namespace isocast::test
