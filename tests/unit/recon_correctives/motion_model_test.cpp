// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/correctives/motion_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sdk/avatar/motion_state.h"

namespace dpl::test {
namespace {

std::vector<JointData> armJoints() {
    std::vector<JointData> j(4);
    j[0].humanoidBone = "hips", j[1].humanoidBone = "leftUpperArm", j[2].humanoidBone = "leftLowerArm",
    j[3].humanoidBone = "leftIndexProximal";
    for (int i = 1; i < 4; ++i) j[size_t(i)].parent = i - 1;
    return j;
}

/** Arms hang at 0.4 rad, and stray by a hundredth. */
std::vector<Pose> standing(uint32_t count) {
    std::vector<Pose> poses(count, Pose::rest(4));
    for (uint32_t i = 0; i < count; ++i) {
        poses[i].localRotations[0] = glm::angleAxis(float(i), Vec3f(0, 1, 0));
        poses[i].localRotations[1] = (i % 2 ? 1.0f : -1.0f) * glm::angleAxis(0.4f + 0.01f * std::sin(float(i)), Vec3f(0, 0, 1));
    }
    return poses;
}

/** The arm is lifted, and the elbow bends. Every tenth pose is the still one again. */
std::vector<Pose> moving(uint32_t count) {
    std::vector<Pose> poses = standing(count);
    for (uint32_t i = 0; i < count; ++i) {
        if (i % 10 == 0) continue;
        poses[i].localRotations[1] = glm::angleAxis(1.2f + 0.5f * std::sin(0.7f * float(i)), Vec3f(0, 0, 1));
        poses[i].localRotations[2] = glm::angleAxis(0.6f + 0.3f * std::cos(1.9f * float(i)), Vec3f(1, 0, 0));
        poses[i].localRotations[3] = glm::angleAxis(1.5f, Vec3f(1, 0, 0));
    }
    return poses;
}

std::vector<float> settled(const MotionModeData& m, const Pose& pose) {
    std::vector<float> k(m.columnCount());
    motionCoefficients(m, stateOf(m, pose), k);
    return k;
}

/** Five pictures a second. */
std::vector<double> times(size_t count) {
    std::vector<double> timesS(count);
    for (size_t i = 0; i < count; ++i) timesS[i] = 0.2 * double(i);
    return timesS;
}

/** Of a film without times: nothing is held, so that states are those of the poses alone. */
Result<MotionModeData> modelOf(const std::vector<JointData>& joints, const std::vector<Pose>& still, const std::vector<Pose>& film,
                               MotionModelSettings settings = {}) {
    settings.holdsS = {0};
    return motionModel(joints, still, film, std::vector<double>(film.size(), 0.0), settings);
}

TEST(MotionModel, isZeroInStillPosesAndCentredInMotion) {
    const auto model = modelOf(armJoints(), standing(20), moving(40));
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_EQ(model->joints, (std::vector<uint32_t>{1, 2})) << "no hips, no fingers";
    ASSERT_EQ(model->groups.size(), 2u) << "there are no legs";
    EXPECT_EQ(model->columnCount(), 3u) << "moved, arm, elbow";
    MotionModeData unlimited = *model;
    unlimited.groups[1].reach = 1e6f;
    EXPECT_TRUE(checkMotionModes(*model, 4));
    for (const Pose& pose : standing(20))
        for (const float k : settled(*model, pose)) EXPECT_EQ(k, 0);
    std::vector<double> mean(3, 0.0), square(3, 0.0);
    for (uint32_t i = 0; i < 40; ++i) {
        const std::vector<float> k = settled(unlimited, moving(40)[i]);
        for (size_t c = 0; c < 3 && i % 10 != 0; ++c) mean[c] += k[c] / 36.0, square[c] += k[c] * k[c] / 36.0;
    }
    EXPECT_NEAR(mean[0], 1, 1e-6);
    for (size_t c = 1; c < 3; ++c) {
        EXPECT_NEAR(mean[c], 0, 1e-4) << c;
        EXPECT_NEAR(square[c], 1, 1e-3) << c;
    }
}

TEST(MotionModel, nothingLeavesTheRangeOfTheMotion) {
    const auto model = modelOf(armJoints(), standing(20), moving(40));
    ASSERT_TRUE(model);
    const auto lengthIn = [&](const Pose& pose) {
        const std::vector<float> k = settled(*model, pose);
        return std::hypot(k[1], k[2]);
    };
    std::vector<float> lengths;
    for (const Pose& pose : moving(40)) lengths.push_back(lengthIn(pose));
    std::sort(lengths.begin(), lengths.end());
    EXPECT_GT(lengths[35], lengths[20]);
    EXPECT_NEAR(lengths.back(), model->groups[1].reach, 1e-5) << "the farthest pose reaches it";
    Pose far = Pose::rest(4);
    for (Quatf& q : far.localRotations) q = glm::angleAxis(3.0f, Vec3f(1, 0, 0));
    EXPECT_LE(lengthIn(far), model->groups[1].reach + 1e-5f);
}

/** A skirt, a shirt, a shoe and hair of one vertex each on a body of one, each with a node of its own. */
MeshData fiveLayers() {
    MeshData mesh;
    const char* names[] = {"body", "bottom", "top", "shoes", "hair"};
    for (uint32_t v = 0; v < 5; ++v) {
        mesh.restPositions.emplace_back(float(v), 0, 0);
        mesh.jointIndices.push_back({uint16_t(v == 2 ? 4 : 1), uint16_t(v == 1 ? 2 : 0), 0, 0});
        mesh.jointWeights.push_back({v == 2 ? uint8_t(40) : uint8_t(128), v == 2 ? uint8_t(215) : uint8_t(127), 0, 0});
        mesh.layers.push_back({.name = names[v],
                               .role = v == 0   ? "body"
                                       : v == 4 ? "hair"
                                                : "garment",
                               .firstVertex = v,
                               .vertexCount = 1});
    }
    return mesh;
}

TEST(MotionModel, reachesTheClothesThatFollowTheLimbs) {
    std::vector<JointData> joints(5);  // hips, spine, leg, arm, hand
    joints[1].humanoidBone = "spine", joints[2].humanoidBone = "leftUpperLeg", joints[3].humanoidBone = "leftUpperArm";
    joints[1].parent = 0, joints[2].parent = 0, joints[3].parent = 1, joints[4].parent = 3;
    PoseCorrectiveData c;
    c.nodeCount = 5, c.motion.joints = {1, 2, 3}, c.motion.holdsS = {0};
    c.motion.groups = {{.columnCount = 1}, {.columnCount = 1}, {.columnCount = 1}};
    c.motion.modes = {1, 0, 0, 0, 0.1f, 1, 1, 0, -0.2f, 1, 0, 1};  // has moved; spine and leg; spine and arm
    for (uint16_t v = 0; v < 5; ++v) c.nodeIndices.push_back({v, 0, 0, 0}), c.nodeWeights.push_back({255, 0, 0, 0});
    const MeshData mesh = fiveLayers();
    EXPECT_EQ(motionReachingNodes(joints, mesh, c), (std::vector<uint32_t>{0, 0b011, 0b101, 0, 0}))
        << "the skirt hears the legs, the shirt the arms by a hand; the spine tells nothing apart";
}

TEST(MotionModel, isEmptyWithoutStillFramesOrMotion) {
    const auto empty = [](const std::vector<Pose>& still, const std::vector<Pose>& motion) {
        const auto model = modelOf(armJoints(), still, motion);
        EXPECT_TRUE(model);
        return model && model->empty();
    };
    EXPECT_TRUE(empty({}, moving(40)));
    EXPECT_TRUE(empty(standing(20), moving(5)));
    EXPECT_TRUE(empty(standing(20), standing(40)));
    std::vector<JointData> nameless(4);
    for (int i = 1; i < 4; ++i) nameless[size_t(i)].parent = i - 1;
    EXPECT_TRUE(modelOf(nameless, standing(20), moving(40))->empty());
}

TEST(MotionModel, holdsPeaksAndTheMoveItselfAlongAFilm) {
    const auto model = motionModel(armJoints(), standing(20), moving(40), times(40));
    ASSERT_TRUE(model) << model.error().message;
    ASSERT_TRUE(checkMotionModes(*model, 4));
    EXPECT_EQ(model->holdsS, MotionModelSettings().holdsS);
    EXPECT_TRUE(model->lagsS.empty()) << "five pictures a second tell no lag";
    std::vector<Pose> film = moving(40);
    rememberFilm(*model, times(40), film);
    EXPECT_EQ(film[0].before, MotionMemory());
    EXPECT_EQ(settled(*model, film[0])[0], 0) << "nobody has moved before the film";
    EXPECT_GT(settled(*model, film[20])[0], 0.8) << "back in the still pose, but it has moved";
    ASSERT_EQ(model->groups.size(), 3u) << "moved, the arm's angles, the arm's peaks";
    EXPECT_FALSE(isOfPeaks(*model, 0) || isOfPeaks(*model, 1));
    EXPECT_TRUE(isOfPeaks(*model, 2));
    Pose anew = film[20];
    anew.before = {};
    const std::vector<float> held = settled(*model, film[20]), forgotten = settled(*model, anew);
    const size_t peaks = 1 + model->groups[1].columnCount;
    double most = 0;
    for (size_t i = peaks; i < held.size(); ++i) most = std::max(most, std::abs(double(held[i]) - double(forgotten[i])));
    EXPECT_GT(most, 0.3) << "the arm hangs again, and the cloth knows how high it was";
    for (const Pose& pose : standing(20))
        for (const float k : settled(*model, pose)) EXPECT_EQ(k, 0);
    std::vector<Pose> shuffled = moving(40);
    std::vector<double> order = times(40);
    std::reverse(shuffled.begin(), shuffled.end()), std::reverse(order.begin(), order.end());
    rememberFilm(*model, order, shuffled);
    for (size_t i = 0; i < film.size(); ++i) EXPECT_EQ(shuffled[39 - i].before, film[i].before) << i;
    rememberFilm(*model, std::vector<double>(40, 3.0), film);
    for (const Pose& pose : film) EXPECT_EQ(pose.before, MotionMemory()) << "no order is known";
    const auto unordered = motionModel(armJoints(), standing(20), moving(40), std::vector<double>(40, 3.0));
    ASSERT_TRUE(unordered);
    EXPECT_EQ(unordered->holdsS, (std::vector<float>{0})) << "and nothing is held that would only repeat the pose";
    EXPECT_EQ(unordered->groups.size(), 2u);
}

TEST(MotionModel, aDenseFilmTellsLags) {
    std::vector<double> timesS = times(60);
    for (double& t : timesS) t /= 5;
    const auto model = motionModel(armJoints(), standing(20), moving(60), timesS);
    ASSERT_TRUE(model) << model.error().message;
    ASSERT_TRUE(checkMotionModes(*model, 4));
    EXPECT_EQ(model->lagsS, MotionModelSettings().lagsS);
    for (const Pose& pose : standing(20))
        for (const float k : settled(*model, pose)) EXPECT_EQ(k, 0);
    std::vector<Pose> film = moving(60);
    rememberFilm(*model, timesS, film);
    const std::vector<float> k = settled(*model, film[31]);
    EXPECT_GT(std::abs(k.back()) + std::abs(k[k.size() - 2]), 0.1f) << "the last group lags";
}

TEST(MotionModel, refusesAPoseOfAnotherRig) {
    auto poses = moving(20);
    poses[7].localRotations.pop_back();
    EXPECT_EQ(modelOf(armJoints(), standing(3), poses).error().code, Code::InvalidArgument);
    EXPECT_EQ(modelOf(armJoints(), poses, moving(20)).error().code, Code::InvalidArgument);
}

}  // namespace
}  // namespace dpl::test
