// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/makehuman.h"

#include <gtest/gtest.h>

#include "reconstruction/input/capture/hand_keypoints.h"
#include "reconstruction/subject/body/body_io.h"
#include "reconstruction/subject/body/body_tools.h"
#include "tests/unit/shared_data.h"

namespace dpl {
namespace {

/** Imported once: reading the targets takes about a second. */
const BodyModel* makeHuman() {
    static const auto body = []() -> std::optional<BodyModel> {
        const auto folder = sharedData("body-makehuman");
        if (!folder) return std::nullopt;
        auto imported = importMakeHuman(*folder);
        if (!imported) {
            ADD_FAILURE() << imported.error().message;
            return std::nullopt;
        }
        return std::move(*imported);
    }();
    return body ? &*body : nullptr;
}

#define NEED_MAKEHUMAN()                                                                                    \
    if (!sharedData("body-makehuman")) GTEST_SKIP() << "shared/data/body-makehuman is not on this machine"; \
    ASSERT_NE(makeHuman(), nullptr);                                                                        \
    const BodyModel& body = *makeHuman()

const BodyKeypoint* keypoint(const BodyModel& body, std::string_view name) {
    for (const BodyKeypoint& k : body.keypoints)
        if (k.name == name) return &k;
    return nullptr;
}

Vec3f place(const BodyModel& body, const BodyKeypoint& k) {
    Vec3f p(0);
    for (auto [v, w] : k.vertices) p += w * body.mesh.restPositions[v];
    for (auto [j, w] : k.joints) p += w * body.joints[j].restPosition;
    return p;
}

TEST(MakeHuman, isAnAdultInMetresOnTheFloorFacingForward) {
    NEED_MAKEHUMAN();
    EXPECT_EQ(body.mesh.restPositions.size(), 14136u);  // skin, eyeballs, teeth, tongue, lashes
    EXPECT_EQ(body.mesh.triangles.size(), 28044u);
    EXPECT_EQ(body.joints.size(), 55u);
    EXPECT_EQ(body.joints[0].name, "pelvis");
    float top = 0, low = 1;
    for (const Vec3f& p : body.mesh.restPositions) top = std::max(top, p.y), low = std::min(low, p.y);
    EXPECT_GT(top, 1.55f);
    EXPECT_LT(top, 1.85f);
    EXPECT_NEAR(low, 0, 0.01f);
    EXPECT_GT(place(body, *keypoint(body, "nose")).z, 0.05f);
    EXPECT_GT(body.joints[size_t(findHumanoid(body, "leftHand"))].restPosition.x, 0.3f);
}

TEST(MakeHuman, has24KeypointsAndTheHumanoidBones) {
    NEED_MAKEHUMAN();
    for (const std::string_view name : scanKeypointNames()) EXPECT_NE(keypoint(body, name), nullptr) << name;
    for (const char* bone :
         {"hips", "spine", "chest", "upperChest", "neck", "head", "leftShoulder", "leftUpperArm", "leftLowerArm", "leftHand",
          "rightUpperLeg", "rightLowerLeg", "rightFoot", "rightToes", "leftThumbProximal", "leftIndexProximal", "rightLittleDistal"})
        EXPECT_GE(findHumanoid(body, bone), 0) << bone;
    for (const std::string_view name : handKeypointNames()) ASSERT_NE(keypoint(body, name), nullptr) << name;
    for (const char* finger : {"thumb", "index", "middle", "ring", "pinky"}) {
        const Vec3d end = place(body, *keypoint(body, std::string(finger) + "3_l")),
                    tip = place(body, *keypoint(body, std::string(finger) + "4_l"));
        EXPECT_GT(glm::length(tip - end), 0.012f) << finger;  // the last bones of adults are 16 to 27 mm long, with their tips
        EXPECT_LT(glm::length(tip - end), 0.04f) << finger;
    }
    EXPECT_LT(std::abs(place(body, *keypoint(body, "eye_l")).x - 0.03f), 0.01f);  // half the distance between adult pupils is 31 mm
}

TEST(MakeHuman, eyeballsFollowTheirEyesAndLidsTheHead) {
    NEED_MAKEHUMAN();
    const int32_t left = findHumanoid(body, "leftEye"), right = findHumanoid(body, "rightEye"), head = findHumanoid(body, "head");
    ASSERT_GE(left, 0);
    ASSERT_GE(right, 0);
    EXPECT_EQ(body.joints[size_t(left)].parent, head);
    const auto onJoint = [&](uint32_t v, int32_t joint) {
        int weight = 0;
        for (int i = 0; i < 4; ++i) weight += int32_t(body.mesh.jointIndices[v][i]) == joint ? body.mesh.jointWeights[v][i] : 0;
        return weight;
    };
    size_t leftCount = 0, rightCount = 0;
    for (uint32_t v = 0; v < body.mesh.restPositions.size(); ++v) {
        if (onJoint(v, left) + onJoint(v, right) == 0) continue;
        EXPECT_GE(v, 13380u) << "skin on an eye";
        EXPECT_EQ(onJoint(v, left) + onJoint(v, right), 255);
        ++(onJoint(v, left) ? leftCount : rightCount);
        const Vec3f from = body.mesh.restPositions[v] - body.joints[size_t(onJoint(v, left) ? left : right)].restPosition;
        EXPECT_NEAR(glm::length(from), 0.0154f, 0.0006f) << "the joint is not in the middle of the eyeball";
    }
    EXPECT_EQ(leftCount, 72u);
    EXPECT_EQ(rightCount, 72u);
}

TEST(MakeHuman, lowerTeethAndChinFollowTheJaw) {
    NEED_MAKEHUMAN();
    const int32_t jaw = findHumanoid(body, "jaw");
    ASSERT_GE(jaw, 0);
    const auto withJaw = [&](uint32_t v) {
        int weight = 0;
        for (int i = 0; i < 4; ++i) weight += int32_t(body.mesh.jointIndices[v][i]) == jaw ? body.mesh.jointWeights[v][i] : 0;
        return weight / 255.0f;
    };
    EXPECT_GT(withJaw(732), 0.5f) << "the lowest of the chin";
    EXPECT_EQ(withJaw(297), 0.0f) << "the tip of the nose";
    size_t whole = 0;
    for (uint32_t v = 13380; v < body.mesh.restPositions.size(); ++v) whole += withJaw(v) > 0.99f;
    EXPECT_GE(whole, 68u + 226u) << "lower teeth and tongue";
}

TEST(MakeHuman, dataWithoutTheDefaultRigGiveABodyWithoutJointsOfTheFace) {
    if (!sharedData("body-makehuman")) GTEST_SKIP() << "shared/data/body-makehuman is not on this machine";
    const auto folder = std::filesystem::path(testing::TempDir()) / "makehuman_without_rig";
    std::filesystem::create_directories(folder);
    std::filesystem::remove(folder / "mpfb2");
    std::filesystem::create_directory_symlink(*sharedData("body-makehuman") / "mpfb2", folder / "mpfb2");
    const auto body = importMakeHuman(folder);
    ASSERT_TRUE(body) << body.error().message;
    EXPECT_EQ(body->joints.size(), 52u);
    EXPECT_EQ(body->mesh.restPositions.size(), 14136u);
}

TEST(MakeHuman, heightMorphRaisesTheHeadAndKeepsTheFeetOnTheFloor) {
    NEED_MAKEHUMAN();
    ASSERT_EQ(body.morphs[0].name, "height");
    const BodyModel tall = shapedBody(body, std::vector<double>{1.0});
    const int32_t head = findHumanoid(body, "head");
    EXPECT_GT(tall.joints[size_t(head)].restPosition.y - body.joints[size_t(head)].restPosition.y, 0.04f);
    float low = 1;
    for (const Vec3f& p : tall.mesh.restPositions) low = std::min(low, p.y);
    EXPECT_NEAR(low, 0, 0.01f);
}

TEST(MakeHuman, jointsStayInsideTheBodyWhenItMorphs) {
    NEED_MAKEHUMAN();
    // The elbow is the mean of its cube; after a change of arm length it must still lie between shoulder and wrist.
    std::vector<double> shape(body.morphs.size(), 0.0);
    for (size_t m = 0; m < shape.size(); ++m)
        if (body.morphs[m].name.find("arm_length") != std::string::npos) shape[m] = 2;
    const BodyModel longArms = shapedBody(body, shape);
    const auto length = [](const BodyModel& b, const char* from, const char* to) {
        return glm::length(b.joints[size_t(findHumanoid(b, from))].restPosition - b.joints[size_t(findHumanoid(b, to))].restPosition);
    };
    EXPECT_GT(length(longArms, "leftUpperArm", "leftLowerArm"), length(body, "leftUpperArm", "leftLowerArm") + 0.005f);
    EXPECT_NEAR(length(longArms, "leftUpperArm", "leftLowerArm"), length(longArms, "rightUpperArm", "rightLowerArm"),
                2e-3f);  // hm08's targets are symmetric to a millimetre or two
}

TEST(MakeHuman, survivesTheRoundTripThroughGltf) {
    NEED_MAKEHUMAN();
    const auto bytes = encodeBody(body);
    ASSERT_TRUE(bytes);
    const auto back = decodeBody(*bytes, "x");
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(back->mesh.restPositions, body.mesh.restPositions);
    EXPECT_EQ(back->morphs.back().jointOffsets, body.morphs.back().jointOffsets);
}

TEST(MakeHuman, wrongFolderIsNamedWithTheRemedy) {
    const auto body = importMakeHuman("/tmp");
    ASSERT_FALSE(body);
    EXPECT_NE(body.error().message.find("base.obj"), std::string::npos);
}

}  // namespace
}  // namespace dpl
