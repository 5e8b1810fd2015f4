// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/avatar_upload.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>

#include <glm/gtc/packing.hpp>

#include "sdk/avatar/pose_correctives.h"
#include "sdk/avatar/scene_light.h"
#include "sdk/core/task.h"
#include "sdk/draw/check_subject.h"
#include "sdk/math/binding.h"
#include "sdk/math/detail.h"
#include "sdk/math/sh.h"

namespace dpl {
namespace {

// shaders/shared/limits.h repeats these constants of other folders.
static_assert(gpu::kUvZeroCode == float(kUvZero) && gpu::kUvCodeSteps == float(kUvSteps) && kPhiSteps == 1024 && kScaleCodes == 2047 &&
              gpu::kGatedBit == kSingleFaceBit && kColourCodes[0] == 1023);
static_assert(sizeof(SplatChunk) == gpu::kChunkWords * 4 && offsetof(SplatChunk, scaleMinM) == gpu::kChunkScaleMin * 4 &&
              offsetof(SplatChunk, scaleMaxM) == gpu::kChunkScaleMax * 4 && offsetof(SplatChunk, dcMin) == gpu::kChunkDcMin * 4 &&
              offsetof(SplatChunk, dcMax) == gpu::kChunkDcMax * 4 && offsetof(SplatChunk, shRange) == gpu::kChunkShRange * 4 &&
              offsetof(SplatChunk, firstParent) == gpu::kChunkFirstParent * 4);
static_assert(kSplatChunkSize == 2 * gpu::kSplatGroup);
static_assert(gpu::kSplatGroup == kSplatGroupSize && sizeof(SplatGroup) == 12);
static_assert(gpu::kGpuMinLight == kMinLight && gpu::kGpuMaxLight == kMaxLight);

constexpr size_t kLightRows = 2;

/** The inverse of fromOctahedron() (sdk/math/formulas/light.inl), as snorm16 x 2. */
uint32_t packedNormal(const Vec3f& n) {
    const float sum = std::abs(n.x) + std::abs(n.y) + std::abs(n.z);
    Vec2f e(n.x / sum, n.y / sum);
    if (n.z < 0) e = (1.0f - glm::abs(Vec2f(e.y, e.x))) * Vec2f(e.x < 0 ? -1 : 1, e.y < 0 ? -1 : 1);
    return glm::packSnorm2x16(e);
}

Status checkBinding(const char* what, uint64_t count, uint64_t each, const DeviceInfo& device, const char* remedy) {
    if (count * each <= device.maxBindingBytes) return {};
    return fail(Code::Unsupported, "{} need {} bytes in one binding, {} allows {}; {}", what, count * each, device.name,
                device.maxBindingBytes, remedy);
}

/** The chunks' tables of parents. Each entry also says which kinds of splats its chunk has on the triangle. */
std::vector<uint32_t> parentTable(const CodedSplats& s) {
    std::vector<uint32_t> table = s.parents;
    for (const SplatChunk& c : s.chunks)
        for (uint32_t i = c.firstSplat; i < c.firstSplat + c.splatCount; ++i)
            table[c.firstParent + s.parent[i]] |= s.size[i] & gpu::kGatedBit ? gpu::kParentGated : gpu::kParentFree;
    return table;
}

template <class T>
uint32_t appendWords(std::vector<uint32_t>& words, const std::vector<T>& values) {
    const size_t first = words.size();
    words.resize(first + (values.size() * sizeof(T) + 3) / 4, 0);
    if (!values.empty()) std::memcpy(words.data() + first, values.data(), values.size() * sizeof(T));
    return uint32_t(first);
}

}  // namespace

Status checkAvatar(const AvatarData& avatar, const CodedSplats& splats, const DeviceInfo& device) {
    DPL_RETURN_IF_ERROR(checkAvatarPosable(avatar));
    const size_t vertices = avatar.mesh.restPositions.size(), triangles = avatar.mesh.triangles.size();
    const uint64_t detail = splats.groups.empty() ? 2 * splats.chunks.size() * sizeof(SplatGroup) : 0;  // of measureGroups
    DPL_RETURN_IF_ERROR(
        checkBinding("splats", splats.bytes() + detail + 32, 1, device, "export the avatar with a lower SH degree or fewer splats"));
    if (2 * splats.chunks.size() > device.maxGroups)
        return fail(Code::Unsupported, "avatar {}: {} chunks of splats, {} draws at most {}; pack the avatar again", avatar.name,
                    splats.chunks.size(), device.name, device.maxGroups / 2);
    if (triangles > gpu::kParentMask)
        return fail(Code::Unsupported, "avatar {}: {} triangles, at most {}; decimate the mesh", avatar.name, triangles, gpu::kParentMask);
    DPL_RETURN_IF_ERROR(checkBinding("projected splats", splats.count(), sizeof(gpu::ProjectedSplat) * gpu::kMaxViews, device,
                                     "export the avatar with fewer splats"));
    DPL_RETURN_IF_ERROR(checkBinding("posed triangles", triangles, sizeof(gpu::TriangleFrame), device, "decimate the mesh"));
    return checkBinding("posed vertices", vertices,
                        avatar.correctives.empty() ? sizeof(gpu::VertexRecord) : sizeof(gpu::CorrectedVertexRecord), device,
                        "decimate the mesh");
}

Status checkSplats(const StaticSplatData& s, const DeviceInfo& device) {
    DPL_RETURN_IF_ERROR(checkGeneralSplats(s));
    const size_t count = s.count(), coefficients = shCoefficientCount(s.shDegree) * 3;
    if ((count + gpu::kSplatGroup - 1) / gpu::kSplatGroup > device.maxGroups)
        return fail(Code::Unsupported, "{} splats, {} draws at most {}; export fewer splats", count, device.name,
                    uint64_t(device.maxGroups) * gpu::kSplatGroup);
    DPL_RETURN_IF_ERROR(checkBinding("SH coefficients", count, (coefficients + 7) / 8 * sizeof(gpu::uvec4), device,
                                     "export the splats with a lower SH degree, or fewer of them"));
    return checkBinding("projected splats", count, sizeof(gpu::ProjectedSplat) * gpu::kMaxViews, device, "export fewer splats");
}

bool reachFar(const StaticSplatData& s) {
    constexpr float kFarM = 8;
    if (s.position.empty()) return false;
    Vec3f low = s.position[0], high = low;
    for (const Vec3f& p : s.position) low = glm::min(low, p), high = glm::max(high, p);
    return !(glm::length(high - low) <= kFarM);
}

std::vector<gpu::uvec4> packSplats(const StaticSplatData& s, std::span<const uint32_t> order, std::span<const GeneralGroup> groups) {
    std::vector<gpu::uvec4> out(order.size() * gpu::kGeneralSplatFours + groups.size() * gpu::kGroupBoxFours);
    gpu::uvec4* next = out.data();
    const auto append = [&]<class Record>(const Record& record) {
        std::memcpy(next, &record, sizeof record);
        next += sizeof record / sizeof *next;
    };
    for (size_t k = 0; k < order.size(); ++k) {
        if (k % kLook == 0 && !taskAt(double(k) / double(order.size()))) break;
        const uint32_t i = order[k];
        const Mat3f turn = glm::mat3_cast(s.rotation[i]);
        const Vec3f &centre = s.position[i], &scaleM = s.scaleM[i];
        const Vec3f axis1 = turn[0] * scaleM.x, axis2 = turn[1] * scaleM.y, axis3 = turn[2] * scaleM.z;
        append(gpu::GeneralSplatRecord{.centreX = centre.x,
                                       .centreY = centre.y,
                                       .centreZ = centre.z,
                                       .opacity = s.opacity[i],
                                       .axis1X = axis1.x,
                                       .axis1Y = axis1.y,
                                       .axis1Z = axis1.z,
                                       .axis2X = axis2.x,
                                       .axis2Y = axis2.y,
                                       .axis2Z = axis2.z,
                                       .axis3X = axis3.x,
                                       .axis3Y = axis3.y,
                                       .axis3Z = axis3.z});
    }
    for (const GeneralGroup& g : groups) {
        append(gpu::GroupBox{.middleX = g.middle.x,
                             .middleY = g.middle.y,
                             .middleZ = g.middle.z,
                             .reachX = g.reach.x,
                             .reachY = g.reach.y,
                             .reachZ = g.reach.z,
                             .areaM2 = g.detail.areaM2,
                             .gain = g.detail.gain,
                             .enough = g.detail.enough});
    }
    return out;
}

std::vector<gpu::uvec4> packSh(const StaticSplatData& s, std::span<const uint32_t> order) {
    const size_t floats = shCoefficientCount(s.shDegree) * 3, stride = (floats + 7) / 8;
    std::vector<gpu::uvec4> out(s.count() * stride);
    const auto half = [](float x) { return uint32_t(glm::packHalf1x16(std::clamp(x, -65504.0f, 65504.0f))); };
    for (size_t i = 0; i < order.size(); ++i) {
        if (i % kLook == 0 && !taskAt(double(i) / double(order.size()))) break;
        uint32_t words[24] = {};
        for (size_t k = 0; k < floats; ++k) words[k / 2] |= half(s.sh[order[i] * floats + k]) << (k % 2 * 16);
        std::memcpy(&out[i * stride], words, stride * sizeof(gpu::uvec4));
    }
    return out;
}

AvatarRecords packAvatar(const AvatarData& avatar, const CodedSplats& splats) {
    AvatarRecords out;
    const ComponentMap components = componentsOf(avatar);
    const std::vector<TriangleReach> reach = reachOfTriangles(splats, avatar.mesh.triangles.size());
    out.components = Components(avatar, components, reach);
    const MeshData& mesh = avatar.mesh;
    std::vector<uint32_t> normals(mesh.restPositions.size(), 0);
    if (!avatar.light.empty()) {
        const std::vector<Vec3f> atRest = restVertexNormals(mesh);
        std::transform(atRest.begin(), atRest.end(), normals.begin(), packedNormal);
    }
    const auto pair = [](uint32_t low, uint32_t high) { return low | high << 16; };
    const auto bytes = [](const glm::u8vec4& w) { return uint32_t(w.x) | uint32_t(w.y) << 8 | uint32_t(w.z) << 16 | uint32_t(w.w) << 24; };
    for (size_t i = 0; i < mesh.restPositions.size(); ++i) {
        const Vec3f& p = mesh.restPositions[i];
        const auto& w = mesh.jointWeights[i];
        glm::u16vec4 j = mesh.jointIndices[i];
        for (int k = 0; k < 4; ++k)
            if (w[k] == 0) j[k] = 0;  // the kernel reads all four joints, and one of weight 0 may have any index
        if (avatar.correctives.empty()) {
            out.vertices.push_back({p.x, p.y, p.z, pair(j.x, j.y), pair(j.z, j.w), bytes(w), components.ofVertex[i], normals[i]});
        } else {
            const auto& n = avatar.correctives.nodeIndices[i];
            out.correctedVertices.push_back({p.x, p.y, p.z, pair(j.x, j.y), pair(j.z, j.w), bytes(w), pair(n.x, n.y), pair(n.z, n.w),
                                             bytes(avatar.correctives.nodeWeights[i]), components.ofVertex[i], normals[i], 0});
        }
    }
    constexpr float kAnywhere = 1e15f;  // never out of view; its products stay finite
    for (size_t i = 0; i < mesh.triangles.size(); ++i) {
        const Triangle& t = mesh.triangles[i];
        const TriangleReach& r = reach[i];
        const auto rest = restTriangle<float>(mesh.restPositions[t.x], mesh.restPositions[t.y], mesh.restPositions[t.z]);
        const Vec3f &t1 = rest.frame[0], &t2 = rest.frame[1], &normal = rest.frame[2];
        out.triangles.push_back({.restT1X = t1.x,
                                 .restT1Y = t1.y,
                                 .restT1Z = t1.z,
                                 .inverse00 = rest.inverse.i00,
                                 .restT2X = t2.x,
                                 .restT2Y = t2.y,
                                 .restT2Z = t2.z,
                                 .inverse01 = rest.inverse.i01,
                                 .restNormalX = normal.x,
                                 .restNormalY = normal.y,
                                 .restNormalZ = normal.z,
                                 .inverse11 = rest.inverse.i11,
                                 .corner0 = t.x,
                                 .corner1 = t.y,
                                 .corner2 = t.z,
                                 .component = rest.valid ? 1u + components.ofTriangle[i] : 0u,
                                 .reach = r.overshoots ? kAnywhere : r.reachM,
                                 .rootLevel = r.rootLevel,
                                 .freeSplats = r.freeSplats,
                                 .gatedSplats = r.gatedSplats});
    }
    out.codes.reserve(size_t(splats.bytes()) / 4 + 3);
    appendWords(out.codes, splats.chunks);
    out.where.firstParent = appendWords(out.codes, parentTable(splats));
    out.where.firstPlace = appendWords(out.codes, splats.place);
    out.where.firstSize = appendWords(out.codes, splats.size);
    out.where.firstColour = appendWords(out.codes, splats.colour);
    out.where.firstParentByte = appendWords(out.codes, splats.parent);
    out.where.firstGroupDetail = appendWords(out.codes, splats.groups);
    if (!splats.shIndex.empty()) out.where.firstShIndex = appendWords(out.codes, splats.shIndex);
    out.where.firstSh = appendWords(out.codes, splats.sh);
    out.where.shWords = shEntryBytes(splats.shDegree) / 4;
    return out;
}

size_t paletteSize(const AvatarData& avatar) {
    return avatar.joints.size() * 3 + avatar.correctives.nodeCount + (avatar.light.empty() ? 0 : kLightRows);
}

uint32_t firstLightRow(const AvatarData& avatar) {
    return avatar.light.empty() ? 0 : uint32_t(paletteSize(avatar) - kLightRows);
}

void packPalette(std::span<const Mat3x4f> worldFromRest, std::span<const Vec4f> nodes, const LightData& light, std::span<gpu::vec4> out) {
    auto row = out.begin();
    for (const Mat3x4f& m : worldFromRest)
        for (int r = 0; r < 3; ++r) *row++ = {m[0][r], m[1][r], m[2][r], m[3][r]};
    for (const Vec4f& n : nodes) *row++ = {n.x, n.y, n.z, n.w};
    if (light.empty()) return;
    const auto& c = light.irradiance;
    *row++ = {c[0], c[1], c[2], c[3]}, *row++ = {c[4], c[5], c[6], c[7]};
}

SplatSet splatSetOf(const AvatarData& avatar, const CodedSplats& splats) {
    return {splats.count(), splats.shDegree, avatar.kappaPx2, avatar.compensated};
}
SplatSet splatSetOf(const StaticSplatData& splats) {
    return {splats.count(), splats.shDegree, splats.kappaPx2, splats.compensated};
}

gpu::FrameData packFrame(const SplatSet& splats, std::span<const Cameraf> views, uint32_t samples, const SplatDetail& detail,
                         float largestGrowth, uint32_t unseen, const Placement& placement) {
    gpu::FrameData f{};
    const SubjectViews seenBy(placement, views);
    Vec3d axis(0), first(0, 0, 1);
    for (size_t v = 0; v < views.size(); ++v) {
        const Cameraf& c = seenBy.cameras()[v];
        const Mat3f r = seenBy[v].viewFromSubject();
        const Vec3f t = seenBy.scale() * c.viewFromWorldTranslation;
        const JacobianClamp<float> limit(c);
        const Vec3f eye = c.eye();
        f.views[v] = {.viewFromWorldRow0 = {r[0][0], r[1][0], r[2][0], t.x},
                      .viewFromWorldRow1 = {r[0][1], r[1][1], r[2][1], t.y},
                      .viewFromWorldRow2 = {r[0][2], r[1][2], r[2][2], t.z},
                      .focalPx = {c.fx, c.fy},
                      .centrePx = {c.cx, c.cy},
                      .minSlopeX = limit.minX,
                      .maxSlopeX = limit.maxX,
                      .minSlopeY = limit.minY,
                      .maxSlopeY = limit.maxY,
                      .eyeX = eye.x,
                      .eyeY = eye.y,
                      .eyeZ = eye.z};
        const Mat3f& world = views[v].viewFromWorldRotation;
        const Vec3d forward(world[0][2], world[1][2], world[2][2]);
        axis += forward;
        if (v == 0) first = forward;
    }
    if (glm::length(axis) < 1e-6) axis = first;  // views in opposite directions have no mean axis
    axis = glm::normalize(axis);
    // Keys begin at the hindmost eye, since nothing behind it is visible. Rounded down to 1/1024 m, so that one eye and a pair of eyes
    // get the same keys.
    double nearest = std::numeric_limits<double>::infinity();
    for (const Cameraf& c : views) nearest = std::min(nearest, glm::dot(axis, Vec3d(c.eye())));
    // Subjects are sorted together, so their depths are those of the world.
    const Vec3d ownAxis = placement.scale * placement.directionToOwn(axis);
    f.sortAxisX = float(ownAxis.x), f.sortAxisY = float(ownAxis.y), f.sortAxisZ = float(ownAxis.z);
    f.sortOffsetM = float(glm::dot(axis, placement.translation));
    f.sortStartM = float(std::floor(nearest * 1024) / 1024);
    f.targetPx = {float(views[0].widthPx), float(views[0].heightPx)};
    f.kappaPx2 = splats.kappaPx2 / float(samples);
    f.compensated = splats.compensated ? 1 : 0;
    f.unseenComponents = unseen;
    f.splatCount = splats.count;
    f.splatsPerM2 = detail.full() ? 0.0f : detail.perM2;
    f.largestGrowth = seenBy.scale() * (detail.full() ? 1.0f : largestGrowth);
    f.shShare = detail.shShare;
    return f;
}

void packGeneralDetail(const GeneralDetail& detail, gpu::FrameData& f) {
    f.splatsPerPixel = detail.full() ? 0.0f : detail.perPixel;
    f.finestPixelM = detail.finestM;
    for (int v = 0; v < 2; ++v)
        f.pixelPlanes[v] = {detail.planes[v].axis.x, detail.planes[v].axis.y, detail.planes[v].axis.z, detail.planes[v].offsetM};
}

}  // namespace dpl
