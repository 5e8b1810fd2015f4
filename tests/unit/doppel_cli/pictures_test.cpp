// SPDX-License-Identifier: Apache-2.0
#include "apps/shared/pictures.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <set>

#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"
#include "tests/package/tiny_avatar.h"
#include "tests/unit/avatar/rigs.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

TEST(Frames, haveNumbersOfFiveDigitsOrMore) {
    EXPECT_EQ(frameNumber(12), "00012");
    EXPECT_EQ(frameNumber(123456), "123456");
    for (const char* name : {"00000", "00012", "99999", "100000"}) EXPECT_TRUE(isFrameNumber(name)) << name;
    for (const char* name : {"", "12", "000012", "0001a", "-0001", "99999999999999999999"}) EXPECT_FALSE(isFrameNumber(name)) << name;
}

TEST(Frames, onlyFramesAreRemoved) {
    const fs::path folder = fs::temp_directory_path() / ("dpl_frames_" + std::to_string(::getpid()));
    fs::create_directories(folder / "full_003.png");  // a folder
    for (const char* name : {"full_001.png", "full_002.png", "full_001.jpg", "mine.png"})
        ASSERT_TRUE(writeFileAtomically(folder / name, std::string("x")));
    const std::set<std::string> frames = {"full_001", "full_002", "full_003"};
    const auto removed = removeFrames(folder, [&](const std::string& name) { return frames.contains(name); });
    ASSERT_TRUE(removed) << removed.error().message;
    EXPECT_EQ(*removed, 2u);
    std::set<std::string> left;
    for (const auto& entry : fs::directory_iterator(folder)) left.insert(entry.path().filename().string());
    EXPECT_EQ(left, (std::set<std::string>{"full_001.jpg", "full_003.png", "mine.png"}));
    const auto nowhere = removeFrames(folder / "nowhere", [](const std::string&) { return true; });
    ASSERT_FALSE(nowhere);
    EXPECT_NE(nowhere.error().message.find("nowhere"), std::string::npos);
    fs::remove_all(folder);
}

TEST(Clips, areCalledAsTheirFileWithoutFolderAndEnding) {
    AvatarData person = test::tinyAvatar();
    person.joints = test::personRig(0.8f);
    sortSplats(person);
    const auto bytes = writeAvatar(person);
    ASSERT_TRUE(bytes) << bytes.error().message;
    auto context = doppel::Context::create(DPL_RENDERER_SOFTWARE, 1);
    ASSERT_TRUE(context) << context.error().message;
    auto avatar = context->loadAvatar(*bytes);
    ASSERT_TRUE(avatar) << avatar.error().message;
    const fs::path folder = fs::temp_directory_path() / ("dpl_clips_" + std::to_string(::getpid()));
    fs::create_directories(folder);
    const std::string joints =
        "HIERARCHY\nROOT Hips\n{\nOFFSET 0 95 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n"
        "JOINT LeftUpLeg\n{\nOFFSET 9 -5 0\nCHANNELS 0\nJOINT LeftLeg\n{\nOFFSET 0 -41 0\nCHANNELS 0\nEnd Site\n{\nOFFSET 0 -41 "
        "0\n}\n}\n}\n"
        "JOINT RightUpLeg\n{\nOFFSET -9 -5 0\nCHANNELS 0\nJOINT RightLeg\n{\nOFFSET 0 -41 0\nCHANNELS 0\nEnd Site\n{\nOFFSET 0 -41 "
        "0\n}\n}\n}\n}\n";
    ASSERT_TRUE(writeFileAtomically(folder / "slow walk.2.bvh", joints + "MOTION\nFrames: 2\nFrame Time: 0.5\n0 0 0\n0 0 9\n"));
    const auto clip = chooseClip(*avatar, (folder / "slow walk.2.bvh").string());
    ASSERT_TRUE(clip) << clip.error().message;
    EXPECT_STREQ(avatar->clip(*clip)->name, "slow walk.2");
    const auto own = chooseClip(*avatar, "slow walk.2");
    ASSERT_TRUE(own) << own.error().message;
    EXPECT_EQ(*own, *clip) << "a clip is found by its name";
    fs::remove_all(folder);
}

}  // namespace
}  // namespace dpl
