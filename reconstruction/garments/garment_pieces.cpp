// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/garments/garment_pieces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <queue>

#include "reconstruction/garments/cut_mesh.h"
#include "sdk/core/result.h"

namespace dpl {
namespace {

constexpr uint8_t kOpen = 255;     // tag of triangles that have no label yet
constexpr float kUnseen = 0.04f;   // LabelField::seen below this: no picture saw the vertex
constexpr float kDown = -0.35f;    // y of the normal of an underside
constexpr double kOneSided = 0.8;  // length of the mean normal; 1: flat, 0.5: half a ball, 0: closed

/** Vertices on the unseen underside of hems: patches that face down, were not seen, and touch both the body's label and another. */
std::vector<uint8_t> hemUndersides(const SurfaceMesh& hull, const LabelField& field) {
    const std::vector<Vec3f> normals = vertexNormals(hull.positions, hull.triangles);
    const auto neighbours = vertexNeighbours(hull.positions.size(), hull.triangles);
    std::vector<uint8_t> candidate(hull.positions.size()), underside(hull.positions.size(), 0), visited(hull.positions.size(), 0);
    for (size_t v = 0; v < candidate.size(); ++v) candidate[v] = field.seen[v] < kUnseen && normals[v].y < kDown;
    for (uint32_t seed = 0; seed < candidate.size(); ++seed) {
        if (!candidate[seed] || visited[seed]) continue;
        std::vector<uint32_t> patch{seed};
        std::vector<uint8_t> touches(field.columns(), 0);
        visited[seed] = 1;
        for (size_t i = 0; i < patch.size(); ++i)
            for (uint32_t n : neighbours[patch[i]]) {
                if (!candidate[n])
                    touches[field.best(n)] = 1;
                else if (!visited[n])
                    visited[n] = 1, patch.push_back(n);
            }
        if (std::count(touches.begin(), touches.end(), 1) < 2) continue;
        for (uint32_t v : patch) underside[v] = 1;
    }
    return underside;
}

/** The hull with a tag at each triangle: its column, or `columns` on the underside of hems. */
TaggedMesh cutLabels(const SurfaceMesh& hull, const LabelField& field) {
    const size_t labels = field.columns(), columns = labels + 1;
    const std::vector<uint8_t> underside = hemUndersides(hull, field);
    TaggedMesh tagged{hull, columns, std::vector<float>(hull.positions.size() * columns),
                      std::vector<uint8_t>(hull.triangles.size(), kOpen)};
    for (size_t v = 0; v < hull.positions.size(); ++v) {
        std::copy_n(&field.score[v * labels], labels, &tagged.rows[v * columns]);
        tagged.rows[v * columns + labels] = underside[v] ? 2.0f : 0.0f;
    }
    for (size_t column = columns; column-- > 1;) {  // the underside first; what remains at the end is the body's
        std::vector<float> value(tagged.mesh.positions.size());
        for (size_t v = 0; v < value.size(); ++v) {
            const float* row = &tagged.rows[v * columns];
            value[v] = row[column] - *std::max_element(row, row + column);
        }
        cutAtZero(tagged, std::move(value), kOpen, uint8_t(column));
    }
    for (uint8_t& tag : tagged.tags)
        if (tag == kOpen) tag = 0;
    return tagged;
}

using EdgeMap = std::map<std::pair<uint32_t, uint32_t>, std::vector<uint32_t>>;

/** For each vertex the length of the shortest path along edges of triangles with `passable`, from vertices with `start`; at most reach. */
std::vector<float> pathLengths(const SurfaceMesh& mesh, const std::vector<uint8_t>& passable, const std::vector<uint8_t>& start,
                               float reach) {
    std::vector<std::vector<uint32_t>> trianglesOf(mesh.positions.size());
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t)
        for (int k = 0; k < 3 && passable[t]; ++k) trianglesOf[mesh.triangles[t][k]].push_back(t);
    std::vector<float> length(mesh.positions.size(), reach);
    using Entry = std::pair<float, uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    for (uint32_t v = 0; v < start.size(); ++v)
        if (start[v]) length[v] = 0, open.push({0.0f, v});
    while (!open.empty()) {
        const auto [at, v] = open.top();
        open.pop();
        if (at > length[v]) continue;
        for (uint32_t t : trianglesOf[v])
            for (int k = 0; k < 3; ++k) {
                const uint32_t n = mesh.triangles[t][k];
                const float next = at + glm::length(mesh.positions[n] - mesh.positions[v]);
                if (next < length[n]) length[n] = next, open.push({next, n});
            }
    }
    return length;
}

/** For each vertex its two neighbours along the border; UINT32_MAX for inner vertices and where borders meet. */
std::vector<std::array<uint32_t, 2>> borderNeighbours(const SurfaceMesh& mesh) {
    std::map<std::pair<uint32_t, uint32_t>, int> uses;
    for (const Triangle& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) {
            const uint32_t a = t[k], b = t[(k + 1) % 3];
            ++uses[{std::min(a, b), std::max(a, b)}];
        }
    std::vector<std::vector<uint32_t>> along(mesh.positions.size());
    for (const auto& [edge, count] : uses)
        if (count == 1) along[edge.first].push_back(edge.second), along[edge.second].push_back(edge.first);
    std::vector<std::array<uint32_t, 2>> out(mesh.positions.size(), {UINT32_MAX, UINT32_MAX});
    for (size_t v = 0; v < along.size(); ++v)
        if (along[v].size() == 2) out[v] = {along[v][0], along[v][1]};
    return out;
}

/** Smooths borders along their length without shrinking them (Taubin 1995, λ|μ), and relaxes inner vertices within their tangent planes so
 *  that triangles are well shaped. */
void smoothPiece(SurfaceMesh& mesh, double lengthM) {
    const auto border = borderNeighbours(mesh);
    const auto neighbours = vertexNeighbours(mesh.positions.size(), mesh.triangles);
    std::vector<uint8_t> onBorder(mesh.positions.size(), 0);
    {
        std::map<std::pair<uint32_t, uint32_t>, int> uses;
        for (const Triangle& t : mesh.triangles)
            for (int k = 0; k < 3; ++k) ++uses[std::minmax(t[k], t[(k + 1) % 3])];
        for (const auto& [edge, count] : uses)
            if (count == 1) onBorder[edge.first] = onBorder[edge.second] = 1;
    }
    double edge = 0, edges = 0;
    for (size_t v = 0; v < border.size(); ++v)
        if (border[v][0] != UINT32_MAX) edge += glm::length(mesh.positions[border[v][0]] - mesh.positions[v]), edges += 1;
    // n rounds of λ = 0.5 smooth over about √n edges.
    const double perEdge = edges > 0 && edge > 0 ? lengthM * edges / edge : 0;
    const int rounds = std::clamp(int(std::ceil(perEdge * perEdge)) * 2, 4, 60);
    for (int round = 0; round < rounds; ++round)
        for (const float step : {0.5f, -0.53f}) {
            std::vector<Vec3f> next = mesh.positions;
            for (size_t v = 0; v < border.size(); ++v)
                if (border[v][0] != UINT32_MAX)
                    next[v] += step * (0.5f * (mesh.positions[border[v][0]] + mesh.positions[border[v][1]]) - mesh.positions[v]);
            mesh.positions = std::move(next);
        }
    for (int round = 0; round < 10; ++round) {
        const std::vector<Vec3f> normals = vertexNormals(mesh.positions, mesh.triangles);
        std::vector<Vec3f> next = mesh.positions;
        for (size_t v = 0; v < next.size(); ++v) {
            if (neighbours[v].empty()) continue;
            if (onBorder[v]) {  // evenly spaced along the border
                if (border[v][0] == UINT32_MAX) continue;
                const Vec3f a = mesh.positions[border[v][0]], b = mesh.positions[border[v][1]], along = b - a;
                const float length2 = glm::dot(along, along);
                if (length2 > 0) next[v] += 0.5f * glm::dot(0.5f * (a + b) - mesh.positions[v], along) / length2 * along;
                continue;
            }
            Vec3f mean(0);
            for (uint32_t n : neighbours[v]) mean += mesh.positions[n] / float(neighbours[v].size());
            Vec3f move = mean - mesh.positions[v];
            move -= normals[v] * glm::dot(move, normals[v]);
            next[v] += 0.5f * move;
        }
        mesh.positions = std::move(next);
    }
}

/** The parts of the hull that belong to garment `column`, and the strip below its neighbours. */
SurfaceMesh takePiece(const TaggedMesh& labelled, uint32_t column, uint32_t none, const PieceOptions& options) {
    const SurfaceMesh& hull = labelled.mesh;
    std::vector<uint8_t> own(hull.positions.size(), 0), others(hull.triangles.size());
    for (size_t t = 0; t < hull.triangles.size(); ++t) {
        others[t] = labelled.tags[t] != 0 && labelled.tags[t] != none && labelled.tags[t] != column;
        for (int k = 0; k < 3 && labelled.tags[t] == column; ++k) own[hull.triangles[t][k]] = 1;
    }
    // The strip: other garments' triangles nearer than overlapM, cut at that distance.
    const auto overlap = float(options.overlapM);
    std::vector<float> beyond = pathLengths(hull, others, own, 4 * overlap);
    TaggedMesh strip{hull, 1, beyond, std::vector<uint8_t>(hull.triangles.size(), 0)};
    for (size_t t = 0; t < hull.triangles.size(); ++t) strip.tags[t] = labelled.tags[t] == column ? 1 : others[t] ? kOpen : 0;
    std::vector<float> value(beyond.size());
    for (size_t v = 0; v < value.size(); ++v) value[v] = overlap - beyond[v];
    cutAtZero(strip, std::move(value), kOpen, 1);
    SurfaceMesh piece{strip.mesh.positions, {}};
    for (size_t t = 0; t < strip.tags.size(); ++t)
        if (strip.tags[t] == 1) piece.triangles.push_back(strip.mesh.triangles[t]);
    const std::vector<Vec3f> normals = vertexNormals(strip.mesh.positions, strip.mesh.triangles);
    std::vector<uint32_t> oldIndex;
    piece = withoutUnused(piece, &oldIndex);
    smoothPiece(piece, options.hemSmoothingM);
    for (size_t v = 0; v < oldIndex.size(); ++v) {
        const float depth = std::clamp(strip.rows[oldIndex[v]] / overlap, 0.0f, 1.0f);
        piece.positions[v] -= float(options.tuckM) * depth * (2 - depth) * normals[oldIndex[v]];
    }
    return piece;
}

/** Area and mean normal (its length tells how much the piece closes around the body) of the triangles with a tag. */
struct TagExtent {
    double areaM2 = 0, oneSided = 0;
};

TagExtent extentOf(const TaggedMesh& labelled, uint32_t tag) {
    TagExtent extent;
    Vec3d sum(0);
    for (size_t t = 0; t < labelled.tags.size(); ++t) {
        if (labelled.tags[t] != tag) continue;
        const Triangle& tri = labelled.mesh.triangles[t];
        const Vec3d a(labelled.mesh.positions[tri.x]), b(labelled.mesh.positions[tri.y]), c(labelled.mesh.positions[tri.z]);
        const Vec3d n = 0.5 * glm::cross(b - a, c - a);
        sum += n, extent.areaM2 += glm::length(n);
    }
    if (extent.areaM2 > 0) extent.oneSided = glm::length(sum) / extent.areaM2;
    return extent;
}

}  // namespace

