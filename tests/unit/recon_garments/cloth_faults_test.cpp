// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/garments/cloth_faults.h"

#include <cmath>

#include <gtest/gtest.h>

#include "sdk/format/motion_modes.h"
#include "tests/unit/heard_task.h"
#include "tests/unit/must.h"

namespace dpl::test {
namespace {

/** Adds a closed box as a layer that one joint moves. */
void addBox(AvatarData& avatar, const char* name, const char* role, const Vec3f& centre, const Vec3f& half, uint16_t joint) {
    MeshData& m = avatar.mesh;
    const auto first = uint32_t(m.restPositions.size()), firstTriangle = uint32_t(m.triangles.size());
    for (uint32_t i = 0; i < 8; ++i) {
        m.restPositions.push_back(centre + half * Vec3f(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
        m.jointIndices.push_back({joint, 0, 0, 0}), m.jointWeights.push_back({255, 0, 0, 0});
    }
    constexpr uint32_t kSides[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    for (const auto& s : kSides) {
        m.triangles.push_back(Triangle(s[0], s[1], s[2]) + first);
        m.triangles.push_back(Triangle(s[0], s[2], s[3]) + first);
    }
    m.layers.push_back({name, role, first, 8, firstTriangle, 12});
}

/** A body of 20 cm and a coat of 30 cm around it that follows another joint. */
AvatarData dressed() {
    AvatarData avatar;
    avatar.joints.resize(2);
    avatar.joints[1].parent = 0;
    addBox(avatar, "body", "body", Vec3f(0), Vec3f(0.1f), 0);
    addBox(avatar, "top", "garment", Vec3f(0), Vec3f(0.15f), 1);
    addBox(avatar, "hair", "hair", Vec3f(0), Vec3f(0.05f), 0);
    return avatar;
}

double shareInside(AvatarData avatar, std::initializer_list<Pose> poses) {
    Jobs jobs(2);
    return garmentPenetration(avatar, std::span(poses.begin(), poses.size()), jobs);
}

TEST(Penetration, isTheShareOfGarmentVerticesInsideTheBody) {
    const Pose rest = Pose::rest(2);
    EXPECT_EQ(shareInside(dressed(), {rest}), 0) << "the hair inside is no garment";
    AvatarData torn = dressed();
    for (const uint32_t v : {8u, 9u}) torn.mesh.restPositions[v] *= 0.5f;
    EXPECT_DOUBLE_EQ(shareInside(torn, {rest}), 2.0 / 8);
}

TEST(Penetration, isTakenInEachPose) {
    // A narrow coat that stands clear of the body, until its joint turns by half a turn about the far end.
    AvatarData avatar = dressed();
    for (uint32_t v = 8; v < 16; ++v) avatar.mesh.restPositions[v] = 0.3f * avatar.mesh.restPositions[v] + Vec3f(1, 0, 0);
    avatar.joints[1].restPosition = {0.5f, 0, 0};
    Pose folded = Pose::rest(2);
    folded.localRotations[1] = glm::angleAxis(3.14159265f, Vec3f(0, 1, 0));
    EXPECT_EQ(shareInside(avatar, {Pose::rest(2)}), 0);
    EXPECT_EQ(shareInside(avatar, {folded}), 1);
    EXPECT_EQ(shareInside(avatar, {Pose::rest(2), folded}), 0.5);
}

TEST(Penetration, nothingLiesInsideWithoutGarmentsOrPoses) {
    AvatarData avatar = dressed();
    EXPECT_EQ(shareInside(avatar, {}), 0);
    avatar.mesh.layers.resize(1);
    EXPECT_EQ(shareInside(avatar, {Pose::rest(2)}), 0);
}

ClothFaults faultsOf(const AvatarData& avatar, const Pose& pose) {
    Jobs jobs(2);
    return must(clothFaults(avatar, std::span(&pose, 1), jobs));
}

/** The coat made 26 cm wide, so that it covers the body within reach. */
AvatarData closelyDressed() {
    AvatarData avatar = dressed();
    for (uint32_t v = 8; v < 16; ++v) avatar.mesh.restPositions[v] *= 13.0f / 15;
    return avatar;
}

TEST(ClothFaults, aWholeCoatShowsNone) {
    const ClothFaults faults = faultsOf(closelyDressed(), Pose::rest(2));
    EXPECT_EQ(faults.penetration, 0);
    EXPECT_EQ(faults.stretchedEdges, 0);
    EXPECT_NEAR(faults.longestStretch, 1, 1e-5);
    EXPECT_EQ(faults.skinPixels, 0);
}

TEST(ClothFaults, bodyCornersThatComeOutOfATurnedCoatAreSkinPixels) {
    // By 45°: of the 36.8 cm that each side shows of the coat, the body comes out over 2 × 1.6 cm, and it is 20 of 26 cm high. A pixel is
    // 5 mm wide, so the strips count as three or four pixels.
    Pose turned = Pose::rest(2);
    turned.localRotations[1] = glm::angleAxis(0.785398163f, Vec3f(0, 1, 0));
    const ClothFaults faults = faultsOf(closelyDressed(), turned);
    EXPECT_NEAR(faults.skinPixels, 2 * 1.6 / 36.8 * 20 / 26, 0.02);
    EXPECT_EQ(faults.stretchedEdges, 0);
}

TEST(ClothFaults, aTornCoatHasStretchedEdges) {
    AvatarData avatar = closelyDressed();
    for (const uint32_t v : {10u, 11u, 14u, 15u}) avatar.mesh.jointIndices[v] = {0, 0, 0, 0};  // its upper half stays
    avatar.joints[1].restPosition = {0, -0.65f, 0};
    Pose torn = Pose::rest(2);
    torn.localRotations[1] = glm::angleAxis(3.14159265f, Vec3f(1, 0, 0));
    const ClothFaults faults = faultsOf(avatar, torn);
    EXPECT_DOUBLE_EQ(faults.stretchedEdges, 16.0 / 36) << "two of three edges of each side's triangles";
    EXPECT_NEAR(faults.longestStretch, std::hypot(1.3, 0.26) / 0.26, 1e-3);
}

TEST(ClothFaults, offsetsAtWorkAreTheShareThatReachesLeave) {
    AvatarData avatar = closelyDressed();
    EXPECT_EQ(faultsOf(avatar, Pose::rest(2)).offsetsAtWork, 1) << "nothing is learned";
    PoseCorrectiveData& c = avatar.correctives;
    c.modeCount = 1, c.nodeCount = 2, c.joints = {1}, c.mean.assign(6, 0), c.modes = {0, 0, 0, 0, 0, 1}, c.reach = 0.25f;  // sin of a bend
    c.nodes = {Vec4f(0.01f, 0, 0, 0), Vec4f(5, 0, 0, 0)};  // the body's own does not count
    for (size_t v = 0; v < avatar.mesh.restPositions.size(); ++v)
        c.nodeIndices.push_back({uint16_t(v < 8), 0, 0, 0}), c.nodeWeights.push_back({255, 0, 0, 0});
    Pose bent = Pose::rest(2);
    bent.localRotations[1] = glm::angleAxis(0.2f, Vec3f(1, 0, 0));
    EXPECT_NEAR(faultsOf(avatar, bent).offsetsAtWork, 1, 1e-6) << "within reach";
    bent.localRotations[1] = glm::angleAxis(1.57079633f, Vec3f(1, 0, 0));
    EXPECT_NEAR(faultsOf(avatar, bent).offsetsAtWork, 0.25, 1e-5);
    MotionModeData m;
    m.groups = {{.columnCount = 1, .reach = 0.5f}}, m.joints = {1}, m.still = {{0, 0, 0, 1}}, m.rangeRad = {{0, 1}}, m.holdsS = {0};
    m.modes = {1, 0};  // has moved
    addMotionModes(c, m);
    c.nodes[0] = Vec4f(0), c.nodes[1] = {0.01f, 0, 0, 0};  // of the garments: bend, has moved
    EXPECT_NEAR(faultsOf(avatar, bent).offsetsAtWork, 0.5, 1e-5) << "motion modes have reaches too";
}

TEST(ClothFaults, needlesAreMeasuredForEachGarment) {
    // The coat's upper half stays while the lower one moves 30 cm to the side; a second garment stays whole.
    AvatarData avatar = closelyDressed();
    addBox(avatar, "hat", "garment", Vec3f(0, 0.3f, 0), Vec3f(0.1f), 0);
    for (const uint32_t v : {10u, 11u, 14u, 15u}) avatar.mesh.jointIndices[v] = {0, 0, 0, 0};
    const auto firstTriangle = avatar.mesh.layers[1].firstTriangle;
    avatar.splats.triangleStart.assign(avatar.mesh.triangles.size() + 1, 0);
    for (size_t t = firstTriangle + 1; t < avatar.splats.triangleStart.size(); ++t) avatar.splats.triangleStart[t] = 1;
    avatar.splats.uv = {{0.3f, 0.3f}}, avatar.splats.phi = {0.5f}, avatar.splats.scaleM = {{0.01f, 0.004f}}, avatar.splats.opacity = {0.5f},
    avatar.splats.flags = {0};
    const Pose rest = Pose::rest(2);
    const double visible = 2 * std::sqrt(2 * std::log(0.5 * 255));  // lengths of a splat of opacity 0.5, in standard deviations
    const ClothFaults still = faultsOf(avatar, rest);
    ASSERT_EQ(still.garments.size(), 2u);
    EXPECT_EQ(still.garments[0].name, "top");
    EXPECT_NEAR(still.garments[0].longestSplatM, visible * 0.01, 1e-6);
    EXPECT_EQ(still.garments[1].longestSplatM, 0) << "no splats";
    Pose torn = rest;
    avatar.joints[1].restPosition = {0, 0.15f, 0};
    torn.localRotations[1] = glm::angleAxis(2 * std::asin(0.5f), Vec3f(0, 0, 1));  // moves what lies 28 cm below by 28 cm
    const ClothFaults faults = faultsOf(avatar, torn);
    EXPECT_GT(faults.garments[0].longestStretch, 1.2);
    EXPECT_EQ(faults.longestStretch, faults.garments[0].longestStretch);
    EXPECT_NEAR(faults.garments[1].longestStretch, 1, 1e-5);
    EXPECT_EQ(faults.longestSplatM, faults.garments[0].longestSplatM);
    EXPECT_GT(faults.longestSplatM, 1.05 * still.longestSplatM);
    EXPECT_LT(faults.longestSplatM, visible * 0.01 * (kStretchHigh + kStretchHighRoom)) << "what is drawn is bounded";
}

TEST(ClothFaults, theWorstPoseIsNamedAndACancelledRunSaysSo) {
    AvatarData avatar = closelyDressed();
    Pose out = Pose::rest(2), in = Pose::rest(2);
    avatar.joints[1].restPosition = {0, 0, 0.13f};  // the middle of the coat's front, whose corners turn into the body
    for (uint32_t v = 8; v < 16; ++v) avatar.mesh.restPositions[v].x *= 0.5f, avatar.mesh.restPositions[v].y *= 0.5f;
    in.localRotations[1] = glm::angleAxis(0.9f, Vec3f(0, 1, 0));
    const std::vector<Pose> poses{out, in, out};
    Jobs jobs(2);
    const ClothFaults faults = must(clothFaults(avatar, poses, jobs));
    EXPECT_GT(faults.penetration, 0);
    EXPECT_EQ(faults.worstPose, 1u);
    test::HeardTask task(1);
    const TaskScope scope(&task);
    const auto cancelled = clothFaults(avatar, poses, jobs);
    ASSERT_FALSE(cancelled);
    EXPECT_EQ(cancelled.error().code, Code::Cancelled);
}

}  // namespace
}  // namespace dpl::test
