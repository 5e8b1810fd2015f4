// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/rest_shoulders.h"

#include <gtest/gtest.h>

#include <random>

#include "reconstruction/subject/body/body_truth.h"
#include "sdk/math/skinning.h"
#include "small_body.h"

namespace dpl {
namespace {

/** A fit whose still pose turns the shoulders by unlike angles, with limbs bent in every frame. */
BodyFit anyFit(const BodyModel& body, uint32_t seed) {
    std::mt19937 random(seed);
    std::normal_distribution<float> normal;
    const auto any = [&] {
        Pose pose = Pose::rest(body.joints.size());
        for (Quatf& q : pose.localRotations)
            q = glm::normalize(Quatf(1, 0.3f * normal(random), 0.3f * normal(random), 0.3f * normal(random)));
        pose.rootTranslation = {normal(random), normal(random), normal(random)};
        return pose;
    };
    BodyFit fit;
    fit.staticPose = any();
    for (int frame = 0; frame < 5; ++frame) fit.poses.push_back(any());
    fit.poses[0] = fit.staticPose;
    for (size_t k = 0; k < scanKeypointNames().size(); ++k)
        fit.landmarks.push_back({uint32_t(k % body.joints.size()), 0.02 * Vec3d(normal(random), normal(random), normal(random))});
    return fit;
}

std::vector<Vec3f> posed(const BodyModel& body, const Pose& pose) {
    std::vector<Mat3x4f> worldFromRest;
    jointTransforms(body.joints, pose, worldFromRest);
    std::vector<Vec3f> at;
    for (size_t j = 0; j < body.joints.size(); ++j) at.push_back(transformed(worldFromRest[j], body.joints[j].restPosition));
    for (size_t v = 0; v < body.mesh.restPositions.size(); ++v)
        at.push_back(skinVertex(body.mesh.restPositions[v], body.mesh.jointIndices[v], body.mesh.jointWeights[v], worldFromRest.data()));
    return at;
}

TEST(RestShoulders, everyPoseStaysWhereItWas) {
    const BodyModel was = smallBody();
    for (uint32_t seed = 0; seed < 20; ++seed) {
        BodyModel body = was;
        BodyFit fit = anyFit(was, seed);
        const BodyFit before = fit;
        restShouldersAsScanned(body, fit);
        const std::vector<std::string> names(scanKeypointNames().begin(), scanKeypointNames().end());
        for (size_t f = 0; f < fit.poses.size(); ++f) {
            const std::vector<Vec3f> is = posed(body, fit.poses[f]), should = posed(was, before.poses[f]);
            for (size_t i = 0; i < is.size(); ++i) ASSERT_LT(glm::length(is[i] - should[i]), 2e-6f) << "frame " << f << ", point " << i;
            const auto marks = posedKeypoints(body, fit.poses[f], names, fit.landmarks),
                       marksBefore = posedKeypoints(was, before.poses[f], names, before.landmarks);
            for (size_t k = 0; k < marks.size(); ++k) ASSERT_LT(glm::length(marks[k].place - marksBefore[k].place), 2e-6) << names[k];
        }
    }
}

TEST(RestShoulders, theStillPoseTurnsNoShoulder) {
    const auto place = [](const BodyModel& body, const std::string& bone) {
        return body.joints[size_t(findHumanoid(body, bone))].restPosition;
    };
    const BodyModel was = smallBody();
    BodyModel body = was;
    BodyFit fit = anyFit(body, 1);
    restShouldersAsScanned(body, fit);
    for (const char* bone : {"leftShoulder", "rightShoulder"})
        EXPECT_GT(std::abs(fit.staticPose.localRotations[size_t(findHumanoid(body, bone))].w), 1 - 1e-6f) << bone;
    EXPECT_GT(glm::length(place(body, "leftUpperArm") - place(was, "leftUpperArm")), 0.01f);
    for (const std::string side : {"left", "right"})
        EXPECT_LT(glm::length(place(body, side + "LowerArm") - place(body, side + "UpperArm") -
                              (place(was, side + "LowerArm") - place(was, side + "UpperArm"))),
                  1e-6f)
            << "arms keep their direction";
}

TEST(RestShoulders, aBodyWithoutShouldersStays) {
    BodyModel body = smallBody();
    for (JointData& joint : body.joints)
        if (joint.humanoidBone.ends_with("Shoulder")) joint.humanoidBone.clear();
    const std::vector<Vec3f> before = body.mesh.restPositions;
    BodyFit fit = anyFit(body, 2);
    const Pose still = fit.staticPose;
    restShouldersAsScanned(body, fit);
    for (size_t v = 0; v < before.size(); ++v) ASSERT_LT(glm::length(body.mesh.restPositions[v] - before[v]), 1e-6f);
    for (size_t j = 0; j < still.localRotations.size(); ++j)
        ASSERT_GT(std::abs(glm::dot(fit.staticPose.localRotations[j], still.localRotations[j])), 1 - 1e-6f);
}

}  // namespace
}  // namespace dpl
