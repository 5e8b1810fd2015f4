// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/needle_figures.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dpl::test {
namespace {

/** A tube around the vertical from the waist to below the knees, as a layer. share: of the legs in the weights at its lower end, where each
 *  half follows its own leg. */
void addTube(AvatarData& a, const std::string& name, const std::string& role, float radiusM, float share) {
    constexpr uint32_t kRings = 14, kAround = 24;
    MeshData& m = a.mesh;
    const auto first = uint32_t(m.restPositions.size()), firstTriangle = uint32_t(m.triangles.size());
    for (uint32_t r = 0; r <= kRings; ++r)
        for (uint32_t s = 0; s < kAround; ++s) {
            const float down = float(r) / kRings, angle = 6.2831853f * (float(s) + 0.5f) / kAround;
            m.restPositions.emplace_back(radiusM * std::cos(angle), 1 - 0.6f * down, radiusM * std::sin(angle));
            const auto leg = uint8_t(255 * share * down);
            m.jointIndices.emplace_back(0, std::cos(angle) > 0 ? 1 : 4, 0, 0), m.jointWeights.emplace_back(255 - leg, leg, 0, 0);
        }
    for (uint32_t r = 0; r < kRings; ++r)
        for (uint32_t s = 0; s < kAround; ++s) {
            const uint32_t p = first + r * kAround + s, q = first + r * kAround + (s + 1) % kAround;
            m.triangles.push_back({p, q, p + kAround}), m.triangles.push_back({q, q + kAround, p + kAround});
        }
    m.layers.push_back({name, role, first, kAround * (kRings + 1), firstTriangle, 2 * kAround * kRings});
}

AvatarData inSkirt() {
    AvatarData a;
    a.joints = {{"hips", -1, {0, 1, 0}, "hips"},
                {"thigh_l", 0, {0.1f, 0.95f, 0}, "leftUpperLeg"},
                {"shin_l", 1, {0.1f, 0.5f, 0}, "leftLowerLeg"},
                {"foot_l", 2, {0.1f, 0.08f, 0}, "leftFoot"},
                {"thigh_r", 0, {-0.1f, 0.95f, 0}, "rightUpperLeg"},
                {"shin_r", 4, {-0.1f, 0.5f, 0}, "rightLowerLeg"},
                {"foot_r", 5, {-0.1f, 0.08f, 0}, "rightFoot"}};
    addTube(a, "body", "body", 0.12f, 0);
    addTube(a, "skirt", "garment", 0.2f, 1);
    for (uint32_t t = 0; t < a.mesh.triangles.size(); ++t) {
        a.splats.triangleStart.push_back(t);
        a.splats.uv.push_back({1.0f / 3, 1.0f / 3}), a.splats.phi.push_back(0), a.splats.scaleM.push_back({0.02f, 0.02f});
        a.splats.opacity.push_back(0.95f), a.splats.flags.push_back(0);
    }
    a.splats.triangleStart.push_back(a.splats.count());
    a.splats.sh.assign(3 * size_t(a.splats.count()), 0.0f);
    return a;
}

const ReportFigure& figure(const ReportData& data, const std::string& key) {
    for (const ReportFigure& f : data.figures)
        if (f.key == key) return f;
    throw std::runtime_error("no figure " + key);
}

TEST(NeedleFigures, standForTheStressPosesAndForEachMove) {
    Jobs jobs(2);
    ReportData data;
    addNeedleFigures(inSkirt(), jobs, data);
    const auto edge = [&](const std::string& poses) { return figure(data, poses + ".skirt.edge").value; };
    EXPECT_GT(edge("needles"), 3) << "each half of the hem follows its own leg";
    EXPECT_GT(edge("needles_walking"), 3);
    EXPECT_GT(edge("needles_squatting"), 1.1);
    EXPECT_NEAR(edge("needles_turning"), 1, 0.01) << "the legs hang";
    EXPECT_TRUE(figure(data, "needles.skirt.edge").bar);
    EXPECT_FALSE(figure(data, "needles_squatting.skirt.edge").bar);
    EXPECT_GT(figure(data, "needles_walking.skirt.splat").value, figure(data, "needles_turning.skirt.splat").value);
    EXPECT_EQ(figure(data, "needles_turning.skirt.outside.most").value, 0);
}

TEST(NeedleFigures, thereAreNoneWithoutLegsOrGarments) {
    Jobs jobs(2);
    AvatarData avatar = inSkirt();
    for (JointData& joint : avatar.joints) joint.name = "part", joint.humanoidBone.clear();
    ReportData data;
    addNeedleFigures(avatar, jobs, data);
    avatar = inSkirt();
    avatar.mesh.layers.pop_back();
    addNeedleFigures(avatar, jobs, data);
    EXPECT_TRUE(data.figures.empty());
}

}  // namespace
}  // namespace dpl::test
