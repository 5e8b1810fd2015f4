// SPDX-License-Identifier: Apache-2.0
// Garment nodes that a pose would put inside the body are pushed out of it.
#include "sdk/avatar/cloth_clearance.h"

#include <gtest/gtest.h>

#include <limits>

#include "sdk/avatar/motion_state.h"
#include "sdk/avatar/posed_mesh.h"
#include "tests/unit/avatar/clothed_legs.h"

namespace dpl {
namespace {

using test::clothedLegs;
using test::stride;

struct Pushed {
    std::vector<Mat3x4f> worldFromRest;
    std::vector<Vec4f> before, after;
    float mostM = 0;
    explicit Pushed(const AvatarData& a, const Pose& pose) {
        std::vector<float> k;
        std::vector<Vec3f> scratch;
        jointTransforms(a.joints, pose, worldFromRest);
        correctiveCoefficients(a.correctives, pose, k);
        correctiveNodes(a.correctives, k, before);
        after = before;
        mostM = ClothClearance(a.joints, a.mesh, a.correctives).push(worldFromRest, after, scratch);
    }
};

/** How deep the skirt's vertices lie in the thighs, metres, together. */
double depthInThighs(const AvatarData& a, const Pushed& pushed, const std::vector<Vec4f>& nodes) {
    Jobs jobs(1);
    std::vector<Vec3f> moved, posed;
    std::vector<float> light;
    spreadCorrectives(a.correctives, nodes, a.mesh.restPositions, jobs, moved, light);
    skin(a.mesh, moved, pushed.worldFromRest, jobs, posed);
    double depth = 0;
    const LayerData& skirt = a.mesh.layers[1];
    for (uint32_t v = skirt.firstVertex; v < skirt.firstVertex + skirt.vertexCount; ++v)
        for (const size_t thigh : {2, 5}) {
            const Mat3x4f& g = pushed.worldFromRest[thigh];
            const Vec3f p = glm::transpose(Mat3f(g)) * (posed[v] - g[3]) - a.joints[thigh].restPosition;
            if (p.y < -0.03f && p.y > -0.42f) depth += std::max(0.0, double(test::kLegM) - std::hypot(double(p.x), double(p.z)));
        }
    return depth;
}

TEST(ClothClearance, atRestNothingIsPushed) {
    const AvatarData a = clothedLegs();
    const Pushed rest(a, stride(0, 0));
    EXPECT_EQ(rest.mostM, 0);
    EXPECT_TRUE(rest.after == rest.before);
}

TEST(ClothClearance, aLegThatRisesPushesTheSkirtOut) {
    const AvatarData a = clothedLegs();
    for (const Pose& pose : {stride(0.8f, -0.3f), stride(-0.5f, 0.9f)}) {
        const Pushed walk(a, pose);
        const double before = depthInThighs(a, walk, walk.before), after = depthInThighs(a, walk, walk.after);
        EXPECT_GT(before, 0.1) << "metres of all vertices: else there is nothing to push";
        EXPECT_LT(after, 0.9 * before) << "neighbours keep together, so it does not all come out";
        EXPECT_GT(walk.mostM, 0.005f);
    }
}

TEST(ClothClearance, movesNoNodeBeyondItsLimitAndReportsTheLargestChange) {
    AvatarData a = clothedLegs();
    PoseCorrectiveData& c = a.correctives;
    for (Vec4f& offset : c.nodes) offset *= 0.2f;  // millimetres, so that pushes want more than the limit gives
    float longest = 0, most = 0;
    for (size_t i = 0; i < c.nodes.size(); ++i) {
        const size_t column = i % c.columnCount();
        const float reach = column < c.modeCount ? c.reach : c.motion.groups[column - c.modeCount].reach;  // groups of one column
        longest = std::max(longest, reach * glm::length(Vec3f(c.nodes[i])));
    }
    const Pushed walk(a, stride(1.4f, -0.6f));
    size_t kept = 0, limited = 0;
    for (size_t n = 0; n < walk.after.size(); ++n) {
        const float limit = std::max(1.3f * longest, glm::length(Vec3f(walk.before[n]))), length = glm::length(Vec3f(walk.after[n]));
        EXPECT_LE(length, limit + 1e-6f);
        EXPECT_EQ(walk.after[n].w, walk.before[n].w) << "brightness";
        most = std::max(most, glm::length(Vec3f(walk.after[n]) - Vec3f(walk.before[n])));
        const bool same = walk.after[n] == walk.before[n];
        kept += same, limited += !same && length > limit - 1e-5f;
    }
    EXPECT_FLOAT_EQ(most, walk.mostM);
    EXPECT_GT(kept, walk.after.size() / 4);
    EXPECT_LT(kept, walk.after.size());
    EXPECT_GT(limited, 0u);
}

TEST(ClothClearance, needsMotionModesABodyLayerAndBones) {
    EXPECT_FALSE(ClothClearance(clothedLegs().joints, clothedLegs().mesh, clothedLegs().correctives).empty());
    AvatarData still = clothedLegs(), bare = clothedLegs(), nameless = clothedLegs(), uncorrected = clothedLegs();
    dropMotionModes(still.correctives);
    bare.mesh.layers[0].role = "garment";
    for (JointData& joint : nameless.joints) joint.humanoidBone.clear(), joint.name = "joint";
    uncorrected.correctives = {};
    for (const AvatarData* a : {&still, &bare, &nameless, &uncorrected})
        EXPECT_TRUE(ClothClearance(a->joints, a->mesh, a->correctives).empty());
}

TEST(ClothClearance, leavesAloneWhatHangsOnNoJointAndPosesThatAreNoNumbers) {
    AvatarData a = clothedLegs();
    const Pushed walk(a, stride(1, -0.3f));
    std::vector<Mat3x4f> torn = walk.worldFromRest;
    for (Mat3x4f& m : torn) m[3] = Vec3f(std::numeric_limits<float>::quiet_NaN());
    std::vector<Vec4f> nodes = walk.before;
    std::vector<Vec3f> scratch;
    EXPECT_EQ(ClothClearance(a.joints, a.mesh, a.correctives).push(torn, nodes, scratch), 0);
    EXPECT_TRUE(nodes == walk.before);
    for (uint32_t v = a.mesh.layers[1].firstVertex; v < a.mesh.jointWeights.size(); ++v) a.mesh.jointWeights[v] = glm::u8vec4(0);
    const Pushed loose(a, stride(1, -0.3f));
    EXPECT_EQ(loose.mostM, 0);
    EXPECT_TRUE(loose.after == loose.before);
}

TEST(ClothClearance, aPosedMeshHasTheSameBytesOnAnyThreads) {
    const AvatarData a = clothedLegs();
    const ClothLimits cloth(a.joints, a.mesh, a.correctives);
    const PosedSubject with{a.joints, a.mesh, a.correctives, {}, nullptr, {}, &cloth}, without{a.joints, a.mesh, a.correctives, {}};
    Jobs one(1), three(3);
    PosedMesh first, second, plain;
    const Pose walk = stride(1, -0.3f);
    first.pose(with, walk, one), second.pose(with, walk, three), plain.pose(without, walk, one);
    const auto same = [](const PosedMesh& a, const PosedMesh& b) {
        return std::equal(a.positions().begin(), a.positions().end(), b.positions().begin(), b.positions().end());
    };
    EXPECT_TRUE(same(first, second));
    EXPECT_FALSE(same(first, plain));
    const Pose rest = stride(0, 0);
    first.pose(with, rest, one), plain.pose(without, rest, one);
    EXPECT_TRUE(same(first, plain)) << "a frame in which nothing is pushed";
}

/** Exponentials of two machines differ in their last digits: of 6,000 factors of exp, four by one between glibc with and without fused
 *  multiply-add. Steps that are off by eight such digits stand for more than that, in every step of a minute. */
TEST(ClothClearance, lastDigitsOfTheFactorsMoveNoVertexByAMicrometre) {
    const AvatarData a = clothedLegs();
    const MotionModeData& motion = a.correctives.motion;
    const ClothLimits cloth(a.joints, a.mesh, a.correctives);
    const PosedSubject subject{a.joints, a.mesh, a.correctives, {}, nullptr, {}, &cloth};
    Jobs jobs(1);
    PosedMesh first, second;
    MotionState x, y;
    size_t apart = 0;
    float most = 0, pushed = 0;
    for (int k = 0; k < 60 * 90; ++k) {
        const float t = float(k) / 90;
        Pose pose = stride(0.7f * std::sin(5 * t), -0.7f * std::sin(4.9f * t)), other = pose;
        const double stepS = 1.0 / 90;
        pose.before = forgetMotion(motion, x, stepS);
        other.before = forgetMotion(motion, y, stepS * (1 + (k % 3 - 1) * 8 * std::numeric_limits<double>::epsilon()));
        x = stateOf(motion, pose), y = stateOf(motion, other);
        apart += !(x == y);
        if (k % 45 != 0) continue;
        first.pose(subject, pose, jobs), second.pose(subject, other, jobs);
        pushed = std::max(pushed, first.pushedM());
        for (size_t v = 0; v < first.positions().size(); ++v)
            most = std::max(most, glm::length(first.positions()[v] - second.positions()[v]));
    }
    EXPECT_GT(apart, 60u * 90 / 2) << "the states differ, or nothing is compared";
    EXPECT_GT(pushed, 0.005f);
    EXPECT_LT(most, 1e-6f);
    RecordProperty("most_nanometres", int(1e9f * most));
}

}  // namespace
}  // namespace dpl
