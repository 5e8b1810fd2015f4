// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/trainable.h"

#include <algorithm>
#include <cmath>

namespace dpl {

namespace {

/** activate.inl as C++. */
struct Activation {
    using real = float;
    using real2 = Vec2f;
    static float max(float a, float b) { return std::max(a, b); }
    static float min(float a, float b) { return std::min(a, b); }
#define DPL_FN static inline
#include "reconstruction/training/trainer/activate.inl"
#undef DPL_FN
};

}  // namespace

Vec2f projectToSimplex(Vec2f uv) {
    return Activation::nearestOnTriangle(uv);
}

void TrainableSplats::resize(uint32_t count, uint32_t degree) {
    shDegree = degree;
    stride = strideFor(degree);
    const size_t n = count, coefficients = shCoefficientCount(degree) * 3;
    triangle.resize(n), flags.resize(n), uv.resize(n), scaleM.resize(n), phi.resize(n), opacity.resize(n);
    rows.assign(n * stride, 0.0f);
    sh.resize(n * coefficients);
}

void TrainableSplats::indexTriangles(size_t triangleCount) {
    triangleStart.assign(triangleCount + 1, 0);
    for (uint32_t t : triangle) ++triangleStart[t + 1];
    for (size_t t = 0; t < triangleCount; ++t) triangleStart[t + 1] += triangleStart[t];
}

void TrainableSplats::activate(size_t begin, size_t end, std::span<const uint8_t> only) {
    const size_t coefficients = shCoefficientCount(shDegree) * 3;
    for (size_t i = begin; i < end; ++i) {
        if (!only.empty() && !only[i]) continue;
        float* row = rows.data() + i * stride;
        uv[i] = projectToSimplex({row[kRowU], row[kRowV]});
        row[kRowU] = uv[i].x, row[kRowV] = uv[i].y;
        phi[i] = row[kRowPhi];
        const float floor2 = sizeFloorM[triangle[i]] * sizeFloorM[triangle[i]];
        for (uint32_t k = 0; k < 2; ++k) {
            float& logScale = row[kRowLogScale1 + k];
            logScale = std::clamp(logScale, kMinLogScale, kMaxLogScale);
            scaleM[i][int(k)] = std::sqrt(std::exp(2 * logScale) + floor2);
        }
        row[kRowOpacityLogit] = std::clamp(row[kRowOpacityLogit], -kMaxOpacityLogit, kMaxOpacityLogit);
        opacity[i] = 1 / (1 + std::exp(-row[kRowOpacityLogit]));
        std::copy_n(row + kRowSh, coefficients, sh.data() + i * coefficients);
    }
}

void TrainableSplats::activateAll(Jobs& jobs) {
    jobs.forRange(count(), 4096, [this](size_t begin, size_t end, uint32_t) { activate(begin, end); });
}

BoundSplatView TrainableSplats::view() const {
    BoundSplatView v;
    v.triangle = triangle, v.uv = uv, v.phi = phi, v.scaleM = scaleM, v.opacity = opacity, v.flags = flags, v.shDegree = shDegree,
    v.sh = sh;
    return v;
}

SplatData TrainableSplats::toSplatData() const {
    SplatData s;
    s.triangleStart = triangleStart;
    s.uv = uv, s.phi = phi, s.scaleM = scaleM, s.opacity = opacity, s.flags = flags, s.shDegree = shDegree, s.sh = sh;
    return s;
}

TrainableSplats TrainableSplats::fromSplatData(const SplatData& splats, std::span<const float> sizeFloorM) {
    TrainableSplats t;
    t.resize(splats.count(), splats.shDegree);
    t.triangleStart = splats.triangleStart;
    t.sizeFloorM.assign(sizeFloorM.begin(), sizeFloorM.end());
    t.flags = splats.flags;
    const size_t coefficients = shCoefficientCount(splats.shDegree) * 3;
    for (size_t tri = 0; tri + 1 < splats.triangleStart.size(); ++tri)
        for (uint32_t i = splats.triangleStart[tri]; i < splats.triangleStart[tri + 1]; ++i) t.triangle[i] = uint32_t(tri);
    for (size_t i = 0; i < t.count(); ++i) {
        float* row = t.rows.data() + i * t.stride;
        row[kRowU] = splats.uv[i].x, row[kRowV] = splats.uv[i].y, row[kRowPhi] = splats.phi[i];
        const float floor = t.sizeFloorM[t.triangle[i]];
        for (uint32_t k = 0; k < 2; ++k) {
            const float s = splats.scaleM[i][int(k)];
            row[kRowLogScale1 + k] = 0.5f * std::log(std::max(s * s - floor * floor, std::exp(2 * kMinLogScale)));
        }
        const float o = std::clamp(splats.opacity[i], 3.4e-4f, 1 - 3.4e-4f);
        row[kRowOpacityLogit] = std::log(o / (1 - o));
        std::copy_n(splats.sh.data() + i * coefficients, coefficients, row + kRowSh);
    }
    return t;
}

}  // namespace dpl
