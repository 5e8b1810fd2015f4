#include "sdk/avatar/pose_correctives.h"

#include <algorithm>
#include <cmath>

namespace dpl {
namespace {

bool allFinite(const std::vector<float>& values) {
    return std::all_of(values.begin(), values.end(), [](float x) { return std::isfinite(x); });
}

}  // namespace

Status checkCorrectives(const PoseCorrectiveData& c, size_t jointCount, size_t vertexCount) {
    if (c.empty()) return {};
    const size_t features = c.joints.size() * 6;
    if (c.modeCount == 0 || c.modeCount > kMaxCorrectiveModes || c.nodeCount > kMaxCorrectiveNodes)
        return fail(Code::CorruptData, "pose correctives have {} modes and {} nodes; 1 to {} and at most {} are possible", c.modeCount, c.nodeCount,
                    kMaxCorrectiveModes, kMaxCorrectiveNodes);
    if (c.joints.empty() || c.mean.size() != features || c.modes.size() != features * c.modeCount || c.nodes.size() != size_t(c.nodeCount) * c.modeCount)
        return fail(Code::CorruptData, "the arrays of the pose correctives do not fit {} joints, {} modes and {} nodes", c.joints.size(), c.modeCount, c.nodeCount);
    if (c.nodeIndices.size() != vertexCount || c.nodeWeights.size() != vertexCount)
        return fail(Code::CorruptData, "pose correctives have weights for {} vertices of {}", c.nodeWeights.size(), vertexCount);
    for (size_t i = 0; i < c.joints.size(); ++i)
        if (c.joints[i] >= jointCount || (i > 0 && c.joints[i] <= c.joints[i - 1]))
            return fail(Code::CorruptData, "pose correctives hear joint {} of {}; joints are listed once, in rising order", c.joints[i], jointCount);
    for (size_t v = 0; v < vertexCount; ++v) {
        const glm::u8vec4 w = c.nodeWeights[v];
        if (w.x + w.y + w.z + w.w != 255) return fail(Code::CorruptData, "pose corrective weights of vertex {} sum to {}, not 255", v, w.x + w.y + w.z + w.w);
        for (int i = 0; i < 4; ++i)
            if (w[i] != 0 && c.nodeIndices[v][i] >= c.nodeCount)
                return fail(Code::CorruptData, "vertex {} hangs on pose corrective node {} of {}", v, c.nodeIndices[v][i], c.nodeCount);
    }
    bool good = allFinite(c.mean) && allFinite(c.modes) && std::isfinite(c.reach) && c.reach > 0;
    for (const Vec4f& n : c.nodes) good = good && std::isfinite(n.x + n.y + n.z + n.w);
    if (!good) return fail(Code::CorruptData, "pose correctives hold a number that is not finite, or no reach");
    return {};
}

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
