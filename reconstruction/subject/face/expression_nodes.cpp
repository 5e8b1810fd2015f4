// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/face/expression_nodes.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/subject/shape/surface_graph.h"
#include "sdk/format/correctives.h"
#include "sdk/format/expressions.h"
#include "sdk/format/face_nodes.h"
#include "sdk/format/skin_weights.h"

namespace dpl {
namespace {

/** V: whether a shape moves the vertex. */
std::vector<uint8_t> movedBy(std::span<const ExpressionShape> shapes, size_t vertexCount) {
    std::vector<uint8_t> moved(vertexCount, 0);
    for (const ExpressionShape& shape : shapes)
        for (size_t v = 0; v < vertexCount; ++v) moved[v] |= uint8_t(glm::length(shape.offsetsM[v]) >= kLeastExpressionM);
    return moved;
}

/** The places of the graph at which nodes stand: the farthest from all others first, until every moved place is near one. */
std::vector<uint32_t> chooseNodes(const SurfaceGraph& graph, const std::vector<uint8_t>& movedPlace) {
    std::vector<float> nearest(movedPlace.size());
    for (size_t p = 0; p < nearest.size(); ++p) nearest[p] = movedPlace[p] ? 1e30f : 0;
    std::vector<uint32_t> nodes;
    std::map<uint32_t, float> settled;
    while (true) {
        const auto farthest = std::max_element(nearest.begin(), nearest.end());
        if (farthest == nearest.end() || *farthest <= kExpressionNodeSpacingM) return nodes;
        nodes.push_back(uint32_t(farthest - nearest.begin()));
        graph.search(nodes.back(), settled, [&](uint32_t place, float distance) {
            if (distance >= nearest[place]) return false;
            nearest[place] = distance;
            return true;
        });
    }
}

/** What the shapes want of each place, and how far its nodes leave it from that. */
class PlaceErrors {
public:
    PlaceErrors(std::span<const ExpressionShape> shapes, const std::vector<uint32_t>& vertexAt, const std::vector<uint8_t>& movedPlace)
        : shapes_(shapes), vertexAt_(vertexAt), movedPlace_(movedPlace) {}

