// SPDX-License-Identifier: Apache-2.0
// The forward records of the SIMD kernel against the same formulas in double, on random and hard splats.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "sdk/splat/splat_engine.h"
#include "tests/unit/splat/bound_forward.h"

namespace dpl::test {
namespace {

constexpr uint32_t kDegree = 3;

struct Scene {
    Cameraf camera;
    SplatData splats;
    std::vector<TriangleFrame<float>> frames;
    std::vector<uint32_t> triangle;
    BoundSplatView view() const {
        return {triangle, splats.uv, splats.phi, splats.scaleM, splats.opacity, splats.flags, kDegree, splats.sh};
    }
};

/** One splat a triangle. Some triangles lie in the near fade or beside the picture, and some splats are needles. */
Scene makeScene(uint32_t count) {
    Scene s;
    s.camera.widthPx = 320, s.camera.heightPx = 240, s.camera.fx = 300, s.camera.fy = 310, s.camera.cx = 155, s.camera.cy = 124;
    s.camera.viewFromWorldRotation = glm::mat3_cast(glm::normalize(Quatf(0.9f, 0.1f, -0.2f, 0.05f)));
    s.camera.viewFromWorldTranslation = {0.1f, -0.2f, 0.3f};
    std::mt19937 random(11);
    std::normal_distribution<float> normal;
    std::uniform_real_distribution<float> uniform(0, 1);
    const Mat3f worldFromView = glm::transpose(s.camera.viewFromWorldRotation);
    for (uint32_t i = 0; i < count; ++i) {
        const auto vector = [&](float size) { return size * Vec3f(normal(random), normal(random), normal(random)); };
        const bool aside = i % 11 == 0;  // slopes are clamped, and the splat is large enough to reach the picture
        const float z = i % 7 == 0 ? 0.06f + 0.12f * uniform(random) : 0.5f + 3 * uniform(random), size = (aside ? 0.3f : 0.02f) * z;
        const float spread = aside ? 0.8f : 0.4f;
        const Vec3f view(spread * z * normal(random), spread * z * normal(random), z);
        const Vec3f centre = worldFromView * (view - s.camera.viewFromWorldTranslation);
        const Vec3f rest[3] = {vector(size), vector(size), vector(size)};
        const Vec3f corners[3] = {centre + vector(size), centre + vector(size), centre + vector(size)};
        TriangleFrame<float> f = poseTriangle(restTriangle(rest[0], rest[1], rest[2]), corners[0], corners[1], corners[2]);
        f.light = Vec3f(0.5f) + Vec3f(uniform(random), uniform(random), uniform(random));
        s.frames.push_back(f);
        s.splats.uv.push_back({0.5f * uniform(random), 0.5f * uniform(random)});
        s.splats.phi.push_back(6.28f * uniform(random));
        const float longM = 0.5f * size * (0.1f + uniform(random));
        s.splats.scaleM.push_back({longM, longM * (i % 5 == 0 ? 0.01f : 0.2f + uniform(random))});
        s.splats.opacity.push_back(0.2f + 0.8f * uniform(random));
        s.splats.flags.push_back(i % 2 ? kSplatSingleFace : 0);
        for (uint32_t k = 0; k < shCoefficientCount(kDegree) * 3; ++k) s.splats.sh.push_back(0.2f * normal(random));
        s.triangle.push_back(i);
    }
    return s;
}

BoundForward<double> exactForward(const Scene& s, uint32_t i) {
    const TriangleFrame<float>& f = s.frames[i];
    TriangleFrame<double> frame;
    frame.v0 = f.v0, frame.v1 = f.v1, frame.v2 = f.v2, frame.f0 = f.f0, frame.f1 = f.f1, frame.normal = f.normal;
    frame.worldFromRest = Mat3d(f.worldFromRest), frame.light = f.light, frame.valid = f.valid;
    const std::vector<double> sh(s.splats.sh.begin() + i * 48, s.splats.sh.begin() + (i + 1) * 48);
    BoundSplat<double> splat;
    splat.uv = s.splats.uv[i], splat.phi = s.splats.phi[i], splat.scaleM = s.splats.scaleM[i], splat.opacity = s.splats.opacity[i];
    splat.singleFace = s.splats.flags[i] & kSplatSingleFace, splat.shDegree = kDegree, splat.sh = sh.data();
    return projectBoundSplat(s.camera.cast<double>(), frame, splat, 0.3);
}

/** Expects |got − want| ≤ ulps · 2⁻²³ · size, where size is the magnitude of the summands of the value. */
void expectWithin(double got, double want, double size, double ulps, const char* what, uint32_t splat) {
    EXPECT_LE(std::abs(got - want), ulps * 0x1p-23 * size) << what << " of splat " << splat << ", " << want;
}

TEST(ForwardRecord, isWhatTheFormulasGiveInDouble) {
    const Scene s = makeScene(4000);
    Jobs jobs(2);
    SplatEngine engine(jobs);
    engine.project(s.view(), s.frames, s.camera, 0.3f, true, true);
    ASSERT_EQ(engine.forwardRecords().size(), s.triangle.size());
    uint32_t shown = 0, fading = 0, gated = 0, clamped = 0;
    for (uint32_t i = 0; i < s.triangle.size(); ++i) {
        const ProjectedSplat& p = engine.projected()[i];
        if (!(p.opacity > 0)) continue;
        ++shown;
        const BoundForward<double> exact = exactForward(s, i);
        const ForwardRecord<float>& r = engine.forwardRecords()[i];
        const ForwardRecord<double>& e = exact.record;
        ASSERT_TRUE(exact.visible);
        const double z = e.depthM, jacobian = 310 / z, far = 1 / (e.inverseDistance * z);
        // View coordinates are sums of numbers as large as the distances to the eye and to the world's origin, which is within 1 m of the
        // eye.
        const double place = 1 + 1 / z + far;
        expectWithin(r.a10, e.a10, std::hypot(e.a10, e.a11), 2, "a10", i);
        expectWithin(r.a21, e.a21, std::hypot(e.a20, e.a21), 2, "a21", i);
        expectWithin(r.inverseZ, e.inverseZ, place * e.inverseZ, 4, "inverseZ", i);
        expectWithin(r.slopeX, e.slopeX, place * (1 + std::abs(e.slopeX)), 8, "slopeX", i);
        expectWithin(r.clampedY, e.clampedY, place * (1 + std::abs(e.slopeY)), 8, "clampedY", i);
        const double length1 = glm::length(Vec3d(s.frames[i].f0)) * std::abs(e.a10) + glm::length(Vec3d(s.frames[i].f1)) * std::abs(e.a11),
                     length2 = glm::length(Vec3d(s.frames[i].f0)) * std::abs(e.a20) + glm::length(Vec3d(s.frames[i].f1)) * std::abs(e.a21),
                     onScreen1 = jacobian * length1 * (1 + std::abs(e.clampedX) + std::abs(e.clampedY)) * place,
                     onScreen2 = jacobian * length2 * (1 + std::abs(e.clampedX) + std::abs(e.clampedY)) * place;
        expectWithin(r.b1X, e.b1X, onScreen1, 8, "b1X", i);
        expectWithin(r.b1Y, e.b1Y, onScreen1, 8, "b1Y", i);
        expectWithin(r.b2X, e.b2X, onScreen2, 8, "b2X", i);
        expectWithin(r.b2Y, e.b2Y, onScreen2, 8, "b2Y", i);
        expectWithin(r.axis1Z, e.axis1Z, length1, 8, "axis1Z", i);
        expectWithin(r.axis2Z, e.axis2Z, length2, 8, "axis2Z", i);
        // Errors of B are amplified in the conic by the condition number of Σ'.
        const double variance = onScreen1 * onScreen1 + onScreen2 * onScreen2 + 0.3, condition = variance * (e.conicA + e.conicC);
        expectWithin(r.conicA, e.conicA, condition * (e.conicA + e.conicC), 16, "conicA", i);
        expectWithin(r.conicB, e.conicB, condition * (e.conicA + e.conicC), 16, "conicB", i);
        expectWithin(r.compensation, e.compensation, condition, 16, "compensation", i);
        expectWithin(r.nearFade, e.nearFade, 1 + 20 * place * z, 8, "nearFade", i);
        expectWithin(r.gate, e.gate, 1 + 20 * place, 16, "gate", i);
        expectWithin(r.cosine, e.cosine, place, 16, "cosine", i);
        expectWithin(r.directionX, e.directionX, place, 8, "directionX", i);
        expectWithin(r.red, e.red, 20 * place, 16, "red", i);
        expectWithin(r.light, e.light, 2, 4, "light", i);
        expectWithin(p.opacity, exact.opacity, condition + 40 * place, 16, "opacity", i);
        fading += e.nearFade < 1, gated += e.gate < 1, clamped += e.slopeX != e.clampedX || e.slopeY != e.clampedY;
    }
    EXPECT_GT(shown, 1000u);
    for (const uint32_t hard : {fading, gated, clamped}) EXPECT_GT(hard, 20u);
}

TEST(ForwardRecord, isThereOnlyWhenAskedFor) {
    const Scene s = makeScene(20);
    Jobs jobs(1);
    SplatEngine engine(jobs);
    engine.project(s.view(), s.frames, s.camera, 0.3f);
    EXPECT_TRUE(engine.forwardRecords().empty());
    engine.project(s.view(), s.frames, s.camera, 0.3f, true, true);
    EXPECT_EQ(engine.forwardRecords().size(), 20u);
    engine.project(s.view(), s.frames, s.camera, 0.3f);
    EXPECT_TRUE(engine.forwardRecords().empty());
}

}  // namespace
}  // namespace dpl::test
