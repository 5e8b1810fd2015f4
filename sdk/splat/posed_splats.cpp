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
                        case SplatNumbers::RotationWxyz:
                        case SplatNumbers::Scale: {
                            if (!axes) axes = triangle.axes(ellipse);
                            const Quatf& q = axes->rotation;
                            if (column.what == SplatNumbers::Rotation)
                                numbers[0] = q.x, numbers[1] = q.y, numbers[2] = q.z, numbers[3] = q.w;
                            else if (column.what == SplatNumbers::RotationWxyz)
                                numbers[0] = q.w, numbers[1] = q.x, numbers[2] = q.y, numbers[3] = q.z;
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
