// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/gpu/self_test.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/training/trainer/frame_pass.h"
#include "reconstruction/training/trainer/random.h"

namespace dpl {
namespace {

constexpr uint32_t kSizePx = 40, kSplats = 300, kSeed = 7;
constexpr float kAllowed = 1e-2f;  // of the largest gradient; sound devices stay below 1e-4 (docs/reference/gpu-training.md)

/** Splats of every kind on two triangles: enough to fill more than one round of the fullest tile, and to touch its neighbours. */
struct SmallScene {
    std::vector<JointData> joints{1};
    MeshData mesh;
    TrainableSplats splats;
    LevelFrame level;

    SmallScene() {
        mesh.restPositions = {{-0.1f, -0.1f, 0}, {0.1f, -0.1f, 0.01f}, {-0.1f, 0.1f, 0.02f}, {0.1f, 0.1f, 0}};
        mesh.triangles = {{0, 1, 2}, {1, 3, 2}};
        mesh.jointIndices.assign(4, {0, 0, 0, 0}), mesh.jointWeights.assign(4, {255, 0, 0, 0});
        splats.resize(kSplats, 1);
        const auto random = [](uint64_t i, uint64_t k) { return float(hashUniform(kSeed, i, k)); };
        for (uint32_t i = 0; i < kSplats; ++i) {
            splats.triangle[i] = i * 2 / kSplats;
            splats.flags[i] = uint8_t((i % 3 == 0 ? kSplatSingleFace : 0) | (i % 2 ? kSplatCloth : 0));
            float* row = splats.rows.data() + size_t(i) * splats.stride;
            row[kRowU] = 0.6f * random(i, 0), row[kRowV] = 0.4f * random(i, 1), row[kRowPhi] = 3 * random(i, 2);
            row[kRowLogScale1] = std::log(0.005f + 0.05f * random(i, 3)), row[kRowLogScale2] = std::log(0.003f + 0.02f * random(i, 4));
            row[kRowOpacityLogit] = -3 + 2 * random(i, 5);
            for (uint32_t k = 0; k < shCoefficientCount(1) * 3; ++k) row[kRowSh + k] = random(i, 6 + k) - 0.5f;
        }
        splats.sizeFloorM.assign(2, 0.001f);
        splats.indexTriangles(2);
        splats.activate(0, kSplats);
        level.used = true, level.widthPx = level.heightPx = kSizePx, level.kappaPx2 = kTrainedKappaPx2;
        level.camera.widthPx = level.camera.heightPx = kSizePx;
        level.camera.fx = level.camera.fy = 2 * kSizePx, level.camera.cx = level.camera.cy = 0.5f * kSizePx;
        level.camera.viewFromWorldRotation = Mat3f(1, 0, 0, 0, -1, 0, 0, 0, -1);
        level.camera.viewFromWorldTranslation = {0, 0, 0.5f};
        const size_t pixels = size_t(kSizePx) * kSizePx;
        level.mask.assign(pixels, 200), level.cloth.assign(pixels, 90);
        for (size_t i = 0; i < 3 * pixels; ++i) level.rgb.push_back(uint8_t(i * 37 % 200));
    }
};

/** Whether the numbers of `here` are those of `there`, but for rounding. */
bool agree(std::span<const float> here, std::span<const float> there) {
    float largest = 0, worst = 0;
    for (size_t i = 0; i < here.size(); ++i) {
        largest = std::max(largest, std::abs(here[i]));
        worst = std::isfinite(there[i]) ? std::max(worst, std::abs(here[i] - there[i])) : INFINITY;
    }
    return worst <= kAllowed * largest;
}

}  // namespace

Status testEngine(GpuEngine& engine) {
    const SmallScene s;
    Jobs jobs(1);
    const std::vector<RestTriangle<float>> bind = restTriangles(s.mesh);
    const VertexIncidence incidence(s.mesh.triangles, s.mesh.restPositions.size());
    const PoseCorrectiveData correctives;
    const LightData light;
    const PassSubject subject{s.splats, s.mesh, correctives, s.joints, {bind}, incidence, light, {}};
    const LossWeights weights{0.8f, 0.2f, 0.3f, 0.1f};
    const Vec3f background(0.3f, 0.6f, 0.2f);
    FramePass pass(jobs);
    const LossValues loss = pass.run(subject, Pose::rest(1), s.level, weights, background, true);

    AdamRows adam;
    DensityStatistics statistics;
    adam.resize(kSplats, s.splats.stride), statistics.resize(kSplats);
    const std::vector<uint8_t> learns(2, 1);
    const std::vector<float> referenceSizeM(2, 0.1f);
    DPL_RETURN_IF_ERROR(engine.upload({s.splats, adam, statistics, learns, referenceSizeM, incidence, s.mesh.triangles, bind}));
    DPL_TRY(const LossValues theirs,
            engine.step({pass.posed().positions(), {}, s.level.camera, s.level.kappaPx2, s.level.target(), {}, weights, background}));
    DPL_TRY(const GpuGradients g, engine.gradients());
    std::vector<float> rows(pass.splatBackward().rowGradients().begin(), pass.splatBackward().rowGradients().end()),
        rowsThere(g.rows.begin(), g.rows.end());
    for (uint32_t i = 0; i < kSplats; ++i)
        for (uint32_t k = 0; k < s.splats.stride; ++k) {
            if (!pass.splatBackward().active()[i]) rows[i * s.splats.stride + k] = 0;
            if (g.screenLength[i] < 0) rowsThere[i * s.splats.stride + k] = 0;
        }
    if (!(std::abs(theirs.total - loss.total) <= 1e-3 * loss.total) || !agree(rows, rowsThere))
        return fail(Code::Unsupported,
                    "{} computes gradients that differ from those of the CPU, so it cannot train; a newer driver may help", engine.name());
    return {};
}

}  // namespace dpl
