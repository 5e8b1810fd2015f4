// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/avatar_check.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "sdk/format/avatar_file.h"
#include "sdk/format/capture_map.h"
#include "sdk/format/check_mesh.h"
#include "sdk/format/correctives.h"
#include "sdk/format/expressions.h"
#include "sdk/format/light.h"
#include "sdk/math/sh.h"

namespace dpl {
namespace {

bool inside(const Vec3f& p) {  // false for NaN too
    return std::abs(p.x) <= kPositionLimitM && std::abs(p.y) <= kPositionLimitM && std::abs(p.z) <= kPositionLimitM;
}

float snap(float x) {
    return std::nearbyint(x / kPositionStepM) * kPositionStepM + 0.0f;
}  // + 0.0f turns −0 into 0
Vec3f snap(const Vec3f& p) {
    return {snap(p.x), snap(p.y), snap(p.z)};
}

Status checkJoints(const std::vector<JointData>& joints) {
    if (joints.empty()) return fail(Code::InvalidArgument, "an avatar needs at least one joint");
    if (joints.size() > ReadLimits().maxJoints)
        return fail(Code::InvalidArgument, "{} joints, at most {} are possible", joints.size(), ReadLimits().maxJoints);
    std::set<std::string> bones;
    for (size_t j = 0; j < joints.size(); ++j) {
        const bool root = joints[j].parent < 0;
        if (root != (j == 0) || joints[j].parent >= int32_t(j))
            return fail(Code::InvalidArgument, "joint {} ('{}') has parent {}: joint 0 is the only root and parents come first", j,
                        joints[j].name, joints[j].parent);
        if (!inside(joints[j].restPosition))
            return fail(Code::InvalidArgument, "joint {} ('{}') is not finite or more than {} m away", j, joints[j].name, kPositionLimitM);
        if (!joints[j].humanoidBone.empty() && !bones.insert(joints[j].humanoidBone).second)
            return fail(Code::InvalidArgument, "two joints are the humanoid bone '{}'", joints[j].humanoidBone);
    }
    return {};
}

Status checkStoredMesh(const MeshData& mesh, size_t jointCount) {
    const size_t n = mesh.restPositions.size();
    if (mesh.colours.size() != n) return fail(Code::InvalidArgument, "{} vertices with {} colours", n, mesh.colours.size());
    if (n > ReadLimits().maxVertices || mesh.triangles.size() > ReadLimits().maxTriangles)
        return fail(Code::InvalidArgument, "{} vertices and {} triangles are more than readers accept", n, mesh.triangles.size());
    DPL_RETURN_IF_ERROR(checkMesh(mesh, jointCount));
    for (size_t v = 0; v < n; ++v) {
        if (!inside(mesh.restPositions[v]))
            return fail(Code::InvalidArgument, "vertex {} is not finite or more than {} m away; are the units metres?", v, kPositionLimitM);
        uint32_t sum = 0;
        for (int k = 0; k < 4; ++k) {
            sum += mesh.jointWeights[v][k];
            if (mesh.jointWeights[v][k] == 0) continue;
            for (int other = 0; other < k; ++other)
                if (mesh.jointWeights[v][other] && mesh.jointIndices[v][other] == mesh.jointIndices[v][k])
                    return fail(Code::InvalidArgument, "vertex {} names joint {} twice; packWeights merges them", v,
                                mesh.jointIndices[v][k]);
        }
        if (sum != 255)
            return fail(Code::InvalidArgument, "the weights of vertex {} sum to {}, not 255; packWeights rounds them so", v, sum);
    }
    return checkLayers(mesh);
}

Status checkSplats(const SplatData& s, size_t triangleCount) {
    const size_t n = s.uv.size();
    if (n > ReadLimits().maxSplats) return fail(Code::InvalidArgument, "{} splats are more than readers accept", n);
    if (s.shDegree > kMaxShDegree) return fail(Code::InvalidArgument, "SH degree {}, at most {} is possible", s.shDegree, kMaxShDegree);
    if (s.phi.size() != n || s.scaleM.size() != n || s.opacity.size() != n || s.flags.size() != n ||
        s.sh.size() != n * shCoefficientCount(s.shDegree) * 3)
        return fail(Code::InvalidArgument, "the arrays of {} splats differ in length: phi {}, scaleM {}, opacity {}, flags {}, sh {}", n,
                    s.phi.size(), s.scaleM.size(), s.opacity.size(), s.flags.size(), s.sh.size());
    if (s.triangleStart.size() != triangleCount + 1)
        return fail(Code::InvalidArgument, "triangleStart has {} entries for {} triangles, one more is needed", s.triangleStart.size(),
                    triangleCount);
    if (s.triangleStart.front() != 0 || s.triangleStart.back() != n)
        return fail(Code::InvalidArgument, "triangleStart runs from {} to {}, not from 0 to {}", s.triangleStart.front(),
                    s.triangleStart.back(), n);
    for (size_t t = 0; t < triangleCount; ++t)
        if (s.triangleStart[t + 1] < s.triangleStart[t]) return fail(Code::InvalidArgument, "triangleStart falls at triangle {}", t);
    for (size_t i = 0; i < n; ++i) {
        const float all = s.uv[i].x + s.uv[i].y + s.phi[i] + s.scaleM[i].x + s.scaleM[i].y + s.opacity[i];
        if (!std::isfinite(all) || std::abs(s.phi[i]) > 1e4f)
            return fail(Code::InvalidArgument, "splat {} has a number that is not finite", i);
        if (s.scaleM[i].x < 0 || s.scaleM[i].y < 0 || s.scaleM[i].x > 1e3f || s.scaleM[i].y > 1e3f)
            return fail(Code::InvalidArgument, "splat {} is {} × {} m large", i, s.scaleM[i].x, s.scaleM[i].y);
    }
    for (size_t k = 0; k < s.sh.size(); ++k)
        if (!(std::abs(s.sh[k]) <= 1e6f)) return fail(Code::InvalidArgument, "SH value {} is not finite or above 1e6", k);
    return {};
}

Status checkClip(const ClipData& clip, size_t jointCount) {
    const size_t n = clip.timesS.size();
    if (n == 0) return fail(Code::InvalidArgument, "clip '{}' has no times", clip.name);
    if (clip.channels.empty() && clip.rootTranslations.empty()) return fail(Code::InvalidArgument, "clip '{}' moves nothing", clip.name);
    for (size_t i = 0; i < n; ++i)
        if (!std::isfinite(clip.timesS[i]) || clip.timesS[i] < 0 || (i && clip.timesS[i] <= clip.timesS[i - 1]))
            return fail(Code::InvalidArgument, "time {} of clip '{}' is negative or not rising", i, clip.name);
    std::set<uint32_t> seen;
    for (const ClipChannel& channel : clip.channels) {
        if (channel.joint >= jointCount || !seen.insert(channel.joint).second)
            return fail(Code::InvalidArgument, "clip '{}' drives joint {} twice, or it does not exist", clip.name, channel.joint);
        if (channel.rotations.size() != n)
            return fail(Code::InvalidArgument, "clip '{}' has {} times and {} rotations of joint {}", clip.name, n,
                        channel.rotations.size(), channel.joint);
        for (const Quatf& q : channel.rotations)
            if (const float l = glm::length(q); !std::isfinite(l) || l < 1e-6f)
                return fail(Code::InvalidArgument, "clip '{}' has a rotation of joint {} that is zero or not finite", clip.name,
                            channel.joint);
    }
    if (!clip.rootTranslations.empty() && clip.rootTranslations.size() != n)
        return fail(Code::InvalidArgument, "clip '{}' has {} times and {} root translations", clip.name, n, clip.rootTranslations.size());
    for (const Vec3f& t : clip.rootTranslations)
        if (!inside(t)) return fail(Code::InvalidArgument, "clip '{}' moves the root more than {} m away", clip.name, kPositionLimitM);
    return {};
}

}  // namespace

Status checkAvatar(const AvatarData& a) {
    DPL_RETURN_IF_ERROR(checkAvatarWithoutSplats(a));
    return checkSplats(a.splats, a.mesh.triangles.size());
}

Status checkAvatarWithoutSplats(const AvatarData& a) {
    DPL_RETURN_IF_ERROR(checkJoints(a.joints));
    DPL_RETURN_IF_ERROR(checkStoredMesh(a.mesh, a.joints.size()));
    if (Status fits = checkCorrectives(a.correctives, a.joints.size(), a.mesh.restPositions.size()); !fits)
        return fail(Code::InvalidArgument, "{}", fits.error().message);
    if (Status fits = checkExpressions(a.expressions, a.correctives); !fits) return fail(Code::InvalidArgument, "{}", fits.error().message);
    if (Status good = checkLight(a.light); !good) return fail(Code::InvalidArgument, "{}", good.error().message);
    DPL_RETURN_IF_ERROR(checkCaptureMap(a.captureMap, a.joints.size()));
    for (const ClipData& clip : a.clips) DPL_RETURN_IF_ERROR(checkClip(clip, a.joints.size()));
    for (const EvidenceData& e : a.evidence)
        if (!std::isfinite(e.gainDb)) return fail(Code::InvalidArgument, "the evidence for '{}' has a gain that is not finite", e.part);
    if (!(a.kappaPx2 >= 0 && a.kappaPx2 < 1e3f)) return fail(Code::InvalidArgument, "kappa is {} px²", a.kappaPx2);
    if (!(a.trainedPixelM == 0 || (a.trainedPixelM >= 1e-6f && a.trainedPixelM <= 1)))
        return fail(Code::InvalidArgument, "trainedPixelM is {} m; 1e-6 to 1 are possible, or 0 for not known", a.trainedPixelM);
    return {};
}

void snapAvatar(AvatarData& a) {
    for (JointData& j : a.joints) j.restPosition = snap(j.restPosition);
    for (Vec3f& p : a.mesh.restPositions) p = snap(p);
    for (size_t v = 0; v < a.mesh.jointIndices.size(); ++v)
        for (int k = 0; k < 4; ++k)
            if (a.mesh.jointWeights[v][k] == 0) a.mesh.jointIndices[v][k] = 0;
    for (ClipData& clip : a.clips) {
        std::sort(clip.channels.begin(), clip.channels.end(), [](const ClipChannel& x, const ClipChannel& y) { return x.joint < y.joint; });
        for (ClipChannel& channel : clip.channels)
            for (Quatf& q : channel.rotations)  // 1e-6: error of a normalisation in float. Within it, a second pass changes nothing
                if (std::abs(glm::dot(q, q) - 1) > 1e-6f) q = glm::normalize(q);
        for (Vec3f& t : clip.rootTranslations) t = snap(t);
    }
}

}  // namespace dpl
