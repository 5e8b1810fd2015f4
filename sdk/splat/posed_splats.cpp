// SPDX-License-Identifier: Apache-2.0
#include "sdk/splat/posed_splats.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>

#include "sdk/splat/coded_groups.h"

namespace dpl {
namespace {

constexpr size_t kWriteBlock = 1024;  // splats of a job
static_assert(kWriteBlock % kGroupSplats == 0);

/** The frame of a triangle in the world. */
TriangleFrame<float> placed(TriangleFrame<float> f, const Placement& placement) {
    const Mat3f turn(placement.rotation);
    const float scale = float(placement.scale);
    for (Vec3f* corner : {&f.v0, &f.v1, &f.v2}) *corner = Vec3f(placement.toWorld(Vec3d(*corner)));
    f.f0 = scale * (turn * f.f0), f.f1 = scale * (turn * f.f1);
    f.normal = turn * f.normal, f.worldFromRest = turn * f.worldFromRest;
    return f;
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
    const float x1 = a.a10 * f00_ + a.a11 * f01_, y1 = a.a10 * f10_ + a.a11 * f11_;
    const float x2 = a.a20 * f00_ + a.a21 * f01_, y2 = a.a20 * f10_ + a.a21 * f11_;
    return {x1 * x1 + x2 * x2, x1 * y1 + x2 * y2, y1 * y1 + y2 * y2, (f00_ * f11_ - f01_ * f10_) * (a.a10 * a.a21 - a.a11 * a.a20)};
}

GaussianAxes PosedTriangle::axes(const SplatEllipse& e) const {
    // The larger eigenvalue is a sum; the smaller one follows from the determinant, so that needles do not cancel.
    const float mean = 0.5f * (e.xx + e.yy), half = 0.5f * (e.xx - e.yy), radius = std::sqrt(half * half + e.xy * e.xy);
    const float major = std::sqrt(mean + radius);
    GaussianAxes out{Quatf(glm::quat_cast(Mat3f(t1_, t2_, normal_))), Vec3f(kFlatThicknessM)};
    if (!(major > 0)) return out;
    out.scaleM = {major, std::abs(e.det) / major, kFlatThicknessM};
    if (!(radius > 0)) return out;
    // From the cosine and sine of 2θ those of θ, which lies within ±90°, and of θ/2, without a difference of near numbers.
    const float cosine2 = half / radius, sine2 = e.xy / radius;
    float cosine, sine;
    if (cosine2 >= 0) {
        cosine = std::sqrt(0.5f * (1 + cosine2)), sine = 0.5f * sine2 / cosine;
    } else {
        const float s = std::sqrt(0.5f * (1 - cosine2));
        cosine = 0.5f * std::abs(sine2) / s, sine = std::copysign(s, sine2);
    }
    const float halfCosine = std::sqrt(0.5f * (1 + cosine));
    out.rotation = out.rotation * Quatf(halfCosine, 0, 0, 0.5f * sine / halfCosine);
    return out;
}

void PosedTriangle::covariance(const SplatEllipse& e, float* six) const {
    const Vec3f &x = t1_, &y = t2_, &n = normal_;
    constexpr float kAcross = kFlatThicknessM * kFlatThicknessM;
    for (int i = 0; i < 3; ++i)
        for (int k = i; k < 3; ++k)
            *six++ = e.xx * x[i] * x[k] + e.xy * (x[i] * y[k] + y[i] * x[k]) + e.yy * y[i] * y[k] + kAcross * n[i] * n[k];
}

float PosedTriangle::shown(const Vec3f& centre, bool singleFace, const std::optional<Vec3f>& eye) const {
    if (!frame_.valid) return 0;
    if (!singleFace || !eye) return frame_.shown;
    return frame_.shown * Formulas<float>::singleFaceGate(glm::dot(frame_.normal, *eye - frame_.v0), glm::length(*eye - centre));
}

void foldLight(float light, uint32_t shDegree, float* sh) {
    for (uint32_t k = 0; k < 3 * shCoefficientCount(shDegree); ++k)
        sh[k] = light * sh[k] + (k < 3 ? (light - 1) * 0.5f / float(kShC0) : 0.0f);
}

uint32_t PosedSplatWriter::choose(const CodedSplats& splats, const SplatDetail& detail) {
    detail_ = detail;
    kept_.clear();
    if (detail.full()) return splats.count();
    for (size_t g = 0; g < splats.groups.size(); ++g) {
        const SplatChunk& c = splats.chunks[g / 2];
        const uint32_t first = uint32_t(g % 2) * kSplatGroupSize, count = std::min(first + kSplatGroupSize, c.splatCount);
        const float share = keptShare(detail.perM2, splats.groups[g].areaM2),
                    growth = detailGrowth(share, splats.groups[g].gain, splats.groups[g].enough);
        float weight[kSplatGroupSize] = {};
        for (uint32_t rank = 0, drawn = drawnRanks(share); rank < drawn; ++rank) weight[placeOfRank(rank)] = detailWeight(share, rank);
        for (uint32_t i = first; i < count; ++i)
            if (weight[i - first] > 0) kept_.push_back({c.firstSplat + i, weight[i - first], growth});
    }
    return uint32_t(kept_.size());
}

uint64_t PosedSplatWriter::write(const CodedSplats& splats, std::span<const TriangleFrame<float>> frames, const Placement& placement,
                                 std::span<const SplatColumn> columns, const std::optional<Vec3f>& eye, uint32_t shDegree,
                                 Jobs& jobs) const {
    using namespace bound_field;
    const size_t count = kept_.empty() ? splats.count() : kept_.size();
    const bool own = placement == Placement();
    std::atomic<uint64_t> saturated = 0;
    jobs.forRange(count, kWriteBlock, [&](size_t begin, size_t end, uint32_t) {
        alignas(64) float packed[kMaxGroupFloats];
        CodedGroups groups(splats, kept_.empty() ? uint32_t(begin) : kept_[begin].splat, detail_.shShare);
        const uint32_t ownDegree = groups.shDegree(), ownFloats = 3 * shCoefficientCount(ownDegree);
        TriangleFrame<float> moved;
        uint64_t beyond = 0;
        for (size_t first = begin; first < end; first += kGroupSplats) {
            const size_t lanes = std::min<size_t>(kGroupSplats, end - first);
            if (kept_.empty()) {
                groups.decode(uint32_t(first), packed);
            } else {
                ChosenSplat chosen[kGroupSplats];
                for (size_t k = 0; k < lanes; ++k) chosen[k] = {kept_[first + k].splat, kept_[first + k].weight, kept_[first + k].growth};
                groups.decode({chosen, lanes}, packed);
            }
            for (size_t lane = 0; lane < lanes; ++lane) {
                const auto field = [&](uint32_t f) { return packed[f * kGroupSplats + lane]; };
                const TriangleFrame<float>& frame = frames[std::bit_cast<uint32_t>(field(kTriangle))];
                if (!own) moved = placed(frame, placement);
                const PosedTriangle triangle(own ? frame : moved);
                const Vec2f uv(field(kU), field(kV));
                const Vec3f centre = triangle.centre(uv);
                const SplatEllipse ellipse = triangle.ellipse({field(kAxis10), field(kAxis11), field(kAxis20), field(kAxis21)});
                float sh[3 * kMaxShCoefficients];
                for (uint32_t k = 0; k < ownFloats; ++k) sh[k] = field(kSh + k);
                std::optional<GaussianAxes> axes;
                for (const SplatColumn& column : columns) {
                    float numbers[3 * kMaxShCoefficients];
                    switch (column.what) {
                        case SplatNumbers::Position:
                            std::memcpy(numbers, &centre, sizeof centre);
                            break;
                        case SplatNumbers::Rotation:
                        case SplatNumbers::Scale: {
                            if (!axes) axes = triangle.axes(ellipse);
                            const Quatf& q = axes->rotation;
                            if (column.what == SplatNumbers::Rotation)
                                numbers[0] = q.x, numbers[1] = q.y, numbers[2] = q.z, numbers[3] = q.w;
                            else
                                std::memcpy(numbers, &axes->scaleM, sizeof axes->scaleM);
                            break;
                        }
                        case SplatNumbers::Covariance:
                            triangle.covariance(ellipse, numbers);
                            break;
                        case SplatNumbers::Opacity:
                            numbers[0] = field(kOpacity) * triangle.shown(centre, field(kSingleFace) > 0, eye);
                            break;
                        case SplatNumbers::Colour: {
                            const Vec3f away = eye ? centre - *eye : Vec3f(0);
                            const float distanceM = glm::length(away);
                            const bool seen = ownDegree > 0 && distanceM > 0;
                            const Vec3f direction = seen ? glm::transpose(triangle.frame().worldFromRest) * (away / distanceM) : Vec3f(0);
                            const Vec3f colour = shColour(sh, seen ? ownDegree : 0, direction, triangle.light(uv));
                            std::memcpy(numbers, &colour, sizeof colour);
                            break;
                        }
                        case SplatNumbers::Sh: {
                            std::memset(numbers, 0, sizeof numbers);
                            std::memcpy(numbers, sh, ownFloats * sizeof(float));
                            const uint32_t degree = std::min(shDegree, ownDegree);
                            if (degree > 0) rotator_.turn(triangle.frame().worldFromRest, degree).apply(numbers);
                            foldLight(triangle.light(uv), degree, numbers);
                            break;
                        }
                    }
                    beyond += column.to.write(first + lane, numbers, numbersOf(column.what, shDegree));
                }
            }
        }
        saturated += beyond;
    });
    return saturated;
}

}  // namespace dpl
