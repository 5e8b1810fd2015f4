// Projection: splats in, ProjectedSplat + tile box + depth key out, in blocks of kProjectBlock splats.
#include <algorithm>
#include <bit>
#include <cmath>

#include "sdk/math/sh.h"
#include "sdk/splat/buffers.h"

namespace dpl {
namespace {

struct Target {
    const Cameraf& camera;
    JacobianClamp<float> limit;
    Vec3f eye;
    float kappaPx2;
};

/** Finishes one splat: opacity-aware box, cull, key. p.x.. p.depthM, conic, opacity and variances must be set. */
bool finish(ProjectedSplat& p, float varianceX, float varianceY, SplatEngine::Buffers& buffers, uint32_t splat) {
    const float q = visibleRadius2(p.opacity);
    if (!(q > 0)) return false;
    p.radiusX = std::sqrt(q * varianceX), p.radiusY = std::sqrt(q * varianceY);
    const float w = float(buffers.widthPx), h = float(buffers.heightPx);
    const float x0 = std::ceil(p.x - p.radiusX - 0.5f), x1 = std::floor(p.x + p.radiusX - 0.5f);
    const float y0 = std::ceil(p.y - p.radiusY - 0.5f), y1 = std::floor(p.y + p.radiusY - 0.5f);
    if (!(x1 >= 0 && y1 >= 0 && x0 < w && y0 < h && x0 <= x1 && y0 <= y1)) return false;
    buffers.boxes[splat] = {uint16_t(std::max(x0, 0.f) / kTileSizePx), uint16_t(std::max(y0, 0.f) / kTileSizePx),
                            uint16_t(std::min(x1, w - 1) / kTileSizePx), uint16_t(std::min(y1, h - 1) / kTileSizePx)};
    buffers.rowScale[splat] = 1 / varianceY;
    return true;
}

/** Sizes the buffers and runs body(splat, ProjectedSplat&) -> visible over all splats, compacting keys block by block. */
template <class Body>
void projectAll(Jobs& jobs, SplatEngine::Buffers& buffers, const Cameraf& camera, uint32_t count, Body&& body) {
    const bool drawable = camera.widthPx > 0 && camera.heightPx > 0 && camera.widthPx <= kMaxTargetPx && camera.heightPx <= kMaxTargetPx;
    buffers.widthPx = drawable ? camera.widthPx : 0, buffers.heightPx = drawable ? camera.heightPx : 0;
    if (!drawable) count = 0;
    buffers.splatCount = count;
    ProjectedSplat* projected = buffers.projected.resize(count);
    buffers.boxes.resize(count);
    buffers.rowScale.resize(count);
    uint32_t* keys = buffers.keys[0].resize(count);
    uint32_t* values = buffers.values[0].resize(count);
    buffers.blocks.resize((count + kProjectBlock - 1) / kProjectBlock);
    jobs.forRange(count, kProjectBlock, [&](size_t begin, size_t end, uint32_t) {
        BlockVisible visible;
        for (size_t i = begin; i < end; ++i) {
            ProjectedSplat p{};
            p.splat = uint32_t(i);
            if (body(uint32_t(i), p)) {
                const uint32_t key = std::bit_cast<uint32_t>(p.depthM);
                keys[begin + visible.count] = key, values[begin + visible.count] = uint32_t(i);
                ++visible.count;
                const TileBox box = buffers.boxes[i];
                visible.tileEntries += uint64_t(box.x1 - box.x0 + 1) * uint64_t(box.y1 - box.y0 + 1);
                visible.minKey = std::min(visible.minKey, key), visible.maxKey = std::max(visible.maxKey, key);
            } else {
                p.opacity = 0;
            }
            projected[i] = p;
        }
        buffers.blocks[begin / kProjectBlock] = visible;
    });
}

void setFootprint(ProjectedSplat& p, const Footprint<float>& f) {
    p.x = f.centrePx.x, p.y = f.centrePx.y;
    p.conicA = f.conicA, p.conicB = f.conicB, p.conicC = f.conicC;
    p.depthM = f.depthM, p.compensation = f.compensation;
}

/** NaN coefficients become black. */
void setColour(ProjectedSplat& p, const Vec3f& c) { p.red = c.x > 0 ? c.x : 0, p.green = c.y > 0 ? c.y : 0, p.blue = c.z > 0 ? c.z : 0; }

}  // namespace

void projectBound(Jobs& jobs, SplatEngine::Buffers& buffers, const BoundSplatView& splats,
                  std::span<const TriangleFrame<float>> triangles, const Cameraf& camera, float kappaPx2,
                  bool compensated) {
    const JacobianClamp<float> limit(camera);
    const Vec3f eye = camera.eye();
    const uint32_t shStride = shCoefficientCount(splats.shDegree) * 3;
    projectAll(jobs, buffers, camera, splats.count(), [&](uint32_t i, ProjectedSplat& p) {
        const bool cloth = splats.flags[i] & kSplatCloth;
        p.cloth = cloth ? 1.f : 0.f;
        if (splats.triangle[i] >= triangles.size()) return false;
        const TriangleFrame<float>& t = triangles[splats.triangle[i]];
        if (!t.valid) return false;
        const Vec3f centre = splatCentre(t, splats.uv[i]);
        Vec3f axis1, axis2;
        splatAxes(t, splats.phi[i], splats.scaleM[i].x, splats.scaleM[i].y, axis1, axis2);
        const Mat3f& r = camera.viewFromWorldRotation;
        const Footprint<float> f = projectSplat(camera, limit, camera.toView(centre), r * axis1, r * axis2, kappaPx2);
        if (!f.visible) return false;
        setFootprint(p, f);
        p.fade = nearFade(f.depthM);
        if (splats.flags[i] & kSplatSingleFace) p.fade *= singleFaceGate(t.normal, centre, eye);
        if (!compensated) p.compensation = 1;
        p.opacity = splats.opacity[i] * p.compensation * p.fade;
        if (!finish(p, f.varianceX, f.varianceY, buffers, i)) return false;
        const Vec3f direction = glm::transpose(t.worldFromRest) * glm::normalize(centre - eye);
        setColour(p, shColour(splats.sh.data() + size_t(i) * shStride, splats.shDegree, direction));
        return true;
    });
}

void projectStatic(Jobs& jobs, SplatEngine::Buffers& buffers, const StaticSplatData& splats, const Cameraf& camera, float kappaPx2,
                   bool compensated) {
    const JacobianClamp<float> limit(camera);
    const Vec3f eye = camera.eye();
    const uint32_t shStride = shCoefficientCount(splats.shDegree) * 3;
    projectAll(jobs, buffers, camera, splats.count(), [&](uint32_t i, ProjectedSplat& p) {
        const Vec3f view = camera.toView(splats.position[i]);
        if (!(view.z > float(kNearM))) return false;
        Mat3f axes = camera.viewFromWorldRotation * glm::mat3_cast(splats.rotation[i]);
        for (int k = 0; k < 3; ++k) axes[k] *= splats.scaleM[i][k];
        const float invZ = 1 / view.z, slopeX = view.x * invZ, slopeY = view.y * invZ;
        const float sx = glm::clamp(slopeX, limit.minX, limit.maxX), sy = glm::clamp(slopeY, limit.minY, limit.maxY);
        Vec3f b0, b1;
        for (int k = 0; k < 3; ++k) {
            b0[k] = camera.fx * invZ * (axes[k].x - sx * axes[k].z);
            b1[k] = camera.fy * invZ * (axes[k].y - sy * axes[k].z);
        }
        const Vec3f minors = glm::cross(b0, b1);
        const float detBB = glm::dot(minors, minors), normX = glm::dot(b0, b0), normY = glm::dot(b1, b1), covariance = glm::dot(b0, b1);
        const float det = detBB + kappaPx2 * (normX + normY) + kappaPx2 * kappaPx2;
        if (!(det > 0) || !std::isfinite(det)) return false;
        const float invDet = 1 / det, varianceX = normX + kappaPx2, varianceY = normY + kappaPx2;
        p.x = camera.fx * slopeX + camera.cx, p.y = camera.fy * slopeY + camera.cy;
        p.conicA = varianceY * invDet, p.conicB = -covariance * invDet, p.conicC = varianceX * invDet;
        p.depthM = view.z;
        p.compensation = compensated ? std::max(float(kMinCompensation), std::sqrt(detBB * invDet)) : 1.f;
        p.fade = nearFade(view.z);
        p.opacity = splats.opacity[i] * p.compensation * p.fade;
        if (!finish(p, varianceX, varianceY, buffers, i)) return false;
        setColour(p, shColour(splats.sh.data() + size_t(i) * shStride, splats.shDegree, glm::normalize(splats.position[i] - eye)));
        return true;
    });
}

}  // namespace dpl
