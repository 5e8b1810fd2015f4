// SPDX-License-Identifier: Apache-2.0
// Mixes of clips, gazes and doppel::Player through the public API.
#include <algorithm>
#include <cmath>

#include "sdk/include/doppel/doppel.hpp"
#include "tests/not_finite.h"
#include "tests/unit/api/api_fixture.h"
#include "tests/unit/avatar/rigs.h"
#include "tests/unit/format/sample_correctives.h"

namespace dpl::test {
namespace {

constexpr int64_t kNsPerS = 1'000'000'000;

/** A person of the rig of the tests, with three clips: a walk of 2 s that travels 1 m along +Z, a turn of the chest, and a raised arm. */
AvatarData person() {
    AvatarData data = tinyAvatar();
    data.joints = personRig(0.8f);
    const auto clip = [&](const char* name, float seconds, const char* bone, const Quatf& last, const Vec3f& travel) {
        ClipData made;
        made.name = name, made.timesS = {0, seconds};
        made.channels = {{uint32_t(jointOf(data.joints, bone)), {Quatf(1, 0, 0, 0), last}}};
        made.rootTranslations = {Vec3f(0), travel};
        return made;
    };
    data.clips = {clip("walk", 2, "leftUpperLeg", glm::angleAxis(0.8f, Vec3f(1, 0, 0)), {0, 0, 1}),
                  clip("turn", 1, "chest", glm::angleAxis(0.6f, Vec3f(0, 1, 0)), Vec3f(0)),
                  clip("wave", 1, "rightUpperArm", glm::angleAxis(-1.2f, Vec3f(0, 0, 1)), Vec3f(0))};
    sortSplats(data);
    data = withCorrectives(std::move(data), 3, {.offsetM = 0.2f, .reach = 0.01f, .motion = 4});
    data.correctives.motion.movedFromRad = 0.01f, data.correctives.motion.movedToRad = 0.02f;
    return data;
}

class MixApiTest : public ApiTest {
protected:
    void SetUp() override {
        ApiTest::SetUp();
        const auto bytes = writeAvatar(person());
        ASSERT_TRUE(bytes) << bytes.error().message;
        DplAvatar handle = nullptr;
        ASSERT_EQ(dplLoadAvatar(context_, bytes->data(), bytes->size(), &handle), DPL_OK) << dplGetLastError();
        person_.emplace(context_, handle);
        arm_ = *person_->findJoint("rightUpperArm");
    }
    void TearDown() override {
        person_.reset();
        ApiTest::TearDown();
    }
    /** Rotations of all joints, then the root translation. */
    std::vector<float> pose() const {
        std::vector<float> numbers(4 * size_t(person_->info()->jointCount) + 3);
        EXPECT_TRUE(person_->pose(std::span(numbers).first(numbers.size() - 3), std::span(numbers).last(3)));
        return numbers;
    }
    std::vector<float> poseOf(std::span<const DplClipLayer> layers, int64_t timeNs = 0) {
        const doppel::Status set = person_->setPoseFromClips(layers, timeNs);
        EXPECT_TRUE(set) << set.error().message;
        return pose();
    }
    std::vector<float> plain(uint32_t clip, double timeS, bool loop = true) {
        EXPECT_TRUE(person_->setPoseFromClip(clip, timeS, loop));
        return pose();
    }
    static double farthest(const std::vector<float>& a, const std::vector<float>& b) {
        double most = 0;
        for (size_t i = 0; i < a.size(); ++i) most = std::max(most, double(std::abs(a[i] - b[i])));
        return most;
    }
    std::vector<uint8_t> state() const { return *person_->motionState(); }

