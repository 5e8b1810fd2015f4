// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/garments/grown_tubes.h"

#include <gtest/gtest.h>

#include <cmath>

#include "modelled_person.h"
#include "reconstruction/subject/garments/cloth_faults.h"
#include "reconstruction/subject/garments/garment_pictures.h"
#include "reconstruction/subject/garments/side_view.h"
#include "tests/unit/must.h"

namespace dpl::test {
namespace {

constexpr uint32_t kAroundSkirt = 24, kRowsOfSkirt = 9;
constexpr float kWaistY = 0.97f, kHemY = 0.42f;

/** Dense splats on every triangle of the garments; the body has none. */
void coverGarments(AvatarData& avatar) {
    SplatData& s = avatar.splats;
    s = {};
    s.triangleStart.assign(1, 0);
    for (uint32_t t = 0; t < avatar.mesh.triangles.size(); ++t) {
        bool garment = false;
        for (const LayerData& layer : avatar.mesh.layers)
            garment |= layer.role == "garment" && t >= layer.firstTriangle && t < layer.firstTriangle + layer.triangleCount;
        constexpr int kGrid = 4;
        for (int i = 0; i < kGrid && garment; ++i)
            for (int j = 0; i + j < kGrid; ++j) {
                s.uv.push_back({(float(i) + 0.33f) / kGrid, (float(j) + 0.33f) / kGrid});
                s.phi.push_back(0), s.scaleM.push_back({0.012f, 0.012f}), s.opacity.push_back(0.98f), s.flags.push_back(0);
            }
        s.triangleStart.push_back(s.count());
    }
    s.sh.assign(3 * size_t(s.count()), 0.0f);
}

/** A person in a wide skirt, 70 cm across at the hem, that both legs move. */
AvatarData inSkirt() {
    AvatarData avatar;
    avatar.joints = joints();
    MeshData& m = avatar.mesh;
    m = body();
    const auto first = uint32_t(m.restPositions.size()), firstTriangle = uint32_t(m.triangles.size());
    for (uint32_t row = 0; row < kRowsOfSkirt; ++row)
        for (uint32_t a = 0; a < kAroundSkirt; ++a) {
            const float down = float(row) / float(kRowsOfSkirt - 1), angle = 6.2831853f * float(a) / float(kAroundSkirt);
            const float radius = 0.17f + 0.18f * down;
            const Vec3f p(radius * std::sin(angle), kWaistY + down * (kHemY - kWaistY), radius * std::cos(angle));
            m.restPositions.push_back(p);
            const float leg = std::min(1.0f, 2 * down), left = leg * std::clamp(0.5f + p.x / 0.3f, 0.0f, 1.0f);
            const auto l = uint8_t(std::lround(255 * left)), r = uint8_t(std::min(255 - int(l), int(std::lround(255 * (leg - left)))));
            m.jointIndices.push_back({0, 1, 2, 0}), m.jointWeights.push_back({uint8_t(255 - l - r), l, r, 0});
        }
    for (uint32_t row = 0; row + 1 < kRowsOfSkirt; ++row)
        for (uint32_t a = 0; a < kAroundSkirt; ++a) {
            const uint32_t p = first + row * kAroundSkirt + a, q = first + row * kAroundSkirt + (a + 1) % kAroundSkirt;
            m.triangles.push_back({p, p + kAroundSkirt, q}), m.triangles.push_back({q, p + kAroundSkirt, q + kAroundSkirt});
        }
    m.layers.push_back(
        {"skirt", "garment", first, kAroundSkirt * kRowsOfSkirt, firstTriangle, uint32_t(m.triangles.size()) - firstTriangle});
    coverGarments(avatar);
    return avatar;
}

/** The legs turned about an axis, by angles of the left and the right one. */
Pose striding(float leftRad, float rightRad, const Vec3f& axis = {1, 0, 0}) {
    Pose pose = Pose::rest(3);
    pose.localRotations[1] = glm::angleAxis(leftRad, axis), pose.localRotations[2] = glm::angleAxis(rightRad, axis);
    return pose;
}

std::vector<Pose> walk() {
    std::vector<Pose> poses;
    for (int i = 0; i < 12; ++i) {
        const float swing = 0.45f * std::sin(6.2831853f * float(i) / 12);
        poses.push_back(striding(swing, -swing));
    }
    return poses;
}

GarmentNeedles skirtIn(const AvatarData& avatar, const std::vector<Pose>& poses) {
    Jobs jobs(2);
    return clothNeedles(avatar, poses, jobs).at(0);
}

TEST(GrownTubes, encloseAGarmentAtRestAndLittleElse) {
    const AvatarData avatar = inSkirt();
    const GrownTubes tubes(avatar.joints, avatar.mesh, avatar.mesh.layers[1]);
    std::vector<Mat3x4f> world;
    jointTransforms(avatar.joints, Pose::rest(3), world);
    for (int side = 0; side < kSides; ++side) {
        const Camerad camera = sideView(avatar.mesh.restPositions, side);
        const std::vector<uint8_t> inside = tubes.outline(world, camera);
        const MeshRaster mesh = rasteriseMesh(avatar.mesh.restPositions, avatar.mesh.triangles, camera);
        size_t missed = 0, covered = 0, filled = 0;
        for (size_t i = 0; i < inside.size(); ++i) {
            const bool seen = mesh.triangle[i] != kNoTriangle;
            covered += seen, filled += inside[i], missed += seen && !inside[i];
        }
        EXPECT_LT(double(missed), 0.001 * double(covered)) << side << ": pixels at the edge";
        EXPECT_LT(double(filled), 1.35 * double(covered)) << side;
    }
}

TEST(GrownTubes, areEmptyWithoutABody) {
    AvatarData avatar = inSkirt();
    avatar.mesh.layers[0].role = "hair";
    EXPECT_TRUE(GrownTubes(avatar.joints, avatar.mesh, avatar.mesh.layers[1]).empty());
}

TEST(OutsideTheTubes, aWideSkirtAtRestHasNone) {
    const GarmentNeedles skirt = skirtIn(inSkirt(), {Pose::rest(3)});
    EXPECT_EQ(skirt.outside.mostPx, 0u);
    EXPECT_EQ(skirt.outside.share, 0);
}

TEST(OutsideTheTubes, aPlainWalkHasNextToNone) {
    const GarmentNeedles skirt = skirtIn(inSkirt(), walk());
    EXPECT_LT(skirt.outside.share, 0.0005);
    EXPECT_LT(skirt.uncovered.share, 0.03);
}

TEST(OutsideTheTubes, aNeedleIsCountedAndItsPoseNamed) {
    // One vertex at the right of the hem follows the left leg. When that crosses to the right, the vertex stands 17 cm out.
    AvatarData avatar = inSkirt();
    const LayerData& skirt = avatar.mesh.layers[1];
    uint32_t right = skirt.firstVertex;
    const auto key = [&](uint32_t v) { return avatar.mesh.restPositions[v].x + avatar.mesh.restPositions[v].y; };
    for (uint32_t v = right; v < skirt.firstVertex + skirt.vertexCount; ++v)
        if (key(v) < key(right)) right = v;
    const std::vector<Pose> poses{Pose::rest(3), striding(-0.3f, 0, {0, 0, 1}), Pose::rest(3)};
    const GarmentNeedles whole = skirtIn(avatar, poses);
    avatar.mesh.jointWeights[right] = {0, 255, 0, 0};
    const GarmentNeedles torn = skirtIn(avatar, poses);
    EXPECT_GT(torn.outside.mostPx, whole.outside.mostPx + 50);
    EXPECT_EQ(torn.outside.worstPose, 1u);
    EXPECT_GT(torn.outside.share, 0);
    EXPECT_EQ(skirtIn(avatar, {Pose::rest(3)}).outside.mostPx, 0u) << "at rest the vertex is in its place";
}

TEST(OutsideTheTubes, countsWhatIsDrawnBeyondTwoCentimetres) {
    // A wrong joint lowers the whole skirt, and the tubes stay. Its sides slope, so it stands out below the hem alone: the hem is 70 cm
    // wide and the legs, with two centimetres around, cover 36 cm of it from front and back and 18 cm from the sides.
    AvatarData avatar = inSkirt();
    const LayerData& skirt = avatar.mesh.layers[1];
    avatar.joints.push_back({"prop", 0, {0, 0.7f, -10}, ""});
    for (uint32_t v = skirt.firstVertex; v < skirt.firstVertex + skirt.vertexCount; ++v)
        avatar.mesh.jointIndices[v] = {3, 0, 0, 0}, avatar.mesh.jointWeights[v] = {255, 0, 0, 0};
    const auto outsideAt = [&](float downM) {
        Pose pose = Pose::rest(4);
        pose.localRotations[3] = glm::angleAxis(downM / 10, Vec3f(1, 0, 0));  // about a line ten metres away: nearly a shift
        return double(skirtIn(avatar, {pose}).outside.mostPx);
    };
    EXPECT_EQ(outsideAt(0), 0);
    EXPECT_EQ(outsideAt(0.01f), 0);
    const double width = 2 * (0.70 - 0.36) + 2 * (0.70 - 0.18), one = outsideAt(0.08f), two = outsideAt(0.12f);
    EXPECT_NEAR(two - one, width * 0.04 / (kSidePixelM * kSidePixelM), 0.15 * two);
    EXPECT_NEAR(two, width * 0.10 / (kSidePixelM * kSidePixelM), 0.3 * two);
}

TEST(UncoveredInTheOutline, isWhatTheWholeAvatarLeavesOpen) {
    // Without the splats of the skirt's lower half, half of its height is open; the body has no splats.
    AvatarData avatar = inSkirt();
    const LayerData& skirt = avatar.mesh.layers[1];
    const double whole = skirtIn(avatar, {Pose::rest(3)}).uncovered.share;
    EXPECT_LT(whole, 0.03);
    for (uint32_t t = skirt.firstTriangle + skirt.triangleCount / 2; t < skirt.firstTriangle + skirt.triangleCount; ++t)
        for (uint32_t i = avatar.splats.triangleStart[t]; i < avatar.splats.triangleStart[t + 1]; ++i) avatar.splats.opacity[i] = 0;
    const GarmentNeedles half = skirtIn(avatar, {Pose::rest(3)});
    const double lower = (0.26 + 0.35) / (0.17 + 0.26 + 0.26 + 0.35);  // of the area of two trapezia
    EXPECT_NEAR(half.uncovered.share, lower, 0.04);
    EXPECT_GT(half.uncovered.mostPx, 1000u);
    EXPECT_EQ(half.outside.mostPx, 0u);
}

TEST(DrawnFaults, ofAllGarmentsAreTheSumOfEach) {
    AvatarData avatar = inSkirt();
    for (uint32_t i = 0; i < avatar.splats.count() / 3; ++i) avatar.splats.opacity[i] = 0;
    const std::vector<Pose> poses{Pose::rest(3)};
    Jobs jobs(2);
    const ClothFaults faults = must(clothFaults(avatar, poses, jobs));
    ASSERT_EQ(faults.garments.size(), 1u);
    EXPECT_EQ(faults.outside.mostPx, faults.garments[0].outside.mostPx);
    EXPECT_EQ(faults.uncovered.share, faults.garments[0].uncovered.share);
    EXPECT_GT(faults.uncovered.mostPx, 0u);
    avatar.splats = {};
    EXPECT_EQ(must(clothFaults(avatar, poses, jobs)).uncovered.mostPx, 0u) << "without splats nothing is drawn, and nothing is measured";
}

}  // namespace
}  // namespace dpl::test
