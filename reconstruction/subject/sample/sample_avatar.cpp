// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/sample/sample_avatar.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtx/component_wise.hpp>

#include "reconstruction/subject/face/face_shapes.h"
#include "reconstruction/subject/sample/raycast.h"
#include "reconstruction/subject/sample/skeleton.h"
#include "sdk/format/avatar_file.h"
#include "sdk/math/sh.h"

namespace dpl {
namespace {

constexpr float kSpacingM = 0.0052f;     // between splats where triangles are large
constexpr float kSpacingOfEdge = 0.45f;  // and where they are small: of their mean edge
constexpr float kFinestM = 0.0016f;      // on the face
constexpr float kDetailM = 0.0018f;      // between splats at the edges of prints and stripes
constexpr float kPlainContrast = 0.08f;  // of a place without such edges
constexpr float kSigmaOfCell = 2.2f;     // neighbours overlap: light comes through in few places, and prints stay sharp
constexpr float kOpacity = 0.99f;
constexpr uint32_t kLightSamples = 24, kContrastLightSamples = 4;
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
    std::vector<float> phi;
    std::vector<Vec2f> scaleM;
    std::vector<Vec3f> colour;
};

/** A part of a triangle, in metres along T1 and T2 from the triangle's first corner. */
struct Cell {
    std::array<Vec2f, 3> corners;

    Vec2f centre() const { return (corners[0] + corners[1] + corners[2]) / 3.0f; }
    /** Side of a square of the same area. */
    float sizeM() const {
        const Vec2f d1 = corners[1] - corners[0], d2 = corners[2] - corners[0];
        return std::sqrt(0.5f * std::abs(d1.x * d2.y - d1.y * d2.x));
    }
};

/** Cuts a cell into `count` of the same area, each time across the longest edge. */
void cut(const Cell& cell, uint32_t count, std::vector<Cell>& cells) {
    if (count == 1) {
        cells.push_back(cell);
        return;
    }
    const auto edge = [&](size_t i) { return glm::length(cell.corners[(i + 1) % 3] - cell.corners[i]); };
    size_t longest = 0;
    for (size_t i = 1; i < 3; ++i)
        if (edge(i) > edge(longest)) longest = i;
    const Vec2f a = cell.corners[longest], b = cell.corners[(longest + 1) % 3], c = cell.corners[(longest + 2) % 3];
    const uint32_t first = count / 2;
    const Vec2f between = glm::mix(a, b, float(first) / float(count));
    cut({{a, between, c}}, first, cells);
    cut({{between, b, c}}, count - first, cells);
}

/** Adds the splat that stands for a cell: with the cell's covariance, enlarged. */
void addSplat(const Cell& cell, const Vec2f& uv, const Vec3f& colour, Patch& patch) {
    float xx = 0, xy = 0, yy = 0;
    for (const Vec2f& corner : cell.corners) {
        const Vec2f d = corner - cell.centre();
        xx += d.x * d.x / 12, xy += d.x * d.y / 12, yy += d.y * d.y / 12;
    }
    const float middle = 0.5f * (xx + yy), apart = std::hypot(0.5f * (xx - yy), xy), angle = 0.5f * std::atan2(2 * xy, xx - yy);
    patch.uv.push_back(uv);
    patch.phi.push_back(angle < 0 ? angle + 3.14159265f : angle);
    patch.scaleM.push_back(kSigmaOfCell * Vec2f(std::sqrt(middle + apart), std::sqrt(std::max(middle - apart, 0.0f))));
    patch.colour.push_back(colour);
}

Patch paint(const Subject& subject, const PersonTracer& tracer, uint32_t triangle) {
    const Triangle& f = subject.mesh.triangles[triangle];
    const auto& at = subject.mesh.restPositions;
    const Vec3f e1 = at[f.y] - at[f.x], e2 = at[f.z] - at[f.x];
    const float area = 0.5f * glm::length(glm::cross(e1, e2)), base = glm::length(e1);
    if (area <= 0) return {};
    const Vec2f corner2(glm::dot(e2, e1) / base, 2 * area / base);
    const auto uvOf = [&](const Vec2f& p) {
        const float v = std::clamp(p.y / corner2.y, 0.0f, 1.0f);
        return Vec2f(std::clamp((p.x - v * corner2.x) / base, 0.0f, 1 - v), v);
    };
    const auto colourAt = [&](const Vec2f& p, float footprintM, uint32_t lightSamples) {
        const Vec2f uv = uvOf(p);
        return tracer.colourAt(triangle, uv.x, uv.y, footprintM, lightSamples);
    };
    const auto isPlain = [&](const Cell& cell) {
        Vec3f low(1), high(0);
        for (const Vec2f& corner : cell.corners) {
            const auto colour = colourAt(corner, 0.5f * cell.sizeM(), kContrastLightSamples);
            if (!colour) return true;
            low = glm::min(low, *colour), high = glm::max(high, *colour);
        }
        return glm::compMax(high - low) < kPlainContrast;
    };

    const float edge = (base + glm::length(e2 - e1) + glm::length(e2)) / 3;
    const float spacing = std::clamp(kSpacingOfEdge * edge, kFinestM, kSpacingM);
    std::vector<Cell> cells;
    cut({{Vec2f(0), Vec2f(base, 0), corner2}}, std::max(1u, uint32_t(area / (spacing * spacing) + 0.5f)), cells);
    Patch patch;
    while (!cells.empty()) {
        const Cell cell = cells.back();
        cells.pop_back();
        if (cell.sizeM() > std::sqrt(2.0f) * kDetailM && !isPlain(cell)) {
            cut(cell, 2, cells);
            continue;
        }
        const auto colour = colourAt(cell.centre(), cell.sizeM(), kLightSamples);
        if (!colour) return {};
        addSplat(cell, uvOf(cell.centre()), *colour, patch);
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

std::vector<ExpressionShape> subjectFace(const Subject& subject) {
    const LayerData& body = subject.mesh.layers.front();
    std::vector<ExpressionShape> shapes = faceShapes(builtinFace(), std::span(subject.canonical).first(body.vertexCount));
    for (ExpressionShape& shape : shapes) shape.offsetsM.resize(subject.canonical.size(), Vec3f(0));
    return shapes;
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
                splats.phi.push_back(patch.phi[i]);
                splats.scaleM.push_back(patch.scaleM[i]);
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
    [[maybe_unused]] const auto added = addExpressions(avatar, subjectFace(subject));  // shapes of its own mesh, on few nodes: cannot fail
    return avatar;
}

Result<std::vector<uint8_t>> makeSampleAvatarFile(const Subject& subject, Jobs& jobs) {
    return writeAvatar(makeSampleAvatar(subject, jobs), {.compact = true});
}

}  // namespace dpl
