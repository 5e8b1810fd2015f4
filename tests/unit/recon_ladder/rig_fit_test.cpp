// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/ladder/rig_fit.h"

#include <gtest/gtest.h>

#include "tests/reference/random_avatar.h"

namespace dpl::test {
namespace {

/** The random ball with a third joint on the second, so that a chain is three long and a branch exists. */
AvatarData branched(uint32_t seed) {
    AvatarData a = randomAvatar(seed, 12);
    a.joints.push_back({"left", 1, Vec3f(0.2f, 1.2f, 0), ""});
    a.joints.push_back({"unmoved", 0, Vec3f(0, 0.5f, 0), ""});
    for (size_t v = 0; v < a.mesh.restPositions.size(); ++v) {
        if (a.mesh.restPositions[v].x < 0.2f) continue;
        a.mesh.jointIndices[v] = {1, 2, 0, 0}, a.mesh.jointWeights[v] = {55, 200, 0, 0};
    }
    return a;
}

std::vector<Vec3f> posed(const AvatarData& a, const Pose& pose) {
    Jobs jobs(1);
    std::vector<Mat3x4f> worldFromRest;
    std::vector<Vec3f> positions;
    jointTransforms(a.joints, pose, worldFromRest);
    skin(a.mesh, worldFromRest, jobs, positions);
    return positions;
}

double largestM(const std::vector<Vec3f>& a, const std::vector<Vec3f>& b) {
    double most = 0;
    for (size_t v = 0; v < a.size(); ++v) most = std::max(most, double(glm::length(a[v] - b[v])));
    return most;
}

TEST(RigFit, findsAPoseFromItsVertices) {
    for (uint32_t seed = 1; seed <= 8; ++seed) {
        const AvatarData a = branched(seed);
        Pose truth = Pose::rest(4);
        std::mt19937 random(seed);
        std::normal_distribution<float> normal;
        for (size_t j = 0; j < 3; ++j)
            truth.localRotations[j] =
                glm::angleAxis(0.5f * normal(random), glm::normalize(Vec3f(normal(random), normal(random), normal(random))));
        truth.rootTranslation = 0.2f * Vec3f(normal(random), normal(random), normal(random));
        const std::vector<Vec3f> targets = posed(a, truth);
        const std::vector<float> weights(targets.size(), 1.0f);
        const Pose found = fitRig(a.joints, a.mesh, targets, weights, Pose::rest(4));
        EXPECT_GT(largestM(posed(a, Pose::rest(4)), targets), 0.05) << "the start must be far off";
        EXPECT_LT(largestM(posed(a, found), targets), 1e-4) << "seed " << seed << "; the pull to the start costs micrometres";
        EXPECT_GT(std::abs(found.localRotations[3].w), 1 - 1e-6f) << "nothing follows this joint, so it stays";
    }
}

TEST(RigFit, verticesOfWeightZeroDoNotCount) {
    const AvatarData a = branched(3);
    Pose truth = Pose::rest(4);
    truth.localRotations[1] = glm::angleAxis(0.6f, Vec3f(1, 0, 0));
    std::vector<Vec3f> targets = posed(a, truth);
    const std::vector<Vec3f> clean = targets;
    std::vector<float> weights(targets.size(), 1.0f);
    for (size_t v = 0; v < targets.size(); v += 4) targets[v] += Vec3f(3, -2, 1), weights[v] = 0;
    const Pose found = fitRig(a.joints, a.mesh, targets, weights, Pose::rest(4));
    EXPECT_LT(largestM(posed(a, found), clean), 1e-4);
}

}  // namespace
}  // namespace dpl::test
