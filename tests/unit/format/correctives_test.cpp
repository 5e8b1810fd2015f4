// SPDX-License-Identifier: Apache-2.0
// checkCorrectives: one case for each kind of bad array. hostile_test.cpp tests damaged files.
#include "sdk/format/correctives.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/not_finite.h"
#include "tests/unit/format/sample_avatars.h"
#include "tests/unit/format/sample_correctives.h"

namespace dpl {
namespace {

struct Bad {
    const char* what;
    void (*damage)(PoseCorrectiveData&);
    const char* sentence;  // part of the expected error
};

TEST(CheckCorrectives, refusesEachKindOfBadMotionMode) {
    const AvatarData avatar = test::layeredAvatar(1, 0, 8, 3);
    const PoseCorrectiveData good = test::randomCorrectives(avatar, 1, {.modes = 2, .nodes = 5, .motion = 3});
    const size_t joints = avatar.joints.size(), vertices = avatar.mesh.restPositions.size();
    ASSERT_TRUE(checkCorrectives(good, joints, vertices));
    const Bad list[] = {
        {"too many columns", [](PoseCorrectiveData& c) { c.motion.groups[1].columnCount = 63, c.nodes.resize(65 * 5); }, "columns"},
        {"columns beyond every number", [](PoseCorrectiveData& c) { c.motion.groups[1].columnCount = 0xffffffffu; }, "columns"},
        {"one column too few", [](PoseCorrectiveData& c) { c.motion.groups[1].columnCount = 1; }, "do not fit"},
        {"a group without columns", [](PoseCorrectiveData& c) { c.motion.groups[0].columnCount = 0; }, "2 groups of 2 columns"},
        {"9 groups", [](PoseCorrectiveData& c) { c.motion.groups.resize(9, c.motion.groups[0]); }, "9 groups"},
        {"reach NaN", [](PoseCorrectiveData& c) { c.motion.groups[0].reach = kNan; }, "impossible"},
        {"reach negative", [](PoseCorrectiveData& c) { c.motion.groups[0].reach = -1; }, "impossible"},
        {"no joints", [](PoseCorrectiveData& c) { c.motion.joints.clear(); }, "0 joints"},
        {"13 joints", [](PoseCorrectiveData& c) { c.motion.joints.resize(13); }, "13 joints"},
        {"no holds", [](PoseCorrectiveData& c) { c.motion.holdsS.clear(); }, "0 holds"},
        {"4 holds", [](PoseCorrectiveData& c) { c.motion.holdsS.resize(4); }, "4 holds"},
        {"4 lags", [](PoseCorrectiveData& c) { c.motion.lagsS.resize(4, 1.0f); }, "4 lags"},
        {"one lag too few", [](PoseCorrectiveData& c) { c.motion.lagsS.clear(); }, "do not fit"},
        {"lag of 0", [](PoseCorrectiveData& c) { c.motion.lagsS[0] = 0; }, "impossible"},
        {"lag NaN", [](PoseCorrectiveData& c) { c.motion.lagsS[0] = kNan; }, "impossible"},
        {"short still", [](PoseCorrectiveData& c) { c.motion.still.pop_back(); }, "do not fit"},
        {"long ranges", [](PoseCorrectiveData& c) { c.motion.rangeRad.emplace_back(0, 1); }, "do not fit"},
        {"short modes", [](PoseCorrectiveData& c) { c.motion.modes.pop_back(); }, "do not fit"},
        {"nodes without the columns", [](PoseCorrectiveData& c) { c.nodes.resize(5 * 2); }, "do not fit"},
        {"joint out of range", [](PoseCorrectiveData& c) { c.motion.joints.back() = 8; }, "joint 8"},
        {"joint twice", [](PoseCorrectiveData& c) { c.motion.joints[3] = c.motion.joints[2]; }, "rising"},
        {"still of length 2", [](PoseCorrectiveData& c) { c.motion.still[1] *= 2.0f; }, "impossible"},
        {"still zero", [](PoseCorrectiveData& c) { c.motion.still[1] = Vec4f(0); }, "impossible"},
        {"still NaN", [](PoseCorrectiveData& c) { c.motion.still[1].y = kNan; }, "impossible"},
        {"rest NaN", [](PoseCorrectiveData& c) { c.motion.rangeRad[1].x = kNan; }, "impossible"},
        {"rest negative", [](PoseCorrectiveData& c) { c.motion.rangeRad[1].x = -0.1f; }, "impossible"},
        {"most infinite", [](PoseCorrectiveData& c) { c.motion.rangeRad[1].y = kInfinity; }, "impossible"},
        {"moved from NaN", [](PoseCorrectiveData& c) { c.motion.movedFromRad = kNan; }, "impossible"},
        {"moved at once", [](PoseCorrectiveData& c) { c.motion.movedToRad = c.motion.movedFromRad; }, "impossible"},
        {"moved backwards", [](PoseCorrectiveData& c) { c.motion.movedToRad = 0.1f, c.motion.movedFromRad = 0.2f; }, "impossible"},
        {"hold negative", [](PoseCorrectiveData& c) { c.motion.holdsS[0] = -1; }, "impossible"},
        {"hold for ever", [](PoseCorrectiveData& c) { c.motion.holdsS[0] = kInfinity; }, "impossible"},
        {"mode NaN", [](PoseCorrectiveData& c) { c.motion.modes[4] = kNan; }, "impossible"},
        {"mode of 1e30", [](PoseCorrectiveData& c) { c.motion.modes[4] = 1e30f; }, "impossible"},
    };
    for (const Bad& bad : list) {
        PoseCorrectiveData c = good;
        bad.damage(c);
        const Status status = checkCorrectives(c, joints, vertices);
        ASSERT_FALSE(status) << bad.what;
        EXPECT_EQ(status.error().code, Code::CorruptData) << bad.what;
        EXPECT_NE(status.error().message.find(bad.sentence), std::string::npos) << bad.what << ": " << status.error().message;
    }
}

TEST(CheckCorrectives, refusesEachKindOfBadArray) {
    const AvatarData avatar = test::layeredAvatar(1, 0, 8, 3);
    const PoseCorrectiveData good = test::randomCorrectives(avatar, 1, {.modes = 2, .nodes = 5});
    const size_t joints = avatar.joints.size(), vertices = avatar.mesh.restPositions.size();
    ASSERT_TRUE(checkCorrectives(good, joints, vertices));
    EXPECT_TRUE(checkCorrectives({}, joints, vertices));
    const Bad list[] = {
        {"no modes", [](PoseCorrectiveData& c) { c.modeCount = 0, c.modes.clear(), c.nodes.clear(); }, "0 modes"},
        {"too many modes", [](PoseCorrectiveData& c) { c.modeCount = 65, c.modes.resize(65 * c.mean.size()), c.nodes.resize(65 * 5); },
         "65 modes"},
        {"too many nodes", [](PoseCorrectiveData& c) { c.nodeCount = 65536, c.nodes.resize(65536 * 2); }, "65536 nodes"},
        {"no joints", [](PoseCorrectiveData& c) { c.joints.clear(), c.mean.clear(), c.modes.clear(); }, "0 joints"},
        {"short mean", [](PoseCorrectiveData& c) { c.mean.pop_back(); }, "do not fit"},
        {"long modes", [](PoseCorrectiveData& c) { c.modes.push_back(0); }, "do not fit"},
        {"short nodes", [](PoseCorrectiveData& c) { c.nodes.pop_back(); }, "do not fit"},
        {"short indices", [](PoseCorrectiveData& c) { c.nodeIndices.pop_back(); }, "indices"},
        {"long weights",
         [](PoseCorrectiveData& c) {
             c.nodeWeights.push_back({255, 0, 0, 0});
         },
         "weights"},
        {"joint out of range", [](PoseCorrectiveData& c) { c.joints.back() = 8; }, "joint 8"},
        {"joint twice", [](PoseCorrectiveData& c) { c.joints[3] = c.joints[2]; }, "rising"},
        {"joints falling", [](PoseCorrectiveData& c) { std::swap(c.joints[0], c.joints[1]); }, "rising"},
        {"weights of 254", [](PoseCorrectiveData& c) { c.nodeWeights[7].x -= 1; }, "vertex 7 sum to 254"},
        {"weights of 511",
         [](PoseCorrectiveData& c) {
             c.nodeWeights[7] = {255, 255, 1, 0};
         },
         "vertex 7 sum to 511"},
        {"node out of range", [](PoseCorrectiveData& c) { c.nodeIndices[4].y = 5; }, "vertex 4 uses pose corrective node 5"},
        {"node out of range, weight 0",
         [](PoseCorrectiveData& c) {
             c.nodeWeights[4] = {255, 0, 0, 0}, c.nodeIndices[4].w = 9;
         },
         "node 9"},
        {"mean NaN", [](PoseCorrectiveData& c) { c.mean[1] = kNan; }, "finite"},
        {"mode infinite", [](PoseCorrectiveData& c) { c.modes[1] = -kInfinity; }, "finite"},
        {"node NaN in light", [](PoseCorrectiveData& c) { c.nodes.back().w = kNan; }, "finite"},
        {"node whose sum would cancel",
         [](PoseCorrectiveData& c) {
             c.nodes[0] = {3e38f, -3e38f, 0, 0};
         },
         "above"},
        {"no reach", [](PoseCorrectiveData& c) { c.reach = 0; }, "reach"},
        {"negative reach", [](PoseCorrectiveData& c) { c.reach = -1; }, "reach"},
        {"reach NaN", [](PoseCorrectiveData& c) { c.reach = kNan; }, "reach"},
        {"reach infinite", [](PoseCorrectiveData& c) { c.reach = kInfinity; }, "reach"},
        {"no reach off the modes", [](PoseCorrectiveData& c) { c.reachOffModes = 0; }, "reach"},
        {"reach off the modes NaN", [](PoseCorrectiveData& c) { c.reachOffModes = kNan; }, "reach"},
    };
    for (const Bad& bad : list) {
        PoseCorrectiveData c = good;
        bad.damage(c);
        const Status status = checkCorrectives(c, joints, vertices);
        ASSERT_FALSE(status) << bad.what;
        EXPECT_EQ(status.error().code, Code::CorruptData) << bad.what;
        EXPECT_NE(status.error().message.find(bad.sentence), std::string::npos) << bad.what << ": " << status.error().message;
    }
}

}  // namespace
}  // namespace dpl
