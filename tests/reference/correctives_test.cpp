// SPDX-License-Identifier: Apache-2.0
// Pose correctives of the CPU renderer against the referee: positions and brightness of vertices.
#include "sdk/avatar/posed_mesh.h"
#include "tests/reference/corrective_cases.h"

namespace dpl {
namespace {

std::vector<Vec4f> posedOnCpu(const AvatarData& avatar, const Pose& pose, bool skinned) {
    Jobs jobs(2);
    PosedMesh mesh;
    mesh.pose({avatar.joints, avatar.mesh, avatar.correctives, {}, &avatar.light}, pose, jobs);
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

}  // namespace
}  // namespace dpl
