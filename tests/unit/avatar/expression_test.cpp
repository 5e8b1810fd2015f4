// SPDX-License-Identifier: Apache-2.0
// Expressions on control nodes: what their weights move, and that weights of zero move nothing.
#include <gtest/gtest.h>

#include <algorithm>

#include "sdk/avatar/posed_mesh.h"
#include "tests/unit/format/sample_avatars.h"
#include "tests/unit/format/sample_expressions.h"

namespace dpl {
namespace {

class Expression : public testing::TestWithParam<bool> {
protected:
    AvatarData plain_ = GetParam() ? test::withCorrectives(test::layeredAvatar(1, 1, 8, 3), 1, {.modes = 2, .nodes = 6, .reach = 0.2f})
                                   : test::layeredAvatar(1, 1, 8, 3);
    AvatarData avatar_ = test::withExpressions(plain_, 2, 4);
    Pose pose_ = [] {
        Pose pose = Pose::rest(8);
        pose.localRotations[3] = glm::angleAxis(0.7f, Vec3f(0, 1, 0));
        return pose;
    }();
    Jobs jobs_{1};

    PosedMesh posed(const AvatarData& avatar, const Pose& pose) {
        PosedMesh mesh;
        mesh.pose({avatar.joints, avatar.mesh, avatar.correctives, {}, nullptr, {}, nullptr, &avatar.expressions}, pose, jobs_);
        return mesh;
    }
    std::vector<Vec3f> vertices(const AvatarData& avatar, const Pose& pose) {
        const PosedMesh mesh = posed(avatar, pose);
        return {mesh.positions().begin(), mesh.positions().end()};
    }
    Pose with(size_t shape, float weight) {
        Pose pose = pose_;
        pose.expression[avatar_.expressions.shapes[shape]] = weight;
        return pose;
    }
};

TEST_P(Expression, weightsOfZeroDrawTheSameBytesAsNoExpressions) {
    EXPECT_EQ(vertices(avatar_, pose_), vertices(plain_, pose_));
    const PosedMesh face = posed(avatar_, pose_), none = posed(plain_, pose_);
    for (size_t v = 0; v < face.light().size(); ++v) EXPECT_EQ(face.light()[v], GetParam() ? none.light()[v] : 1.0f) << v;
}

TEST_P(Expression, aWeightMovesTheNodesOfItsShapeInProportion) {
    const PosedMesh rest = posed(avatar_, pose_), half = posed(avatar_, with(1, 0.5f));
    const ExpressionData& x = avatar_.expressions;
    size_t moved = 0;
    for (uint16_t n = 0; n < avatar_.correctives.nodeCount; ++n) {
        const auto entry = std::find(x.nodes.begin() + x.begin(1), x.nodes.begin() + x.ends[1], n);
        const bool moves = entry != x.nodes.begin() + x.ends[1];
        const Vec4f want = moves ? Vec4f(0.5f * x.offsetsM[size_t(entry - x.nodes.begin())], 0) : Vec4f(0);
        EXPECT_LT(glm::length(half.nodes()[n] - rest.nodes()[n] - want), 1e-7f) << n;
        moved += moves;
    }
    EXPECT_GT(moved, 0u);
    EXPECT_NE(vertices(avatar_, with(1, 0.5f)), vertices(avatar_, pose_));
}

TEST_P(Expression, thePoseNeitherFadesNorShortensIt) {
    Pose far = pose_;
    for (Quatf& q : far.localRotations) q = glm::angleAxis(2.5f, glm::normalize(Vec3f(1, 1, 0)));
    Pose smiling = far;
    smiling.expression[avatar_.expressions.shapes[2]] = 1;
    const ExpressionData& x = avatar_.expressions;
    const uint16_t node = x.nodes[x.begin(2)];
    EXPECT_LT(glm::length(Vec3f(posed(avatar_, smiling).nodes()[node] - posed(avatar_, far).nodes()[node]) - x.offsetsM[x.begin(2)]),
              1e-7f);
}

TEST_P(Expression, isPartOfAPose) {
    EXPECT_FALSE(samePose(pose_, with(0, 0.25f)));
    EXPECT_TRUE(samePose(with(0, 0.25f), with(0, 0.25f)));
}

INSTANTIATE_TEST_SUITE_P(Avatars, Expression, testing::Bool(), [](const auto& info) { return info.param ? "corrected" : "plain"; });

}  // namespace
}  // namespace dpl
