// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/file_kind.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace {

using namespace dpl;
using namespace std::string_literals;

FileKind kindOf(const std::string& content, const std::string& name = "file") {
    return fileKindOf({reinterpret_cast<const uint8_t*>(content.data()), content.size()}, name);
}

std::string glb(const std::string& json) {
    const auto word = [](size_t n) { return std::string{char(n & 255), char(n >> 8 & 255), char(n >> 16 & 255), char(n >> 24 & 255)}; };
    return "glTF" + word(2) + word(20 + json.size()) + word(json.size()) + "JSON" + json;
}

TEST(FileKind, isToldByTheContent) {
    EXPECT_EQ(kindOf("ply\nformat binary_little_endian 1.0\n"), FileKind::Subject);
    EXPECT_EQ(kindOf("\x1f\x8b\x08 packed", "x.bvh"), FileKind::Subject);
    EXPECT_EQ(kindOf("NGSP...."), FileKind::Subject);
    EXPECT_EQ(kindOf(glb(R"({"extensionsUsed":["DPL_gaussian_avatar"],"animations":[]})")), FileKind::Subject);
    EXPECT_EQ(kindOf(glb(R"({"extensionsUsed":["KHR_gaussian_splatting"]})")), FileKind::Subject);
    EXPECT_EQ(kindOf(glb(R"({"animations":[{}]})")), FileKind::Motion);
    EXPECT_EQ(kindOf("HIERARCHY\nROOT hips"), FileKind::Motion);
    EXPECT_EQ(kindOf("\r\n  hierarchy\n"), FileKind::Motion);
    EXPECT_EQ(kindOf(R"({"asset":{"version":"2.0"}})"), FileKind::Motion);
}

TEST(FileKind, brokenFilesGoToTheLoaderOfTheirName) {
    EXPECT_EQ(kindOf("", "walk.BVH"), FileKind::Motion);
    EXPECT_EQ(kindOf("rubbish", "walk.gltf"), FileKind::Motion);
    EXPECT_EQ(kindOf("glTF", "cut.glb"), FileKind::Subject);
    EXPECT_EQ(kindOf(glb("{}").substr(0, 18)), FileKind::Subject);
    const std::string avatar = glb(R"({"animations":[{}],"extensionsUsed":["DPL_gaussian_avatar"]})");
    EXPECT_EQ(kindOf(avatar.substr(0, avatar.size() - 4)), FileKind::Subject) << "cut off behind its animations";
}

TEST(FileKind, namesOutsideTheJsonDoNotCount) {
    EXPECT_EQ(kindOf(glb("{}") + "\"animations\""), FileKind::Subject);
    EXPECT_EQ(kindOf("glTF" + "\0\0\0\0\0\0\0\0\xff\xff\xff\xffJSON{\"animations\":1}"s), FileKind::Subject) << "a length beyond the file";
}

TEST(FileKind, restIsUnknown) {
    for (const char* text : {"", "\x89PNG", "solid", "   "}) EXPECT_EQ(kindOf(text, "picture.png"), FileKind::Unknown) << text;
}

TEST(FileKind, everyPrefixIsJudged) {
    const std::string whole = glb(R"({"animations":[{"channels":[]}]})");
    for (size_t bytes = 0; bytes <= whole.size(); ++bytes) {
        const FileKind kind = kindOf(whole.substr(0, bytes), "x.glb");
        EXPECT_EQ(kind == FileKind::Unknown, bytes < 4) << bytes;
    }
}

}  // namespace
