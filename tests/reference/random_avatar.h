// SPDX-License-Identifier: Apache-2.0
// Random but reproducible avatars and general splats for tests.
#pragma once

#include <random>

#include "sdk/avatar/rig.h"
#include "sdk/format/avatar_data.h"
#include "sdk/math/camera.h"

namespace dpl {

/** A bumpy sphere of radius 0.45 to 0.5 m around (0, 1, 0), with two joints and `splatsPerTriangle` splats on each triangle. */
inline AvatarData randomAvatar(uint32_t seed, uint32_t rings = 8, uint32_t splatsPerTriangle = 4, uint32_t shDegree = 2) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> uniform(0, 1);
    std::normal_distribution<float> normal;
    AvatarData a;
    a.name = "random";
    a.joints = {{"root", -1, Vec3f(0, 0.7f, 0), "hips"}, {"upper", 0, Vec3f(0, 1.1f, 0), "spine"}};
    const uint32_t segments = 2 * rings;
    for (uint32_t r = 0; r <= rings; ++r)
        for (uint32_t s = 0; s < segments; ++s) {
            const float theta = 3.14159265f * (float(r) + 0.3f) / (float(rings) + 0.6f), phi = 6.2831853f * float(s) / float(segments);
            const float radius = 0.45f + 0.05f * uniform(random);
            const Vec3f p(radius * std::sin(theta) * std::cos(phi), 1 + radius * std::cos(theta), radius * std::sin(theta) * std::sin(phi));
            a.mesh.restPositions.push_back(p);
            const int upper = int(255 * glm::clamp((p.y - 0.7f) / 0.6f, 0.f, 1.f));
            a.mesh.jointIndices.emplace_back(0, 1, 0, 0);
            a.mesh.jointWeights.emplace_back(255 - upper, upper, 0, 0);
            a.mesh.colours.emplace_back(128, 128, 128, 255);
        }
    for (uint32_t r = 0; r < rings; ++r)
        for (uint32_t s = 0; s < segments; ++s) {
            const uint32_t p00 = r * segments + s, p01 = r * segments + (s + 1) % segments, p10 = p00 + segments, p11 = p01 + segments;
            a.mesh.triangles.push_back({p00, p01, p10});
            a.mesh.triangles.push_back({p01, p11, p10});
        }
    a.mesh.layers = {{"body", "body", 0, uint32_t(a.mesh.restPositions.size()), 0, uint32_t(a.mesh.triangles.size())}};
    SplatData& s = a.splats;
    s.shDegree = shDegree;
    s.triangleStart.push_back(0);
    for (size_t t = 0; t < a.mesh.triangles.size(); ++t) {
        for (uint32_t k = 0; k < splatsPerTriangle; ++k) {
            float u = uniform(random), v = uniform(random);
            if (u + v > 1) u = 1 - u, v = 1 - v;
            s.uv.emplace_back(u, v);
            s.phi.push_back(6.2831853f * uniform(random));
            s.scaleM.push_back(Vec2f(0.03f * std::exp(0.8f * normal(random)), 0.03f * std::exp(0.8f * normal(random))));
            s.opacity.push_back(0.02f + 0.98f * uniform(random));
            s.flags.push_back(uint8_t(random() % 4));
            for (uint32_t c = 0; c < (shDegree + 1) * (shDegree + 1) * 3; ++c) s.sh.push_back((c < 3 ? 0.8f : 0.3f) * normal(random));
        }
        s.triangleStart.push_back(s.count());
    }
    return a;
}

inline Pose randomPose(const AvatarData& avatar, uint32_t seed) {
    std::mt19937 random(seed);
    std::normal_distribution<float> normal;
    Pose pose = Pose::rest(avatar.joints.size());
    for (size_t j = 0; j < pose.localRotations.size(); ++j)
        pose.localRotations[j] =
            glm::angleAxis((j ? 0.8f : 3.f) * normal(random), glm::normalize(Vec3f(normal(random), normal(random), normal(random))));
    pose.rootTranslation = 0.1f * Vec3f(normal(random), normal(random), normal(random));
    return pose;
}

/** A camera at `eye` that looks at `target`, with world +Y up in the image. */
inline Cameraf lookAt(const Vec3f& eye, const Vec3f& target, uint32_t widthPx, uint32_t heightPx, float focalPx) {
    Cameraf c;
    c.widthPx = widthPx, c.heightPx = heightPx, c.fx = c.fy = focalPx, c.cx = float(widthPx) / 2, c.cy = float(heightPx) / 2;
    const Vec3f forward = glm::normalize(target - eye), right = glm::normalize(glm::cross(forward, Vec3f(0, 1, 0)));
    const Vec3f down = glm::cross(forward, right);
    c.viewFromWorldRotation = glm::transpose(Mat3f(right, down, forward));
    c.viewFromWorldTranslation = -(c.viewFromWorldRotation * eye);
    return c;
}

/** `count` general splats, normally distributed around the origin with a standard deviation of 0.4 m. */
inline StaticSplatData randomStaticSplats(uint32_t seed, uint32_t count, uint32_t shDegree = 3, float sizeM = 0.02f) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> uniform(0, 1);
    std::normal_distribution<float> normal;
    StaticSplatData s;
    s.shDegree = shDegree;
    for (uint32_t i = 0; i < count; ++i) {
        s.position.push_back(0.4f * Vec3f(normal(random), normal(random), normal(random)));
        s.rotation.push_back(glm::normalize(Quatf(normal(random), normal(random), normal(random), normal(random))));
        s.scaleM.push_back(sizeM * Vec3f(std::exp(normal(random)), std::exp(normal(random)), std::exp(normal(random))));
        s.opacity.push_back(0.02f + 0.98f * uniform(random));
        for (uint32_t c = 0; c < (shDegree + 1) * (shDegree + 1) * 3; ++c) s.sh.push_back((c < 3 ? 0.8f : 0.2f) * normal(random));
    }
    return s;
}

}  // namespace dpl
