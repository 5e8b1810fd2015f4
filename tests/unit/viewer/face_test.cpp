// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/face.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "sdk/format/avatar_file.h"
#include "sdk/format/expression_names.h"
#include "tests/package/tiny_avatar.h"
#include "tests/unit/format/sample_expressions.h"

namespace {

using namespace dpl;

std::array<std::string, DPL_EXPRESSION_COUNT> allNames() {
    std::array<std::string, DPL_EXPRESSION_COUNT> names;
    std::copy(kExpressionNames.begin(), kExpressionNames.end(), names.begin());
    return names;
}

FaceByHand wholeFace() {
    std::vector<uint32_t> held(DPL_EXPRESSION_COUNT);
    std::iota(held.begin(), held.end(), 0u);
    return FaceByHand::of(allNames(), held);
}

const FaceSlider& only(const FaceByHand& face, const char* search) {
    const auto found = face.sliders(search);
    EXPECT_EQ(found.size(), 1u) << search;
    return *found.at(0);
}

uint32_t indexOf(const char* name) {
    return uint32_t(*expressionOf(name));
}

TEST(FaceSliders, haveAllExpressionsOnceBySide) {
    FaceByHand face = wholeFace();
    face.together = false;
    EXPECT_EQ(face.sliders("").size(), size_t(DPL_EXPRESSION_COUNT));
    face.together = true;
    std::array<int, DPL_EXPRESSION_COUNT> moved{};
    for (const FaceSlider* slider : face.sliders("")) {
        ++moved[slider->expressions[0]];
        if (slider->expressions[1] != slider->expressions[0]) ++moved[slider->expressions[1]];
    }
    EXPECT_TRUE(std::all_of(moved.begin(), moved.end(), [](int times) { return times == 1; }));
}

TEST(FaceSliders, moveLeftAndRightTogetherOrAlone) {
    FaceByHand face = wholeFace();
    face.set(only(face, "blink"), 0.5f);
    EXPECT_EQ(face.weights[indexOf("eyeBlinkLeft")], 0.5f);
    EXPECT_EQ(face.weights[indexOf("eyeBlinkRight")], 0.5f);
    EXPECT_FALSE(face.isNeutral());
    face.together = false;
    face.set(only(face, "eyeBlinkRight"), 0);
    EXPECT_EQ(face.weights[indexOf("eyeBlinkLeft")], 0.5f);
    EXPECT_EQ(face.weights[indexOf("eyeBlinkRight")], 0);
    EXPECT_EQ(only(face, "eye blink left").words, "eye blink left");
}

TEST(FaceSliders, bothEyesLookToOneSide) {
    FaceByHand face = wholeFace();
    face.set(only(face, "look left"), 1);
    EXPECT_EQ(face.weights[indexOf("eyeLookOutLeft")], 1);
    EXPECT_EQ(face.weights[indexOf("eyeLookInRight")], 1);
    EXPECT_EQ(face.weights[indexOf("eyeLookInLeft")], 0);
}

TEST(FaceSliders, aMouthThatGoesLeftHasNoOtherSide) {
    FaceByHand face = wholeFace();
    face.set(only(face, "mouthLeft"), 1);
    EXPECT_EQ(std::count(face.weights.begin(), face.weights.end(), 1.0f), 1);
}

TEST(FaceSliders, areFoundByWordsAndNamesInAnyCase) {
    const FaceByHand face = wholeFace();
    EXPECT_EQ(only(face, "SMILE").names, "mouthSmileLeft, mouthSmileRight");
    EXPECT_EQ(only(face, "jawopen").region, FaceRegion::Jaw);
    EXPECT_TRUE(face.sliders("smirk").empty());
    const auto all = face.sliders("");
    EXPECT_TRUE(std::is_sorted(all.begin(), all.end(), [](const auto* a, const auto* b) { return a->region < b->region; }));
    EXPECT_EQ(only(face, "sneer").region, FaceRegion::Cheeks);
    EXPECT_EQ(only(face, "tongue").region, FaceRegion::Tongue);
}

TEST(FaceSliders, areThoseThatTheAvatarHolds) {
    const auto context = doppel::Context::create(DPL_RENDERER_SOFTWARE, 1);
    ASSERT_TRUE(context);
    AvatarData plain = test::tinyAvatar();
    sortSplats(plain);
    const auto without = context->loadAvatar(*writeAvatar(plain));
    const auto with = context->loadAvatar(*writeAvatar(test::withExpressions(plain, 3, 4, 0.05f)));
    ASSERT_TRUE(without && with);
    EXPECT_FALSE(FaceByHand::of(*without)->any());
    auto face = FaceByHand::of(*with);
    ASSERT_TRUE(face && face->any());
    EXPECT_EQ(face->sliders("").size(), 4u) << "one side alone is a slider too";
}

}  // namespace