    std::optional<doppel::Avatar> person_;
    uint32_t arm_ = 0;
};

TEST_F(MixApiTest, oneLayerIsTheClipAndALaterOneCoversItsPart) {
    for (const double t : {0.3, 1.9, 5.3, -0.4}) {
        const DplClipLayer looped[] = {doppel::clipLayer(0, t)}, clamped[] = {doppel::clipLayer(0, t, 0.2f, 0, 0)};
        EXPECT_EQ(poseOf(looped), plain(0, t)) << t;
        EXPECT_EQ(poseOf(clamped), plain(0, t, false)) << t;
    }
    const DplClipLayer both[] = {doppel::clipLayer(0, 1.2), doppel::clipLayer(2, 0.7, 1, arm_)};
    const std::vector<float> mixed = poseOf(both), walking = plain(0, 1.2), waving = plain(2, 0.7);
    for (size_t i = 0; i < mixed.size(); ++i) EXPECT_EQ(mixed[i], i / 4 == arm_ ? waving[i] : walking[i]) << i;
}

TEST_F(MixApiTest, mistakesAreSentencesAndThePoseStays) {
    const std::vector<float> kept = plain(0, 1);
    const auto refusal = [&](const std::vector<DplClipLayer>& layers, DplResult code, const char* says) {
        EXPECT_EQ(dplSetPoseFromClips(person_->handle(), layers.data(), uint32_t(layers.size()), 0), code);
        EXPECT_TRUE(errorSays(says)) << dplGetLastError();
        EXPECT_EQ(pose(), kept);
    };
    const DplClipLayer walk = doppel::clipLayer(0, 0.5);
    const DplResult wrong = DPL_ERROR_INVALID_ARGUMENT;
    refusal({walk, doppel::clipLayer(7, 0)}, DPL_ERROR_NOT_FOUND, "layer 1: there is no clip 7; the avatar has 3; a clip is of the avatar");
    refusal({walk, doppel::clipLayer(1, 0, 1, 400)}, DPL_ERROR_NOT_FOUND, "layer 1: there is no joint 400");
    refusal({walk, doppel::clipLayer(1, double(kNan))}, wrong, "layer 1: timeS is not finite");
    refusal({walk, doppel::clipLayer(1, 0, kNan)}, wrong, "layer 1: the weight is");
    refusal({walk, doppel::clipLayer(1, 0, -1)}, wrong, "layer 1: the weight is -1");
    refusal({doppel::clipLayer(0, 0, 0), doppel::clipLayer(1, 0, 0)}, wrong, "sum to 0");
    refusal({doppel::clipLayer(2, 0, 1, arm_)}, wrong, "layers of the whole body come first");
    refusal({doppel::clipLayer(0, 0, 1, 0, 64)}, wrong, "unknown flags 64");
    refusal({}, wrong, "layers is NULL");
    refusal(std::vector<DplClipLayer>(65, walk), wrong, "65 layers");
    DplClipLayer far = walk;
    far.shiftM[0] = 1e9f;
    refusal({far}, wrong, "root translation");
    far.shiftM[0] = kNan;
    refusal({far}, wrong, "the heading or the shift");
    EXPECT_EQ(dplFindJoint(person_->handle(), "tail", &arm_), DPL_ERROR_NOT_FOUND);
    EXPECT_EQ(dplSetPoseFromClips(nullptr, &walk, 1, 0), wrong);
}

TEST_F(MixApiTest, aClipOfAnotherAvatarIsNotThere) {
    const DplClipLayer walk[] = {doppel::clipLayer(0, 0.25)};
    EXPECT_EQ(dplSetPoseFromClips(avatar_, walk, 1, 0), DPL_OK) << "number 0 is the avatar's own clip: " << dplGetLastError();
    const DplClipLayer foreign[] = {doppel::clipLayer(2, 0.25)};
    EXPECT_EQ(dplSetPoseFromClips(avatar_, foreign, 1, 0), DPL_ERROR_NOT_FOUND);
    EXPECT_TRUE(errorSays("load it onto this one too")) << dplGetLastError();
}

TEST_F(MixApiTest, clothesRememberAMixByItsTimeAndOnlyWhatWasDrawn) {
    const DplClipLayer still[] = {doppel::clipLayer(0, 0)};
    const DplClipLayer moving[] = {doppel::clipLayer(0, 1.5, 0.5f), doppel::clipLayer(1, 0.5, 0.5f)};
    const auto shown = [&](std::span<const DplClipLayer> layers, int64_t timeNs) {
        EXPECT_TRUE(person_->setPoseFromClips(layers, timeNs));
        return state();  // as drawing does
    };
    EXPECT_TRUE(person_->settle());
    shown(still, 0);
    const std::vector<uint8_t> rest = shown(still, kNsPerS);
    EXPECT_TRUE(person_->settle());
    shown(moving, 0);
    const std::vector<uint8_t> after = shown(still, kNsPerS);
    EXPECT_NE(after, rest) << "the same pose and time after a motion";
    EXPECT_EQ(shown(still, kNsPerS), after) << "a second time for one picture";
    EXPECT_TRUE(person_->settle());
    shown(still, 0);
    EXPECT_TRUE(person_->setPoseFromClips(moving, kNsPerS / 2));  // never drawn
    EXPECT_EQ(shown(still, kNsPerS), rest);
    shown(moving, 2 * kNsPerS);
    EXPECT_TRUE(person_->setPoseFromClips(still, kNsPerS)) << "time may run backwards: what is held fades";
    EXPECT_EQ(poseOf(still, 0), plain(0, 0)) << "and the pose does not depend on it";
}

TEST_F(MixApiTest, aJoinedLayerGoesOnFromTheOneBefore) {
    DplClipLayer before = doppel::clipLayer(0, 3), next = doppel::clipLayer(0, 0.5, 0);
    before.flags |= DPL_LAYER_TRAVEL;
    ASSERT_TRUE(person_->joinClipLayer(before, next));
    EXPECT_NEAR(next.shiftM[1], 1.5f - 0.25f, 1e-5f);
    next.weight = 1;
    EXPECT_LT(std::abs(poseOf({&next, 1}).back() - poseOf({&before, 1}).back()), 1e-5f);
    const DplClipLayer kept = next;
    before.timeS = double(kNan);
    EXPECT_FALSE(person_->joinClipLayer(before, next));
    EXPECT_EQ(std::memcmp(&kept, &next, sizeof next), 0);
    EXPECT_EQ(dplJoinClipLayer(person_->handle(), nullptr, &next), DPL_ERROR_INVALID_ARGUMENT);
    next.clip = 9;
    EXPECT_EQ(dplJoinClipLayer(person_->handle(), &kept, &next), DPL_ERROR_NOT_FOUND);
}

// ---- looking

TEST_F(MixApiTest, looksAtAPointFromAnyPoseAndKeepsItsTime) {
    const DplClipLayer walk[] = {doppel::clipLayer(0, 0.5)};
    const std::vector<float> walking = poseOf(walk, 5 * kNsPerS);
    const std::vector<uint8_t> before = state();
    doppel::Gaze gaze({1, 1.5f, 1});
    ASSERT_TRUE(person_->lookAtPoint(gaze));
    const std::vector<float> looking = pose();
    const uint32_t head = *person_->findJoint("head"), neck = *person_->findJoint("neck");
    EXPECT_GT(looking[4 * head + 1], 0.05f) << "to the left, about +Y";
    for (size_t i = 0; i < looking.size(); ++i)
        if (i / 4 != head && i / 4 != neck) {
            EXPECT_EQ(looking[i], walking[i]) << i;
        }
    const auto timeOf = [](const std::vector<uint8_t>& bytes) { return std::vector<uint8_t>(bytes.begin() + 16, bytes.begin() + 24); };
    EXPECT_EQ(timeOf(state()), timeOf(before));
    gaze.headWeight = gaze.eyeWeight = 0;
    const std::vector<float> again = poseOf(walk);
    ASSERT_TRUE(person_->lookAtPoint(gaze));
    EXPECT_EQ(pose(), again);
}

TEST_F(MixApiTest, mistakesInAGazeAreSentencesAndThePoseStays) {
    const std::vector<float> kept = plain(0, 1);
    const auto refusal = [&](const DplGaze& gaze, const char* says) {
        EXPECT_EQ(dplLookAtPoint(person_->handle(), &gaze), DPL_ERROR_INVALID_ARGUMENT);
        EXPECT_TRUE(errorSays(says)) << dplGetLastError();
        EXPECT_EQ(pose(), kept);
    };
    const std::vector<float> places = *person_->jointPositions();
    const uint32_t neck = *person_->findJoint("neck");
    refusal(doppel::Gaze({places[3 * neck], places[3 * neck + 1], places[3 * neck + 2]}), "inside the avatar itself");
    refusal(doppel::Gaze({kNan, 0, 0}), "target is not finite");
    doppel::Gaze gaze({0, 1, 5});
    gaze.headWeight = kNan;
    refusal(gaze, "headWeight");
    gaze.headWeight = 1, gaze.eyeLimitRad[1] = -1;
    refusal(gaze, "a limit is -1");
    EXPECT_EQ(dplLookAtPoint(person_->handle(), nullptr), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(dplLookAtPoint(avatar_, &gaze), DPL_ERROR_UNSUPPORTED) << "two joints, no head";
    EXPECT_TRUE(errorSays("pelvis, left_shoulder")) << dplGetLastError();
}

// ---- doppel::Player

TEST_F(MixApiTest, aPlayerPlaysPausesLoopsAndChangesItsSpeed) {
    doppel::Player player;
    EXPECT_TRUE(player.layers(7 * kNsPerS).empty());
    const int64_t start = 100 * kNsPerS;
    ASSERT_TRUE(player.play(*person_, 0, start));
    const auto at = [&](double seconds) { return poseOf(player.layers(start + int64_t(seconds * 1e9))); };
    EXPECT_LT(farthest(at(0.5), plain(0, 0.5)), 1e-6);
    EXPECT_LT(farthest(at(3.5), plain(0, 1.5)), 1e-6) << "it loops";
    player.pause(start + 4 * kNsPerS);
    EXPECT_TRUE(player.paused());
    EXPECT_LT(farthest(at(9), plain(0, 0)), 1e-6);
    player.resume(start + 10 * kNsPerS);
    EXPECT_LT(farthest(at(10.5), plain(0, 0.5)), 1e-6);
    ASSERT_TRUE(player.setSpeed(2, start + 10 * kNsPerS + kNsPerS / 2));
    EXPECT_LT(farthest(at(10.8), plain(0, 1.1)), 1e-6);
    ASSERT_TRUE(player.setSpeed(-1, start + 11 * kNsPerS));
    EXPECT_LT(farthest(at(11.5), plain(0, 1)), 1e-6) << "backwards";
    ASSERT_TRUE(player.play(*person_, 1, start + 12 * kNsPerS, {.fadeS = 0, .fromS = 0.25, .loop = false}));
    EXPECT_LT(farthest(at(12), plain(1, 0.25)), 1e-6) << "a cut";
    EXPECT_LT(farthest(at(20), plain(1, 1, false)), 1e-6) << "holds its end";
}

TEST_F(MixApiTest, aPlayerCrossFadesAlikeAtEveryRateAlsoFromWithinAFade) {
    std::vector<std::vector<float>> ends;
    for (const int hz : {30, 120}) {
        doppel::Player player;
        ASSERT_TRUE(player.play(*person_, 0, 0));
        std::vector<float> before;
        double longest = 0;
        for (int frame = 0; frame <= hz; ++frame) {
            const int64_t now = int64_t(frame) * kNsPerS / hz;
            if (frame == hz / 5 || frame == 2 * hz / 5) {
                ASSERT_TRUE(player.play(*person_, frame == hz / 5 ? 1 : 2, now, {.fadeS = 0.4}));
            }
            const std::vector<float> pose = poseOf(player.layers(now), now);
            if (frame > 0) longest = std::max(longest, farthest(before, pose) * hz);
            before = pose;
            if (frame == hz / 2) ends.push_back(pose);
        }
        EXPECT_LT(longest, 3) << "a second";
        EXPECT_LT(farthest(before, plain(2, 0.6)), 1e-6) << "and ends in the clip alone";
        EXPECT_EQ(player.layers(kNsPerS).size(), 1u) << "what has faded out is dropped";
    }
    EXPECT_LT(farthest(ends[0], ends[1]), 1e-5);
}

TEST_F(MixApiTest, aPlayerOfAPartOfTheBodyFadesInAndOutOverAnother) {
    doppel::Player body, arm(arm_);
    ASSERT_TRUE(body.play(*person_, 0, 0));
    ASSERT_TRUE(arm.play(*person_, 2, 0, {.fadeS = 0.5}));
    const auto at = [&](double seconds) {
        const auto now = int64_t(seconds * 1e9);
        const auto under = body.layers(now), over = arm.layers(now);
        std::vector<DplClipLayer> layers(under.begin(), under.end());
        layers.insert(layers.end(), over.begin(), over.end());
        return poseOf(layers);
    };
    const auto armIs = [&](const std::vector<float>& pose, const std::vector<float>& like) {
        return std::abs(pose[4 * arm_ + 2] - like[4 * arm_ + 2]) < 1e-6f;
    };
    EXPECT_TRUE(armIs(at(0), plain(0, 0)));
    const float half = at(0.25)[4 * arm_ + 2];
    EXPECT_TRUE(half < -0.05f && half > plain(2, 0.25)[4 * arm_ + 2]) << half;
    EXPECT_TRUE(armIs(at(0.6), plain(2, 0.6)));
    ASSERT_TRUE(arm.stop(kNsPerS, 0.5));
    EXPECT_FALSE(armIs(at(1.3), plain(0, 1.3)));
    EXPECT_EQ(at(1.6), plain(0, 1.6)) << "gone";
    EXPECT_TRUE(arm.layers(2 * kNsPerS).empty());
    ASSERT_TRUE(arm.play(*person_, 2, 3 * kNsPerS, {.fadeS = 0.1}));
    EXPECT_TRUE(armIs(at(3.5), plain(2, 0.5))) << "and back";
}

TEST_F(MixApiTest, aPlayerThatTravelsGoesOnFromRoundToRoundAndClipToClip) {
    doppel::Player player;
    ASSERT_TRUE(player.play(*person_, 0, 0, {.travel = true}));
    const auto z = [&](double seconds) { return poseOf(player.layers(int64_t(seconds * 1e9))).back(); };
    EXPECT_NEAR(z(4.6), 2.3f, 1e-5f);
    ASSERT_TRUE(player.play(*person_, 0, 5 * kNsPerS, {.speed = 2, .fadeS = 1, .travel = true}));
    EXPECT_NEAR(z(5), 2.5f, 1e-5f) << "not back at the start";
    EXPECT_NEAR(z(8), 2.5f + 3, 1e-4f) << "at twice the speed";
}

TEST_F(MixApiTest, aPlayerRefusesInASentenceAndPlaysOn) {
    doppel::Player player, arm(arm_);
    ASSERT_TRUE(player.play(*person_, 0, 0));
    const auto refusal = [&](const doppel::Status& status, DplResult code) {
        EXPECT_FALSE(status);
        if (!status) {
            EXPECT_EQ(status.error().code, code) << status.error().message;
        }
        EXPECT_EQ(player.layers(kNsPerS).size(), 1u);
    };
    refusal(player.play(*person_, 9, 0), DPL_ERROR_NOT_FOUND);
    refusal(player.play(*person_, 1, 0, {.speed = double(kNan)}), DPL_ERROR_INVALID_ARGUMENT);
    refusal(player.play(*person_, 1, 0, {.fadeS = -1}), DPL_ERROR_INVALID_ARGUMENT);
    refusal(player.play(*person_, 1, 0, {.fromS = double(kInfinity)}), DPL_ERROR_INVALID_ARGUMENT);
    refusal(player.setSpeed(double(kNan), 0), DPL_ERROR_INVALID_ARGUMENT);
    refusal(player.stop(0), DPL_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(arm.stop(0)) << "nothing plays, so nothing stops";
    for (int k = 0; k < 100; ++k) ASSERT_TRUE(player.play(*person_, uint32_t(k % 3), kNsPerS + k, {.fadeS = 5}));
    const auto layers = player.layers(2 * kNsPerS);
    EXPECT_LE(layers.size(), DPL_MAX_CLIP_LAYERS);
    EXPECT_TRUE(person_->setPoseFromClips(layers, 2 * kNsPerS)) << "a clip a frame";
}

}  // namespace
}  // namespace dpl::test
