// Tests of files that appear whole or not at all.
// SPDX-License-Identifier: MPL-2.0
#include "volume/atomic_file.h"

#include "temporary_folder.h"
#include "volume/errors.h"

#include <gtest/gtest.h>

#include <fstream>

namespace isocast {
namespace {

using test::TemporaryFolder;

std::string contents(const std::filesystem::path& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
}

void write(const AtomicFile& file, const std::string& text) {
    std::ofstream(file.temporary_path()) << text;
}

TEST(AtomicFile, AppearsOnCommitAlone) {
    const TemporaryFolder folder;
    {
        AtomicFile file(folder / "a.vdb");
        write(file, "whole");
        EXPECT_FALSE(std::filesystem::exists(folder / "a.vdb"));
        EXPECT_EQ(file.temporary_path().parent_path(), (folder / "a.vdb").parent_path());
        EXPECT_EQ(file.temporary_path().extension(), ".vdb");
        file.commit();
        EXPECT_EQ(contents(folder / "a.vdb"), "whole");
    }
    EXPECT_EQ(contents(folder / "a.vdb"), "whole");
    EXPECT_EQ(folder.entry_count(), 1);
}

TEST(AtomicFile, WithoutCommitLeavesNothingAndKeepsTheOldFile) {
    const TemporaryFolder folder;
    std::ofstream(folder / "a.txt") << "old";
    {
        const AtomicFile file(folder / "a.txt");
        write(file, "half of the new");
        EXPECT_EQ(folder.entry_count(), 2);
    }
    EXPECT_EQ(contents(folder / "a.txt"), "old");
    EXPECT_EQ(folder.entry_count(), 1);
}

TEST(AtomicFile, ReplacesTheOldFile) {
    const TemporaryFolder folder;
    std::ofstream(folder / "a.txt") << "old";
    AtomicFile file(folder / "a.txt");
    write(file, "new");
    file.commit();
    EXPECT_EQ(contents(folder / "a.txt"), "new");
}

TEST(AtomicFile, TwoOfOneNameDoNotMeet) {
    const TemporaryFolder folder;
    const AtomicFile first(folder / "a.txt");
    const AtomicFile second(folder / "a.txt");
    EXPECT_NE(first.temporary_path(), second.temporary_path());
}

TEST(AtomicFile, NamesTheFolderThatDoesNotExist) {
    const TemporaryFolder folder;
    const std::filesystem::path path = folder / "missing" / "a.vdb";
    const std::string message = test::message_of<InputError>([&] { const AtomicFile file(path); });
    EXPECT_NE(message.find(path.parent_path().string()), std::string::npos) << message;
    EXPECT_NE(message.find("does not exist"), std::string::npos) << message;
}

TEST(AtomicFile, RefusesAFolderAsItsName) {
    const TemporaryFolder folder;
    EXPECT_THROW(const AtomicFile file(folder / ""), InputError);
    std::filesystem::create_directory(folder / "a.vdb");
    EXPECT_THROW(const AtomicFile file(folder / "a.vdb"), InputError);
}

TEST(AtomicFile, FailedCommitIsAnErrorAndLeavesNothing) {
    const TemporaryFolder folder;
    {
        AtomicFile file(folder / "a.txt");
        std::filesystem::create_directory(folder / "a.txt"); // a file cannot take its place
        EXPECT_THROW(file.commit(), ResourceError);
    }
    EXPECT_EQ(folder.entry_count(), 1);
}

} // namespace
} // namespace isocast
