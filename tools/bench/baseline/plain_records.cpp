// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/baseline/plain_records.h"

#include <cmath>

#include "sdk/avatar/pose_correctives.h"
#include "sdk/math/binding.h"
#include "sdk/math/camera.h"
#include "sdk/math/sh.h"

namespace dpl::plain {
namespace {

// The shaders hold a second copy of the footprint constants. These lines check that both copies agree.
static_assert(kGpuMinTriangleAreaM2 == float(kMinTriangleAreaM2) && kGpuMaxTriangleAspect == float(kMaxTriangleAspect));
static_assert(kGpuMaxAlpha == float(kMaxAlpha) && kGpuMinAlpha == float(kMinAlpha) && kGpuMinCompensation == float(kMinCompensation));
static_assert(kGpuNearM == float(kNearM) && kGpuNearFadeEndM == float(kNearFadeEndM) && kGpuGateEnd == float(dpl::kGateEnd));
static_assert(kGateFlag == kSplatSingleFace);
static_assert(kGpuMinLight == kMinLight && kGpuMaxLight == kMaxLight);

Status checkBinding(const char* what, uint64_t count, uint64_t each, const DeviceInfo& device) {
    if (count * each <= device.maxBindingBytes) return {};
    return fail(Code::Unsupported, "{} of the plain frame need {} bytes in one binding, {} allows {}", what, count * each, device.name,
                device.maxBindingBytes);
}

}  // namespace

Status checkFits(const AvatarData& avatar, const DeviceInfo& device) {
    const size_t count = avatar.splats.count(), triangles = avatar.mesh.triangles.size(), vertices = avatar.mesh.restPositions.size();
    if (triangles > kTriangleMask)
        return fail(Code::Unsupported, "avatar {}: {} triangles, the plain frame has room for {}", avatar.name, triangles, kTriangleMask);
    DPL_RETURN_IF_ERROR(checkBinding("SH coefficients", count, shCoefficientCount(avatar.splats.shDegree) * 3 * sizeof(float), device));
    DPL_RETURN_IF_ERROR(checkBinding("projected splats", count, sizeof(ProjectedSplat), device));
    DPL_RETURN_IF_ERROR(checkBinding("posed triangles", triangles, sizeof(TriangleFrame), device));
    return checkBinding("posed vertices", vertices, avatar.correctives.empty() ? sizeof(VertexRecord) : sizeof(CorrectedVertexRecord),
                        device);
}

Status checkFits(const StaticSplatData& splats, const DeviceInfo& device) {
    DPL_RETURN_IF_ERROR(checkBinding("SH coefficients", splats.count(), shCoefficientCount(splats.shDegree) * 3 * sizeof(float), device));
    return checkBinding("splats", splats.count(), sizeof(GeneralSplatRecord), device);
}

Records pack(const AvatarData& avatar) {
    Records out;
    const MeshData& mesh = avatar.mesh;
    const auto pair = [](uint32_t low, uint32_t high) { return low | high << 16; };
    const auto bytes = [](const glm::u8vec4& w) { return uint32_t(w.x) | uint32_t(w.y) << 8 | uint32_t(w.z) << 16 | uint32_t(w.w) << 24; };
    for (size_t i = 0; i < mesh.restPositions.size(); ++i) {
        const Vec3f& p = mesh.restPositions[i];
        const auto& j = mesh.jointIndices[i];
        const auto& w = mesh.jointWeights[i];
        if (avatar.correctives.empty()) {
            out.vertices.push_back({p.x, p.y, p.z, pair(j.x, j.y), pair(j.z, j.w), bytes(w), 0, 0});
        } else {
            const auto& n = avatar.correctives.nodeIndices[i];
            out.correctedVertices.push_back({p.x, p.y, p.z, pair(j.x, j.y), pair(j.z, j.w), bytes(w), pair(n.x, n.y), pair(n.z, n.w),
                                             bytes(avatar.correctives.nodeWeights[i]), 0, 0, 0});
        }
    }
    for (const Triangle& t : mesh.triangles) {
        const auto rest = restTriangle<float>(mesh.restPositions[t.x], mesh.restPositions[t.y], mesh.restPositions[t.z]);
        const auto column = [&](int k, float w) { return vec4{rest.frame[k].x, rest.frame[k].y, rest.frame[k].z, w}; };
        out.triangles.push_back(
            {column(0, rest.inverse.i00), column(1, rest.inverse.i01), column(2, rest.inverse.i11), {t.x, t.y, t.z, rest.valid ? 1u : 0u}});
    }
    const SplatData& s = avatar.splats;
    out.splats.reserve(s.count());
    for (uint32_t t = 0; t + 1 < s.triangleStart.size(); ++t) {
        for (uint32_t i = s.triangleStart[t]; i < s.triangleStart[t + 1]; ++i) {
            const float c = std::cos(s.phi[i]), sine = std::sin(s.phi[i]);
            out.splats.push_back({{s.uv[i].x, s.uv[i].y},
                                  s.scaleM[i].x * c,
                                  s.scaleM[i].x * sine,
                                  s.scaleM[i].y * c,
                                  s.scaleM[i].y * sine,
                                  s.opacity[i],
                                  t | uint32_t(s.flags[i]) << kFlagShift});
        }
    }
    return out;
}

std::vector<GeneralSplatRecord> pack(const StaticSplatData& s) {
    std::vector<GeneralSplatRecord> out;
    out.reserve(s.count());
    for (size_t i = 0; i < s.count(); ++i) {
        const Mat3f turn = glm::mat3_cast(s.rotation[i]);
        const auto axis = [&](int k) {
            return vec4{turn[k].x * s.scaleM[i][k], turn[k].y * s.scaleM[i][k], turn[k].z * s.scaleM[i][k], 0};
        };
        out.push_back({{s.position[i].x, s.position[i].y, s.position[i].z, s.opacity[i]}, axis(0), axis(1), axis(2)});
    }
    return out;
}

size_t paletteRows(const AvatarData& avatar) {
    return avatar.joints.size() * 3 + avatar.correctives.nodeCount;
}

void packPalette(std::span<const Mat3x4f> worldFromRest, std::span<const Vec4f> nodes, std::span<vec4> out) {
    auto row = out.begin();
    for (const Mat3x4f& m : worldFromRest)
        for (int r = 0; r < 3; ++r) *row++ = {m[0][r], m[1][r], m[2][r], m[3][r]};
    for (const Vec4f& n : nodes) *row++ = {n.x, n.y, n.z, n.w};
}

FrameData packFrame(const SplatSet& splats, const Cameraf& c) {
    FrameData f{};
    const Mat3f& r = c.viewFromWorldRotation;
    const Vec3f& t = c.viewFromWorldTranslation;
    const JacobianClamp<float> limit(c);
    const Vec3f eye = c.eye();
    f.views[0] = {{r[0][0], r[1][0], r[2][0], t.x},
                  {r[0][1], r[1][1], r[2][1], t.y},
                  {r[0][2], r[1][2], r[2][2], t.z},
                  {c.fx, c.fy, c.cx, c.cy},
                  {limit.minX, limit.maxX, limit.minY, limit.maxY},
                  {eye.x, eye.y, eye.z, 0}};
    const Vec3f axis = glm::normalize(Vec3f(r[0][2], r[1][2], r[2][2]));
    f.sortAxis = {axis.x, axis.y, axis.z, 0};
    f.target = {float(c.widthPx), float(c.heightPx), splats.kappaPx2, 0};
    f.counts = {splats.count, 1, splats.shDegree, splats.compensated ? 1u : 0u};
    return f;
}

}  // namespace dpl::plain
