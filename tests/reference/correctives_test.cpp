// SPDX-License-Identifier: Apache-2.0
// Pose correctives of the CPU renderer against the referee: positions and brightness of vertices.
#include "sdk/avatar/motion_state.h"
#include "sdk/avatar/posed_mesh.h"
#include "tests/reference/corrective_cases.h"
#include "tests/unit/avatar/clothed_legs.h"

namespace dpl {
namespace {

std::vector<Vec4f> posedOnCpu(const AvatarData& avatar, const Pose& pose, bool skinned) {
    Jobs jobs(2);
    PosedMesh mesh;
    const ClothLimits cloth(avatar.joints, avatar.mesh, avatar.correctives);
    mesh.pose({avatar.joints, avatar.mesh, avatar.correctives, {}, &avatar.light, {}, &cloth, &avatar.expressions}, pose, jobs);
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

TEST(Correctives, expressionsAreTheReferees) {
    expectExpressionsMatch("CPU", posedOnCpu);
}

TEST(MotionState, whatClothesRememberIsTheReferees) {
    const AvatarData avatar = randomAvatar(4);
    std::mt19937 random(9);
    MotionModeData motion = test::randomMotion(avatar.joints.size(), 3, random);
    motion.lagsS = {0.15f, 1}, motion.modes.assign(motion.featureCount() * motion.columnCount(), 0.1f);
    double worst = 0, held = 0, lagged = 0;
    for (uint32_t seed = 0; seed < 40; ++seed) {
        std::vector<ReferenceEarlierPose> earlier;
        MotionState state;
        for (const double seconds : {0.4, 1e-3, 2.0, 0.0, 0.03}) {
            Pose pose = randomPose(avatar, 100 * seed + uint32_t(earlier.size()));
            earlier.push_back({pose, seconds});
            if (earlier.size() > 1) pose.before = forgetMotion(motion, state, earlier[earlier.size() - 2].secondsToNext);
            state = stateOf(motion, pose);
        }
        const MotionMemory is = forgetMotion(motion, state, earlier.back().secondsToNext), want = referenceMemory(motion, earlier);
        for (size_t i = 0; i < motion.heldCount(); ++i)
            worst = std::max(worst, std::abs(is.held[i] - want.held[i])), held = std::max(held, want.held[i]);
        for (size_t i = 0; i < motion.lagCount(); ++i)
            worst = std::max(worst, std::abs(is.lagged[i] - want.lagged[i])), lagged = std::max(lagged, std::abs(want.lagged[i]));
        for (size_t l = 0; l < motion.lagsS.size(); ++l) worst = std::max(worst, std::abs(is.earlier[l] - want.earlier[l]));
    }
    EXPECT_GT(std::min(held, lagged), 0.3);
    EXPECT_LT(worst, 1e-9) << "its integrals are Simpson's";
}

struct MovedNodes {
    double pushedM = 0, easedM = 0;  // by clearance and by strain, of a node at most
};

/** Poses clothed legs, with offsets that many times as large, and compares with the referee. */
MovedNodes expectClothLimitsMatch(float larger) {
    AvatarData avatar = test::clothedLegs();
    avatar.correctives.reachOffModes = 0.05f;  // unlike the film
    for (Vec4f& value : avatar.correctives.nodes) value = Vec4f(larger * Vec3f(value), value.w);
    const ClothLimits cloth(avatar.joints, avatar.mesh, avatar.correctives);
    const ClothClearance clearance(avatar.joints, avatar.mesh, avatar.correctives);
    Jobs jobs(1);
    PosedMesh mesh;
    MovedNodes most;
    double worst = 0;
    const Pose thin = test::stride(2.2f, -2.2f);  // its blends of both thighs have no volume: nothing can be pushed there
    for (const Pose& pose : {test::stride(0, 0), test::stride(0.5f, -0.4f), test::stride(1, -0.3f), test::stride(-0.6f, 1.3f), thin}) {
        mesh.pose({avatar.joints, avatar.mesh, avatar.correctives, {}, nullptr, {}, &cloth}, pose, jobs);
        const std::vector<glm::dvec3> want = referenceSkin(avatar, pose);
        for (size_t v = 0; v < want.size(); ++v) worst = std::max(worst, glm::length(glm::dvec3(mesh.positions()[v]) - want[v]));
        std::vector<Vec4f> nodes;
        std::vector<Vec3f> scratch;
        correctiveNodes(avatar.correctives, mesh.coefficients(), nodes);
        most.pushedM = std::max(most.pushedM, double(clearance.push(mesh.worldFromRest(), nodes, scratch)));
        for (size_t n = 0; n < nodes.size(); ++n) most.easedM = std::max(most.easedM, double(glm::length(mesh.nodes()[n] - nodes[n])));
    }
    std::printf("[ CLOTH ] offsets x %.0f: nodes pushed by up to %.1f mm, eased by %.1f mm; vertices %.4f mm from the referee\n",
                double(larger), 1e3 * most.pushedM, 1e3 * most.easedM, 1e3 * worst);
    EXPECT_LT(worst, 2e-5);
    return most;
}

TEST(Correctives, limitsOfClothAreTheReferees) {
    EXPECT_GT(expectClothLimitsMatch(1).pushedM, 0.01);
    EXPECT_GT(expectClothLimitsMatch(6).easedM, 0.01);
}

}  // namespace
}  // namespace dpl
