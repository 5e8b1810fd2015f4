// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/hidden_splats.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "apps/viewer/subject.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"
#include "tests/package/tiny_avatar.h"
#include "tests/unit/must.h"

namespace {

using namespace dpl;

class HiddenSplatsTest : public ::testing::Test {
protected:
    void SetUp() override {
        AvatarData data = test::tinyAvatar();                      // a square that faces +Z
        for (size_t i = 0; i < 10; ++i) data.splats.flags[i] = 0;  // these show both sides
        sortSplats(data);
        const auto bytes = must(writeAvatar(data));
        ASSERT_TRUE(writeFileAtomically(file_, bytes));
        auto avatar = context_->loadAvatar(bytes);
        ASSERT_TRUE(avatar);
        subject_.emplace(must(ViewedSubject::of(std::move(*avatar), "tiny.glb")));
        subject_->clip.reset();
        subject_->path = file_;
    }
    void TearDown() override { std::filesystem::remove(file_); }
    HiddenSplats seenFrom(const Vec3d& eye) {
        EXPECT_TRUE(subject_->pose({}, 0));
        return must(finder_.find(must(gateQuestion(*subject_, eye))));
    }
    const std::filesystem::path file_ = std::filesystem::temp_directory_path() / ("doppel_gate_" + std::to_string(::getpid()) + ".glb");
    doppel::Result<doppel::Context> context_ = doppel::Context::create(DPL_RENDERER_SOFTWARE, 1);
    std::optional<ViewedSubject> subject_;
    GateFinder finder_;
};

TEST_F(HiddenSplatsTest, fromBehindAllButThoseWithTwoSides) {
    const HiddenSplats front = seenFrom({0, 1, 3}), behind = seenFrom({0, 1, -3});
    EXPECT_EQ(front.splats, 128u);
    EXPECT_EQ(front.hidden, 0u);
    EXPECT_TRUE(front.places.empty());
    EXPECT_EQ(behind.splats, 128u);
    EXPECT_EQ(behind.hidden, 118u);
    ASSERT_EQ(behind.places.size(), 118u);
    for (const Vec3f& place : behind.places) {
        EXPECT_NEAR(place.z, 0, 1e-3f);
        EXPECT_LT(std::abs(place.x), 0.6f);
    }
}

TEST_F(HiddenSplatsTest, turnsAndMovesWithTheAvatar) {
    subject_->turnedDeg = 180, subject_->movedM = {2, 1};
    EXPECT_EQ(seenFrom({2, 1, -2}).hidden, 0u) << "it faces -Z now";
    const HiddenSplats other = seenFrom({2, 1, 4});
    ASSERT_EQ(other.hidden, 118u);
    EXPECT_NEAR(other.places[0].z, 1, 1e-3f);
    subject_->turnedDeg = 0;
    subject_->byHandDeg[0] = {0, 180, 0};
    EXPECT_EQ(seenFrom({2, 1, 4}).hidden, 118u) << "bent, not turned";
}

TEST_F(HiddenSplatsTest, asksOfFilesAlone) {
    subject_->path.clear();
    ASSERT_TRUE(subject_->pose({}, 0));
    EXPECT_FALSE(finder_.find(must(gateQuestion(*subject_, {0, 1, 3}))));
    subject_->path = "/no/such.glb";
    EXPECT_FALSE(finder_.find(must(gateQuestion(*subject_, {0, 1, 3}))));
}

}  // namespace
