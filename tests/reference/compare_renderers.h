// SPDX-License-Identifier: Apache-2.0
// Draws a scene with the CPU splat engine and compares every channel with the referee's picture.
#pragma once

#include <gtest/gtest.h>

#include <cstdio>

#include "apps/reference/reference_renderer.h"
#include "sdk/splat/splat_engine.h"
#include "tests/reference/image_compare.h"

namespace dpl {

/** Triangle frames and splats in float from the referee's scene. Skinning is the referee's; that of sdk/avatar has its own tests. */
struct EngineInput {
    std::vector<TriangleFrame<float>> frames;
    std::vector<uint32_t> triangle;
    std::vector<Vec2f> uv, scaleM;
    std::vector<float> phi, opacity, sh;
    std::vector<uint8_t> flags;
    uint32_t shDegree = 0;

    explicit EngineInput(const ReferenceScene& scene) : shDegree(scene.shDegree) {
        for (const glm::uvec3& t : scene.triangles) {
            frames.push_back(drawnTriangle(restTriangle(Vec3f(scene.rest[t.x]), Vec3f(scene.rest[t.y]), Vec3f(scene.rest[t.z])),
                                           Vec3f(scene.posed[t.x]), Vec3f(scene.posed[t.y]), Vec3f(scene.posed[t.z])));
            if (!scene.light.empty()) frames.back().light = Vec3f(scene.light[t.x], scene.light[t.y], scene.light[t.z]);
        }
        for (const ReferenceBoundSplat& s : scene.splats) {
            triangle.push_back(s.triangle), uv.emplace_back(s.uv), phi.push_back(float(s.phi)), scaleM.emplace_back(s.scaleM);
            opacity.push_back(float(s.opacity)), flags.push_back(s.flags);
            for (const double x : s.sh) sh.push_back(float(x));
        }
    }
    BoundSplatView view() const { return {triangle, uv, phi, scaleM, opacity, flags, shDegree, sh}; }
};

inline constexpr double kBarDb = 50;  // against the reference, required of every renderer

/** Expects at least psnrDb in colour, alpha and cloth, and prints PSNR and largest error. Depth is compared where alpha > 0.5. */
inline void expectSameImage(const char* name, const SplatImage& image, const ReferenceImage& reference, double psnrDb) {
    ASSERT_EQ(image.alpha.size(), reference.alpha.size()) << name;
    const ImageDifference colour = compareImages(image.rgb, reference.rgb), alpha = compareImages(image.alpha, reference.alpha);
    double depthError = 0;
    for (size_t i = 0; i < image.depthM.size(); ++i)
        if (reference.alpha[i] > 0.5)
            depthError = std::max(depthError, std::abs(image.depthM[i] - reference.depthM[i]) / reference.depthM[i]);
    std::printf("%-34s colour %6.1f dB, max %.2e | alpha %6.1f dB, max %.2e | depth max %.1e | covered %4.1f %%\n", name, colour.psnrDb,
                colour.maxError, alpha.psnrDb, alpha.maxError, depthError, 100 * coverage(reference.alpha, 0.004));
    EXPECT_GE(colour.psnrDb, psnrDb) << name;
    EXPECT_GE(alpha.psnrDb, psnrDb) << name;
    if (!image.cloth.empty()) {
        EXPECT_GE(compareImages(image.cloth, reference.cloth).psnrDb, psnrDb) << name;
    }
    // Float rounding may flip a splat across the 1/255 cut-off or a depth tie. That moves depth by its weight times the spread of depths.
    EXPECT_LT(depthError, 0.02) << name;
}

inline SplatImage drawSoftware(const ReferenceScene& scene, const Cameraf& camera, uint32_t threads = 2) {
    Jobs jobs(threads);
    SplatEngine engine(jobs);
    const EngineInput input(scene);
    SplatImage image;
    engine.project(input.view(), input.frames, camera, float(kKappaPx2));
    engine.bin();
    engine.blend(image, {.cloth = true, .depth = true});
    return image;
}

inline SplatImage drawSoftware(const StaticSplatData& splats, const Cameraf& camera, uint32_t threads = 2) {
    Jobs jobs(threads);
    SplatEngine engine(jobs);
    SplatImage image;
    engine.project(splats, camera, float(kKappaPx2));
    engine.bin();
    engine.blend(image, {.cloth = true, .depth = true});
    return image;
}

}  // namespace dpl
