// SPDX-License-Identifier: Apache-2.0
// Tests of pose correctives for every renderer: rest offset, brightness and posed position of each vertex match the referee to 1e-3 of
// their range, for hard avatars and poses. The referee uses the node values as trained, the renderer as a file stores them (16 bits).
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <functional>
#include <random>

#include "apps/reference/reference_renderer.h"
#include "sdk/avatar/rig.h"
#include "sdk/avatar/scene_light.h"
#include "sdk/format/correctives.h"
#include "tests/reference/random_avatar.h"
#include "tests/unit/format/sample_correctives.h"
#include "tests/unit/format/sample_expressions.h"

namespace dpl {

constexpr double kCorrectiveBar = 1e-3;  // required: share of the range
constexpr double kSceneLightBar = 2e-3;  // half a level of white
// Twice what was measured: an error of 7.5e-5 of the range on every renderer, mostly from the 16-bit node values; and 0.3 µm on the GPU
// from float positions a metre from the origin.
constexpr double kCorrectiveShare = 1.5e-4, kPlaceRoundingM = 6e-7;

/** The mesh of randomAvatar on a random tree of `joints` joints; each vertex follows up to four of them. */
inline AvatarData riggedBlob(uint32_t seed, uint32_t joints) {
    AvatarData a = randomAvatar(seed, 12, 1, 0);
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> uniform(-0.4f, 0.4f);
    a.joints.clear();
    for (uint32_t j = 0; j < joints; ++j) {
        JointData joint;
        joint.name = formatText("joint {}", j);
        joint.parent = j ? int32_t(random() % j) : -1;
        joint.restPosition = Vec3f(uniform(random), 1 + uniform(random), uniform(random));
        a.joints.push_back(joint);
    }
    for (size_t v = 0; v < a.mesh.restPositions.size(); ++v) {
        std::vector<std::pair<uint32_t, float>> near;
        for (uint32_t j = 0; j < joints; ++j)
            near.emplace_back(j, 1 / (0.05f + glm::length(a.mesh.restPositions[v] - a.joints[j].restPosition)));
        const PackedWeights packed = packWeights(near);
        a.mesh.jointIndices[v] = packed.joints, a.mesh.jointWeights[v] = packed.weights;
    }
    return a;
}

/** riggedBlob with humanoid bones and two layers, so that it has several components. Splats are millimetres
 * large. overshooting: every third splat has its centre off its triangle. */
inline AvatarData randomPerson(uint32_t seed, bool corrected, bool overshooting) {
    AvatarData a = riggedBlob(seed, 9);
    constexpr const char* kBones[] = {"hips", "spine", "neck", "head", "leftHand", "rightHand", "leftUpperLeg", "rightUpperLeg", ""};
    for (size_t j = 0; j < a.joints.size(); ++j) a.joints[j].humanoidBone = kBones[j];
    const uint32_t triangles = uint32_t(a.mesh.triangles.size()), vertices = uint32_t(a.mesh.restPositions.size());
    a.mesh.layers = {{"body", "body", 0, vertices, 0, triangles * 3 / 4},
                     {"top", "garment", 0, vertices, triangles * 3 / 4, triangles - triangles * 3 / 4}};
    for (Vec2f& scale : a.splats.scaleM) scale *= 0.1f;
    for (size_t i = 0; overshooting && i < a.splats.uv.size(); i += 3) a.splats.uv[i] = i % 2 ? Vec2f(1.05f, -0.05f) : Vec2f(1, 1);
    return corrected ? test::withCorrectives(std::move(a), seed) : a;
}

/** Makes the modes orthogonal, as trained ones are (PoseCorrectiveData): Gram-Schmidt, keeping their lengths. */
inline void separateModes(PoseCorrectiveData& c) {
    const size_t features = 6 * c.joints.size();
    for (uint32_t i = 0; i < c.modeCount; ++i) {
        std::vector<double> row(c.modes.begin() + ptrdiff_t(i * features), c.modes.begin() + ptrdiff_t((i + 1) * features));
        const auto dot = [&](auto&& a, auto&& b) {
            double sum = 0;
            for (size_t f = 0; f < features; ++f) sum += double(a[f]) * double(b[f]);
            return sum;
        };
        const double length2 = dot(row, row);
        for (uint32_t j = 0; j < i; ++j) {
            const std::span<const float> other(&c.modes[j * features], features);
            const double share = dot(row, other) / dot(other, other);
            for (size_t f = 0; f < features; ++f) row[f] -= share * other[f];
        }
        const double scale = std::sqrt(length2 / dot(row, row));
        for (size_t f = 0; f < features; ++f) c.modes[i * features + f] = float(scale * row[f]);
    }
}

/** An avatar, and which limits its poses must reach: coefficients shortened to `reach`, faded off the modes, brightness clamped at both
 * ends. */
struct CorrectiveCase {
    const char* name;
    uint32_t joints;
    test::CorrectiveOptions options;
    bool shortens, fades, clamps;
};

constexpr std::array kCorrectiveCases = {
    CorrectiveCase{"two joints, nothing limits", 2, {.reach = 1e5f}, false, false, false},
    CorrectiveCase{"17 joints, 12 modes, 1,500 nodes",
                   17,
                   {.modes = 12, .nodes = 1500, .light = 0.15f, .reach = 3.25f, .reachOffModes = 1e6f},
                   true,
                   false,
                   false},
    CorrectiveCase{"64 modes", 17, {.modes = 64, .nodes = 300, .light = 0.05f, .reach = 1e5f}, false, false, false},
    CorrectiveCase{"far beyond reach", 17, {.modes = 7, .light = 0.2f, .reach = 0.3f}, true, false, false},
    CorrectiveCase{"off the modes", 17, {.modes = 12, .nodes = 200, .reach = 100, .reachOffModes = 0.25f}, false, true, false},
    CorrectiveCase{"11 modes of 12 numbers: off is a small difference",
                   2,
                   {.modes = 11, .nodes = 60, .light = 0.1f, .reach = 100, .reachOffModes = 0.05f},
                   false,
                   true,
                   false},
    CorrectiveCase{"brightness clamped both ways", 17, {.modes = 5, .light = 4, .reach = 3}, true, false, true},
    CorrectiveCase{"motion modes", 9, {.modes = 4, .nodes = 60, .light = 0.1f, .reach = 1e5f, .motion = 5}, false, false, false},
    CorrectiveCase{"motion modes do not fade", 17, {.modes = 7, .light = 0.1f, .reach = 0.3f, .motion = 3}, true, false, false},
    CorrectiveCase{
        "offsets of a millimetre", 17, {.modes = 12, .nodes = 200, .offsetM = 4e-4f, .light = 1e-3f, .reach = 3.25f}, true, false, false},
};

/** What a long and wild life before a pose leaves. */
inline MotionMemory randomMemory(std::mt19937& random) {
    std::uniform_real_distribution<double> share;
    std::normal_distribution<double> normal;
    MotionMemory memory;
    for (double& held : memory.held) held = 1.5 * share(random);
    for (double& lagged : memory.lagged) lagged = 0.4 * normal(random);
    for (double& earlier : memory.earlier) earlier = share(random);
    return memory;
}

/** Poses with joints turned by 0 to several turns, and quaternions of any length and sign. The last turns every joint by a quarter turn.
 *  Every other pose remembers earlier ones. */
inline std::vector<Pose> correctivePoses(size_t joints, uint32_t seed) {
    std::mt19937 random(seed), life(seed);
    std::normal_distribution<float> normal;
    std::vector<Pose> poses;
    for (const float turnRad : {0.0f, 1e-3f, 0.03f, 0.2f, 0.2f, 0.6f, 0.6f, 1.5f, 1.5f, 3.0f, 10.0f}) {
        Pose pose = Pose::rest(joints);
        for (Quatf& q : pose.localRotations) {
            const Vec3f axis = glm::normalize(Vec3f(normal(random), normal(random), normal(random)));
            q = (random() % 2 ? 1.0f : -1.0f) * std::exp(normal(random)) * glm::angleAxis(turnRad * normal(random), axis);
        }
        pose.rootTranslation = Vec3f(normal(random), normal(random), normal(random));
        if (poses.size() % 2 == 1) pose.before = randomMemory(life);
        poses.push_back(pose);
    }
    poses.push_back(Pose::rest(joints));
    for (Quatf& q : poses.back().localRotations) q = glm::angleAxis(glm::half_pi<float>(), Vec3f(1, 0, 0));
    return poses;
}

/** Vertices of a pose. xyz: position in metres, corrected at rest or (skinned) posed; w: brightness. */
using CorrectedVertices = std::function<std::vector<Vec4f>(const AvatarData& avatar, const Pose& pose, bool skinned)>;

/** Compares every case and pose with the referee. Errors are divided by the range of the avatar: the largest offset and the largest change
 * of brightness over all its poses. */
inline void expectCorrectivesMatch(const char* renderer, const CorrectedVertices& verticesOf) {
    double worstOffset = 0, worstLight = 0, worstPosed = 0;
    uint32_t seed = 40;
    for (const CorrectiveCase& c : kCorrectiveCases) {
        ++seed;
        AvatarData trained = test::withCorrectives(riggedBlob(seed, c.joints), seed, c.options);
        separateModes(trained.correctives);
        AvatarData shipped = trained;
        const auto streams = encodeCorrectives(trained.correctives);
        PoseCorrectiveData head;
        head.joints = trained.correctives.joints, head.modeCount = c.options.modes, head.nodeCount = c.options.nodes;
        head.reach = c.options.reach, head.reachOffModes = c.options.reachOffModes, head.motion = trained.correctives.motion;
        const auto decoded =
            decodeCorrectives({streams.mean, streams.modes, streams.ranges, streams.nodes, streams.nodeIndices, streams.nodeWeights}, head,
                              trained.mesh.restPositions.size());
        ASSERT_TRUE(decoded) << c.name;
        shipped.correctives = *decoded;

        double offsetRange = 0, lightRange = 0, offsetError = 0, lightError = 0, posedError = 0, darkest = 1, brightest = 1;
        bool shortened = false, faded = false;
        for (const Pose& pose : correctivePoses(c.joints, seed)) {
            ASSERT_TRUE(checkPose(shipped.joints, pose)) << c.name;
            const ReferenceCorrection want = referenceCorrection(trained, pose);
            const std::vector<glm::dvec3> wantPosed = referenceSkin(trained, pose);
            const std::vector<Vec4f> rest = verticesOf(shipped, pose, false), posed = verticesOf(shipped, pose, true);
            ASSERT_EQ(rest.size(), wantPosed.size()) << c.name;
            ASSERT_EQ(posed.size(), wantPosed.size()) << c.name;
            for (size_t v = 0; v < rest.size(); ++v) {
                const glm::dvec3 offset = glm::dvec3(rest[v]) - glm::dvec3(trained.mesh.restPositions[v]);
                offsetRange = std::max(offsetRange, glm::length(want.offset[v]));
                lightRange = std::max(lightRange, std::abs(want.light[v] - 1));
                offsetError = std::max(offsetError, glm::length(offset - want.offset[v]));
                lightError = std::max({lightError, std::abs(rest[v].w - want.light[v]), std::abs(posed[v].w - want.light[v])});
                posedError = std::max(posedError, glm::length(glm::dvec3(posed[v]) - wantPosed[v]));
                darkest = std::min(darkest, want.light[v]), brightest = std::max(brightest, want.light[v]);
            }
            PoseCorrectiveData free = trained.correctives;
            free.reachOffModes = 1e6f;
            const auto lengthOf = [&](const PoseCorrectiveData& data) {
                double sum = 0;
                const std::vector<double> all = referenceCoefficients(data, pose).k;
                for (size_t i = 0; i < data.modeCount; ++i) sum += all[i] * all[i];
                return std::sqrt(sum);
            };
            const double whole = lengthOf(free);
            faded |= lengthOf(trained.correctives) < 0.9 * whole;
            shortened |= whole > 0.999 * c.options.reach;
        }
        std::printf("%-9s %-50s offset %.1e of %7.3f mm | brightness %.1e of %.4f | posed %.1e of the offset\n", renderer, c.name,
                    offsetError / offsetRange, offsetRange * 1e3, lightError / lightRange, lightRange, posedError / offsetRange);
        EXPECT_GT(offsetRange, 1e-5) << c.name;
        EXPECT_GT(lightRange, 1e-4) << c.name;
        EXPECT_EQ(shortened, c.shortens) << c.name;
        EXPECT_EQ(faded, c.fades) << c.name;
        EXPECT_EQ(darkest == 0.2 && brightest == 3.0, c.clamps) << c.name << ": " << darkest << " to " << brightest;
        EXPECT_LE(offsetError, kCorrectiveBar * offsetRange) << c.name;
        EXPECT_LE(lightError, kCorrectiveBar * lightRange) << c.name;
        EXPECT_LE(offsetError, kCorrectiveShare * offsetRange + kPlaceRoundingM) << c.name;
        EXPECT_LE(lightError, kCorrectiveShare * lightRange) << c.name;
        worstOffset = std::max(worstOffset, offsetError / offsetRange), worstLight = std::max(worstLight, lightError / lightRange);
        worstPosed = std::max(worstPosed, posedError);
    }
    EXPECT_LT(worstPosed, 5e-6) << "metres; roots stand some metres from the origin; measured 1.8e-6";
    std::printf("%-9s largest error of the offsets %.1e of their range, of the brightness %.1e; of posed places %.1e m\n", renderer,
                worstOffset, worstLight, worstPosed);
}

/** Expressions for every renderer: with pose correctives and without, each vertex at rest and posed is the referee's. */
inline void expectExpressionsMatch(const char* renderer, const CorrectedVertices& verticesOf) {
    for (const bool corrected : {true, false}) {
        AvatarData avatar = riggedBlob(50, 9);
        if (corrected) avatar = test::withCorrectives(std::move(avatar), 50, {.modes = 4, .nodes = 60, .light = 0.1f, .reach = 2});
        avatar = test::withExpressions(std::move(avatar), 51, 7);
        std::mt19937 random(52);
        double worst = 0, worstPosed = 0, moved = 0;
        for (Pose pose : correctivePoses(9, 53)) {
            const ReferenceCorrection plain = referenceCorrection(avatar, pose);
            pose.expression = test::randomWeights(random);
            const ReferenceCorrection want = referenceCorrection(avatar, pose);
            const std::vector<glm::dvec3> wantPosed = referenceSkin(avatar, pose);
            const std::vector<Vec4f> rest = verticesOf(avatar, pose, false), posed = verticesOf(avatar, pose, true);
            ASSERT_EQ(rest.size(), wantPosed.size());
            for (size_t v = 0; v < rest.size(); ++v) {
                const glm::dvec3 offset = glm::dvec3(rest[v]) - glm::dvec3(avatar.mesh.restPositions[v]);
                worst = std::max(worst, glm::length(offset - want.offset[v]));
                worstPosed = std::max(worstPosed, glm::length(glm::dvec3(posed[v]) - wantPosed[v]));
                moved = std::max(moved, glm::length(want.offset[v] - plain.offset[v]));
                EXPECT_EQ(want.light[v], plain.light[v]) << "brightness knows nothing of expressions";
            }
        }
        std::printf("%-9s expressions%s move by up to %.1f mm: error %.1e m at rest, %.1e m posed\n", renderer,
                    corrected ? " beside correctives" : " alone", 1e3 * moved, worst, worstPosed);
        EXPECT_GT(moved, 0.01);
        EXPECT_LT(worst, kPlaceRoundingM) << "metres; measured 6.3e-8 on the CPU, 3.0e-7 on lavapipe";
        EXPECT_LT(worstPosed, 5e-6) << "as of pose correctives";
    }
}

/** Light of the scene for every renderer: the brightness of each vertex matches the referee's, correctives included, where irradiance is
 *  within its bounds, at them, and where the brightness is clamped. */
inline void expectSceneLightMatches(const char* renderer, const CorrectedVertices& verticesOf) {
    double worst = 0, lowest = 10, highest = 0;
    uint32_t atBounds = 0, clamped = 0;
    for (uint32_t seed = 70; seed < 74; ++seed) {
        AvatarData avatar = test::withCorrectives(riggedBlob(seed, 9), seed);
        std::mt19937 random(seed);
        std::normal_distribution<float> normal(0, seed == 73 ? 2.0f : 0.35f);
        for (float& c : avatar.light.irradiance) c = std::clamp(normal(random), -4.0f, 4.0f);
        for (const Vec3f& n : restVertexNormals(avatar.mesh)) {
            const double e = referenceIrradiance(avatar.light, glm::normalize(glm::dvec3(n)));
            atBounds += e == 0.3 || e == 3.0;
        }
        for (const Pose& pose : correctivePoses(9, seed)) {
            const ReferenceScene want = sceneOf(avatar, pose);
            const std::vector<Vec4f> have = verticesOf(avatar, pose, true);
            ASSERT_EQ(have.size(), want.light.size());
            for (size_t v = 0; v < have.size(); ++v) {
                worst = std::max(worst, std::abs(double(have[v].w) - want.light[v]));
                lowest = std::min(lowest, want.light[v]), highest = std::max(highest, want.light[v]);
                clamped += want.light[v] == 0.2 || want.light[v] == 3.0;
            }
        }
    }
    std::printf("%-9s light of the scene: largest error %.1e, brightness from %.2f to %.2f\n", renderer, worst, lowest, highest);
    EXPECT_GT(atBounds, 0u);
    EXPECT_GT(clamped, 0u);
    EXPECT_LT(lowest, 0.6);
    EXPECT_GT(highest, 1.5);
    EXPECT_LT(worst, kSceneLightBar);
}

}  // namespace dpl