    Vec3f wanted(const ExpressionShape& shape, uint32_t place) const {
        const Vec3f offset = shape.offsetsM[vertexAt_[place]];
        return glm::length(offset) < kLeastExpressionM ? Vec3f(0) : offset;
    }
    std::vector<float> of(std::span<const uint32_t> nodes, std::span<const PackedWeights> bound) const {
        std::vector<float> off(movedPlace_.size(), 0);
        for (const ExpressionShape& shape : shapes_)
            for (uint32_t p = 0; p < off.size(); ++p) {
                if (!movedPlace_[p]) continue;
                Vec3f sum(0);
                for (int k = 0; k < 4; ++k)
                    if (bound[p].weights[k]) sum += float(bound[p].weights[k]) / 255.0f * wanted(shape, nodes[bound[p].joints[k]]);
                off[p] = std::max(off[p], glm::length(sum - wanted(shape, p)));
            }
        return off;
    }

private:
    std::span<const ExpressionShape> shapes_;
    const std::vector<uint32_t>& vertexAt_;
    const std::vector<uint8_t>& movedPlace_;
};

/** Places that are off by too much, and by more than their neighbours are. */
std::vector<uint32_t> worstPlaces(const SurfaceGraph& graph, const std::vector<float>& off) {
    std::vector<uint32_t> worst;
    for (uint32_t p = 0; p < off.size(); ++p) {
        const auto worse = [&](const std::pair<uint32_t, float>& to) { return std::pair(off[to.first], to.first) > std::pair(off[p], p); };
        if (off[p] > kExpressionOffM && std::none_of(graph.neighbours[p].begin(), graph.neighbours[p].end(), worse)) worst.push_back(p);
    }
    return worst;
}

/** For each moved place up to four nodes: at a node that one alone, else by weights ((1 − d/d₅)/d)², which are exact at nodes. */
std::vector<PackedWeights> bindPlaces(const SurfaceGraph& graph, std::span<const uint32_t> nodes) {
    std::vector<std::vector<std::pair<float, uint32_t>>> near(graph.neighbours.size());
    std::map<uint32_t, float> settled;
    for (uint32_t n = 0; n < nodes.size(); ++n)
        graph.search(nodes[n], settled, [&](uint32_t place, float distance) {
            if (distance > 4 * kExpressionNodeSpacingM) return false;
            near[place].emplace_back(distance, n);
            return true;
        });
    std::vector<PackedWeights> packed(near.size());
    for (size_t p = 0; p < near.size(); ++p) {
        std::sort(near[p].begin(), near[p].end());
        const size_t count = std::min<size_t>(4, near[p].size());
        if (count == 0) continue;
        const float reach = near[p].size() > 4 ? near[p][4].first : 1.5f * near[p][count - 1].first + 1e-6f;
        std::vector<std::pair<uint32_t, float>> weights;
        for (size_t i = 0; i < count; ++i) {
            const auto [distance, node] = near[p][i];
            const float w = std::max(0.0f, 1 - distance / reach) / std::max(distance, 1e-7f);
            weights.emplace_back(node, w * w + 1e-6f);
            if (distance < 1e-7f) break;
        }
        packed[p] = packWeights(weights);
    }
    return packed;
}

/** Largest change of an offset at a vertex of the face by a pose corrective, at coefficients of `reach`. */
float correctivesOffM(const PoseCorrectiveData& before, const PoseCorrectiveData& after, std::span<const uint32_t> vertices) {
    const auto offsetAt = [](const PoseCorrectiveData& c, uint32_t v, uint32_t column) {
        Vec3f sum(0);
        for (int k = 0; k < 4; ++k)
            sum += float(c.nodeWeights[v][k]) / 255.0f * Vec3f(c.nodes[size_t(c.nodeIndices[v][k]) * c.columnCount() + column]);
        return sum;
    };
    float off = 0;
    for (const uint32_t v : vertices)
        for (uint32_t column = 0; column < after.columnCount(); ++column)
            off = std::max(off, after.reach * glm::length(offsetAt(after, v, column) - offsetAt(before, v, column)));
    return off;
}

}  // namespace

Result<ExpressionNodesReport> addExpressions(AvatarData& avatar, std::span<const ExpressionShape> shapes) {
    const MeshData& mesh = avatar.mesh;
    const size_t vertexCount = mesh.restPositions.size();
    if (!avatar.expressions.empty()) return fail(Code::InvalidArgument, "the avatar has expressions already");
    for (const ExpressionShape& shape : shapes)
        if (shape.offsetsM.size() != vertexCount)
            return fail(Code::InvalidArgument, "an expression has {} offsets for {} vertices", shape.offsetsM.size(), vertexCount);
    const std::vector<uint8_t> moved = movedBy(shapes, vertexCount);
    std::vector<Triangle> touched;
    for (const Triangle& t : mesh.triangles)
        if (moved[t.x] || moved[t.y] || moved[t.z]) touched.push_back(t);
    const SurfaceGraph graph(mesh.restPositions, touched);
    std::vector<uint8_t> movedPlace(graph.neighbours.size(), 0);
    std::vector<uint32_t> vertexAt(graph.neighbours.size(), 0);
    for (size_t v = vertexCount; v-- > 0;) movedPlace[graph.mergedOf[v]] |= moved[v], vertexAt[graph.mergedOf[v]] = uint32_t(v);
    const PlaceErrors errors(shapes, vertexAt, movedPlace);
    std::vector<uint32_t> nodes = chooseNodes(graph, movedPlace);
    std::vector<PackedWeights> bound = bindPlaces(graph, nodes);
    std::vector<float> off = errors.of(nodes, bound);
    for (std::vector<uint32_t> more; !(more = worstPlaces(graph, off)).empty();) {
        nodes.insert(nodes.end(), more.begin(), more.end());
        bound = bindPlaces(graph, nodes);
        off = errors.of(nodes, bound);
    }

    ExpressionNodesReport report{.nodes = uint32_t(nodes.size())};
    if (nodes.empty()) return report;
    PoseCorrectiveData& c = avatar.correctives;
    ExpressionData& x = avatar.expressions;
    const PoseCorrectiveData before = c;
    std::vector<FaceVertex> vertices;
    for (uint32_t v = 0; v < vertexCount; ++v) {
        if (!movedPlace[graph.mergedOf[v]]) continue;
        const PackedWeights& to = bound[graph.mergedOf[v]];
        FaceVertex& made = vertices.emplace_back(FaceVertex{v, glm::u16vec4(0), to.weights});
        for (int k = 0; k < 4; ++k) made.nodes[k] = to.weights[k] == 0 ? uint16_t(0) : uint16_t(to.joints[k]);
    }
    if (const Status fits = bindToFace(vertices, uint32_t(nodes.size()), vertexCount, c, x); !fits)
        return fail(Code::InvalidArgument, "{}", fits.error().message);
    const uint32_t first = x.firstNode;
    report.correctivesOffM = correctivesOffM(before, c, x.vertices);

    std::vector<Vec3f> nodeOffset(nodes.size());
    for (const ExpressionShape& shape : shapes) {
        for (size_t n = 0; n < nodes.size(); ++n) {
            nodeOffset[n] = errors.wanted(shape, nodes[n]);
            if (nodeOffset[n] != Vec3f(0)) x.nodes.push_back(uint16_t(first + n)), x.offsetsM.push_back(nodeOffset[n]);
        }
        if (x.nodes.size() == x.begin(x.shapes.size())) continue;  // it moves nothing
        x.shapes.push_back(shape.expression), x.ends.push_back(uint32_t(x.nodes.size()));
        for (size_t v = 0; v < vertexCount; ++v) {
            if (!movedPlace[graph.mergedOf[v]]) continue;
            Vec3f sum(0);
            for (int k = 0; k < 4; ++k)
                if (c.nodeWeights[v][k]) sum += float(c.nodeWeights[v][k]) / 255.0f * nodeOffset[c.nodeIndices[v][k] - first];
            report.shapesOffM = std::max(report.shapesOffM, glm::length(sum - shape.offsetsM[v]));
        }
    }
    report.entries = uint32_t(x.nodes.size());
    if (const Status fits = checkExpressions(x, c); !fits) return fail(Code::InvalidArgument, "{}", fits.error().message);
    return report;
}

}  // namespace dpl
