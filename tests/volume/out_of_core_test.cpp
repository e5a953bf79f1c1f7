// Tests of fields whose samples lie in a scratch file because memory has no room for them.
// SPDX-License-Identifier: MPL-2.0
#include "random_fields.h"
#include "temporary_folder.h"
#include "volume/analytic_fields.h"
#include "volume/errors.h"
#include "volume/files.h"
#include "volume/sparsify.h"
#include "volume_writers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/vfs.h>

#include <csignal>
#include <cstdlib>

namespace isocast {
namespace {

using test::Random;
using test::TemporaryFolder;
using testing::AllOf;
using testing::HasSubstr;

/// Sets TMPDIR while it lives.
class TemporaryVariable {
public:
    explicit TemporaryVariable(const std::string& folder) {
        if (const char* before = std::getenv("TMPDIR")) before_ = before;
        ::setenv("TMPDIR", folder.c_str(), 1);
    }
    ~TemporaryVariable() {
        if (before_)
            ::setenv("TMPDIR", before_->c_str(), 1);
        else
            ::unsetenv("TMPDIR");
    }

private:
    std::optional<std::string> before_;
};

std::unique_ptr<SparseField> read_sparse(const std::filesystem::path& path, double memory_bytes) {
    std::unique_ptr<FieldSource> field = read_field(path, {}, memory_bytes);
    return std::unique_ptr<SparseField>(&dynamic_cast<SparseField&>(*field.release()));
}

constexpr double plenty = 1e18;
constexpr double none = 0;

TEST(OutOfCore, VdbBlocksInAScratchFileAreThoseInMemory) {
    const TemporaryFolder folder;
    const TemporaryVariable scratch(folder.path());
    Random random(1);
    for (int i = 0; i < 12; ++i) {
        // Blocks at random also have signs that only added blocks carry.
        for (const Outside outside : {Outside::SignedBackground, Outside::Background}) {
            write_vdb(SparseField(GridSpace::uniform(0.5), 1.5, outside,
                                  test::random_blocks(random, 3, i % 2 == 0 ? 0.05 : 0.4, 1.5F)),
                      folder / "a.vdb");
            const auto in_memory = read_sparse(folder / "a.vdb", plenty);
            const auto in_scratch = read_sparse(folder / "a.vdb", none);
            EXPECT_EQ(folder.entry_count(), 1); // the scratch file has no name any more
            ASSERT_EQ(in_scratch->blocks().size(), in_memory->blocks().size());
            for (std::size_t k = 0; k < in_memory->blocks().size(); ++k) {
                EXPECT_EQ(in_scratch->blocks()[k].coordinate, in_memory->blocks()[k].coordinate);
                EXPECT_EQ(in_scratch->blocks()[k].values, in_memory->blocks()[k].values);
                EXPECT_EQ(in_scratch->blocks()[k].active, in_memory->blocks()[k].active);
            }
            const IndexBox around = dilated(in_memory->extent(), 20, 20);
            EXPECT_EQ(test::copied(*in_scratch, around), test::copied(*in_memory, around));
        }
    }
}

TEST(OutOfCore, SamplesOfACompressedVolumeToo) {
    const TemporaryFolder folder;
    const TemporaryFolder scratch;
    const TemporaryVariable variable(scratch.path());
    Random random(2);
    for (const auto& path : test::write_all(test::random_volume(random), folder)) {
        const auto in_memory = read_field(path, {}, plenty);
        const auto in_scratch = read_field(path, {}, none);
        EXPECT_EQ(scratch.entry_count(), 0);
        EXPECT_EQ(test::copied(*in_scratch, in_scratch->extent()),
                  test::copied(*in_memory, in_memory->extent()));
    }
    const TemporaryVariable missing(scratch / "missing");
    EXPECT_THAT(
        test::message_of<ResourceError>([&] { read_field(folder / "gzip.nii.gz", {}, none); }),
        AllOf(HasSubstr("gzip.nii.gz"), HasSubstr("missing")));
}

/// What reading says where there is no memory and TMPDIR is `scratch`.
std::string scratch_error(const std::filesystem::path& path, const std::string& scratch) {
    const TemporaryVariable variable(scratch);
    return test::message_of<ResourceError>([&] { read_field(path, {}, none); });
}

TEST(OutOfCore, AFullDiskIsAnErrorThatNamesTheFolderAndTheCause) {
    const TemporaryFolder folder;
    write_vdb(to_sparse(*sampled(builtin_field("torus"), 60, 3)), folder / "a.vdb");
    // A limit to the size of files stands for the full disk.
    rlimit old_limit{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &old_limit), 0);
    const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
    rlimit limit = old_limit;
    limit.rlim_cur = 20000;
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
    const std::string message = scratch_error(folder / "a.vdb", folder.path());
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &old_limit), 0);
    std::signal(SIGXFSZ, old_handler);
    EXPECT_THAT(message, AllOf(HasSubstr("a.vdb"), HasSubstr(folder.path()), HasSubstr("TMPDIR"),
                               HasSubstr("File too large")));
    EXPECT_EQ(folder.entry_count(), 1);
}

TEST(OutOfCore, AScratchFolderThatIsMissingOrInMemoryIsAnError) {
    const TemporaryFolder folder;
    write_vdb(to_sparse(*sampled(builtin_field("torus"), 60, 3)), folder / "a.vdb");
    EXPECT_THAT(scratch_error(folder / "a.vdb", folder / "missing"),
                AllOf(HasSubstr("a.vdb"), HasSubstr("missing"), HasSubstr("No such file")));
    struct statfs system {};
    constexpr auto tmpfs = 0x01021994; // statfs(2)
    if (::statfs("/dev/shm", &system) != 0 || system.f_type != tmpfs)
        GTEST_SKIP() << "no file system in memory to try";
    EXPECT_THAT(scratch_error(folder / "a.vdb", "/dev/shm"),
                AllOf(HasSubstr("/dev/shm"), HasSubstr("tmpfs")));
}

TEST(OutOfCore, ALimitOfTheProcessIsSeen) {
    rlimit old_limit{};
    ASSERT_EQ(::getrlimit(RLIMIT_DATA, &old_limit), 0);
    rlimit limit = old_limit;
    limit.rlim_cur = std::size_t{1} << 30;
    ASSERT_EQ(::setrlimit(RLIMIT_DATA, &limit), 0);
    const double available = available_memory_bytes();
    ASSERT_EQ(::setrlimit(RLIMIT_DATA, &old_limit), 0);
    EXPECT_LE(available, 0x1p30);
    EXPECT_GE(available_memory_bytes(), available);
}

} // namespace
} // namespace isocast
