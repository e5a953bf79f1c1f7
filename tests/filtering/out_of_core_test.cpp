// A field that is larger than the memory: its blocks' ranges, found in a process that may not have
// as much.
// SPDX-License-Identifier: MPL-2.0
#include "../volume/temporary_folder.h"
#include "filtering/blocks.h"
#include "filtering/filter.h"
#include "volume/errors.h"
#include "volume/files.h"

#include <gtest/gtest.h>
#include <malloc.h>
#include <sys/resource.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>

namespace isocast {
namespace {

using test::TemporaryFolder;

constexpr const char* path_variable = "ISOCAST_OUT_OF_CORE_TEST";

/// A sphere of distances of 330 voxels, with blocks as far as 10 voxels from it.
SparseField large_sphere() {
    constexpr int reach = 43;
    FieldBlocks blocks;
    for (int z = -reach; z <= reach; ++z)
        for (int y = -reach; y <= reach; ++y)
            for (int x = -reach; x <= reach; ++x) {
                const double middle = (block_size * Vec3d(x + 0.5, y + 0.5, z + 0.5)).norm() - 330;
                if (std::abs(middle) > 10) continue;
                FieldBlock block;
                block.coordinate = {x, y, z};
                for (std::size_t i = 0; i < block.values.size(); ++i) {
                    const Index3 p =
                        block_size * block.coordinate + Index3(i % 8, i / 8 % 8, i / 64);
                    const double distance = p.cast<double>().norm() - 330;
                    block.values[i] = static_cast<float>(std::clamp(distance, -3.0, 3.0));
                    block.active[i] = std::abs(distance) < 3;
                }
                blocks.push_back(block);
            }
    return {GridSpace::uniform(1), 3, Outside::SignedBackground, std::move(blocks)};
}

std::size_t data_bytes() {
    std::ifstream file("/proc/self/status");
    std::string word;
    std::size_t kibibytes = 0;
    while (file >> word)
        if (word == "VmData:" && file >> kibibytes) break;
    return kibibytes * 1024;
}

BlockRanges ranges_of(const std::string& path, double memory_bytes) {
    const std::shared_ptr<const FieldSource> field = read_field(path, {}, memory_bytes);
    return find_block_ranges(*control_samples(field, Filter::Interpolating), Kernel::BSpline);
}

bool is_same(const BlockRanges& a, const BlockRanges& b) {
    // Pages have no padding that is not zero: all members start from zeros.
    return a.pages.size() == b.pages.size() &&
           std::ranges::equal(a.pages, b.pages, [](const BlockPage& p, const BlockPage& q) {
               return p.coordinate == q.coordinate && p.blocks == q.blocks &&
                      std::memcmp(&p.range, &q.range, sizeof p.range) == 0 &&
                      std::memcmp(&p.samples, &q.samples, sizeof p.samples) == 0 &&
                      std::memcmp(&p.ranges, &q.ranges, sizeof p.ranges) == 0;
           });
}

/// Ends the process: 0 if all is as it should be.
[[noreturn]] void find_ranges_in_a_quarter_of_the_memory(const char* path) {
    const auto finish = [](int code, const char* why) {
        std::fprintf(stderr, "%s\n", why);
        std::_Exit(code);
    };
    constexpr double no_limit = 1e18;
    std::size_t decoded = 0;
    {
        const auto field = read_field(path, {}, no_limit);
        decoded = dynamic_cast<const SparseField&>(*field).blocks().size() * sizeof(FieldBlock);
    }
    const BlockRanges expected = ranges_of(path, no_limit);
    ::malloc_trim(0);
    rlimit limit{};
    ::getrlimit(RLIMIT_DATA, &limit);
    // What the system counts: heap and other memory of our own, not mapped files. A quarter holds
    // the grid's topology, an eleventh of the decoded grid, and each thread's samples of a page.
    limit.rlim_cur = data_bytes() + decoded / 4;
    ::setrlimit(RLIMIT_DATA, &limit);
    try {
        static_cast<void>(read_field(path, {}, no_limit));
        finish(2, "the limit does not bite");
    } catch (const ResourceError&) {
    }
    try {
        // Without being told, it sees the limit.
        const BlockRanges found = ranges_of(path, default_field_bytes());
        if (!is_same(found, expected)) finish(3, "other ranges");
    } catch (const std::exception& error) {
        finish(4, error.what());
    }
    finish(0, "the same ranges");
    std::abort();
}

TEST(OutOfCore, RangesOfAVdbFileAreTheSameInAQuarterOfTheMemoryThatItTakes) {
#ifdef __SANITIZE_ADDRESS__
    GTEST_SKIP() << "the sanitizer's own memory is beyond any limit";
#endif
    // The new process starts this test again, with the file that is there by then.
    testing::FLAGS_gtest_death_test_style = "threadsafe";
    std::optional<TemporaryFolder> folder;
    if (std::getenv(path_variable) == nullptr) {
        folder.emplace();
        const std::filesystem::path path = *folder / "a.vdb";
        write_vdb(large_sphere(), path);
        ::setenv(path_variable, path.c_str(), 1);
    }
    EXPECT_EXIT(find_ranges_in_a_quarter_of_the_memory(std::getenv(path_variable)),
                testing::ExitedWithCode(0), "the same ranges");
    ::unsetenv(path_variable);
}

} // namespace
} // namespace isocast
