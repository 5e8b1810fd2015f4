// SPDX-License-Identifier: Apache-2.0
// CoOptimiser::checkpoint and restore: every number that the next step reads, in one versioned file.
//
//   "DPLT" | version u32 | fingerprint u64 | payload bytes u64 | payload hash u64 | payload
#include <xxhash.h>

#include <cmath>
#include <cstring>

#include "reconstruction/splat/co_optimise_state.h"
#include "reconstruction/splat/corrective_bytes.h"
#include "sdk/core/arrays.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

constexpr uint32_t kMagic = 0x544C5044, kVersion = 2;

void putAdam(Writer& w, const AdamVector& a) {
    putArray(w, a.first), putArray(w, a.second), w.value(a.steps);
}
Status getAdam(Reader& r, AdamVector& a) {
    DPL_CHECK_OK(getArray(r, a.first));
    DPL_CHECK_OK(getArray(r, a.second));
    DPL_TRY(a.steps, r.u32());
    return {};
}

bool allFinite(const std::vector<float>& v) {
    for (float x : v)
        if (!std::isfinite(x)) return false;
    return true;
}
bool allFinite(const std::vector<Vec4f>& v) {
    for (const Vec4f& x : v)
        if (!std::isfinite(x.x + x.y + x.z + x.w)) return false;
    return true;
}
bool allFinite(const std::vector<Vec3f>& v) {
    for (const Vec3f& x : v)
        if (!std::isfinite(x.x) || !std::isfinite(x.y) || !std::isfinite(x.z)) return false;
    return true;
}

}  // namespace

uint64_t CoOptimiser::State::fingerprint() const {
    // Everything that shapes the run. The settings are hashed field by field: padding bytes have no fixed value.
    Writer w;
    const CoOptimiseSettings& s = settings;
    w.value(s.seed), w.value(s.steps), w.value(s.maxSplats), w.value(s.init.splatCount), w.value(s.init.shDegree);
    putArray(w, s.init.clothLabels), putArray(w, s.init.openLabels), putArray(w, s.levelStarts);
    for (float x : {s.loss.l1,
                    s.loss.ssim,
                    s.loss.mask,
                    s.loss.cloth,
                    s.earlyMaskFactor,
                    s.regularise.scaleHinge,
                    s.regularise.anisotropy,
                    s.regularise.edgeRatio,
                    s.regularise.laplacian,
                    s.regularise.pose,
                    s.regularise.camera,
                    s.closeupGradientScale,
                    s.rateUv,
                    s.endUv,
                    s.ratePhi,
                    s.rateLogScale,
                    s.endLogScale,
                    s.rateOpacity,
                    s.endOpacity,
                    s.rateDc,
                    s.rateRest,
                    s.endColour,
                    s.rateOffsets,
                    s.endOffsets,
                    s.rateRotation,
                    s.rateTranslation,
                    s.endPose,
                    s.rateCamera,
                    s.rateNodeOffset,
                    s.rateNodeLight,
                    s.endNodes,
                    s.nodeDecay,
                    float(s.smoothingLengthM)})
        w.value(x);
    for (bool b : {s.learnSplats, s.learnGeometry, s.learnPoses, s.learnCameras, s.learnCorrectives, s.densify, s.learnPlacement,
                   s.fullResolutionOnly})
        w.value(uint8_t(b));
    w.value(s.geometryEvery), w.value(s.densityEvents);
    putArray(w, templatePositions), putArray(w, input.mesh.triangles), putArray(w, input.triangleLabel);
    putCorrectiveModel(w, input.correctives);
    for (const TrainFrame& f : input.frames) {
        w.value(XXH3_64bits(f.image.pixels.data(), f.image.pixels.size()));
        w.value(XXH3_64bits(f.mask.pixels.data(), f.mask.pixels.size()));
        w.value(XXH3_64bits(f.labels.pixels.data(), f.labels.pixels.size()));
        w.value(f.camera.viewFromWorldRotation), w.value(f.camera.viewFromWorldTranslation);
        w.value(f.camera.fx), w.value(f.camera.fy), w.value(f.camera.cx), w.value(f.camera.cy), w.value(f.kind);
        putArray(w, f.pose.localRotations), w.value(f.pose.rootTranslation);
    }
    const std::vector<uint8_t> bytes = w.finish();
    return XXH3_64bits(bytes.data(), bytes.size());
}

