// SPDX-License-Identifier: Apache-2.0
// A small procedural avatar for renderer tests: a tube along +Y that bends at one of its two joints, with layers of splats of every kind.
#pragma once

#include <cmath>
#include <random>

#include "sdk/avatar/rig.h"
#include "sdk/format/avatar_data.h"
#include "sdk/format/splat_codec.h"
#include "sdk/math/camera.h"
#include "sdk/math/sh.h"

namespace dpl {

struct TubeOptions {
    uint32_t splatsPerTriangle = 8, rings = 20, segments = 16, shDegree = 2, seed = 7;
    bool singleFace = true;  // every second triangle ring; false: none
    float colourSpread = 1;  // of the random SH coefficients
};

/** About 5,000 splats at the defaults; 1 m tall, 0.18 m radius, joint 1 bends it at y = 0.5. */
inline AvatarData makeTube(const TubeOptions& o = {}) {
    AvatarData a;
    a.name = "tube";
    a.joints = {{"root", -1, {0, 0, 0}, "hips"}, {"bend", 0, {0, 0.5f, 0}, "spine"}};
    for (uint32_t r = 0; r <= o.rings; ++r) {
        const float y = float(r) / float(o.rings);
        const float upper = std::min(1.0f, std::max(0.0f, (y - 0.4f) / 0.2f));
        const uint8_t w1 = uint8_t(std::lround(upper * 255));
        for (uint32_t s = 0; s < o.segments; ++s) {
            const float angle = 6.2831853f * float(s) / float(o.segments);
            a.mesh.restPositions.push_back({0.18f * std::cos(angle), y, 0.18f * std::sin(angle)});
            a.mesh.colours.push_back({200, 150, 120, 255});
            a.mesh.jointIndices.push_back({0, 1, 0, 0});
            a.mesh.jointWeights.push_back({uint8_t(255 - w1), w1, 0, 0});
        }
    }
    for (uint32_t r = 0; r < o.rings; ++r)
        for (uint32_t s = 0; s < o.segments; ++s) {
            const uint32_t p = r * o.segments + s, q = r * o.segments + (s + 1) % o.segments, up = o.segments;
            a.mesh.triangles.push_back({p, p + up, q});
            a.mesh.triangles.push_back({q, p + up, q + up});
        }
    a.mesh.layers = {{"body", "body", 0, uint32_t(a.mesh.restPositions.size()), 0, uint32_t(a.mesh.triangles.size())}};

    std::mt19937 random(o.seed);
    std::uniform_real_distribution<float> uniform(0, 1);
    std::normal_distribution<float> normal(0, 1);
    SplatData& s = a.splats;
    s.shDegree = o.shDegree;
    s.triangleStart.push_back(0);
    for (uint32_t t = 0; t < a.mesh.triangles.size(); ++t) {
        for (uint32_t k = 0; k < o.splatsPerTriangle; ++k) {
            float u = uniform(random), v = uniform(random);
            if (u + v > 1) u = 1 - u, v = 1 - v;
            s.uv.push_back({u, v});
            s.phi.push_back(uniform(random) * 3.14159f);
            s.scaleM.push_back({0.006f + 0.015f * uniform(random), 0.003f + 0.008f * uniform(random)});
            s.opacity.push_back(0.3f + 0.69f * uniform(random));
            s.flags.push_back(
                uint8_t((o.singleFace && (t / (2 * o.segments)) % 2 == 0 ? kSplatSingleFace : 0) | (k % 3 == 0 ? kSplatCloth : 0)));
            for (uint32_t c = 0; c < shCoefficientCount(o.shDegree) * 3; ++c)
                s.sh.push_back(o.colourSpread * normal(random) * (c < 3 ? 0.9f : 0.15f));
        }
        s.triangleStart.push_back(s.count());
    }
    return a;
}

/** Codes and decodes the splats once, as renderers keep them. The referee, which knows no codes, then draws the same splats. */
inline AvatarData codedOnce(AvatarData a) {
    a.splats = decodeSplats(*codeSplats(a.mesh, a.splats), a.mesh.triangles.size());
    return a;
}

/** Bends the upper half by `bend` radians about +X and turns the tube by `turn` radians about +Y. */
inline Pose tubePose(float bend, float turn = 0) {
    Pose pose = Pose::rest(2);
    pose.localRotations[0] = glm::angleAxis(turn, Vec3f(0, 1, 0));
    pose.localRotations[1] = glm::angleAxis(bend, Vec3f(1, 0, 0));
    return pose;
}

/** Looks at (0, 0.5, 0) from `distanceM`, `azimuth` radians around +Y from +Z; `shiftM` moves the eye along its right. */
inline Cameraf tubeCamera(uint32_t widthPx, uint32_t heightPx, float azimuth, float distanceM = 1.8f, float shiftM = 0) {
    Cameraf c;
    c.widthPx = widthPx, c.heightPx = heightPx;
    c.fx = c.fy = 1.2f * float(std::max(widthPx, heightPx));
    c.cx = float(widthPx) / 2, c.cy = float(heightPx) / 2;
    const Vec3f forward(-std::sin(azimuth), 0, -std::cos(azimuth)), down(0, -1, 0), right = glm::cross(down, forward);
    const Vec3f eye = Vec3f(0, 0.5f, 0) - forward * distanceM + right * shiftM;
    c.viewFromWorldRotation = glm::transpose(Mat3f(right, down, forward));
    c.viewFromWorldTranslation = -(c.viewFromWorldRotation * eye);
    return c;
}

}  // namespace dpl
