// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/sample/sample_avatar.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/subject/sample/raycast.h"
#include "reconstruction/subject/sample/skeleton.h"
#include "sdk/format/avatar_file.h"
#include "sdk/math/sh.h"

namespace dpl {
namespace {

constexpr float kSpacingM = 0.0042f;      // between splats where triangles are large
constexpr float kSpacingOfEdge = 0.45f;   // and where they are small: of their mean edge
constexpr float kFinestM = 0.0016f;       // on the face
constexpr float kSigmaOfSpacing = 0.62f;  // neighbours overlap without gaps
constexpr float kOpacity = 0.97f;
constexpr uint32_t kLightSamples = 24;
constexpr double kFramesPerSecond = 30;
constexpr double kMovesS = 18.75, kWalkS = 1.1;

/** A clip of `count` keys at 30 Hz; joints that never turn have no channel. */
template <class PoseAt>
ClipData keyed(std::string name, size_t count, double stepS, const PoseAt& poseAt) {
    ClipData clip;
    clip.name = std::move(name);
    clip.channels.resize(kBuiltinJointCount);
    for (uint32_t j = 0; j < kBuiltinJointCount; ++j) clip.channels[j].joint = j;
    for (size_t i = 0; i < count; ++i) {
        const Pose pose = poseOf(poseAt(double(i) * stepS));
        clip.timesS.push_back(float(double(i) * stepS));
        clip.rootTranslations.push_back(pose.rootTranslation);
        for (uint32_t j = 0; j < kBuiltinJointCount; ++j) clip.channels[j].rotations.push_back(pose.localRotations[j]);
    }
    std::erase_if(clip.channels, [](const ClipChannel& channel) {
        return std::all_of(channel.rotations.begin(), channel.rotations.end(), [](const Quatf& q) { return q.w > 1 - 1e-9f; });
    });
    return clip;
}

/** The splats of one triangle. */
struct Patch {
    std::vector<Vec2f> uv;
    std::vector<Vec3f> colour;
    float sigmaM = 0;
};

Patch paint(const Subject& subject, const PersonTracer& tracer, uint32_t triangle) {
    const Triangle& f = subject.mesh.triangles[triangle];
    const auto& at = subject.mesh.restPositions;
    const float area = 0.5f * glm::length(glm::cross(at[f.y] - at[f.x], at[f.z] - at[f.x]));
    if (area <= 0) return {};
    const float edge = (glm::length(at[f.y] - at[f.x]) + glm::length(at[f.z] - at[f.y]) + glm::length(at[f.x] - at[f.z])) / 3;
    const float spacing = std::clamp(kSpacingOfEdge * edge, kFinestM, kSpacingM);
    const uint32_t count = std::max(1u, uint32_t(area / (spacing * spacing) + 0.5f));
    const float reach = std::sqrt(area / float(count));
    Patch patch;
    patch.sigmaM = kSigmaOfSpacing * reach;
    for (uint32_t i = 0; i < count; ++i) {
        // Roberts' sequence spreads points evenly over the unit square; its upper half is folded into the triangle.
        float u = 0.5f + 0.7548777f * float(i), v = 0.5f + 0.5698403f * float(i);
        u -= std::floor(u), v -= std::floor(v);
        if (count == 1) u = v = 1.0f / 3;
        if (u + v > 1) u = 1 - u, v = 1 - v;
        const auto colour = tracer.colourAt(triangle, u, v, reach, kLightSamples);
        if (!colour) return {};
        patch.uv.push_back({u, v});
        patch.colour.push_back(*colour);
    }
    return patch;
}

}  // namespace

ClipData walkOnTheSpot() {
    const auto pose = [](double timeS) {
        TruthPose p{std::vector<Vec3d>(kBuiltinJointCount, Vec3d(0)), Vec3d(0)};
        const double phase = 2 * 3.14159265358979 * timeS / kWalkS;
        for (const double side : {1.0, -1.0}) {  // left, right: half a cycle apart
            const bool left = side > 0;
            const double swing = std::sin(phase + (left ? 0 : 3.14159265358979)), lift = std::cos(phase + (left ? 0 : 3.14159265358979));
            p.rotations[left ? kLeftHip : kRightHip].x = -0.08 - 0.40 * swing;
            p.rotations[left ? kLeftKnee : kRightKnee].x = 0.12 + 0.75 * std::pow(std::max(0.0, lift), 1.5);
            p.rotations[left ? kLeftAnkle : kRightAnkle].x = -0.05 + 0.16 * swing;
            // Arms hang (the rest pose holds them 42° below the horizontal) and swing against the legs.
            p.rotations[left ? kLeftShoulder : kRightShoulder] = {0.32 * swing, 0, -0.62 * side};
            p.rotations[left ? kLeftElbow : kRightElbow] = {0, -0.28 * side, 0};
        }
        p.rotations[kPelvis].y = 0.09 * std::sin(phase);
        p.rotations[kSpine2].y = -0.10 * std::sin(phase);
        p.rotations[kSpine3].y = -0.06 * std::sin(phase);
        p.rotations[kNeck].y = 0.05 * std::sin(phase);
        p.translation.y = 0.015 * std::cos(2 * phase) - 0.025;
        return p;
    };
    const size_t steps = size_t(std::lround(kWalkS * kFramesPerSecond));
    return keyed("walk", steps + 1, kWalkS / double(steps), pose);
}

AvatarData makeSampleAvatar(const Subject& subject, Jobs& jobs) {
    PersonTracer tracer(subject);
    tracer.setVertices({subject.mesh.restPositions.begin(), subject.mesh.restPositions.end()});
    const size_t triangles = subject.mesh.triangles.size();
    std::vector<Patch> patches(triangles);
    jobs.forRange(triangles, 256, [&](size_t begin, size_t end, uint32_t) {
        for (size_t t = begin; t < end; ++t) patches[t] = paint(subject, tracer, uint32_t(t));
    });

    AvatarData avatar;
    avatar.name = subject.name;
    avatar.generator = "doppel sample-avatar";
    avatar.joints = subject.joints;
    avatar.mesh = subject.mesh;
    SplatData& splats = avatar.splats;
    splats.triangleStart.push_back(0);
    for (size_t layer = 0; layer < subject.parts.size(); ++layer) {
        const uint8_t flags = uint8_t(kSplatSingleFace | (subject.parts[layer].cloth ? kSplatCloth : 0));
        const LayerData& range = subject.mesh.layers[layer];
        for (uint32_t t = range.firstTriangle; t < range.firstTriangle + range.triangleCount; ++t) {
            const Patch& patch = patches[t];
            for (size_t i = 0; i < patch.uv.size(); ++i) {
                splats.uv.push_back(patch.uv[i]);
                splats.phi.push_back(0);
                splats.scaleM.push_back(Vec2f(patch.sigmaM));
                splats.opacity.push_back(kOpacity);
                splats.flags.push_back(flags);
                for (int c = 0; c < 3; ++c) splats.sh.push_back((patch.colour[i][c] - 0.5f) / float(kShC0));
            }
            splats.triangleStart.push_back(splats.count());
        }
    }
    const SampleMotion motion = SampleMotion::dynamicSequence(subject.seed, kMovesS);
    const size_t keys = size_t(std::lround(kMovesS * kFramesPerSecond)) + 1;
    avatar.clips = {walkOnTheSpot(), keyed("moves", keys, 1 / kFramesPerSecond, [&](double timeS) { return motion.pose(timeS); })};
    sortSplats(avatar);
    return avatar;
}

Result<std::vector<uint8_t>> makeSampleAvatarFile(const Subject& subject, Jobs& jobs) {
    return writeAvatar(makeSampleAvatar(subject, jobs), {.compact = true});
}

}  // namespace dpl