Status CoOptimiser::checkpoint(const std::filesystem::path& path) const {
    const State& s = *state_;
    Writer w;
    w.value(s.step), w.value(s.splats.shDegree);
    putArray(w, s.splats.triangle), putArray(w, s.splats.flags), putArray(w, s.splats.rows), putArray(w, s.splats.sizeFloorM);
    putArray(w, s.adam.first), putArray(w, s.adam.second), putArray(w, s.adam.steps);
    putArray(w, s.statistics.gradientSum), putArray(w, s.statistics.seen);
    putArray(w, s.u), putArray(w, s.adamOffsets.first), putArray(w, s.adamOffsets.second), w.value(s.adamOffsets.steps);
    putArray(w, s.restGradientSum), w.value(s.restGradientCount);
    putArray(w, s.input.correctives.nodes), putArray(w, s.adamNodes.first), putArray(w, s.adamNodes.second), putArray(w, s.adamNodes.steps);
    for (size_t f = 0; f < s.poses.size(); ++f) {
        putArray(w, s.poses[f].localRotations), w.value(s.poses[f].rootTranslation);
        putAdam(w, s.adamPoses[f]), putAdam(w, s.adamCameras[f]);
        w.value(s.cameraTurn[f]), w.value(s.cameraShift[f]);
    }
    putArray(w, s.curve);
    for (double x : {s.sumLoss, s.sumL1, s.sumSsim, s.sumMask, s.sumSquared, s.sumSquaredCount}) w.value(x);
    w.value(s.sumSteps);
    const std::vector<uint8_t> payload = w.finish();
    Writer file;
    file.value(kMagic), file.value(kVersion), file.value(s.fingerprint()), file.value(uint64_t(payload.size()));
    file.value(uint64_t(XXH3_64bits(payload.data(), payload.size())));
    file.append(payload);
    return writeFileAtomically(path, file.finish());
}

