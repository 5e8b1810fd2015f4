// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/folder_list.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "tests/unit/must.h"

namespace {

using namespace dpl;
namespace fs = std::filesystem;
using Kind = FolderEntry::Kind;

class FolderListTest : public ::testing::Test {
protected:
    void SetUp() override { fs::create_directories(folder_); }
    void TearDown() override { fs::remove_all(folder_); }
    void file(const std::string& name) {
        fs::create_directories((folder_ / name).parent_path());
        std::ofstream(folder_ / name) << "x";
    }
    const fs::path folder_ = fs::temp_directory_path() / ("doppel-folder-list-" + std::to_string(::getpid()));
};

TEST_F(FolderListTest, listsWhatCanBeOpenedFoldersFirst) {
    for (const char* name : {"b.glb", "A.PLY", "c.spz", "walk.bvh", "notes.txt", ".hidden.glb", "out/progress.json", "scan/scan.json",
                             "old/run.json", "pictures/a.jpg", ".git/a.glb", "folder.glb/a"})
        file(name);
    const FolderList list = must(listFolder(folder_ / "out" / ".."));
    EXPECT_EQ(list.folder, folder_);
    EXPECT_FALSE(list.cut);
    EXPECT_EQ(list.entries, (std::vector<FolderEntry>{{"folder.glb", Kind::Folder},
                                                      {"old", Kind::Run},
                                                      {"out", Kind::Run},
                                                      {"pictures", Kind::Folder},
                                                      {"scan", Kind::Scan},
                                                      {"A.PLY", Kind::File},
                                                      {"b.glb", Kind::File},
                                                      {"c.spz", Kind::File},
                                                      {"walk.bvh", Kind::File}}));
}

TEST_F(FolderListTest, saysWhatCannotBeListed) {
    file("a.glb");
    for (const fs::path& path : {folder_ / "a.glb", folder_ / "nowhere"}) {
        const auto list = listFolder(path);
        ASSERT_FALSE(list);
        EXPECT_NE(list.error().message.find(path.filename().string()), std::string::npos);
    }
}

TEST_F(FolderListTest, aHugeFolderIsCut) {
    for (size_t i = 0; i < FolderList::kMostEntries + 5; ++i) file(std::to_string(i) + ".glb");
    const FolderList list = must(listFolder(folder_));
    EXPECT_TRUE(list.cut);
    EXPECT_EQ(list.entries.size(), FolderList::kMostEntries);
}

}  // namespace
