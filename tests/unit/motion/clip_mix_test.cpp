// SPDX-License-Identifier: Apache-2.0
// Mixes of clips against their double-precision reference, and what they promise: shares, masks, travel, and what clothes remember.
#include "sdk/motion/clip_mix.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "sdk/avatar/pose_correctives.h"
#include "sdk/motion/clip.h"
#include "sdk/motion/motion_clock.h"
#include "sdk/motion/retarget.h"
#include "tests/not_finite.h"
#include "tests/unit/avatar/rigs.h"
#include "tests/unit/format/sample_correctives.h"
#include "tests/unit/motion/mix_reference.h"
#include "tests/unit/motion/mocap.h"
#include "tests/unit/render/tube_avatar.h"

namespace dpl {
namespace {

const std::vector<JointData> kRig = test::personRig(0.8f);
const uint32_t kArm = uint32_t(test::jointOf(kRig, "rightUpperArm"));

Quatf randomTurn(std::mt19937& random, double mostRad) {
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> angle(0, mostRad);
    Vec3d axis(normal(random), normal(random), normal(random));
    return Quatf(glm::angleAxis(angle(random), glm::normalize(axis)));
}

/** All joints turn by up to mostRad from rest, between `keys` keys that take `seconds`; the root goes as far as a metre. */
ClipData randomClip(uint32_t seed, double mostRad, int keys = 5, double seconds = 2) {
    std::mt19937 random(seed);
    std::normal_distribution<float> normal;
    ClipData clip;
    clip.name = "clip";
    clip.channels.resize(kRig.size());
    for (uint32_t j = 0; j < kRig.size(); ++j) clip.channels[j].joint = j;
    for (int k = 0; k < keys; ++k) {
        clip.timesS.push_back(float(k * seconds / std::max(1, keys - 1)));
        for (ClipChannel& channel : clip.channels) {
            const Quatf q = randomTurn(random, mostRad);
            channel.rotations.push_back(k % 2 ? -q : q);
        }
        clip.rootTranslations.push_back(0.3f * Vec3f(normal(random), normal(random), normal(random)));
    }
    EXPECT_TRUE(checkClip(clip, kRig));
    return clip;
}

bool sameBytes(const Pose& a, const Pose& b) {
    return a.localRotations.size() == b.localRotations.size() &&
           std::memcmp(a.localRotations.data(), b.localRotations.data(), a.localRotations.size() * sizeof(Quatf)) == 0 &&
           std::memcmp(&a.rootTranslation, &b.rootTranslation, sizeof(Vec3f)) == 0 && a.before == b.before;
}

double farthest(const Pose& a, const Pose& b) {
    double most = glm::length(a.rootTranslation - b.rootTranslation);
    for (size_t j = 0; j < a.localRotations.size(); ++j)
        most = std::max(most, test::angleBetween(Quatd(a.localRotations[j]), Quatd(b.localRotations[j])));
    return most;
}

ClipLayer layerOf(const ClipData& clip, double timeS, float weight = 1, uint32_t joint = 0) {
    ClipLayer layer{&clip, timeS, weight, joint};
    layer.loops = true;
    return layer;
}

Pose mixOf(std::vector<ClipLayer> layers) {
    ClipMix mix;
    Pose pose;
    const Status made = mix.mix(layers, kRig, pose);
    EXPECT_TRUE(made) << made.error().message;
    EXPECT_TRUE(checkPose(kRig, pose));
    return pose;
}

TEST(ClipMix, oneLayerIsThePlainClipByteByByte) {
    const ClipData clip = randomClip(1, 3), other = randomClip(2, 3), one = randomClip(3, 3, 1);
    for (const double t : {-3.3, 0.0, 0.7, 2.0, 1e6}) {
        EXPECT_TRUE(sameBytes(mixOf({layerOf(clip, t)}), samplePose(clip, kRig, loopedTimeS(clip, t)))) << t;
        EXPECT_TRUE(sameBytes(mixOf({layerOf(clip, t, 0.3f), layerOf(other, t, 0)}), samplePose(clip, kRig, loopedTimeS(clip, t)))) << t;
        EXPECT_TRUE(sameBytes(mixOf({{&clip, t}}), samplePose(clip, kRig, t))) << t << ": clamped";
        EXPECT_TRUE(sameBytes(mixOf({layerOf(one, t)}), samplePose(one, kRig, 0))) << t << ": a clip of one key";
    }
}

TEST(ClipMix, twoClipsAgreeWithTheReferenceWhateverTheirWeightsAndOrder) {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> uniform(0, 1);
    for (uint32_t round = 0; round < 40; ++round) {
        const ClipData a = randomClip(10 + round, 3.1, round % 7 ? 4 : 1), b = randomClip(60 + round, 3.1);
        const double t = 3 * double(uniform(random));
        const float first = round % 5 == 0 ? 1.0f : 4 * uniform(random), second = round % 9 == 0 ? 1e-7f : uniform(random);
        const Pose pa = samplePose(a, kRig, loopedTimeS(a, t)), pb = samplePose(b, kRig, loopedTimeS(b, t));
        const Pose mixed = mixOf({layerOf(a, t, first), layerOf(b, t, second)});
        EXPECT_LT(farthest(mixed, mixOf({layerOf(b, t, second), layerOf(a, t, first)})), 2e-6) << "the order does not count";
        for (size_t j = 0; j < kRig.size(); ++j) {
            const Quatd qa(pa.localRotations[j]), qb(pb.localRotations[j]);
            if (std::abs(glm::dot(qa, qb)) < 1e-3) continue;  // half a turn apart: either way round is right
            const Quatd want = test::mixOfTwo(qa, qb, double(first), double(second));
            // Nearly half a turn apart a rounded quaternion turns the sum by up to 1 / its length.
            EXPECT_LT(test::angleBetween(Quatd(mixed.localRotations[j]), want), 4e-6) << round << ' ' << j;
        }
        const Vec3d root =
            (double(first) * Vec3d(pa.rootTranslation) + double(second) * Vec3d(pb.rootTranslation)) / (double(first) + double(second));
        EXPECT_LT(glm::length(Vec3d(mixed.rootTranslation) - root), 1e-6);
    }
}

TEST(ClipMix, threeClipsAgreeWithTheReferenceInAnyOrder) {
    std::mt19937 random(6);
    std::uniform_real_distribution<float> uniform(0, 1);
    for (uint32_t round = 0; round < 20; ++round) {
        const std::vector<ClipData> clips = {randomClip(100 + round, 0.7), randomClip(200 + round, 0.7), randomClip(300 + round, 0.7)};
        std::vector<ClipLayer> layers;
        std::vector<double> weights;
        for (const ClipData& clip : clips)
            layers.push_back(layerOf(clip, 1.3, uniform(random))), weights.push_back(double(layers.back().weight));
        const Pose mixed = mixOf(layers);
        for (size_t j = 0; j < kRig.size(); ++j) {
            std::vector<Quatd> turns;
            for (const ClipData& clip : clips) turns.emplace_back(samplePose(clip, kRig, 1.3).localRotations[j]);
            EXPECT_LT(test::angleBetween(Quatd(mixed.localRotations[j]), test::mixOfMany(turns, weights)), 2e-6) << round << ' ' << j;
        }
        EXPECT_LT(farthest(mixed, mixOf({layers[2], layers[0], layers[1]})), 2e-6);
    }
}

TEST(ClipMix, halfATurnApartAndOppositeQuaternionsGiveARotation) {
    const auto turned = [](const Quatf& q) {
        ClipData clip;
        clip.name = "turned", clip.timesS = {0};
        for (uint32_t j = 0; j < kRig.size(); ++j) clip.channels.push_back({j, {q}});
        return clip;
    };
    const Quatf q(0.5f, 0.5f, 0.5f, 0.5f);
    const ClipData plus = turned(q), minus = turned(-q), half = turned(q * Quatf(0, 1, 0, 0)), other = turned(q * Quatf(0, -1, 0, 0));
    EXPECT_LT(farthest(mixOf({layerOf(plus, 0, 0.5f), layerOf(minus, 0, 0.5f)}), mixOf({layerOf(plus, 0)})), 1e-6) << "one rotation";
    for (const ClipData* far : {&half, &other}) {
        const Pose mixed = mixOf({layerOf(plus, 0, 0.5f), layerOf(*far, 0, 0.5f)});
        EXPECT_NEAR(test::angleBetween(Quatd(mixed.localRotations[3]), Quatd(q)), 0.5 * glm::pi<double>(), 1e-5);
    }
    mixOf({layerOf(plus, 0, 0.1f), layerOf(half, 0, 1), layerOf(other, 0, 1), layerOf(minus, 0, 1e-30f)});  // which nearly cancel
}

TEST(ClipMix, aMaskedLayerChangesNothingOutsideItsMask) {
    const ClipData walk = randomClip(21, 2.5), wave = randomClip(22, 2.5);
    const Pose plain = mixOf({layerOf(walk, 0.4)}), waving = samplePose(wave, kRig, 1.1);
    for (const float weight : {0.0f, 0.25f, 1.0f, 7.0f}) {
        const Pose mixed = mixOf({layerOf(walk, 0.4), layerOf(wave, 1.1, weight, kArm)});
        size_t moved = 0;
        for (size_t j = 0; j < kRig.size(); ++j) {
            bool below = false;
            for (int32_t k = int32_t(j); k >= 0; k = kRig[size_t(k)].parent) below = below || uint32_t(k) == kArm;
            moved += below;
            if (!below) {
                EXPECT_EQ(std::memcmp(&mixed.localRotations[j], &plain.localRotations[j], sizeof(Quatf)), 0) << kRig[j].name;
                continue;
            }
            const Quatd from(plain.localRotations[j]), to(waving.localRotations[j]);
            const double share = std::min(double(weight), 1.0);
            if (std::abs(glm::dot(from, to)) < 0.05) continue;
            EXPECT_LT(test::angleBetween(Quatd(mixed.localRotations[j]), test::mixOfTwo(from, to, 1 - share, share)), 1e-5) << weight;
        }
        EXPECT_EQ(moved, 15u) << "upper arm, lower arm, hand and twelve finger joints";
        EXPECT_EQ(mixed.rootTranslation, plain.rootTranslation);
    }
}

TEST(ClipMix, layersOfOnePartCrossFadeAndTogetherCoverAtMostAll) {
    const ClipData walk = randomClip(31, 1), wave = randomClip(32, 1), salute = randomClip(33, 1);
    const Pose over = mixOf({layerOf(walk, 0), layerOf(wave, 0.2, 3, kArm), layerOf(salute, 0.3, 1, kArm)});
    const Quatd want = test::mixOfTwo(Quatd(samplePose(wave, kRig, 0.2).localRotations[kArm]),
                                      Quatd(samplePose(salute, kRig, 0.3).localRotations[kArm]), 0.75, 0.25);
    EXPECT_LT(test::angleBetween(Quatd(over.localRotations[kArm]), want), 2e-6) << "nothing of the walk is left";
    const uint32_t spine = uint32_t(test::jointOf(kRig, "spine"));
    const Pose narrow = mixOf({layerOf(walk, 0), layerOf(salute, 0.3, 1, spine), layerOf(wave, 0.2, 1, kArm)});
    EXPECT_EQ(narrow.localRotations[kArm], samplePose(wave, kRig, 0.2).localRotations[kArm]) << "later layers lie above";
    EXPECT_EQ(narrow.localRotations[spine], samplePose(salute, kRig, 0.3).localRotations[spine]);
}

TEST(ClipMix, isContinuousInTimeAndWeight) {
    const ClipData walk = randomClip(41, 1.4), run = randomClip(42, 1.4), wave = randomClip(43, 1.4);
    double longest = 0;
    Pose before;
    for (int k = 0; k <= 4000; ++k) {
        const float w = float(k) / 4000;
        // The times stay within the clips: at the seam of a loop the clip itself jumps.
        const Pose now = mixOf({layerOf(walk, 1.9 * double(w), 1 - w), layerOf(run, 1.5 * double(w), w), layerOf(wave, 0.5, w, kArm)});
        if (k > 0) longest = std::max(longest, farthest(before, now));
        before = now;
    }
    EXPECT_LT(longest, 0.01);
    EXPECT_GT(longest, 1e-4);
}

TEST(ClipMix, givesTheSameBytesAgainAndForgetsWhatItMixedBefore) {
    const ClipData walk = randomClip(51, 2), run = randomClip(52, 2), wave = randomClip(53, 2);
    const std::vector<ClipLayer> layers = {layerOf(walk, 0.3, 0.4f), layerOf(run, 1.2, 0.6f), layerOf(wave, 0.9, 0.5f, kArm)};
    ClipMix mix;
    Pose first, again;
    again.before.held[1] = 0.5;
    ASSERT_TRUE(mix.mix(layers, kRig, first));
    const ClipLayer between[] = {layerOf(run, 0.1), layerOf(run, 0.1, 0.5f, 3)};
    Pose other;
    ASSERT_TRUE(mix.mix(between, kRig, other));
    ASSERT_TRUE(mix.mix(layers, kRig, again));
    EXPECT_TRUE(sameBytes(first, again));
}

// ---- travel

GroundPlace randomPlace(std::mt19937& random, double headingRad) {
    std::normal_distribution<double> normal;
    return {headingRad, {normal(random), normal(random)}};
}

void expectSamePlace(const GroundPlace& a, const GroundPlace& b, double tolerance, double what) {
    EXPECT_NEAR(a.shiftM.x, b.shiftM.x, tolerance) << what;
    EXPECT_NEAR(a.shiftM.y, b.shiftM.y, tolerance) << what;
    EXPECT_NEAR(std::remainder(a.headingRad - b.headingRad, 2 * glm::pi<double>()), 0, tolerance) << what;
}

TEST(GroundPlace, repeatsInClosedFormAsOftenAsOneByOne) {
    std::mt19937 random(7);
    const double pi = glm::pi<double>();
    for (const double heading : {0.0, 1e-14, 1e-9, 1e-3, 0.4, 2 * pi / 3, pi, -pi, 2 * pi, 6.0, -7.1}) {
        const GroundPlace step = randomPlace(random, heading);
        GroundPlace one, back;
        for (int rounds = 0; rounds <= 50; ++rounds) {
            expectSamePlace(repeated(step, rounds), one, 1e-10, heading);
            expectSamePlace(repeated(step, -rounds), back, 1e-10, heading);
            one = step * one, back = inverse(step) * back;
        }
    }
}

/** A quarter circle to the left with a radius of a metre, in `seconds`; it starts at the origin and faces as it goes. */
ClipData curve(double seconds, double headingRad = 0) {
    ClipData clip;
    clip.name = "curve";
    clip.channels = {{0, {}}};
    for (int k = 0; k <= 20; ++k) {
        const double a = k / 20.0 * 0.5 * glm::pi<double>(), s = std::sin(headingRad), c = std::cos(headingRad);
        const Vec2d at(1 - std::cos(a), std::sin(a));
        clip.timesS.push_back(float(seconds * k / 20));
        clip.channels[0].rotations.push_back(Quatf(glm::angleAxis(a + headingRad, Vec3d(0, 1, 0))));
        clip.rootTranslations.push_back(Vec3f(Vec3d(c * at.x + s * at.y, 0.01 * k, c * at.y - s * at.x)));
    }
    return clip;
}

TEST(ClipMix, aWalkThatTravelsGoesOnWhereTheRoundBeforeEnded) {
    const ClipData clip = curve(2);
    ClipLayer layer = layerOf(clip, 0);
    layer.travels = true;
    for (const double t : {0.5, 2.5, 4.5, 6.5, 8.5, -1.5, 800.5}) {  // a circle, every round a quarter
        layer.timeS = t;
        const Pose pose = mixOf({layer});
        const double a = t / 2 * 0.5 * glm::pi<double>();
        EXPECT_NEAR(pose.rootTranslation.x, 1 - std::cos(a), 2e-3) << t;
        EXPECT_NEAR(pose.rootTranslation.z, std::sin(a), 2e-3) << t;
        EXPECT_NEAR(pose.rootTranslation.y, 0.05, 1e-5) << "heights stay those of the clip";
        const Vec3f ahead = pose.localRotations[0] * Vec3f(0, 0, 1);
        EXPECT_NEAR(std::remainder(std::atan2(double(ahead.x), double(ahead.z)) - a, 2 * glm::pi<double>()), 0, 1e-4) << t;
    }
    const auto at = [&](double t) {
        layer.timeS = t;
        return mixOf({layer}).rootTranslation;
    };
    const Vec3f seam = at(2 + 1e-6) - at(2 - 1e-6);
    EXPECT_LT(std::hypot(seam.x, seam.z), 1e-4);
    layer.travels = false;
    EXPECT_GT(glm::length(at(2 + 1e-6) - at(2 - 1e-6)), 1) << "as a plain clip jumps";
}

TEST(ClipMix, aJoinedClipGoesOnWhereTheOneBeforeStands) {
    const ClipData before = curve(2, 0.3), after = curve(3, -1.9);
    ClipLayer from = layerOf(before, 9.4), to = layerOf(after, 1);
    from.travels = to.travels = true;
    from.place = {0.7, {4, -2}};
    to.place = placeAfter(from, to, kRig);
    const Pose a = mixOf({from}), b = mixOf({to});
    EXPECT_NEAR(a.rootTranslation.x, b.rootTranslation.x, 1e-5);
    EXPECT_NEAR(a.rootTranslation.z, b.rootTranslation.z, 1e-5);
    EXPECT_LT(test::angleBetween(Quatd(a.localRotations[0]), Quatd(b.localRotations[0])), 0.02);
    expectSamePlace(placeAfter(to, to, kRig), to.place, 1e-6, 0);
    expectSamePlace(placeAfter(from, from, kRig), from.place, 1e-6, 0);
}

TEST(ClipMix, hipsThatSwayDoNotTurnAWalkerWhoIsJoined) {
    ClipData sway = curve(4);
    sway.rootTranslations.clear(), sway.timesS.clear(), sway.channels[0].rotations.clear();
    for (int k = 0; k <= 120; ++k) {  // by 10 degrees, once a second
        sway.timesS.push_back(float(k) / 30);
        sway.channels[0].rotations.push_back(Quatf(glm::angleAxis(0.17 * std::sin(2 * glm::pi<double>() * k / 30), Vec3d(0, 1, 0))));
    }
    EXPECT_NEAR(placeAfter(layerOf(sway, 1.25), layerOf(sway, 1.75), kRig).headingRad, 0, 0.02);
}

TEST(ClipMix, aCrossFadeOfTwoRecordedWalksDoesNotJump) {
    NEED_MOCAP(first, "02_01");
    NEED_MOCAP(second, "07_01");
    const auto walk = retarget(*first, kRig), other = retarget(*second, kRig);
    ASSERT_TRUE(walk && other);
    const double start = 1.2;
    ClipLayer a = layerOf(*walk, 0), b = layerOf(*other, 0.8);
    a.timeS = start;
    b.place = placeAfter(a, b, kRig);
    double fastest = 0, slowest = 1e9;
    Vec3f last(0);
    for (int k = 0; k <= 100; ++k) {  // within a second
        const float share = float(k) / 100;
        a.timeS = start + k * 0.01, b.timeS = 0.8 + k * 0.01;
        a.weight = 1 - share, b.weight = share;
        const Vec3f at = mixOf({a, b}).rootTranslation;
        if (k > 0) {
            const double speed = std::hypot(double(at.x - last.x), double(at.z - last.z)) / 0.01;
            fastest = std::max(fastest, speed), slowest = std::min(slowest, speed);
        }
        last = at;
    }
    EXPECT_LT(fastest, 2.2) << "metres a second";
    EXPECT_GT(slowest, 0.5) << "a person who slides back stops first";
}

// ---- what clothes remember

TEST(ClipMix, clothesRememberAMixAlikeAtEveryRate) {
    const AvatarData tube = test::withCorrectives(makeTube(), 4, {.offsetM = 0.06f, .motion = 4});
    const auto swing = [](double rate, double most) {
        ClipData clip;
        clip.name = "swing", clip.channels = {{0, {}}, {1, {}}};
        for (int k = 0; k <= 120; ++k) {
            clip.timesS.push_back(float(k) / 30);
            clip.channels[0].rotations.push_back(Quatf(glm::angleAxis(0.3 * std::sin(rate * k / 30), Vec3d(0, 1, 0))));
            clip.channels[1].rotations.push_back(Quatf(glm::angleAxis(most * std::sin(0.7 * rate * k / 30), Vec3d(1, 0, 0))));
        }
        return clip;
    };
    const ClipData slow = swing(2, 0.9), fast = swing(4, 0.5);
    const MotionModeData& motion = tube.correctives.motion;
    const auto nodesAt = [&](int hz, bool remembers) {
        ClipMix mix;
        MotionClock clock;
        Pose pose;
        for (int frame = 0; frame <= 3 * hz; ++frame) {
            const double t = double(frame) / hz;
            const float share = float(std::clamp(t - 1, 0.0, 1.0));
            ClipLayer a = layerOf(slow, t, 1 - share), b = layerOf(fast, t, share), over = layerOf(fast, 0.5 * t, 0.5f, 1);
            EXPECT_TRUE(mix.mix(std::vector{a, b, over}, tube.joints, pose));
            clock.setTime(1'000'000'000 + int64_t(frame) * 1'000'000'000 / hz);
            clock.show(motion, pose);
        }
        if (!remembers) pose.before = {};
        std::vector<float> coefficients;
        std::vector<Vec4f> nodes;
        correctiveCoefficients(tube.correctives, pose, coefficients);
        correctiveNodes(tube.correctives, coefficients, nodes);
        return nodes;
    };
    const auto largest = [](const std::vector<Vec4f>& a, const std::vector<Vec4f>& b) {
        float most = 0;
        for (size_t n = 0; n < a.size(); ++n) most = std::max(most, glm::length(Vec3f(a[n]) - Vec3f(b[n])));
        return most;
    };
    const std::vector<Vec4f> slowest = nodesAt(30, true);
    for (const int hz : {72, 90, 120}) EXPECT_LT(largest(slowest, nodesAt(hz, true)), 0.001f) << hz;
    EXPECT_GT(largest(slowest, nodesAt(30, false)), 0.002f) << "what is remembered is twice the tolerance";
}

// ---- refusals

TEST(ClipMix, refusesWhatIsNoMixInASentenceAndKeepsThePose) {
    const ClipData walk = randomClip(61, 1), wave = randomClip(62, 1);
    ClipMix mix;
    Pose pose = samplePose(walk, kRig, 0.3);
    const Pose kept = pose;
    const auto refusal = [&](std::vector<ClipLayer> layers, Code code) {
        const Status status = mix.mix(layers, kRig, pose);
        EXPECT_FALSE(status);
        EXPECT_TRUE(sameBytes(pose, kept));
        if (status) return std::string();
        EXPECT_EQ(status.error().code, code);
        return status.error().message;
    };
    const auto says = [](const std::string& text, const char* what) { return text.find(what) != std::string::npos; };
    const Code wrong = Code::InvalidArgument;
    EXPECT_TRUE(says(refusal({}, wrong), "at least one layer"));
    EXPECT_TRUE(says(refusal({layerOf(walk, 0), layerOf(wave, double(kNan))}, wrong), "layer 1: timeS is not finite"));
    EXPECT_TRUE(says(refusal({layerOf(walk, double(kInfinity))}, wrong), "layer 0: timeS"));
    for (const float weight : {kNan, kInfinity, -0.1f})
        EXPECT_TRUE(says(refusal({layerOf(walk, 0), layerOf(wave, 0, weight, kArm)}, wrong), "layer 1: the weight is")) << weight;
    EXPECT_TRUE(says(refusal({layerOf(walk, 0, 0), layerOf(wave, 0, 0)}, wrong), "sum to 0"));
    EXPECT_TRUE(says(refusal({layerOf(walk, 0, 0), layerOf(wave, 0, 1, kArm)}, wrong), "sum to 0"));
    EXPECT_TRUE(says(refusal({layerOf(wave, 0, 1, kArm), layerOf(walk, 0)}, wrong), "come first"));
    EXPECT_TRUE(says(refusal({layerOf(walk, 0), layerOf(wave, 0, 1, 9999)}, Code::NotFound), "there is no joint 9999"));
    ClipLayer moved = layerOf(walk, 0);
    moved.place.shiftM.y = double(kNan);
    EXPECT_TRUE(says(refusal({moved}, wrong), "the heading or the shift is not finite"));
}

}  // namespace
}  // namespace dpl
