// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/expressions.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "sdk/format/face_nodes.h"
#include "sdk/format/plain_bytes.h"

namespace dpl {
namespace {

constexpr int kOffsetSteps = 32767;
using OffsetCodes = std::array<int16_t, 3>;  // of an offset; i16vec3 may be padded

bool onNodeZero(const PoseCorrectiveData& c, size_t vertex) {
    for (int k = 0; k < 4; ++k)
        if (c.nodeWeights[vertex][k] != 0 && c.nodeIndices[vertex][k] != 0) return false;
    return true;
}

}  // namespace

std::optional<size_t> expressionOf(std::string_view name) {
    if (name.empty()) return {};
    const char first = name[0] >= 'A' && name[0] <= 'Z' ? char(name[0] - 'A' + 'a') : name[0];
    for (size_t e = 0; e < kExpressionCount; ++e) {
        const std::string_view known = kExpressionNames[e];
        if (known[0] == first && known.substr(1) == name.substr(1)) return e;
    }
    return {};
}

Status checkExpressions(const ExpressionData& x, const PoseCorrectiveData& c) {
    if (x.ends.size() != x.shapes.size() || x.nodes.size() != x.offsetsM.size() || x.nodes.size() != (x.empty() ? 0 : x.ends.back()))
        return fail(Code::CorruptData, "the arrays of {} expressions differ in length", x.shapes.size());
    if (x.empty() && !c.empty() && !c.followsPose()) return fail(Code::CorruptData, "control nodes that neither pose nor expression moves");
    for (size_t s = 0; s < x.shapes.size(); ++s) {
        if (x.shapes[s] >= kExpressionCount || (s > 0 && x.shapes[s] <= x.shapes[s - 1]))
            return fail(Code::CorruptData, "expression {} is number {} of {}; each is listed once, in rising order", s, int(x.shapes[s]),
                        kExpressionCount);
        const char* name = kExpressionNames[x.shapes[s]];
        if (x.ends[s] < x.begin(s) || x.ends[s] > x.nodes.size())
            return fail(Code::CorruptData, "the entries of expression '{}' end at {} of {}", name, x.ends[s], x.nodes.size());
        for (uint32_t e = x.begin(s); e < x.ends[s]; ++e) {
            if (x.nodes[e] >= c.nodeCount || (x.nodes[e] == 0 && !c.followsPose()))
                return fail(Code::CorruptData, "expression '{}' moves control node {} of {}", name, x.nodes[e], c.nodeCount);
            if (e > x.begin(s) && x.nodes[e] <= x.nodes[e - 1])
                return fail(Code::CorruptData, "expression '{}' lists control node {} out of order", name, x.nodes[e]);
            for (int axis = 0; axis < 3; ++axis)
                if (!(std::abs(x.offsetsM[e][axis]) <= kMostExpressionM))  // not for NaN either
                    return fail(Code::CorruptData, "expression '{}' moves a node by {} m, at most {} are possible", name,
                                x.offsetsM[e][axis], kMostExpressionM);
        }
    }
    return checkFaceNodes(x, c);
}

void dropPoseModes(PoseCorrectiveData& c, ExpressionData& x) {
    PoseCorrectiveData out;
    if (x.firstNode > 0) {
        const std::vector<FaceVertex> vertices = faceVertices(x, c);
        for (uint16_t& node : x.nodes) node = uint16_t(node - x.firstNode);
        const uint32_t nodeCount = c.nodeCount - x.firstNode;
        shareFaceNodes(x);
        (void)bindToFace(vertices, nodeCount, c.nodeIndices.size(), out, x);  // the vertices have passed the same checks
        for (uint16_t& node : x.nodes) node = uint16_t(node + x.firstNode);
    } else if (!x.empty()) {
        std::vector<uint16_t> nodeOf(c.nodeCount, 0);  // node 0 never moves
        for (const uint16_t node : x.nodes) nodeOf[node] = 1;
        out.nodeCount = 1;
        for (uint16_t& node : nodeOf)
            if (node != 0) node = uint16_t(out.nodeCount++);
        for (uint16_t& node : x.nodes) node = nodeOf[node];
        out.nodeIndices = std::move(c.nodeIndices), out.nodeWeights = std::move(c.nodeWeights);
        for (glm::u16vec4& nodes : out.nodeIndices)
            for (int k = 0; k < 4; ++k) nodes[k] = nodeOf[nodes[k]];
    }
    c = std::move(out);
}

ExpressionStreams<std::vector<uint8_t>> encodeExpressions(const ExpressionData& x, const PoseCorrectiveData& c) {
    std::vector<uint32_t> counts;
    std::vector<float> ranges;
    std::vector<OffsetCodes> codes;
    for (size_t s = 0; s < x.shapes.size(); ++s) {
        float range = 0;
        for (uint32_t e = x.begin(s); e < x.ends[s]; ++e)
            for (int axis = 0; axis < 3; ++axis) range = std::max(range, std::abs(x.offsetsM[e][axis]));
        counts.push_back(x.ends[s] - x.begin(s)), ranges.push_back(range);
        for (uint32_t e = x.begin(s); e < x.ends[s]; ++e) {
            OffsetCodes& code = codes.emplace_back();
            for (int axis = 0; axis < 3 && range > 0; ++axis)
                code[size_t(axis)] = int16_t(std::lround(double(kOffsetSteps) * x.offsetsM[e][axis] / range));
        }
    }
    ExpressionStreams<std::vector<uint8_t>> out{bytesOf(counts), bytesOf(ranges), bytesOf(x.nodes), bytesOf(codes), {}, {}, {}};
    if (c.followsPose()) return out;
    std::vector<uint32_t> vertices;
    std::vector<glm::u16vec4> indices;
    std::vector<glm::u8vec4> weights;
    for (size_t v = 0; v < c.nodeWeights.size(); ++v) {
        if (onNodeZero(c, v)) continue;
        vertices.push_back(uint32_t(v)), indices.push_back(c.nodeIndices[v]), weights.push_back(c.nodeWeights[v]);
    }
    out.vertices = bytesOf(vertices), out.nodeIndices = bytesOf(indices), out.nodeWeights = bytesOf(weights);
    return out;
}

Result<ExpressionData> decodeExpressions(const ExpressionStreams<std::span<const uint8_t>>& in, std::vector<uint8_t> shapes) {
    const size_t entries = in.nodes.size() / sizeof(uint16_t);
    if (in.counts.size() != shapes.size() * sizeof(uint32_t) || in.ranges.size() != shapes.size() * sizeof(float) ||
        in.nodes.size() != entries * sizeof(uint16_t) || in.offsets.size() != entries * sizeof(OffsetCodes))
        return fail(Code::CorruptData, "the streams of the expressions do not hold {} shapes and {} entries", shapes.size(), entries);
    ExpressionData x;
    std::vector<uint32_t> counts;
    std::vector<float> ranges;
    std::vector<OffsetCodes> codes;
    fill(counts, in.counts), fill(ranges, in.ranges), fill(x.nodes, in.nodes), fill(codes, in.offsets);
    uint64_t end = 0;
    x.offsetsM.reserve(entries);
    for (size_t s = 0; s < shapes.size(); ++s) {
        if (counts[s] > entries - end)
            return fail(Code::CorruptData, "expression '{}' has {} entries, {} are left", kExpressionNames[shapes[s]], counts[s],
                        entries - end);
        end += counts[s];
        x.ends.push_back(uint32_t(end));
        for (size_t e = x.offsetsM.size(); e < end; ++e) {
            Vec3f& offset = x.offsetsM.emplace_back();
            for (size_t axis = 0; axis < 3; ++axis) offset[int(axis)] = float(double(codes[e][axis]) * ranges[s] / kOffsetSteps);
        }
    }
    if (end != entries) return fail(Code::CorruptData, "{} entries of expressions belong to no shape", entries - end);
    x.shapes = std::move(shapes);
    return x;
}

Result<PoseCorrectiveData> decodeExpressionNodes(const ExpressionStreams<std::span<const uint8_t>>& in, uint32_t nodeCount,
                                                 size_t vertexCount) {
    const size_t count = in.vertices.size() / sizeof(uint32_t);
    if (in.vertices.size() != count * sizeof(uint32_t) || in.nodeIndices.size() != count * sizeof(glm::u16vec4) ||
        in.nodeWeights.size() != count * sizeof(glm::u8vec4))
        return fail(Code::CorruptData, "the streams of the expressions' control nodes do not hold {} vertices", count);
    std::vector<uint32_t> vertices;
    std::vector<glm::u16vec4> indices;
    std::vector<glm::u8vec4> weights;
    fill(vertices, in.vertices), fill(indices, in.nodeIndices), fill(weights, in.nodeWeights);
    PoseCorrectiveData c;
    c.nodeCount = nodeCount;
    c.nodeIndices.assign(vertexCount, glm::u16vec4(0));
    c.nodeWeights.assign(vertexCount, glm::u8vec4(255, 0, 0, 0));
    for (size_t i = 0; i < count; ++i) {
        if (vertices[i] >= vertexCount || (i > 0 && vertices[i] <= vertices[i - 1]))
            return fail(Code::CorruptData, "expressions move vertex {} of {}; each is listed once, in rising order", vertices[i],
                        vertexCount);
        c.nodeIndices[vertices[i]] = indices[i], c.nodeWeights[vertices[i]] = weights[i];
        if (onNodeZero(c, vertices[i])) return fail(Code::CorruptData, "expressions list vertex {}, which never moves", vertices[i]);
    }
    return c;
}

}  // namespace dpl
