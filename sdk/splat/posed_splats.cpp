// SPDX-License-Identifier: Apache-2.0
#include "sdk/splat/posed_splats.h"

#include <algorithm>
#include <atomic>

#include "sdk/splat/coded_groups.h"
#include "sdk/splat/write_kernel.h"

namespace dpl {
namespace {

constexpr size_t kWriteBlock = 1024;  // splats of a job
constexpr size_t kWriteAhead = 64;    // splats decoded at a time
static_assert(kWriteBlock % kWriteAhead == 0 && kWriteAhead % kGroupSplats == 0);

WriteConstants constantsOf(const Placement& placement, const std::optional<Vec3f>& eye, uint32_t shDegree, const ShRotator& rotator) {
    WriteConstants c{};
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) c.rotation[3 * row + column] = float(placement.rotation[column][row]);
    const Vec3f to(placement.translation), own = eye ? Vec3f(placement.toOwn(Vec3d(*eye))) : Vec3f(0);
    for (int k = 0; k < 3; ++k) c.translation[k] = to[k], c.eye[k] = own[k];
    c.scale = float(placement.scale), c.hasEye = eye.has_value(), c.shDegree = shDegree;
    float *direction = c.shDirections, *inverse = c.shInverse;
    for (uint32_t band = 1; band <= kMaxShDegree; ++band)
        for (uint32_t i = 0; i < 2 * band + 1; ++i) {
            for (int k = 0; k < 3; ++k) *direction++ = float(rotator.direction(band, i)[k]);
            for (uint32_t k = 0; k < 2 * band + 1; ++k) *inverse++ = float(rotator.inverse(band, i, k));
        }
    return c;
}

}  // namespace

PosedTriangle::PosedTriangle(const TriangleFrame<float>& frame) : frame_(frame) {
    if (!frame.valid) return;
    normal_ = frame.normal;
    t1_ = glm::normalize(frame.v1 - frame.v0);
    t2_ = glm::cross(normal_, t1_);
    f00_ = glm::dot(t1_, frame.f0), f01_ = glm::dot(t1_, frame.f1), f10_ = glm::dot(t2_, frame.f0), f11_ = glm::dot(t2_, frame.f1);
}

SplatEllipse PosedTriangle::ellipse(const Formulas<float>::PlaneAxes& a) const {
    return EllipseFormulas<float>::planeEllipse(a, f00_, f01_, f10_, f11_);
}

GaussianAxes PosedTriangle::axes(const SplatEllipse& e) const {
    const auto a = EllipseFormulas<float>::ellipseAxes(e);
    const float thin = EllipseFormulas<float>::flatThicknessM();
    return {Quatf(glm::quat_cast(Mat3f(t1_, t2_, normal_))) * Quatf(a.halfCosine, 0, 0, a.halfSine),
            Vec3f(a.major > 0 ? Vec2f(a.major, a.minor) : Vec2f(thin), thin)};
}

void PosedTriangle::covariance(const SplatEllipse& e, float* six) const {
    const Vec3f &x = t1_, &y = t2_, &n = normal_;
    const float thin = EllipseFormulas<float>::flatThicknessM();
    for (int i = 0; i < 3; ++i)
        for (int k = i; k < 3; ++k) *six++ = EllipseFormulas<float>::ellipseCovariance(e, thin * thin, x[i], y[i], n[i], x[k], y[k], n[k]);
}

float PosedTriangle::shown(const Vec3f& centre, bool singleFace, const std::optional<Vec3f>& eye) const {
    if (!frame_.valid) return 0;
    if (!singleFace || !eye) return frame_.shown;
    return frame_.shown * Formulas<float>::singleFaceGate(glm::dot(frame_.normal, *eye - frame_.v0), glm::length(*eye - centre));
}

void foldLight(float light, uint32_t shDegree, float* sh) {
    for (uint32_t k = 0; k < 3 * shCoefficientCount(shDegree); ++k)
        sh[k] = k < 3 ? EllipseFormulas<float>::litCoefficient0(sh[k], light) : light * sh[k];
}

uint32_t PosedSplatWriter::choose(const CodedSplats& splats, const SplatDetail& detail) {
    detail_ = detail;
    kept_.clear();
    if (detail.full()) return splats.count();
    keepSplats(splats.chunks, splats.groups, detail, kept_);
    return uint32_t(kept_.size());
}

uint64_t PosedSplatWriter::write(const CodedSplats& splats, std::span<const TriangleFrame<float>> frames, const Placement& placement,
                                 std::span<const SplatColumn> columns, const std::optional<Vec3f>& eye, uint32_t shDegree,
                                 Jobs& jobs) const {
    const size_t count = kept_.empty() ? splats.count() : kept_.size();
    const WriteConstants constants = constantsOf(placement, eye, shDegree, rotator_);
    std::atomic<uint64_t> saturated = 0;
    jobs.forRange(count, kWriteBlock, [&](size_t begin, size_t end, uint32_t) {
        alignas(64) float packed[kWriteAhead / kGroupSplats * kMaxGroupFloats];
        CodedGroups groups(splats, kept_.empty() ? uint32_t(begin) : kept_[begin].splat, detail_.shShare);
        const size_t groupFloats = size_t(groupFields(true, groups.shDegree())) * kGroupSplats;
        uint64_t beyond = 0;
        for (size_t first = begin; first < end; first += kWriteAhead) {
            const size_t last = std::min(first + kWriteAhead, end);
            float* group = packed;
            for (size_t at = first; at < last; at += kGroupSplats, group += groupFloats) {
                if (kept_.empty()) {
                    groups.decode(uint32_t(at), group);
                    continue;
                }
                const size_t lanes = std::min<size_t>(kGroupSplats, last - at);
                ChosenSplat chosen[kGroupSplats];
                for (size_t k = 0; k < lanes; ++k) chosen[k] = {kept_[at + k].splat, kept_[at + k].weight, kept_[at + k].growth};
                groups.decode({chosen, lanes}, group);
            }
            beyond += writeGroups({&constants, packed, uint32_t(last - first), groups.shDegree(), frames.data(), columns, first});
        }
        saturated += beyond;
    });
    return saturated;
}

}  // namespace dpl
