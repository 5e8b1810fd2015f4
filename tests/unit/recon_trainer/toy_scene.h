// SPDX-License-Identifier: Apache-2.0
// A small skinned ball with a pattern, seen by a ring of cameras. The splat engine draws its pictures from known splats.
#pragma once

#include <atomic>
#include <cmath>

#include "reconstruction/training/trainer/co_optimise.h"
#include "sdk/avatar/posed_mesh.h"
#include "tests/unit/ball_mesh.h"

namespace dpl::test {

inline std::vector<JointData> twoJoints() {
    std::vector<JointData> joints(2);
    joints[0].name = "root", joints[1].name = "top", joints[1].parent = 0;
    joints[1].restPosition = {0, 0, 0};
    return joints;
}

/** Correctives with one mode, the upper joint's bend about X, and two nodes, at the ball's top and bottom. Node values are zero. */
inline PoseCorrectiveData toyCorrectives(const MeshData& mesh) {
    PoseCorrectiveData c;
    c.modeCount = 1, c.nodeCount = 2, c.joints = {1}, c.reach = 2;
    c.mean.assign(6, 0.0f);
    c.modes = {0, 0, 0, 0, 0, 2};  // 2·sin(bend)
    c.nodeIndices.assign(mesh.restPositions.size(), {0, 1, 0, 0});
    for (const Vec3f& p : mesh.restPositions) {
        const int top = int(255 * std::clamp(0.5f + 2.5f * p.y, 0.0f, 1.0f));
        c.nodeWeights.push_back({uint8_t(top), uint8_t(255 - top), 0, 0});
    }
    c.nodes.assign(2, Vec4f(0));
    return c;
}

/** The same frames with one label at every pixel. */
inline std::vector<TrainFrame> labelled(std::vector<TrainFrame> frames, uint8_t label) {
    for (TrainFrame& frame : frames) {
        FramePicture picture = **frame.picture.get();
        picture.labels.widthPx = picture.mask.widthPx, picture.labels.heightPx = picture.mask.heightPx;
        picture.labels.pixels.assign(picture.mask.pixels.size(), label);
        frame.picture = std::make_shared<const FramePicture>(std::move(picture));
    }
    return frames;
}

/** swayM (metres) and turn (radians): distance of each frame's true pose from the frame's stated pose. correctives: those of the truth; if
 *  given, every frame is a moving one with its own bend. */
inline CoOptimiseInput toyScene(Jobs& jobs, uint32_t frameCount = 8, float swayM = 0, float turn = 0, uint32_t sizePx = 72,
                                const PoseCorrectiveData& correctives = {}, bool held = false) {
    CoOptimiseInput in;
    in.joints = twoJoints();
    in.mesh = ballMesh();
    const TriangleSight sight{std::vector<float>(in.mesh.triangles.size(), 0.0f), std::vector<uint8_t>(in.mesh.triangles.size(), 1)};
    InitSettings init;
    init.splatCount = 3000, init.shDegree = 0;
    const auto flags = triangleFlags(in.mesh.restPositions, in.mesh.triangles, {}, {}, init);
    TrainableSplats splats = *initialSplats({in.joints, in.mesh, {}, {}}, flags, sight, init, 1, jobs);
    for (uint32_t i = 0; i < splats.count(); ++i) {
        const Triangle& t = in.mesh.triangles[splats.triangle[i]];
        const Vec3f p = (1 - splats.uv[i].x - splats.uv[i].y) * in.mesh.restPositions[t.x] + splats.uv[i].x * in.mesh.restPositions[t.y] +
                        splats.uv[i].y * in.mesh.restPositions[t.z];
        float* row = splats.rows.data() + i * splats.stride;
        const Vec3f colour(0.5f + 0.4f * std::sin(30 * p.x), 0.5f + 0.4f * std::cos(26 * p.y), p.z > 0 ? 0.8f : 0.2f);
        for (int c = 0; c < 3; ++c) row[kRowSh + uint32_t(c)] = (colour[c] - 0.5f) / float(kShC0);
        row[kRowOpacityLogit] = 3;
    }
    splats.activateAll(jobs);
    const auto rest = restTriangles(in.mesh);
    SplatEngine engine(jobs);
    SplatImage image;
    for (uint32_t k = 0; k < frameCount; ++k) {
        TrainFrame f;
        f.name = "toy_" + std::to_string(k);
        f.kind = k % 4 == 3 ? FrameKind::Dynamic : k % 4 == 2 ? FrameKind::StaticCloseup : FrameKind::StaticFull;
        const double a = 6.283185307 * k / frameCount, distance = f.kind == FrameKind::StaticCloseup ? 0.6 : 0.9;
        f.camera.widthPx = f.camera.heightPx = sizePx;
        f.camera.fx = f.camera.fy = 1.3 * sizePx, f.camera.cx = f.camera.cy = 0.5 * sizePx;
        // The eye is at distance·(sin a, 0, cos a) and looks at the origin. The view's y axis points down.
        f.camera.viewFromWorldRotation = Mat3d(std::cos(a), 0, -std::sin(a), 0, -1, 0, -std::sin(a), 0, -std::cos(a));
        f.camera.viewFromWorldTranslation = {0, 0, distance};
        f.pose = Pose::rest(2);
        if (!correctives.empty() && held) {
            f.kind = FrameKind::Dynamic;
            f.pose.before.held[0] = k % 2;
        } else if (!correctives.empty()) {
            f.kind = FrameKind::Dynamic;
            f.pose.localRotations[1] = glm::angleAxis(0.5f * std::sin(2.1f * float(k)), Vec3f(1, 0, 0));
        }
        Pose truth = f.pose;
        truth.rootTranslation = swayM * Vec3f(std::sin(3.0f * k), std::cos(5.0f * k), std::sin(7.0f * k));
        const Vec3f axis = glm::normalize(Vec3f(std::cos(2.0f * k), std::sin(3.0f * k), 0.5f));
        truth.localRotations[1] = glm::angleAxis(turn, axis) * truth.localRotations[1];
        PosedMesh posed;
        posed.pose({in.joints, in.mesh, correctives, rest}, truth, jobs);
        engine.project(splats.view(), posed.frames(), f.camera.cast<float>(), kTrainedKappaPx2);
        engine.bin();
        engine.blend(image);
        FramePicture picture{{sizePx, sizePx, {}}, {sizePx, sizePx, {}}, {}};
        for (size_t i = 0; i < image.alpha.size(); ++i) {
            picture.mask.pixels.push_back(image.alpha[i] >= 0.5f ? 255 : 0);
            for (size_t c = 0; c < 3; ++c)
                picture.image.pixels.push_back(
                    uint8_t(std::clamp(255 * (image.rgb[i * 3 + c] + (1 - image.alpha[i]) * 0.3f) + 0.5f, 0.0f, 255.0f)));
        }
        f.picture = std::make_shared<const FramePicture>(std::move(picture));
        in.frames.push_back(std::move(f));
    }
    return in;
}

/** Counts pictures that are decoded each time somebody asks for them. */
struct PictureCounts {
    std::atomic<int> decoded{0}, alive{0}, mostAlive{0};
};

/** The same frames, with pictures that nobody keeps. `counts` must outlive them. */
inline std::vector<TrainFrame> decodedOnDemand(std::vector<TrainFrame> frames, PictureCounts& counts) {
    for (TrainFrame& frame : frames)
        frame.picture = LazyPicture([kept = *frame.picture.get(), &counts]() -> Result<std::shared_ptr<const FramePicture>> {
            ++counts.decoded;
            const int alive = ++counts.alive;
            for (int most = counts.mostAlive; most < alive && !counts.mostAlive.compare_exchange_weak(most, alive);) {
            }
            return std::shared_ptr<const FramePicture>(new FramePicture(*kept), [&counts](const FramePicture* picture) {
                --counts.alive;
                delete picture;
            });
        });
    return frames;
}

inline CoOptimiseSettings toySettings(uint32_t steps) {
    CoOptimiseSettings s;
    s.steps = steps, s.seed = 42;
    s.init.splatCount = 1500, s.init.shDegree = 1;
    s.maxSplats = 2200, s.densityEvents = 4;
    s.levelStarts = {0.0f, 0.3f};
    return s;
}

}  // namespace dpl::test
