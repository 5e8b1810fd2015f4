#include "sdk/avatar/pose_correctives.h"

#include <algorithm>
#include <cmath>

namespace dpl {

float correctiveCoefficients(const PoseCorrectiveData& c, const Pose& pose, std::vector<float>& coefficients) {
    const size_t features = c.joints.size() * 6;
    coefficients.assign(c.modeCount, 0.0f);
    for (size_t j = 0; j < c.joints.size(); ++j) {
        float feature[6];
        correctiveFeature(pose.localRotations[c.joints[j]], feature);
        for (uint32_t i = 0; i < c.modeCount; ++i)
            for (size_t f = 0; f < 6; ++f) coefficients[i] += c.modes[i * features + j * 6 + f] * (feature[f] - c.mean[j * 6 + f]);
    }
    float sum = 0;
    for (const float k : coefficients) sum += k * k;
    const float length = std::sqrt(sum);
    if (length > c.reach)
        for (float& k : coefficients) k *= c.reach / length;
    return length;
}

void correctiveNodes(const PoseCorrectiveData& c, std::span<const float> coefficients, std::vector<Vec4f>& nodes) {
    nodes.resize(c.nodeCount);
    for (uint32_t n = 0; n < c.nodeCount; ++n) {
        Vec4f sum(0);
        for (uint32_t i = 0; i < c.modeCount; ++i) sum += coefficients[i] * c.nodes[size_t(n) * c.modeCount + i];
        nodes[n] = sum;
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
    jobs.forRange(moved.size(), 2048, std::ref(body));  // std::ref: no allocation for the captures
}

}  // namespace dpl
