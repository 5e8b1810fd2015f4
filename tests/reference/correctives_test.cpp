// SPDX-License-Identifier: Apache-2.0
// Pose correctives of the CPU renderer against the referee: positions and brightness of vertices.
#include "sdk/avatar/posed_mesh.h"
#include "tests/reference/corrective_cases.h"
#include "tests/unit/avatar/clothed_legs.h"

namespace dpl {
namespace {

std::vector<Vec4f> posedOnCpu(const AvatarData& avatar, const Pose& pose, bool skinned) {
    Jobs jobs(2);
    PosedMesh mesh;
    mesh.pose({avatar.joints, avatar.mesh, avatar.correctives, {}, &avatar.light, {}, nullptr, &avatar.expressions}, pose, jobs);
    std::vector<Vec4f> out;
    for (size_t v = 0; v < mesh.light().size(); ++v) out.emplace_back(skinned ? mesh.positions()[v] : mesh.rest()[v], mesh.light()[v]);
    return out;
}

TEST(Correctives, cpuVerticesAreTheRefereesToAThousandthOfTheirRange) {
    expectCorrectivesMatch("CPU", posedOnCpu);
}

TEST(SceneLight, cpuBrightnessIsTheReferees) {
    expectSceneLightMatches("CPU", posedOnCpu);
}

// Garment nodes that are pushed out of the body.
TEST(Correctives, expressionsAreTheReferees) {
    expectExpressionsMatch("CPU", posedOnCpu);
}

TEST(Correctives, clearanceIsTheReferees) {
    const AvatarData avatar = test::clothedLegs();
    const ClothClearance clearance(avatar.joints, avatar.mesh, avatar.correctives);
    Jobs jobs(1);
    PosedMesh mesh;
    double worst = 0, pushed = 0;
    const Pose thin = test::stride(2.2f, -2.2f);  // its blends of both thighs have no volume: nothing can be pushed there
    for (const Pose& pose : {test::stride(0, 0), test::stride(0.5f, -0.4f), test::stride(1, -0.3f), test::stride(-0.6f, 1.3f), thin}) {
        mesh.pose({avatar.joints, avatar.mesh, avatar.correctives, {}, nullptr, {}, &clearance}, pose, jobs);
        const std::vector<glm::dvec3> want = referenceSkin(avatar, pose);
        for (size_t v = 0; v < want.size(); ++v) worst = std::max(worst, glm::length(glm::dvec3(mesh.positions()[v]) - want[v]));
        pushed = std::max(pushed, double(mesh.pushedM()));
    }
    std::printf("[ CLEARANCE ] pushed by %.1f mm, %.4f mm from the referee\n", 1e3 * pushed, 1e3 * worst);
    EXPECT_GT(pushed, 0.01);
    EXPECT_LT(worst, 2e-5);
}

}  // namespace
}  // namespace dpl
