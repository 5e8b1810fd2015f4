// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/face_nodes.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "sdk/format/correctives.h"
#include "sdk/format/expressions.h"
#include "sdk/format/plain_bytes.h"

namespace dpl {
namespace {

constexpr int kByteSteps = 127, kWordSteps = 32767;
const glm::u8vec4 kAlone(255, 0, 0, 0);

bool isByteShape(float rangeM) {
    return rangeM <= kByteRangeM;
}

/** The value of the pose's column at a vertex. */
Vec4f columnAt(const PoseCorrectiveData& c, uint32_t vertex, uint32_t column) {
    Vec4f sum(0);
    for (int k = 0; k < 4; ++k)
        sum += float(c.nodeWeights[vertex][k]) / 255.0f * c.nodes[size_t(c.nodeIndices[vertex][k]) * c.columnCount() + column];
    return sum;
}

template <class T>
void put(std::vector<uint8_t>& out, T value) {
    const auto* raw = reinterpret_cast<const uint8_t*>(&value);
    out.insert(out.end(), raw, raw + sizeof value);
}

float rangeOf(const ExpressionData& x, size_t shape) {
    float range = 0;
    for (uint32_t e = x.begin(shape); e < x.ends[shape]; ++e)
        for (int axis = 0; axis < 3; ++axis) range = std::max(range, std::abs(x.offsetsM[e][axis]));
    return range;
}

void putOffset(std::vector<uint8_t>& out, const Vec3f& offsetM, float rangeM) {
    for (int axis = 0; axis < 3; ++axis) {
        const double share = rangeM > 0 ? double(offsetM[axis]) / double(rangeM) : 0;
        if (isByteShape(rangeM))
            put(out, int8_t(std::lround(kByteSteps * share)));
        else
            put(out, int16_t(std::lround(kWordSteps * share)));
    }
}

/** Of one shape; the bytes are there. */
Vec3f offsetAt(std::span<const uint8_t> offsets, size_t entry, float rangeM) {
    Vec3f out;
    for (size_t axis = 0; axis < 3; ++axis) {
        if (isByteShape(rangeM)) {
            out[int(axis)] = float(double(int8_t(offsets[3 * entry + axis])) * double(rangeM) / kByteSteps);
        } else {
            int16_t code;
            std::memcpy(&code, offsets.data() + 2 * (3 * entry + axis), sizeof code);
            out[int(axis)] = float(double(code) * double(rangeM) / kWordSteps);
        }
    }
    return out;
}

/** The vertices of a file, in rising order. */
Result<std::vector<FaceVertex>> verticesOf(const FaceStreams<std::span<const uint8_t>>& in) {
    const size_t alone = in.alone.size() / sizeof(uint32_t), several = in.vertices.size() / sizeof(uint32_t);
    if (in.alone.size() != alone * sizeof(uint32_t) || in.aloneNodes.size() != alone * sizeof(uint16_t) ||
        in.vertices.size() != several * sizeof(uint32_t) || in.nodeIndices.size() != several * sizeof(glm::u16vec4) ||
        in.nodeWeights.size() != several * sizeof(glm::u8vec4))
        return fail(Code::CorruptData, "the streams of the face's control nodes do not hold {} and {} vertices", alone, several);
    std::vector<uint32_t> ones, others;
    std::vector<uint16_t> nodes;
    std::vector<glm::u16vec4> indices;
    std::vector<glm::u8vec4> weights;
    fill(ones, in.alone), fill(others, in.vertices), fill(nodes, in.aloneNodes), fill(indices, in.nodeIndices),
        fill(weights, in.nodeWeights);
    std::vector<FaceVertex> out;
    out.reserve(alone + several);
    size_t a = 0, b = 0;
    while (a < alone || b < several) {
        if (b == several || (a < alone && ones[a] < others[b])) {
            out.push_back({ones[a], glm::u16vec4(nodes[a], 0, 0, 0), kAlone}), ++a;
        } else {
            if (weights[b] == kAlone)
                return fail(Code::CorruptData, "expressions list vertex {}, on one node, among those on several", others[b]);
            out.push_back({others[b], indices[b], weights[b]}), ++b;
        }
    }
    return out;
}

}  // namespace

Status bindToFace(std::span<const FaceVertex> vertices, uint32_t nodeCount, size_t vertexCount, PoseCorrectiveData& c, ExpressionData& x) {
    const uint32_t first = std::max(1u, c.nodeCount);  // without a pose node 0 never moves
    if (nodeCount == 0 || nodeCount > kMaxCorrectiveNodes || first > kMaxCorrectiveNodes - nodeCount)
        return fail(Code::CorruptData, "{} control nodes for expressions beside {}; a file holds 1 to {}", nodeCount, first,
                    kMaxCorrectiveNodes);
    constexpr uint32_t kNowhere = 0xffffffffu;
    std::vector<uint32_t> standsAt(nodeCount, kNowhere);
    for (size_t i = 0; i < vertices.size(); ++i) {
        const FaceVertex& v = vertices[i];
        if (v.vertex >= vertexCount || (i > 0 && v.vertex <= vertices[i - 1].vertex))
            return fail(Code::CorruptData, "expressions move vertex {} of {}; each is listed once, in rising order", v.vertex, vertexCount);
        for (int k = 0; k < 4; ++k)
            if (v.nodes[k] >= nodeCount) return fail(Code::CorruptData, "vertex {} is on node {} of {}", v.vertex, v.nodes[k], nodeCount);
        if (v.weights == kAlone && standsAt[v.nodes[0]] == kNowhere) standsAt[v.nodes[0]] = v.vertex;
    }
    if (const auto lost = std::find(standsAt.begin(), standsAt.end(), kNowhere); lost != standsAt.end())
        return fail(Code::CorruptData, "control node {} of the face has no vertex of its own", lost - standsAt.begin());
    if (c.empty()) {
        c.nodeCount = 1;
        c.nodeIndices.assign(vertexCount, glm::u16vec4(0)), c.nodeWeights.assign(vertexCount, kAlone);
    }
    c.nodes.reserve(c.nodes.size() + size_t(nodeCount) * c.columnCount());
    for (const uint32_t vertex : standsAt)
        for (uint32_t column = 0; column < c.columnCount(); ++column) c.nodes.push_back(columnAt(c, vertex, column));
    c.nodeCount += nodeCount;
    x.firstNode = first;
    for (const FaceVertex& v : vertices) {
        x.vertices.push_back(v.vertex);
        x.poseIndices.push_back(c.nodeIndices[v.vertex]), x.poseWeights.push_back(c.nodeWeights[v.vertex]);
        for (int k = 0; k < 4; ++k) c.nodeIndices[v.vertex][k] = uint16_t(first + v.nodes[k]);
        c.nodeWeights[v.vertex] = v.weights;
    }
    return {};
}

PoseCorrectiveData withoutFaceNodes(const PoseCorrectiveData& c, const ExpressionData& x) {
    if (x.firstNode == 0) return c;
    PoseCorrectiveData out = c;
    out.nodeCount = x.firstNode;
    out.nodes.resize(size_t(x.firstNode) * c.columnCount());
    for (size_t i = 0; i < x.vertices.size(); ++i)
        out.nodeIndices[x.vertices[i]] = x.poseIndices[i], out.nodeWeights[x.vertices[i]] = x.poseWeights[i];
    return out;
}

std::vector<FaceVertex> faceVertices(const ExpressionData& x, const PoseCorrectiveData& c) {
    std::vector<FaceVertex> out;
    for (const uint32_t v : x.vertices) {
        FaceVertex& to = out.emplace_back(FaceVertex{v, c.nodeIndices[v], c.nodeWeights[v]});
        for (int k = 0; k < 4; ++k) to.nodes[k] = uint16_t(to.nodes[k] - x.firstNode);
    }
    return out;
}

void shareFaceNodes(ExpressionData& x) {
    x.firstNode = 0;
    x.vertices.clear(), x.poseIndices.clear(), x.poseWeights.clear();
}

Status checkFaceNodes(const ExpressionData& x, const PoseCorrectiveData& c) {
    const size_t count = x.vertices.size();
    if (x.poseIndices.size() != count || x.poseWeights.size() != count || (x.firstNode == 0) != (count == 0) || x.firstNode > c.nodeCount)
        return fail(Code::CorruptData, "the nodes of the face do not fit {} vertices and {} nodes", count, c.nodeCount);
    if (x.firstNode == 0) return {};
    std::vector<uint8_t> standsAlone(c.nodeCount - x.firstNode, 0);
    size_t next = 0;
    for (uint32_t v = 0; v < c.nodeIndices.size(); ++v) {
        const bool own = next < count && x.vertices[next] == v;
        for (int k = 0; k < 4; ++k) {
            if ((c.nodeIndices[v][k] >= x.firstNode) != own)
                return fail(Code::CorruptData, "vertex {} is on node {}, which {}", v, c.nodeIndices[v][k],
                            own ? "is none of the face" : "is one of the face");
            if (own && (x.poseIndices[next][k] >= x.firstNode))
                return fail(Code::CorruptData, "vertex {} was on node {} of {}", v, x.poseIndices[next][k], x.firstNode);
        }
        if (own && c.nodeWeights[v] == kAlone) standsAlone[c.nodeIndices[v][0] - x.firstNode] = 1;
        next += own;
    }
    if (next != count) return fail(Code::CorruptData, "the vertices of the face are out of order");
    if (std::find(standsAlone.begin(), standsAlone.end(), 0) != standsAlone.end())
        return fail(Code::CorruptData, "a control node of the face has no vertex of its own");
    for (const uint16_t node : x.nodes)
        if (node < x.firstNode) return fail(Code::CorruptData, "expressions move control node {}, which is none of the face", node);
    return {};
}

FaceStreams<std::vector<uint8_t>> encodeFace(const ExpressionData& x, const PoseCorrectiveData& c) {
    FaceStreams<std::vector<uint8_t>> out;
    for (size_t s = 0; s < x.shapes.size(); ++s) {
        const float range = rangeOf(x, s);
        put(out.counts, x.ends[s] - x.begin(s)), put(out.ranges, range);
        for (uint32_t e = x.begin(s); e < x.ends[s]; ++e) {
            put(out.nodes, uint16_t(x.nodes[e] - x.firstNode));
            putOffset(out.offsets, x.offsetsM[e], range);
        }
    }
    for (const FaceVertex& v : faceVertices(x, c)) {
        if (v.weights == kAlone)
            put(out.alone, v.vertex), put(out.aloneNodes, v.nodes[0]);
        else
            put(out.vertices, v.vertex), put(out.nodeIndices, v.nodes), put(out.nodeWeights, v.weights);
    }
    return out;
}

Status decodeFace(const FaceStreams<std::span<const uint8_t>>& in, std::vector<uint8_t> shapes, uint32_t nodeCount, AvatarData& avatar) {
    const size_t entries = in.nodes.size() / sizeof(uint16_t);
    if (in.counts.size() != shapes.size() * sizeof(uint32_t) || in.ranges.size() != shapes.size() * sizeof(float) ||
        in.nodes.size() != entries * sizeof(uint16_t))
        return fail(Code::CorruptData, "the streams of the expressions do not hold {} shapes and {} entries", shapes.size(), entries);
    ExpressionData x;
    std::vector<uint32_t> counts;
    std::vector<float> ranges;
    fill(counts, in.counts), fill(ranges, in.ranges), fill(x.nodes, in.nodes);
    std::span<const uint8_t> left = in.offsets;
    uint64_t end = 0;
    for (size_t s = 0; s < shapes.size(); ++s) {
        const char* name = kExpressionNames[shapes[s]];
        const uint64_t bytes = uint64_t(counts[s]) * (isByteShape(ranges[s]) ? 3 : 6);
        if (counts[s] > entries - end || bytes > left.size())
            return fail(Code::CorruptData, "expression '{}' has {} entries, {} are left", name, counts[s], entries - end);
        if (!(ranges[s] >= 0 && ranges[s] <= kMostExpressionM))  // not for NaN either
            return fail(Code::CorruptData, "expression '{}' moves by {} m, at most {} are possible", name, ranges[s], kMostExpressionM);
        for (uint32_t e = 0; e < counts[s]; ++e) x.offsetsM.push_back(offsetAt(left, e, ranges[s]));
        left = left.subspan(size_t(bytes)), end += counts[s];
        x.ends.push_back(uint32_t(end));
    }
    if (end != entries || !left.empty()) return fail(Code::CorruptData, "{} entries of expressions belong to no shape", entries - end);
    x.shapes = std::move(shapes);
    DPL_TRY(const std::vector<FaceVertex> vertices, verticesOf(in));
    DPL_RETURN_IF_ERROR(bindToFace(vertices, nodeCount, avatar.mesh.restPositions.size(), avatar.correctives, x));
    for (uint16_t& node : x.nodes) {
        if (node >= nodeCount) return fail(Code::CorruptData, "expressions move control node {} of {}", node, nodeCount);
        node = uint16_t(node + x.firstNode);
    }
    avatar.expressions = std::move(x);
    return {};
}

}  // namespace dpl
