// SPDX-License-Identifier: Apache-2.0
// Small avatars for the format tests.
#pragma once

#include <cmath>
#include <random>

#include "sdk/format/avatar_data.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/skin_weights.h"
#include "sdk/math/sh.h"

namespace dpl::test {

/** Two joints, one layer of two triangles, three splats of SH degree 0, one clip. The pinned file of version 1 holds it. */
inline AvatarData tinyAvatar() {
    AvatarData a;
    a.name = "tiny", a.generator = "doppel tests";
    a.joints = {{"hips", -1, {0, 1, 0}, "hips"}, {"spine", 0, {0, 1.25f, 0}, "spine"}};
    a.mesh.restPositions = {{0, 1, 0}, {0.5f, 1, 0}, {0.5f, 1.5f, 0}, {0, 1.5f, 0.25f}};
    a.mesh.colours.assign(4, {200, 120, 10, 255});
    a.mesh.jointIndices.assign(4, {0, 1, 0, 0});
    a.mesh.jointWeights = {{255, 0, 0, 0}, {128, 127, 0, 0}, {5, 250, 0, 0}, {1, 254, 0, 0}};
    a.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    a.mesh.layers = {{"body", "body", 0, 4, 0, 2}};
    SplatData& s = a.splats;
    s.triangleStart = {0, 2, 3};
    s.uv = {{0.25f, 0.25f}, {0.5f, 0.25f}, {0.33f, 0.33f}};
    s.phi = {0, 1, 3};
    s.scaleM = {{0.01f, 0.002f}, {0.02f, 0.02f}, {0.004f, 0.003f}};
    s.opacity = {1, 0.5f, 0.25f};
    s.flags = {kSplatSingleFace, kSplatCloth, 0};
    s.sh = {0.1f, 0.2f, 0.3f, -1, 0, 1, 0.5f, 0.25f, -0.125f};
    a.clips = {{"nod", {0, 0.5f}, {{1, {Quatf(1, 0, 0, 0), Quatf(std::sqrt(0.75f), 0.5f, 0, 0)}}}, {{0, 0, 0}, {0, 0.125f, 0}}}};
    a.evidence = {{"sh degree 1", false, 0.02f, 0, "gain below 0.1 dB"}};
    return a;
}

/** The same with pose correctives of two nodes and two modes. The pinned file of version 2 holds it. */
inline AvatarData tinyCorrectedAvatar() {
    AvatarData a = tinyAvatar();
    PoseCorrectiveData& c = a.correctives;
    c.modeCount = 2, c.nodeCount = 2, c.reach = 1.25f;
    c.joints = {1};
    c.mean = {0, 0.125f, 0, -0.25f, 0, 0};
    c.modes = {1, 0, 0, 0, 0, 0, 0, 0, 0.5f, 0, 0, -0.75f};
    c.nodeIndices = {{0, 0, 0, 0}, {0, 1, 0, 0}, {1, 0, 0, 0}, {1, 0, 0, 0}};
    c.nodeWeights = {{255, 0, 0, 0}, {130, 125, 0, 0}, {200, 55, 0, 0}, {255, 0, 0, 0}};
    c.nodes = {{0.02f, 0, 0, -0.5f}, {0, -0.01f, 0, 0.25f}, {-0.010000305f, 0, 0, 0.25000763f}, {0, 0.0025000763f, 0, 0}};
    return a;
}

/** The same with two motion modes of one joint. The pinned file of version 3 holds it. */
inline AvatarData tinyMovingAvatar() {
    AvatarData a = tinyCorrectedAvatar();
    MotionModeData& m = a.correctives.motion;
    m.groups = {{1, 2}, {1, 0.75f}}, m.movedFromRad = 0.125f, m.movedToRad = 0.375f;
    m.joints = {1}, m.still = {{0, 0, 0.6f, 0.8f}}, m.rangeRad = {{0.0625f, 1.5f}}, m.holdsS = {0, 1.5f};
    m.modes = {1, 0, 0, 0, -0.5f, 1.25f, 0, 0};
    a.correctives.nodes = {{0.02f, 0, 0, -0.5f}, {0, -0.01f, 0, 0.25f}, {0, 0, 0.03f, 0}, {0, 0, 0, 0.5f},
                           {0, 0, 0, 0},         {0, 0, 0, 0},          {0, 0, 0, 0},     {0, 0, 0, -0.5f}};
    return a;
}

/** tinyAvatar in light from above and the left. */
inline AvatarData tinyLitAvatar() {
    AvatarData a = tinyAvatar();
    a.light.irradiance = {-0.5f, 0.25f, -0.3f, 0.1f, 0, -0.125f, 0.0625f, 0.01f};
    return a;
}

/** A map with sides of all kinds: fine, coarse, blurred, not seen. */
inline CaptureMapData sampleCaptureMap(size_t joints) {
    CaptureMapData map;
    for (size_t j = 0; j < joints; ++j)
        map.sides.insert(map.sides.end(),
                         {{0.0012f * float(j + 1), 0.0012f * float(j + 1), 14}, {0.004f, 0.0105f, 255}, {}, {0.03f, 0.03f, 0}});
    return map;
}

/** Random but reproducible: three layers of wavy grids with skin weights, splats of all sizes, two clips. */
inline AvatarData layeredAvatar(uint32_t seed, uint32_t shDegree, uint32_t joints = 20, uint32_t cells = 12,
                                uint32_t splatsPerTriangle = 4) {
    std::mt19937 random(seed);
    auto real = [&](double low, double high) { return float(low + (high - low) * (random() / 4294967295.0)); };
    AvatarData a;
    a.name = "random", a.generator = "doppel tests", a.kappaPx2 = 0.3f;
    for (uint32_t j = 0; j < joints; ++j)
        a.joints.push_back({"joint" + std::to_string(j), j == 0 ? -1 : int32_t(random() % j), {real(-1, 1), real(0, 2), real(-1, 1)}, ""});
    a.joints[0].humanoidBone = "hips";
    const char* roles[3] = {"body", "garment", "hair"};
    for (uint32_t l = 0; l < 3; ++l) {
        LayerData layer{std::string("layer") + char('0' + l), roles[l], uint32_t(a.mesh.restPositions.size()), 0,
                        uint32_t(a.mesh.triangles.size()),    0};
        const uint32_t n = cells + l;
        for (uint32_t y = 0; y <= n; ++y)
            for (uint32_t x = 0; x <= n; ++x) {
                a.mesh.restPositions.emplace_back(x * 0.05f + real(-0.01, 0.01), y * 0.07f + real(-0.01, 0.01),
                                                  l * 0.1f + real(-0.02, 0.02));
                a.mesh.colours.emplace_back(random() & 255, random() & 255, random() & 255, 255);
                const std::pair<uint32_t, float> weights[5] = {{random() % joints, real(0, 1)},
                                                               {random() % joints, real(0, 1)},
                                                               {random() % joints, real(0, 1)},
                                                               {random() % joints, real(0, 1)},
                                                               {random() % joints, real(0, 1)}};
                const PackedWeights packed = packWeights(weights);
                a.mesh.jointIndices.push_back(packed.joints), a.mesh.jointWeights.push_back(packed.weights);
            }
        for (uint32_t y = 0; y < n; ++y)
            for (uint32_t x = 0; x < n; ++x) {
                const uint32_t v = layer.firstVertex + y * (n + 1) + x;
                a.mesh.triangles.emplace_back(v, v + 1, v + n + 2);
                a.mesh.triangles.emplace_back(v, v + n + 2, v + n + 1);
            }
        layer.vertexCount = uint32_t(a.mesh.restPositions.size()) - layer.firstVertex,
        layer.triangleCount = uint32_t(a.mesh.triangles.size()) - layer.firstTriangle;
        a.mesh.layers.push_back(layer);
    }
    SplatData& s = a.splats;
    s.shDegree = shDegree;
    s.triangleStart.push_back(0);
    for (size_t t = 0; t < a.mesh.triangles.size(); ++t) {
        const uint32_t count = random() % (2 * splatsPerTriangle + 1);
        for (uint32_t i = 0; i < count; ++i) {
            float u = real(0, 1), v = real(0, 1);
            if (u + v > 1) u = 1 - u, v = 1 - v;
            s.uv.emplace_back(u, v), s.phi.push_back(real(0, 3.14159)),
                s.scaleM.emplace_back(std::exp(real(-8, -4)), std::exp(real(-8, -4)));
            s.opacity.push_back(real(0, 1)), s.flags.push_back(uint8_t(random() & 3));
            for (uint32_t k = 0; k < shCoefficientCount(shDegree) * 3; ++k) s.sh.push_back(k < 3 ? real(-1.7, 1.7) : real(-0.3, 0.3));
        }
        s.triangleStart.push_back(s.count());
    }
    sortSplats(a);
    for (uint32_t c = 0; c < 2; ++c) {
        ClipData clip{"clip" + std::to_string(c), {}, {}, {}};
        for (uint32_t i = 0; i < 5; ++i)
            clip.timesS.push_back(i / 30.0f), clip.rootTranslations.emplace_back(real(-3, 3), real(-1, 1), real(-3, 3));
        for (uint32_t j = 0; j < joints; j += 2) {
            ClipChannel channel{j, {}};
            for (uint32_t i = 0; i < 5; ++i)
                channel.rotations.push_back(glm::normalize(Quatf(real(0.1, 1), real(-1, 1), real(-1, 1), real(-1, 1))));
            clip.channels.push_back(channel);
        }
        a.clips.push_back(clip);
    }
    a.evidence = {{"sh degree " + std::to_string(shDegree), true, 0.5f, 1234, "held-out gain"},
                  {"pose offsets", false, 0, 0, "not measured"}};
    return a;
}

}  // namespace dpl::test
