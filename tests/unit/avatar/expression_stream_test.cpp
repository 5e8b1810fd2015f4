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

TEST(ExpressionStream, vrm0sNamesMeanWhatVrm1sDo) {
    const float half = 0.5f;
    const auto one = [&](const char* name) { return *expressionFrom({&name, 1}, {&half, 1}); };
    const std::pair<const char*, const char*> same[] = {{"joy", "happy"},
                                                        {"angry", "angry"},
                                                        {"sorrow", "sad"},
                                                        {"fun", "relaxed"},
                                                        {"a", "aa"},
                                                        {"i", "ih"},
                                                        {"u", "ou"},
                                                        {"e", "ee"},
                                                        {"o", "oh"},
                                                        {"blink", "blink"},
                                                        {"blink_l", "blinkLeft"},
                                                        {"blink_r", "blinkRight"},
                                                        {"lookup", "lookUp"},
                                                        {"lookdown", "lookDown"},
                                                        {"lookleft", "lookLeft"},
                                                        {"lookright", "lookRight"},
                                                        {"Joy", "happy"},
                                                        {"Blink_L", "blinkLeft"},
                                                        {"LookUp", "lookUp"},
                                                        {"A", "aa"}};
    for (const auto& [before, now] : same) {
        EXPECT_EQ(one(before), one(now)) << before;
        EXPECT_NE(one(before), ExpressionWeights{}) << before;
    }
    EXPECT_EQ(one("Neutral"), ExpressionWeights{});
}

TEST(ExpressionStream, openXrsWeightsNeedNoNames) {
    const auto fed = [](size_t count, std::initializer_list<std::pair<size_t, float>> given) {
        std::vector<float> weights(count);
        for (const auto& [i, weight] : given) weights[i] = weight;
        return *expressionFrom({}, weights);
    };
    for (const size_t count : {63u, 70u}) {  // XR_FB_face_tracking, XR_FB_face_tracking2
        EXPECT_EQ(weightOf(fed(count, {{24, 0.5f}}), "jawOpen"), 0.5f) << "XR_FACE_EXPRESSION2_JAW_DROP_FB";
        EXPECT_EQ(weightOf(fed(count, {{12, 1.0f}}), "eyeBlinkLeft"), 1) << "EYES_CLOSED_L";
        EXPECT_EQ(weightOf(fed(count, {{62, 1.0f}}), "mouthUpperUpRight"), 1) << "UPPER_LIP_RAISER_R";
        // Both eyes look to the subject's left: the left one outwards, the right one inwards.
        const ExpressionWeights aside = fed(count, {{16, 0.5f}, {17, 0.5f}});
        EXPECT_EQ(weightOf(aside, "eyeLookOutLeft") + weightOf(aside, "eyeLookInRight"), 1);
        EXPECT_EQ(std::accumulate(aside.begin(), aside.end(), 0.0f), 1);
        EXPECT_EQ(weightOf(fed(count, {{2, 1.0f}}), "cheekPuff"), 0.5f) << "one cheek of two";
        EXPECT_EQ(weightOf(fed(count, {{34, 1.0f}, {35, 1.0f}, {36, 1.0f}, {37, 1.0f}}), "mouthFunnel"), 1) << "four quarters";
    }
    EXPECT_EQ(weightOf(fed(70, {{68, 0.75f}}), "tongueOut"), 0.75f);
    EXPECT_EQ(fed(70, {{6, 1.0f}, {48, 1.0f}, {69, 1.0f}}), ExpressionWeights{}) << "cheeks sucked in, lips tightened: ARKit has none";
    const auto all = expressionFrom({}, std::vector<float>(70, 1.0f));
    ASSERT_TRUE(all);
    for (const float weight : *all) EXPECT_EQ(weight, 1) << "all 52 are reached, none beyond 1";
}

TEST(ExpressionStream, openXrsNamesGoWithAndWithoutTheirPrefix) {
    const float half = 0.5f;
    for (const char* name : {"JAW_DROP", "XR_FACE_EXPRESSION2_JAW_DROP_FB", "XR_FACE_EXPRESSION_JAW_DROP_FB"})
        EXPECT_EQ(weightOf(*expressionFrom({&name, 1}, {&half, 1}), "jawOpen"), 0.5f) << name;
    const char* none = "XR_FACE_EXPRESSION2_COUNT_FB";
    EXPECT_NE(refusal({&none, 1}, {&half, 1}).find("COUNT"), std::string::npos);
}

TEST(ExpressionStream, swappedSidesMirrorTheFaceAndDoNoMore) {
    std::vector<std::string> names(kExpressionNames.begin(), kExpressionNames.end()), swapped;
    for (const std::string& name : names) {
        std::string other = name;
        if (name.ends_with("Left")) other = name.substr(0, name.size() - 4) + "Right";
        if (name.ends_with("Right")) other = name.substr(0, name.size() - 5) + "Left";
        swapped.push_back(other);
    }
    const std::vector<float> weights = ramp(52);
    const auto right = expressionFrom(pointersOf(names), weights), wrong = expressionFrom(pointersOf(swapped), weights);
    ASSERT_TRUE(right && wrong);
    for (size_t i = 0; i < names.size(); ++i) EXPECT_EQ(weightOf(*wrong, swapped[i].c_str()), weightOf(*right, names[i].c_str()));
}

TEST(ExpressionStream, refusesWhatItCannotTell) {
    for (const size_t count : {0u, 1u, 51u, 53u, 60u, 62u, 64u, 69u, 71u})
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
