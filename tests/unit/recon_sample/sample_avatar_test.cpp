// SPDX-License-Identifier: Apache-2.0
// The avatar of the procedural subject: a file can hold it, splats cover what is seen and nothing else, clips are whole.
#include "reconstruction/subject/sample/sample_avatar.h"

#include <gtest/gtest.h>

#include "sdk/format/avatar_file.h"
#include "tests/unit/recon_sample/subjects.h"

namespace dpl {
namespace {

const AvatarData& avatar() {
    static const AvatarData kAvatar = [] {
        Jobs jobs(2);
        return makeSampleAvatar(subject(), jobs);
    }();
    return kAvatar;
}

TEST(SampleAvatar, isAFileOfThreeMegabytesAtMostWithItsClips) {
    Jobs jobs(2);
    const auto file = makeSampleAvatarFile(subject(), jobs);
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_LT(file->size(), 3'000'000u);
    const auto read = readAvatar(*file);
    ASSERT_TRUE(read) << read.error().message;
    ASSERT_EQ(read->clips.size(), 2u);
    EXPECT_EQ(read->clips[0].name, "walk");
    EXPECT_EQ(read->clips[1].name, "moves");
}

TEST(SampleAvatar, splatsCoverWhatIsSeenAndNothingElse) {
    const SplatData& splats = avatar().splats;
    for (size_t t = 0; t < avatar().mesh.triangles.size(); ++t)
        ASSERT_EQ(splats.triangleStart[t + 1] == splats.triangleStart[t], subject().hiddenFace[t] == 1) << "triangle " << t;
    EXPECT_GT(splats.count(), 80'000u);
    EXPECT_LT(splats.count(), 200'000u);
}

TEST(SampleAvatar, hasTheSameBytesForAnyNumberOfThreads) {
    Jobs one(1);
    const AvatarData again = makeSampleAvatar(subject(), one);
    EXPECT_EQ(again.splats.sh, avatar().splats.sh);
    EXPECT_EQ(again.splats.triangleStart, avatar().splats.triangleStart);
}

TEST(SampleAvatar, walkEndsWhereItBegan) {
    const ClipData walk = walkOnTheSpot();
    ASSERT_GT(walk.channels.size(), 8u);
    for (const ClipChannel& channel : walk.channels)
        EXPECT_GT(std::abs(glm::dot(channel.rotations.front(), channel.rotations.back())), 1 - 1e-6f) << "joint " << channel.joint;
    EXPECT_LT(glm::length(walk.rootTranslations.front() - walk.rootTranslations.back()), 1e-6f);
}

}  // namespace
}  // namespace dpl
