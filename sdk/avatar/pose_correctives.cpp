// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/pose_correctives.h"

#include <algorithm>
#include <cmath>

#include "sdk/avatar/motion_state.h"

namespace dpl {
namespace {

/** Values of kTogether nodes from `first` on. Each sum adds its modes in order, so a result does not depend on kTogether; several sums do
 * not wait for one another. */
template <uint32_t kTogether>
void sumModes(const PoseCorrectiveData& c, std::span<const float> coefficients, uint32_t first, std::vector<Vec4f>& nodes) {
    const uint32_t columns = c.columnCount();
    const Vec4f* rows = c.nodes.data() + size_t(first) * columns;
    Vec4f sums[kTogether]{};
    for (uint32_t i = 0; i < columns; ++i)
        for (uint32_t k = 0; k < kTogether; ++k) sums[k] += coefficients[i] * rows[size_t(k) * columns + i];
    std::copy_n(sums, kTogether, nodes.data() + first);
}

}  // namespace

CorrectiveDistance correctiveCoefficients(const PoseCorrectiveData& c, const Pose& pose, std::vector<float>& coefficients) {
    const size_t features = c.joints.size() * 6;
    coefficients.assign(c.columnCount(), 0.0f);
    float away = 0;
    for (size_t j = 0; j < c.joints.size(); ++j) {
        float feature[6];
        correctiveFeature(pose.localRotations[c.joints[j]], feature);
        for (size_t f = 0; f < 6; ++f) feature[f] -= c.mean[j * 6 + f], away += feature[f] * feature[f];
        for (uint32_t i = 0; i < c.modeCount; ++i)
            for (size_t f = 0; f < 6; ++f) coefficients[i] += c.modes[i * features + j * 6 + f] * feature[f];
    }
    float squares = 0;
    for (uint32_t i = 0; i < c.modeCount; ++i) {
        float mode = 0;
        for (size_t f = 0; f < features; ++f) mode += c.modes[i * features + f] * c.modes[i * features + f];
        const float k2 = coefficients[i] * coefficients[i];
        squares += k2;
        if (mode > 0) away -= k2 / mode;
    }
    CorrectiveDistance distance{std::sqrt(squares), std::sqrt(std::max(0.0f, away))};
    float& keep = distance.drawn;
    if (distance.length > c.reach) keep *= c.reach / distance.length;
    if (distance.offModes > c.reachOffModes) keep *= c.reachOffModes / distance.offModes;
    if (keep < 1)
        for (float& k : coefficients) k *= keep;
    if (!c.motion.empty())
        motionCoefficients(c.motion, stateOf(c.motion, pose), std::span(coefficients).subspan(c.modeCount), pose.clothStiffness);
    return distance;
}

void correctiveNodes(const PoseCorrectiveData& c, std::span<const float> coefficients, std::vector<Vec4f>& nodes) {
    nodes.resize(c.nodeCount);
    uint32_t n = 0;
    for (; n + 4 <= c.nodeCount; n += 4) sumModes<4>(c, coefficients, n, nodes);
    for (; n < c.nodeCount; ++n) sumModes<1>(c, coefficients, n, nodes);
}

void addExpression(const ExpressionData& x, const ExpressionWeights& weights, std::vector<float>& coefficients, std::span<Vec4f> nodes) {
    for (size_t s = 0; s < x.shapes.size(); ++s) {
        const float weight = weights[x.shapes[s]];
        coefficients.push_back(weight);
        if (weight == 0) continue;
        for (uint32_t e = x.begin(s); e < x.ends[s]; ++e) nodes[x.nodes[e]] += Vec4f(weight * x.offsetsM[e], 0);
    }
}

void spreadCorrectives(const PoseCorrectiveData& c, std::span<const Vec4f> nodes, std::span<const Vec3f> restPositions, Jobs& jobs,
                       std::vector<Vec3f>& moved, std::vector<float>& light) {
    moved.resize(restPositions.size()), light.resize(restPositions.size());
    const auto body = [&](size_t begin, size_t end, uint32_t) {
        for (size_t v = begin; v < end; ++v) {
            Vec4f sum(0);
            for (int i = 0; i < 4; ++i)
                if (c.nodeWeights[v][i] != 0) sum += float(c.nodeWeights[v][i]) * nodes[c.nodeIndices[v][i]];
            sum *= 1.0f / 255.0f;
            moved[v] = restPositions[v] + Vec3f(sum);
            light[v] = std::clamp(1.0f + sum.w, kMinLight, kMaxLight);
        }
    };
    jobs.forRange(moved.size(), 2048, body);
}

}  // namespace dpl
