// SPDX-License-Identifier: Apache-2.0
// Weights of other programs by their names: ARKit, Live Link, MediaPipe, VRM; and what is refused.
#include "sdk/avatar/expression_stream.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <string>

#include "tests/not_finite.h"

namespace dpl {
namespace {

float weightOf(const ExpressionWeights& weights, const char* name) {
    return weights[*expressionOf(name)];
}

std::vector<const char*> pointersOf(const std::vector<std::string>& names) {
    std::vector<const char*> out;
    for (const std::string& name : names) out.push_back(name.c_str());
    return out;
}

/** 52 different weights. */
std::vector<float> ramp(size_t count) {
    std::vector<float> weights;
    for (size_t i = 0; i < count; ++i) weights.push_back(float(i % 53) / 64);
    return weights;
}

std::string refusal(std::span<const char* const> names, std::span<const float> weights) {
    const auto result = expressionFrom(names, weights);
    EXPECT_FALSE(result);
    return result ? "" : result.error().message;
}

TEST(ExpressionStream, arkitsWeightsNeedNoNames) {
    const std::vector<float> weights = ramp(52);
    const auto plain = expressionFrom({}, weights), named = expressionFrom(kExpressionNames, weights);
    ASSERT_TRUE(plain && named);
    EXPECT_TRUE(std::equal(weights.begin(), weights.end(), plain->begin()));
    EXPECT_EQ(*named, *plain);
}

TEST(ExpressionStream, arkitsRawValuesInSwiftNameSidesByALetter) {
    const char* names[] = {"eyeBlink_L", "mouthSmile_R", "jawLeft"};
    const float given[] = {0.25f, 0.5f, 0.75f};
    const auto taken = expressionFrom(names, given);
    ASSERT_TRUE(taken);
    EXPECT_EQ(weightOf(*taken, "eyeBlinkLeft"), 0.25f);
    EXPECT_EQ(weightOf(*taken, "mouthSmileRight"), 0.5f);
    EXPECT_EQ(weightOf(*taken, "jawLeft"), 0.75f);
    EXPECT_EQ(std::accumulate(taken->begin(), taken->end(), 0.0f), 1.5f);
    for (const char* unknown : {"jaw_Q", "_L", "browInnerUp_L"})
        EXPECT_NE(refusal({&unknown, 1}, {given, 1}).find(std::string("'") + unknown + "'"), std::string::npos) << unknown;
}

TEST(ExpressionStream, liveLinksAnglesAreLeftOut) {
    std::vector<std::string> names;
    for (const char* name : kExpressionNames) {
        names.push_back(name);
        names.back()[0] = char(names.back()[0] - 'a' + 'A');
    }
    for (const char* angle :
         {"HeadYaw", "HeadPitch", "HeadRoll", "LeftEyeYaw", "LeftEyePitch", "LeftEyeRoll", "RightEyeYaw", "RightEyePitch", "RightEyeRoll"})
        names.push_back(angle);
    const std::vector<float> weights = ramp(61);
    const auto named = expressionFrom(pointersOf(names), weights), plain = expressionFrom({}, weights);
    ASSERT_TRUE(named && plain);
    EXPECT_EQ(*named, *plain);
    EXPECT_TRUE(std::equal(plain->begin(), plain->end(), weights.begin()));
}

TEST(ExpressionStream, mediaPipesOrderIsTakenFromItsNames) {
    std::vector<std::string> names(kExpressionNames.begin(), kExpressionNames.end() - 1);  // no tongueOut
    std::sort(names.begin(), names.end());
    names.insert(names.begin(), "_neutral");
    ASSERT_EQ(names.size(), 52u);
    std::vector<float> weights = ramp(52);
    weights[0] = 0.9f;
    const auto result = expressionFrom(pointersOf(names), weights);
    ASSERT_TRUE(result);
    for (size_t i = 1; i < names.size(); ++i) EXPECT_EQ(weightOf(*result, names[i].c_str()), weights[i]) << names[i];
    EXPECT_EQ(weightOf(*result, "tongueOut"), 0);
}

TEST(ExpressionStream, vrmsPresetsAreMixtures) {
    const auto one = [](const char* name, float weight) { return *expressionFrom({&name, 1}, {&weight, 1}); };
    EXPECT_EQ(weightOf(one("blink", 0.5f), "eyeBlinkLeft"), 0.5f);
    EXPECT_EQ(weightOf(one("blink", 0.5f), "eyeBlinkRight"), 0.5f);
    EXPECT_EQ(weightOf(one("blinkLeft", 1), "eyeBlinkRight"), 0);
    EXPECT_EQ(weightOf(one("aa", 1), "jawOpen"), 0.7f);
    EXPECT_EQ(weightOf(one("happy", 0.5f), "mouthSmileLeft"), 0.4f);
    EXPECT_EQ(weightOf(one("lookLeft", 1), "eyeLookOutLeft"), 1);
    EXPECT_EQ(weightOf(one("lookLeft", 1), "eyeLookInRight"), 1);
    for (const char* preset : {"happy", "angry", "sad", "relaxed", "surprised", "aa", "ih", "ou", "ee", "oh", "blink", "blinkLeft",
                               "blinkRight", "lookUp", "lookDown", "lookLeft", "lookRight"})
        EXPECT_NE(one(preset, 1), ExpressionWeights{}) << preset;
    EXPECT_EQ(one("neutral", 1), ExpressionWeights{});
    const char* both[] = {"aa", "surprised"};
    const float weights[] = {1, 1};
    EXPECT_EQ(weightOf(*expressionFrom(both, weights), "jawOpen"), 1) << "0.7 + 0.4, held in 0 to 1";
}

TEST(ExpressionStream, refusesWhatItCannotTell) {
    for (const size_t count : {0u, 1u, 51u, 53u, 60u, 62u})
        EXPECT_NE(refusal({}, ramp(count)).find("without names"), std::string::npos) << count;
    const char* smirk = "smirk";
    const char* none = nullptr;
    const char* jaw = "jawOpen";
    const float half = 0.5f, bad = kNan;
    EXPECT_NE(refusal({&smirk, 1}, {&half, 1}).find("'smirk'"), std::string::npos);
    EXPECT_NE(refusal({&none, 1}, {&half, 1}).find("NULL"), std::string::npos);
    EXPECT_NE(refusal({&jaw, 1}, {&bad, 1}).find("'jawOpen' is not a number"), std::string::npos);
    const float wild[] = {3};
    EXPECT_EQ(weightOf(*expressionFrom({&jaw, 1}, wild), "jawOpen"), 1);
}

}  // namespace
}  // namespace dpl