Status CoOptimiser::restore(const std::filesystem::path& path) {
    DPL_TRY(const std::vector<uint8_t> bytes, readFile(path));
    State& s = *state_;
    const auto damaged = [&](const char* what) {
        return fail(Code::CorruptData, "checkpoint '{}' is damaged ({}): delete it and train again", path.string(), what);
    };
    Reader r(bytes);
    DPL_TRY(const uint32_t magic, r.u32());
    if (magic != kMagic) return damaged("not a checkpoint");
    DPL_TRY(const uint32_t version, r.u32());
    if (version != kVersion)
        return fail(Code::Version, "checkpoint '{}' has version {}, this build reads {}: delete it and train again", path.string(), version,
                    kVersion);
    DPL_TRY(const uint64_t fingerprint, r.value<uint64_t>());
    if (fingerprint != s.fingerprint())
        return fail(Code::InvalidArgument, "checkpoint '{}' belongs to other input or settings: delete it and train again", path.string());
    DPL_TRY(const uint64_t size, r.value<uint64_t>());
    DPL_TRY(const uint64_t hash, r.value<uint64_t>());
    if (size != r.remaining() || hash != XXH3_64bits(bytes.data() + r.position(), size)) return damaged("wrong length or hash");

    uint32_t step = 0, degree = 0;
    std::vector<uint32_t> triangle;
    TrainableSplats splats;
    std::vector<float> rows;
    AdamRows adam;
    DensityStatistics statistics;
    DPL_TRY(step, r.u32());
    DPL_TRY(degree, r.u32());
    if (degree > kMaxShDegree || step > s.settings.steps) return damaged("step or SH degree");
    DPL_CHECK_OK(getArray(r, triangle));
    splats.resize(uint32_t(triangle.size()), degree);
    splats.triangle = std::move(triangle);
    const size_t n = splats.count(), f = s.mesh.triangles.size();
    DPL_CHECK_OK(getArray(r, splats.flags));
    DPL_CHECK_OK(getArray(r, splats.rows));
    DPL_CHECK_OK(getArray(r, splats.sizeFloorM));
    DPL_CHECK_OK(getArray(r, adam.first));
    DPL_CHECK_OK(getArray(r, adam.second));
    DPL_CHECK_OK(getArray(r, adam.steps));
    DPL_CHECK_OK(getArray(r, statistics.gradientSum));
    DPL_CHECK_OK(getArray(r, statistics.seen));
    adam.stride = splats.stride;
    const size_t values = n * splats.stride;
    if (splats.flags.size() != n || splats.rows.size() != values || splats.sizeFloorM.size() != f || adam.first.size() != values ||
        adam.second.size() != values || adam.steps.size() != n || statistics.gradientSum.size() != n || statistics.seen.size() != n)
        return damaged("array sizes");
    for (size_t i = 0; i < n; ++i)
        if (splats.triangle[i] >= f || (i > 0 && splats.triangle[i] < splats.triangle[i - 1])) return damaged("triangle order");
    std::vector<Vec3f> u, gradientSum;
    AdamUniform adamOffsets;
    uint32_t gradientCount = 0;
    DPL_CHECK_OK(getArray(r, u));
    DPL_CHECK_OK(getArray(r, adamOffsets.first));
    DPL_CHECK_OK(getArray(r, adamOffsets.second));
    DPL_TRY(adamOffsets.steps, r.u32());
    DPL_CHECK_OK(getArray(r, gradientSum));
    DPL_TRY(gradientCount, r.u32());
    if (u.size() != s.u.size() || gradientSum.size() != s.restGradientSum.size() ||
        (adamOffsets.first.size() != u.size() && !adamOffsets.first.empty()) || adamOffsets.second.size() != adamOffsets.first.size())
        return damaged("offset sizes");
    if (!allFinite(splats.rows) || !allFinite(adam.first) || !allFinite(adam.second) || !allFinite(u) || !allFinite(gradientSum))
        return damaged("numbers that are not finite");
    std::vector<Vec4f> nodes;
    AdamRows adamNodes = s.adamNodes;
    DPL_CHECK_OK(getArray(r, nodes));
    DPL_CHECK_OK(getArray(r, adamNodes.first));
    DPL_CHECK_OK(getArray(r, adamNodes.second));
    DPL_CHECK_OK(getArray(r, adamNodes.steps));
    if (nodes.size() != s.input.correctives.nodes.size() || adamNodes.first.size() != s.adamNodes.first.size() ||
        adamNodes.second.size() != s.adamNodes.second.size() || adamNodes.steps.size() != s.adamNodes.steps.size())
        return damaged("pose corrective sizes");
    if (!allFinite(nodes) || !allFinite(adamNodes.first) || !allFinite(adamNodes.second)) return damaged("numbers that are not finite");
    auto poses = s.poses;
    auto adamPoses = s.adamPoses, adamCameras = s.adamCameras;
    auto turn = s.cameraTurn, shift = s.cameraShift;
    for (size_t k = 0; k < poses.size(); ++k) {
        DPL_CHECK_OK(getArray(r, poses[k].localRotations));
        DPL_TRY(poses[k].rootTranslation, r.value<Vec3f>());
        if (auto status = checkPose(s.input.joints, poses[k]); !status) return damaged("a pose");
        DPL_CHECK_OK(getAdam(r, adamPoses[k]));
        DPL_CHECK_OK(getAdam(r, adamCameras[k]));
        DPL_TRY(turn[k], r.value<Vec3d>());
        DPL_TRY(shift[k], r.value<Vec3d>());
    }
    std::vector<CurvePoint> curve;
    DPL_CHECK_OK(getArray(r, curve));
    double sums[6];
    for (double& x : sums) {
        DPL_TRY(x, r.value<double>());
    }
    DPL_TRY(const uint32_t sumSteps, r.u32());

    s.step = step;
    s.splats = std::move(splats);
    s.splats.indexTriangles(f);
    s.splats.activateAll(s.jobs);
    s.adam = std::move(adam), s.statistics = std::move(statistics);
    s.u = std::move(u), s.adamOffsets = std::move(adamOffsets), s.restGradientSum = std::move(gradientSum),
    s.restGradientCount = gradientCount;
    s.input.correctives.nodes = std::move(nodes), s.adamNodes = std::move(adamNodes);
    s.poses = std::move(poses), s.adamPoses = std::move(adamPoses), s.adamCameras = std::move(adamCameras);
    s.cameraTurn = std::move(turn), s.cameraShift = std::move(shift);
    s.curve = std::move(curve);
    s.sumLoss = sums[0], s.sumL1 = sums[1], s.sumSsim = sums[2], s.sumMask = sums[3], s.sumSquared = sums[4], s.sumSquaredCount = sums[5];
    s.sumSteps = sumSteps;
    s.levelIndex = -1, s.orderEpoch = ~0ull;
    s.applyOffsets();
    return {};
}

}  // namespace dpl
