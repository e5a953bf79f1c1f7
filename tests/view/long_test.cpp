// A long session at the viewer.
// SPDX-License-Identifier: MPL-2.0
#include "window_session.h"

#include <random>

namespace isocast::test {
namespace {

/// Drags, wheel, iso values and effects at random.
TEST(ViewLong, MemoryStaysFlatOverAThousandInteractions) {
    WindowSession session({"field:gyroid@64"});
    session.wait_for_rest();
    session.click("Effects");
    session.wait_for_rest();
    std::mt19937 random(4);
    const auto any = [&](int lo, int hi) {
        return std::uniform_int_distribution<int>(lo, hi)(random);
    };
    std::vector<long> resident;
    for (int i = 0; i < 1000; ++i) {
        const int x = any(360, 1270);
        const int y = any(10, 770);
        switch (i % 4) {
        case 0:
            session.drag(1, x, y, any(360, 1270), any(10, 770), 4);
            break;
        case 1:
            session.xdotool("mousemove " + std::to_string(x) + ' ' + std::to_string(y) +
                            (any(0, 1) ? " click 4" : " click 5"));
            break;
        case 2:
            session.click("iso", 0.3 + 0.4 * any(0, 100) / 100);
            break;
        default:
            session.xdotool(i % 8 == 3 ? "key r" : "key o");
            break;
        }
        if (i % 100 == 99) {
            session.wait_for_rest();
            resident.push_back(session.resident_kib());
        }
    }
    for (const long kib : resident) std::printf("%ld KiB\n", kib);
    // From when everything has been drawn once: a leak of a kilobyte an interaction would be 1 MiB,
    // a picture's texture alone is 11. The allocator's own arenas move by some MiB.
    EXPECT_LT(resident.back() - resident[2], 16 * 1024);
    session.close();
    EXPECT_EQ(session.wait_for_end(), 0);
}

} // namespace
} // namespace isocast::test
