// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/splat/density.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "reconstruction/splat/random.h"

namespace dpl {

DensityReport densify(TrainableSplats& splats, AdamRows& adam, DensityStatistics& statistics, std::span<const RestTriangle<float>> rest,
                      std::span<const float> triangleSizeM, const DensitySettings& settings, uint64_t event) {
    const uint32_t count = splats.count(), stride = splats.stride;
    DensityReport report;
    std::vector<uint8_t> keep(count, 1), grow(count, 0);
    for (size_t t = 0; t + 1 < splats.triangleStart.size(); ++t) {
        uint32_t best = splats.triangleStart[t], left = 0;
        for (uint32_t i = splats.triangleStart[t]; i < splats.triangleStart[t + 1]; ++i) {
            keep[i] = splats.opacity[i] >= settings.minOpacity;
            left += keep[i];
            if (splats.opacity[i] > splats.opacity[best]) best = i;
        }
        if (left == 0 && splats.triangleStart[t + 1] > splats.triangleStart[t]) keep[best] = 1;
    }
    uint32_t kept = 0;
    for (uint8_t k : keep) kept += k;
    report.pruned = count - kept;
    const uint32_t room = settings.maxSplats > kept ? std::min(settings.maxGrowth, settings.maxSplats - kept) : 0;
    std::vector<uint32_t> order;
    const auto score = [&](uint32_t i) { return statistics.seen[i] ? statistics.gradientSum[i] / float(statistics.seen[i]) : 0.0f; };
    for (uint32_t i = 0; i < count; ++i)
        if (keep[i] && score(i) > 0 && std::isfinite(score(i)) && splats.opacity[i] > 0.05f) order.push_back(i);
    std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return score(a) > score(b); });
    if (order.size() > room) order.resize(room);
    for (uint32_t i : order) grow[i] = 1;

    const uint32_t newCount = kept + uint32_t(order.size());
    TrainableSplats out;
    out.resize(newCount, splats.shDegree);
    out.sizeFloorM = splats.sizeFloorM;
    AdamRows moments;
    moments.resize(newCount, stride);
    uint32_t at = 0;
    const auto place = [&](uint32_t from, const float* row, bool withMoments) {
        out.triangle[at] = splats.triangle[from], out.flags[at] = splats.flags[from];
        std::copy_n(row, stride, out.rows.data() + size_t(at) * stride);
        if (withMoments) {
            std::copy_n(adam.first.data() + size_t(from) * stride, stride, moments.first.data() + size_t(at) * stride);
            std::copy_n(adam.second.data() + size_t(from) * stride, stride, moments.second.data() + size_t(at) * stride);
            moments.steps[at] = adam.steps[from];
        }
        ++at;
    };
    std::vector<float> row(stride);
    for (uint32_t i = 0; i < count; ++i) {
        if (!keep[i]) continue;
        const float* source = splats.rows.data() + size_t(i) * stride;
        if (!grow[i]) {
            place(i, source, true);
            continue;
        }
        const uint32_t t = splats.triangle[i];
        const RestInverse<float>& inverse = rest[t].inverse;
        const Vec2f s = splats.scaleM[i];
        const bool big = std::max(s.x, s.y) > std::max(settings.bigM, 0.6f * triangleSizeM[t]);
        big ? ++report.split : ++report.cloned;
        const float c = std::cos(source[kRowPhi]), sn = std::sin(source[kRowPhi]);
        for (uint32_t child = 0; child < 2; ++child) {
            std::copy_n(source, stride, row.data());
            if (!big && child == 0) {
                // The opacity 1 − √(1 − o) makes the two clones together as opaque as the original.
                row[kRowOpacityLogit] =
                    std::log(std::max(1e-4f, 1 - std::sqrt(1 - splats.opacity[i])) / std::max(1e-4f, std::sqrt(1 - splats.opacity[i])));
                place(i, row.data(), true);
                continue;
            }
            const auto [n0, n1] = hashNormals(settings.seed, 100 + event, uint64_t(i) * 2 + child);
            const float reach = big ? 1.0f : 0.5f;
            const float a = reach * float(n0) * s.x, b = reach * float(n1) * s.y;
            const float x = c * a - sn * b, y = sn * a + c * b;  // in the triangle's rest plane, metres
            row[kRowU] += inverse.i00 * x + inverse.i01 * y;
            row[kRowV] += inverse.i11 * y;
            if (big) {
                row[kRowLogScale1] -= std::log(1.6f), row[kRowLogScale2] -= std::log(1.6f);
            } else {
                row[kRowOpacityLogit] =
                    std::log(std::max(1e-4f, 1 - std::sqrt(1 - splats.opacity[i])) / std::max(1e-4f, std::sqrt(1 - splats.opacity[i])));
            }
            place(i, row.data(), false);
        }
    }
    out.indexTriangles(splats.triangleStart.size() - 1);
    out.activate(0, newCount);
    splats = std::move(out);
    adam = std::move(moments);
    statistics.resize(newCount);
    return report;
}

}  // namespace dpl
