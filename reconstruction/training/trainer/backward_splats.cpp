// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/backward_splats.h"

#include <algorithm>
#include <cmath>

namespace dpl {

void SplatBackward::run(const SplatBackwardInput& in, bool geometry) {
    const TrainableSplats& s = in.splats;
    const size_t count = s.count(), triangleCount = in.frames.size(), stride = s.stride;
    rowGradients_.resize(count * stride);
    active_.resize(count);
    screenLength_.resize(count);
    if (geometry) corners_.resize(triangleCount * 3), lights_.resize(triangleCount * 3);
    const auto view = backwardViewOf(in.camera);
    const uint32_t coefficients = shCoefficientCount(s.shDegree) * 3;
    constexpr size_t kTrianglesPerBlock = 512;
    jobs_.forRange(triangleCount, kTrianglesPerBlock, [&](size_t begin, size_t end, uint32_t) {
        ParameterGradient<float> g;
        for (size_t t = begin; t < end; ++t) {
            TriangleGradient<float> triangle;
            bool any = false;
            for (uint32_t i = s.triangleStart[t]; i < s.triangleStart[t + 1]; ++i) {
                const EntrySums& sums = in.sums[i];
                active_[i] = sums.weight > 0;
                if (!active_[i]) continue;
                any = true;
                const ScreenGradient<float> screen = screenGradient(in.projected[i], sums);
                screenLength_[i] = std::sqrt(screen.x * screen.x + screen.y * screen.y);
                SplatParameters<float> p;
                p.uv = s.uv[i], p.opacity = s.opacity[i];
                p.singleFace = s.flags[i] & kSplatSingleFace;
                p.shDegree = s.shDegree, p.sh = s.sh.data() + size_t(i) * coefficients;
                backwardSplat(view, in.frames[t], p, in.records[i], screen, g, triangle);
                float* row = rowGradients_.data() + i * stride;
                row[kRowU] = g.uv.x, row[kRowV] = g.uv.y, row[kRowPhi] = g.phi;
                const float floor2 = s.sizeFloorM[t] * s.sizeFloorM[t];
                for (int k = 0; k < 2; ++k) {
                    const float s2 = s.scaleM[i][k] * s.scaleM[i][k];
                    row[kRowLogScale1 + uint32_t(k)] = g.logScale[k] * std::max(0.0f, s2 - floor2) / s2;
                }
                row[kRowOpacityLogit] = g.opacity * p.opacity * (1 - p.opacity);
                std::copy_n(g.sh, coefficients, row + kRowSh);
                std::fill(row + kRowSh + coefficients, row + stride, 0.0f);
            }
            if (!geometry) continue;
            Vec3f* corner = corners_.data() + t * 3;
            corner[0] = corner[1] = corner[2] = Vec3f(0);
            for (int c = 0; c < 3; ++c) lights_[t * 3 + size_t(c)] = triangle.light[c];
            if (!any) continue;
            const RestTriangle<float>&bind = in.rest.bind[t], &now = in.rest.now.empty() ? bind : in.rest.now[t];
            finishTriangle(in.frames[t], bind, now, triangle, corner);
        }
    });
}

void SplatBackward::gatherVertices(const VertexIncidence& incidence, std::vector<Vec3f>& gPosed, std::vector<float>& gLight) const {
    gPosed.resize(incidence.offset.size() - 1), gLight.resize(gPosed.size());
    jobs_.forRange(gPosed.size(), 2048, [&](size_t begin, size_t end, uint32_t) {
        for (size_t v = begin; v < end; ++v) {
            Vec3f sum(0);
            float light = 0;
            for (uint32_t k = incidence.offset[v]; k < incidence.offset[v + 1]; ++k)
                sum += corners_[incidence.corners[k]], light += lights_[incidence.corners[k]];
            gPosed[v] = sum, gLight[v] = light;
        }
    });
}

}  // namespace dpl
