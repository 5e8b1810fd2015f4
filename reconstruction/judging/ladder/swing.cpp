// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/ladder/swing.h"

#include <algorithm>
#include <cmath>

namespace dpl {
namespace {

constexpr double kShiftStepS = 0.005;
constexpr size_t kLeastTimes = 4;
constexpr double kLeastSwingM = 1e-6;  // of the truth; less is rounding

/** The parts at a time, which must lie within those of the samples. */
std::vector<Vec2d> partsAt(std::span<const SwingSample> samples, double timeS) {
    size_t after = 1;
    while (after + 1 < samples.size() && samples[after].timeS < timeS) ++after;
    const SwingSample &a = samples[after - 1], &b = samples[after];
    const double share = (timeS - a.timeS) / (b.timeS - a.timeS);
    std::vector<Vec2d> parts(a.parts.size());
    for (size_t p = 0; p < parts.size(); ++p) parts[p] = a.parts[p] + share * (b.parts[p] - a.parts[p]);
    return parts;
}

void takeMeanAway(std::vector<std::vector<Vec2d>>& series) {
    for (size_t p = 0; p < series[0].size(); ++p) {
        Vec2d mean(0);
        for (const auto& parts : series) mean += parts[p] / double(series.size());
        for (auto& parts : series) parts[p] -= mean;
    }
}

double product(const std::vector<std::vector<Vec2d>>& a, const std::vector<std::vector<Vec2d>>& b) {
    double sum = 0;
    for (size_t t = 0; t < a.size(); ++t)
        for (size_t p = 0; p < a[t].size(); ++p) sum += glm::dot(a[t][p], b[t][p]);
    return sum;
}

}  // namespace

Swing compareSwing(std::span<const SwingSample> truth, std::span<const SwingSample> avatar, double mostLateS) {
    Swing best;
    if (avatar.size() < 2) return best;
    const size_t least = std::max(kLeastTimes, (3 * truth.size() + 3) / 4);
    const auto steps = int(std::lround(mostLateS / kShiftStepS));
    for (int step = -steps; step <= steps; ++step) {
        const double shiftS = step * kShiftStepS;
        std::vector<std::vector<Vec2d>> a, b;
        for (const SwingSample& sample : truth) {
            const double timeS = sample.timeS + shiftS;
            if (timeS < avatar.front().timeS || timeS > avatar.back().timeS) continue;
            a.push_back(sample.parts), b.push_back(partsAt(avatar, timeS));
        }
        if (a.size() < least || a[0].empty()) continue;
        takeMeanAway(a), takeMeanAway(b);
        const double aa = product(a, a), bb = product(b, b);
        const double rmsM = std::sqrt(aa / double(a.size() * a[0].size()));
        if (!(rmsM > kLeastSwingM)) continue;
        const double correlation = bb > 0 ? product(a, b) / std::sqrt(aa * bb) : 0;
        if (best.times == 0 || correlation > best.correlation) best = {rmsM, std::sqrt(bb / aa), shiftS, correlation, a.size()};
    }
    return best;
}

}  // namespace dpl
