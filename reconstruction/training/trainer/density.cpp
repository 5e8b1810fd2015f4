// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/density.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "reconstruction/training/trainer/random.h"

namespace dpl {
namespace {

/** Which splats stay, and which of those become two. */
struct Choice {
    std::vector<uint8_t> keep, grow;  // one a splat
    uint32_t kept = 0, grown = 0;
};

Choice choose(const TrainableSplats& splats, const DensityStatistics& statistics, const DensitySettings& settings) {
    const uint32_t count = splats.count();
    Choice choice{std::vector<uint8_t>(count, 1), std::vector<uint8_t>(count, 0)};
    for (size_t t = 0; t + 1 < splats.triangleStart.size(); ++t) {
        uint32_t best = splats.triangleStart[t], left = 0;
        for (uint32_t i = splats.triangleStart[t]; i < splats.triangleStart[t + 1]; ++i) {
            choice.keep[i] = splats.opacity[i] >= settings.minOpacity;
            left += choice.keep[i];
            if (splats.opacity[i] > splats.opacity[best]) best = i;
        }
        if (left == 0 && splats.triangleStart[t + 1] > splats.triangleStart[t]) choice.keep[best] = 1;
    }
    for (uint8_t k : choice.keep) choice.kept += k;
    const uint32_t room = settings.maxSplats > choice.kept ? std::min(settings.maxGrowth, settings.maxSplats - choice.kept) : 0;
    std::vector<uint32_t> order;
    const auto score = [&](uint32_t i) { return statistics.seen[i] ? statistics.gradientSum[i] / float(statistics.seen[i]) : 0.0f; };
    for (uint32_t i = 0; i < count; ++i)
        if (choice.keep[i] && score(i) > 0 && std::isfinite(score(i)) && splats.opacity[i] > 0.05f) order.push_back(i);
    std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return score(a) > score(b); });
    if (order.size() > room) order.resize(room);
    for (uint32_t i : order) choice.grow[i] = 1;
    choice.grown = uint32_t(order.size());
    return choice;
}

/** The opacity 1 − √(1 − o), as a logit: two such splats together are as opaque as one of opacity o. */
float halvedLogit(float opacity) {
    const float through = std::sqrt(1 - opacity);
    return std::log(std::max(1e-4f, 1 - through) / std::max(1e-4f, through));
}

/** New splats, placed one after another, with their Adam rows. */
class SplatPlacement {
public:
    SplatPlacement(const TrainableSplats& from, const AdamRows& adam, uint32_t count) : from_(from), adam_(adam) {
        splats.resize(count, from.shDegree);
        splats.sizeFloorM = from.sizeFloorM;
        moments.resize(count, from.stride);
    }
    TrainableSplats splats;
    AdamRows moments;

    /** A splat with this row, on the triangle and with the flags of splat `origin`; with its moments, too, or with none. */
    void add(uint32_t origin, const float* row, bool withMoments) {
        const uint32_t stride = from_.stride;
        splats.triangle[at_] = from_.triangle[origin], splats.flags[at_] = from_.flags[origin];
        std::copy_n(row, stride, splats.rows.data() + size_t(at_) * stride);
        if (withMoments) {
            std::copy_n(adam_.first.data() + size_t(origin) * stride, stride, moments.first.data() + size_t(at_) * stride);
            std::copy_n(adam_.second.data() + size_t(origin) * stride, stride, moments.second.data() + size_t(at_) * stride);
            moments.steps[at_] = adam_.steps[origin];
        }
        ++at_;
    }

private:
    const TrainableSplats& from_;
    const AdamRows& adam_;
    uint32_t at_ = 0;
};

}  // namespace

DensityReport densify(TrainableSplats& splats, AdamRows& adam, DensityStatistics& statistics, std::span<const RestTriangle<float>> rest,
                      std::span<const float> triangleSizeM, const DensitySettings& settings, uint64_t event) {
    const Choice choice = choose(splats, statistics, settings);
    const uint32_t count = splats.count(), stride = splats.stride, newCount = choice.kept + choice.grown;
    DensityReport report;
    report.pruned = count - choice.kept;
    SplatPlacement placement(splats, adam, newCount);
    std::vector<float> row(stride);
    for (uint32_t i = 0; i < count; ++i) {
        if (!choice.keep[i]) continue;
        const float* source = splats.rows.data() + size_t(i) * stride;
        if (!choice.grow[i]) {
            placement.add(i, source, true);
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
            if (!big) row[kRowOpacityLogit] = halvedLogit(splats.opacity[i]);
            if (!big && child == 0) {
                placement.add(i, row.data(), true);
                continue;
            }
            const auto [n0, n1] = hashNormals(settings.seed, 100 + event, uint64_t(i) * 2 + child);
            const float reach = big ? 1.0f : 0.5f;
            const float a = reach * float(n0) * s.x, b = reach * float(n1) * s.y;
            const float x = c * a - sn * b, y = sn * a + c * b;  // in the triangle's rest plane, metres
            row[kRowU] += inverse.i00 * x + inverse.i01 * y;
            row[kRowV] += inverse.i11 * y;
            if (big) row[kRowLogScale1] -= std::log(1.6f), row[kRowLogScale2] -= std::log(1.6f);
            placement.add(i, row.data(), false);
        }
    }
    placement.splats.indexTriangles(splats.triangleStart.size() - 1);
    placement.splats.activate(0, newCount);
    splats = std::move(placement.splats);
    adam = std::move(placement.moments);
    statistics.resize(newCount);
    return report;
}

}  // namespace dpl