GarmentPieces takeGarments(const SurfaceMesh& hull, LabelField field, const PieceOptions& options) {
    const std::vector<float> areas = vertexAreas(hull);
    const double total = std::accumulate(areas.begin(), areas.end(), 0.0);
    const size_t columns = field.columns();
    std::vector<double> voted(columns, 0);
    for (size_t v = 0; v < areas.size(); ++v) voted[field.best(v)] += areas[v];
    std::vector<double> minArea(columns, options.minPieceShare * total);
    minArea[0] = 0.25 * std::numbers::pi * options.holeM * options.holeM;
    removeIslands(hull, field, minArea);
    TaggedMesh labelled = cutLabels(hull, field);

    GarmentPieces out;
    bool refused = false;
    for (uint32_t column = 1; column < columns; ++column) {
        GarmentDecision decision{field.labels[column], true, "", 0, 0};
        const std::string& name = decision.label.name;
        const TagExtent extent = extentOf(labelled, column);
        if (voted[column] <= 0)
            decision.kept = false, decision.reason = formatText("no picture shows the label {}", name);
        else if (extent.areaM2 < options.minPieceShare * total)
            decision.kept = false, decision.reason = formatText("the label {} covers {} % of the surface in pieces too small for a layer",
                                                                name, std::round(1e4 * voted[column] / total) / 100);
        else if (extent.oneSided > kOneSided)
            decision.kept = false,
            decision.reason = formatText("the label {} was seen on one side only, so the shape of its other side is not known", name);
        if (!decision.kept && extent.areaM2 > 0) minArea[column] = std::numeric_limits<double>::infinity(), refused = true;
        out.decisions.push_back(std::move(decision));
    }
    if (refused) {  // their surface goes to what is around them
        removeIslands(hull, field, minArea);
        labelled = cutLabels(hull, field);
    }
    for (GarmentDecision& decision : out.decisions) {
        if (!decision.kept) continue;
        const auto column = uint32_t(&decision - out.decisions.data()) + 1;
        GarmentPiece piece{column, takePiece(labelled, column, uint32_t(columns), options)};
        decision.areaM2 = extentOf(labelled, column).areaM2;
        decision.triangles = uint32_t(piece.mesh.triangles.size());
        decision.reason = formatText("{} triangles, {} m²", decision.triangles, std::round(100 * decision.areaM2) / 100);
        out.pieces.push_back(std::move(piece));
    }
    return out;
}

}  // namespace dpl
