// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/options.h"

#include <gtest/gtest.h>

namespace {

using namespace dpl;

std::optional<ViewerOptions> read(std::vector<const char*> words, int* exitCode) {
    words.insert(words.begin(), "doppel-viewer");
    return readOptions(int(words.size()), words.data(), exitCode);
}

TEST(ViewerOptions, filesComeWithoutAnOption) {
    int exitCode = -1;
    const auto options = read({"a.glb", "walk.bvh", "--room", "bright"}, &exitCode);
    ASSERT_TRUE(options);
    EXPECT_EQ(options->files, (std::vector<std::string>{"a.glb", "walk.bvh"}));
    EXPECT_EQ(options->room, "bright");
    EXPECT_FALSE(options->isScript());
}

TEST(ViewerOptions, aScriptHasASizeAndFrames) {
    int exitCode = -1;
    const auto shot = read({"a.glb", "--screenshot", "x.png", "--size", "300x200", "--hide-panels"}, &exitCode);
    ASSERT_TRUE(shot);
    EXPECT_TRUE(shot->isScript());
    EXPECT_EQ(shot->size.widthPx, 300u);
    EXPECT_EQ(shot->frames, 1u);
    EXPECT_TRUE(shot->hidePanels);
    const auto turn = read({"a.glb", "--turntable", "turn.mp4"}, &exitCode);
    ASSERT_TRUE(turn);
    EXPECT_EQ(turn->frames, 120u);
    EXPECT_EQ(read({"a.glb", "--turntable", "turn", "--frames", "8"}, &exitCode)->frames, 8u);
}

TEST(ViewerOptions, refusesWhatItCannotDo) {
    const std::vector<std::vector<const char*>> wrong = {{"--room", "green"},
                                                         {"--size", "0x4"},
                                                         {"--frames", "0"},
                                                         {"--screenshot", "x.jpg"},
                                                         {"--screenshot", "nowhere/x.png"},
                                                         {"--turntable", "turn.avi"},
                                                         {"--azimuth", "nan"},
                                                         {"--nonsense"},
                                                         {"--screenshot", "x.png", "--turntable", "y.mp4"}};
    for (const auto& words : wrong) {
        int exitCode = 0;
        EXPECT_FALSE(read(words, &exitCode)) << words[0] << ' ' << (words.size() > 1 ? words[1] : "");
        EXPECT_EQ(exitCode, 2);
    }
}

TEST(ViewerOptions, helpSucceeds) {
    int exitCode = -1;
    EXPECT_FALSE(read({"--help"}, &exitCode));
    EXPECT_EQ(exitCode, 0);
}

}  // namespace
