// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/correctives.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "sdk/format/motion_modes.h"
#include "sdk/format/plain_bytes.h"

namespace dpl {
namespace {

constexpr float kMaxValue = 1e6f;  // far above the values of any avatar; products of three stay finite in float
constexpr int kSteps = 32767;

bool allSane(std::span<const float> values) {
    return std::all_of(values.begin(), values.end(), [](float x) { return std::abs(x) <= kMaxValue; });  // false for NaN too
}

/** Largest magnitude of each component of a column, over its nodes. */
Vec4f rangeOfColumn(const PoseCorrectiveData& c, uint32_t column) {
    Vec4f range(0);
    for (uint32_t n = 0; n < c.nodeCount; ++n) range = glm::max(range, glm::abs(c.nodes[size_t(n) * c.columnCount() + column]));
    return range;
}

/** Every vertex has four nodes that exist. */
Status checkNodesOfVertices(const PoseCorrectiveData& c, size_t vertexCount) {
    if (c.nodeIndices.size() != vertexCount || c.nodeWeights.size() != vertexCount)
        return fail(Code::CorruptData, "pose correctives have {} indices and {} weights for {} vertices", c.nodeIndices.size(),
                    c.nodeWeights.size(), vertexCount);
    for (size_t v = 0; v < vertexCount; ++v) {
        const glm::u8vec4 w = c.nodeWeights[v];
        if (w.x + w.y + w.z + w.w != 255)
            return fail(Code::CorruptData, "pose corrective weights of vertex {} sum to {}, not 255", v, w.x + w.y + w.z + w.w);
        for (int i = 0; i < 4; ++i)
            if (c.nodeIndices[v][i] >= c.nodeCount)
                return fail(Code::CorruptData, "vertex {} uses pose corrective node {} of {}", v, c.nodeIndices[v][i], c.nodeCount);
    }
    return {};
}

}  // namespace

Status checkCorrectives(const PoseCorrectiveData& c, size_t jointCount, size_t vertexCount) {
    if (c.empty()) return {};
    const size_t features = c.joints.size() * 6;
    if (!c.followsPose() && c.joints.empty() && c.mean.empty() && c.modes.empty() && c.nodes.empty() && c.motion.empty() &&
        c.nodeCount <= kMaxCorrectiveNodes)
        return checkNodesOfVertices(c, vertexCount);
    DPL_RETURN_IF_ERROR(checkMotionModes(c.motion, jointCount));
    if (c.modeCount == 0 || c.modeCount > kMaxCorrectiveModes || c.motion.columnCount() > kMaxCorrectiveModes - c.modeCount ||
        c.nodeCount > kMaxCorrectiveNodes)
        return fail(Code::CorruptData, "pose correctives have {} modes and {} nodes; 1 to {} and at most {} are possible",
                    uint64_t(c.modeCount) + c.motion.columnCount(), c.nodeCount, kMaxCorrectiveModes, kMaxCorrectiveNodes);
    if (c.joints.empty() || c.mean.size() != features || c.modes.size() != features * c.modeCount ||
        c.nodes.size() != size_t(c.nodeCount) * c.columnCount())
        return fail(Code::CorruptData, "the arrays of the pose correctives do not fit {} joints, {} modes and {} nodes", c.joints.size(),
                    c.columnCount(), c.nodeCount);
    for (size_t i = 0; i < c.joints.size(); ++i)
        if (c.joints[i] >= jointCount || (i > 0 && c.joints[i] <= c.joints[i - 1]))
            return fail(Code::CorruptData, "pose correctives name joint {} of {}; each joint is listed once, in rising order", c.joints[i],
                        jointCount);
    DPL_RETURN_IF_ERROR(checkNodesOfVertices(c, vertexCount));
    bool good =
        allSane(c.mean) && allSane(c.modes) && c.reach > 0 && c.reach <= kMaxValue && c.reachOffModes > 0 && c.reachOffModes <= kMaxValue;
    for (const Vec4f& n : c.nodes) good = good && allSane({&n.x, 4});
    if (!good) return fail(Code::CorruptData, "pose correctives hold a number that is not finite or above {}, or no reach", kMaxValue);
    return {};
}

CorrectiveStreams<std::vector<uint8_t>> encodeCorrectives(const PoseCorrectiveData& c) {
    std::vector<Vec4f> ranges;
    for (uint32_t i = 0; i < c.columnCount(); ++i) ranges.push_back(rangeOfColumn(c, i));
    std::vector<glm::i16vec4> codes(c.nodes.size());
    for (size_t e = 0; e < codes.size(); ++e)
        for (int k = 0; k < 4; ++k)
            if (const float range = ranges[e % c.columnCount()][k]; range > 0)
                codes[e][k] = int16_t(std::lround(double(kSteps) * c.nodes[e][k] / range));
    return {bytesOf(c.mean), bytesOf(c.modes), bytesOf(ranges), bytesOf(codes), bytesOf(c.nodeIndices), bytesOf(c.nodeWeights)};
}

Result<PoseCorrectiveData> decodeCorrectives(const CorrectiveStreams<std::span<const uint8_t>>& in, PoseCorrectiveData c,
                                             size_t vertexCount) {
    const size_t features = c.joints.size() * 6, entries = size_t(c.nodeCount) * c.columnCount();
    if (in.mean.size() != features * sizeof(float) || in.modes.size() != features * c.modeCount * sizeof(float) ||
        in.ranges.size() != c.columnCount() * sizeof(Vec4f) || in.nodes.size() != entries * sizeof(glm::i16vec4) ||
        in.nodeIndices.size() != vertexCount * sizeof(glm::u16vec4) || in.nodeWeights.size() != vertexCount * sizeof(glm::u8vec4))
        return fail(Code::CorruptData, "the streams of the pose correctives do not hold {} joints, {} modes, {} nodes and {} vertices",
                    c.joints.size(), c.columnCount(), c.nodeCount, vertexCount);
    fill(c.mean, in.mean), fill(c.modes, in.modes), fill(c.nodeIndices, in.nodeIndices), fill(c.nodeWeights, in.nodeWeights);
    std::vector<Vec4f> ranges;
    fill(ranges, in.ranges);
    c.nodes.resize(entries);
    for (size_t e = 0; e < entries; ++e) {
        glm::i16vec4 code;
        std::memcpy(&code, in.nodes.data() + e * sizeof(code), sizeof(code));
        for (int k = 0; k < 4; ++k) c.nodes[e][k] = float(double(code[k]) * ranges[e % c.columnCount()][k] / kSteps);
    }
    return c;
}

}  // namespace dpl
