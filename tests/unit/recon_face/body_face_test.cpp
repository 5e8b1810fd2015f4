// SPDX-License-Identifier: Apache-2.0
// The expressions of a body on an avatar that was fitted with it.
#include "reconstruction/subject/face/body_face.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "reconstruction/subject/body/body_tools.h"
#include "reconstruction/subject/face/expression_nodes.h"
#include "reconstruction/subject/sample/builtin_body.h"
#include "sdk/avatar/posed_mesh.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/expression_names.h"
#include "tests/unit/format/sample_correctives.h"
#include "tests/unit/must.h"

namespace dpl {
namespace {

const BodyModel& builtin() {
    static const BodyModel kBody = makeBuiltinBody();
    return kBody;
}

/** An avatar without splats whose body was fitted: other proportions, and a surface up to 3 mm off. */
AvatarData fittedAvatar() {
    std::vector<double> shape;
    for (size_t m = 0; m < builtin().morphs.size(); ++m) shape.push_back(m % 2 == 0 ? 0.8 : -0.6);
    const BodyModel shaped = shapedBody(builtin(), shape);
    AvatarData avatar;
    avatar.joints = shaped.joints, avatar.mesh = shaped.mesh;
    for (Vec3f& p : avatar.mesh.restPositions) p += 0.003f * Vec3f(std::sin(40 * p.y), std::sin(50 * p.x), std::sin(60 * p.y));
    avatar.splats.triangleStart.assign(avatar.mesh.triangles.size() + 1, 0);
    return avatar;
}

TEST(BodyFace, aFittedAvatarShowsEveryExpressionOfTheBuiltinBody) {
    AvatarData avatar = fittedAvatar();
    const AvatarData before = avatar;
    const EvidenceData row = must(addBodyFace(avatar, builtin()));
    EXPECT_FALSE(row.kept);
    EXPECT_NE(row.reason.find("face not filmed"), std::string::npos);
    EXPECT_EQ(avatar.expressions.shapes.size(), 51u);
    const std::vector<ExpressionShape> wanted = shapesAtSize(builtin(), before.mesh);
    Jobs jobs(2);
    PosedMesh posed;
    for (const ExpressionShape& shape : wanted) {
        Pose pose = Pose::rest(avatar.joints.size());
        pose.expression[shape.expression] = 1;
        posed.pose({avatar.joints, avatar.mesh, avatar.correctives, {}, nullptr, {}, nullptr, &avatar.expressions}, pose, jobs);
        for (size_t v = 0; v < before.mesh.restPositions.size(); ++v) {
            const Vec3f moved = posed.rest()[v] - before.mesh.restPositions[v];
            ASSERT_LT(glm::length(moved - shape.offsetsM[v]), 3.5e-4f) << kExpressionNames[shape.expression] << ", vertex " << v;
        }
    }
}

TEST(BodyFace, shapesGrowWithTheHead) {
    MeshData large = builtin().mesh;
    for (Vec3f& p : large.restPositions) p = 1.2f * p + Vec3f(0.1f, 0, 0);
    const std::vector<ExpressionShape> shapes = shapesAtSize(builtin(), large);
    ASSERT_EQ(shapes.size(), builtin().expressions.size());
    for (size_t v = 0; v < large.restPositions.size(); v += 7)
        ASSERT_LT(glm::length(shapes[0].offsetsM[v] - 1.2f * builtin().expressions[0].offsetsM[v]), 1e-6f);
}

TEST(BodyFace, takesFewBytes) {
    AvatarData avatar = fittedAvatar();
    const size_t still = must(writeAvatar(avatar, {.compact = true})).size();
    must(addBodyFace(avatar, builtin()));
    const size_t bytes = must(writeAvatar(avatar, {.compact = true})).size() - still;
    std::printf("[ FACE ] %.1f KB on %u nodes\n", double(bytes) / 1e3, avatar.correctives.nodeCount);
    EXPECT_LE(bytes, 150'000u);
}

TEST(BodyFace, itsNodesCostLittleBesidePoseCorrectives) {
    AvatarData avatar = test::withCorrectives(fittedAvatar(), 3, {.modes = 12, .nodes = 200});
    const size_t still = must(writeAvatar(avatar, {.compact = true})).size();
    must(addBodyFace(avatar, builtin()));
    const size_t bytes = must(writeAvatar(avatar, {.compact = true})).size() - still;
    std::printf("[ FACE ] %.1f KB beside 12 modes, on %u nodes\n", double(bytes) / 1e3, avatar.correctives.nodeCount - 200);
    EXPECT_LE(bytes, 270'000u) << "240 KB measured: each node repeats 12 values of random correctives, which hardly compress";
}

TEST(BodyFace, aBodyWithoutExpressionsLeavesTheAvatarAsItIs) {
    AvatarData avatar = fittedAvatar();
    const auto before = must(writeAvatar(avatar));
    BodyModel still = builtin();
    still.expressions.clear();
    const EvidenceData row = must(addBodyFace(avatar, still));
    EXPECT_NE(row.reason.find("brings no shapes"), std::string::npos);
    EXPECT_EQ(must(writeAvatar(avatar)), before);
}

TEST(BodyFace, anAvatarOfAnotherBodyIsRefused) {
    AvatarData avatar = fittedAvatar();
    BodyModel other = builtin();
    other.mesh.restPositions.pop_back();
    const auto refused = addBodyFace(avatar, other);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Code::InvalidArgument);
}

}  // namespace
}  // namespace dpl
