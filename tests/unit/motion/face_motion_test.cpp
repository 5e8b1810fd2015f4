// SPDX-License-Identifier: Apache-2.0
// What a face does by itself: people's rates and times of blinks, small glances, nothing that jumps, and streams that fade when they stop.
#include "sdk/motion/face_motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sdk/format/expression_names.h"
#include "tests/not_finite.h"

namespace dpl {
namespace {

constexpr int64_t kMs = 1'000'000, kSecond = 1000 * kMs, kHour = 3600 * kSecond;

size_t at(const char* name) {
    return *expressionOf(name);
}

TEST(FaceMotion, blinksAsPeopleAtRestDo) {
    for (const uint32_t seed : {1u, 2u, 4'000'000'000u}) {
        double closedAtMs = 0, fullAtMs = 0, last = 0;
        std::vector<double> closingMs, openingMs, beganS;
        for (int64_t ms = -1000; ms < kHour / kMs; ++ms) {
            const double closed = blinkAt(seed, ms * kMs);
            ASSERT_GE(closed, 0);
            ASSERT_LE(closed, 1);
            ASSERT_LE(std::abs(closed - last), 0.025) << "it jumps at " << ms << " ms";  // 1.5 / 75 ms, the steepest
            if (last == 0 && closed > 0) closedAtMs = double(ms), beganS.push_back(1e-3 * double(ms));
            if (closed > 0.9999 && closedAtMs > 0) fullAtMs = double(ms);
            if (last > 0 && closed == 0 && fullAtMs > closedAtMs)
                closingMs.push_back(fullAtMs - closedAtMs), openingMs.push_back(double(ms) - fullAtMs);
            last = closed;
        }
        EXPECT_GE(double(beganS.size()) / 60, 15) << seed;
        EXPECT_LE(double(beganS.size()) / 60, 20) << seed;
        for (const auto& [times, least, most] : {std::tuple(&closingMs, 73, 102), {&openingMs, 148, 202}}) {
            ASSERT_GT(times->size(), 800u);
            EXPECT_GE(*std::min_element(times->begin(), times->end()), least);
            EXPECT_LE(*std::max_element(times->begin(), times->end()), most);
        }
        double mean = 0, square = 0, cube = 0;
        const size_t gaps = beganS.size() - 1;
        for (size_t i = 0; i < gaps; ++i) mean += (beganS[i + 1] - beganS[i]) / double(gaps);
        for (size_t i = 0; i < gaps; ++i) {
            const double off = beganS[i + 1] - beganS[i] - mean;
            square += off * off / double(gaps), cube += off * off * off / double(gaps);
        }
        EXPECT_GT(cube / std::pow(square, 1.5), 1) << "long times between blinks are rare and long, as those of people";
    }
}

TEST(FaceMotion, glancesAreSmallAndNeverJump) {
    for (const uint32_t seed : {1u, 7u}) {
        size_t fixations = 0, moves = 0;
        bool moved = false;
        Vec2d last = glanceAt(seed, 0);
        double farthest = 0, sum = 0;
        for (int64_t ms = 0; ms < 600'000; ++ms) {
            const Vec2d now = glanceAt(seed, ms * kMs);
            farthest = std::max(farthest, glm::length(now)), sum += now.x;
            const double stepDeg = glm::length(now - last);
            ASSERT_LE(stepDeg, 0.4) << ms;  // people's eyes do 5 degrees at up to 250 degrees a second
            moves += stepDeg > 0;
            fixations += moved && stepDeg == 0;
            moved = stepDeg > 0, last = now;
        }
        EXPECT_LE(farthest, kFarthestGlanceDeg);
        EXPECT_GT(farthest, 3);
        EXPECT_LT(std::abs(sum) / 600'000, 0.3) << "no side is preferred";
        EXPECT_GT(fixations, 300u);
        EXPECT_LT(fixations, 600u);
        EXPECT_LT(moves, 30'000u) << "the eyes rest most of the time";
    }
}

TEST(FaceMotion, isAFunctionOfSeedAndTime) {
    const FaceMotion motion{3, 1, 1, 0, 0};
    std::vector<ExpressionWeights> forwards;
    for (int64_t i = -50; i < 500; ++i) forwards.push_back(faceAt({}, motion, i * 130 * kMs));
    for (int64_t i = 499; i >= -50; --i) EXPECT_EQ(faceAt({}, motion, i * 130 * kMs), forwards[size_t(i + 50)]);
    EXPECT_TRUE(std::any_of(forwards.begin(), forwards.end(), [](const auto& w) { return w[at("eyeBlinkLeft")] > 0.5f; }));
    FaceMotion other = motion;
    other.seed = 4;
    size_t apart = 0;
    for (int64_t i = 0; i < 500; ++i) apart += faceAt({}, other, i * 130 * kMs) != forwards[size_t(i + 50)];
    EXPECT_GT(apart, 400u) << "people of other seeds do other things";
    for (const int64_t far : {INT64_MIN, INT64_MAX, int64_t(1'800'000'000) * kSecond}) {
        const auto weights = faceAt({}, motion, far);
        EXPECT_TRUE(std::all_of(weights.begin(), weights.end(), [](float w) { return w >= 0 && w <= 1; }));
    }
}

TEST(FaceMotion, addsToWhatIsSetAndStaysInRange) {
    ExpressionWeights given{};
    given[at("eyeBlinkLeft")] = 0.4f, given[at("jawOpen")] = 0.7f;
    EXPECT_EQ(faceAt(given, {9, 0, 0, 0, 0}, 123 * kSecond), given) << "zeros add nothing: the same bytes";
    bool full = false, looked = false;
    for (int64_t ms = 0; ms < 60'000; ms += 10) {
        const auto idle = faceAt({}, {9, 1, 1, 0, 0}, ms * kMs), both = faceAt(given, {9, 1, 1, 0, 0}, ms * kMs);
        EXPECT_FLOAT_EQ(both[at("eyeBlinkLeft")], std::min(1.0f, 0.4f + idle[at("eyeBlinkLeft")]));
        EXPECT_EQ(idle[at("eyeBlinkLeft")], idle[at("eyeBlinkRight")]);
        EXPECT_EQ(both[at("jawOpen")], 0.7f) << "idle faces do not speak";
        EXPECT_EQ(idle[at("eyeLookOutLeft")], idle[at("eyeLookInRight")]) << "both eyes look to the same side";
        EXPECT_TRUE(idle[at("eyeLookInLeft")] == 0 || idle[at("eyeLookOutLeft")] == 0);
        EXPECT_LE(idle[at("eyeLookOutLeft")], 0.15f) << "5 of 34 degrees";
        full |= idle[at("eyeBlinkLeft")] > 0.95f, looked |= idle[at("eyeLookOutLeft")] > 0.01f;
    }
    EXPECT_TRUE(full && looked);
}

TEST(FaceMotion, aStreamThatStopsFadesToNeutral) {
    ExpressionWeights given{};
    given[at("jawOpen")] = 0.8f;
    const FaceMotion motion{0, 0, 0, 0.3f, 10 * kSecond};
    const auto shown = [&](int64_t ms) { return faceAt(given, motion, 10 * kSecond + ms * kMs)[at("jawOpen")]; };
    EXPECT_EQ(shown(-5000), 0.8f) << "pictures of before";
    EXPECT_EQ(shown(0), 0.8f);
    EXPECT_EQ(shown(299), 0.8f);
    EXPECT_NEAR(shown(425), 0.4f, 1e-5f) << "half way after 0.125 s";
    EXPECT_EQ(shown(551), 0);
    EXPECT_EQ(shown(3'600'000), 0);
    for (int64_t ms = 290; ms < 560; ++ms) EXPECT_LE(shown(ms) - shown(ms + 1), 0.8f * 0.0061f) << "nothing jumps";
    FaceMotion kept = motion;
    kept.holdS = 0;
    EXPECT_EQ(faceAt(given, kept, kHour), given) << "an expression that is no stream's stays";
}

TEST(FaceMotion, refusesNumbersThatMeanNothing) {
    for (const float bad : {kNan, kInfinity, -kInfinity, -0.1f, 1.1f}) {
        EXPECT_EQ(checkFaceMotion({0, bad, 0, 0, 0}).error().code, Code::InvalidArgument) << bad;
        EXPECT_NE(checkFaceMotion({0, 0, bad, 0, 0}).error().message.find("glances"), std::string::npos) << bad;
    }
    for (const float bad : {kNan, kInfinity, -1.0f, 3601.0f}) EXPECT_FALSE(checkFaceMotion({0, 0, 0, bad, 0})) << bad;
    EXPECT_TRUE(checkFaceMotion({0, 1, 1, 3600, INT64_MIN}));
}

}  // namespace
}  // namespace dpl
