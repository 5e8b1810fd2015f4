// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/garments/garment_pieces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <queue>

#include "reconstruction/subject/garments/cut_mesh.h"
#include "reconstruction/subject/shape/edge_uses.h"
#include "reconstruction/subject/shape/vertex_sets.h"
#include "sdk/core/result.h"

namespace dpl {
namespace {

constexpr uint8_t kOpen = 255;  // tag of triangles that have no label yet
constexpr float kDown = -0.3f;  // y of the normal where the hull turns from a hem's outside to its closed underside
// Above a skirt's underside is air up to the crotch; above an armpit, the crotch of trousers or a sole the body is near.
constexpr float kDeepAirM = 0.42f;
constexpr double kDeepShare = 0.15;  // of a patch's area with so much air: the patch is an underside
constexpr float kLeastAirM = 0.04f;  // above each vertex of it
constexpr float kAirStepM = 0.015f;
constexpr float kTouchM = 0.01f;   // distance at which the way up has met the body
constexpr double kOneSided = 0.8;  // length of the mean normal; 1: flat, 0.5: half a ball, 0: closed

/** The hull with a tag at each triangle: its column, or `columns` on the underside of hems. */
TaggedMesh cutLabels(const SurfaceMesh& hull, const LabelField& field, std::span<const float> underside) {
    const size_t labels = field.columns(), columns = labels + 1;
    TaggedMesh tagged{hull, columns, std::vector<float>(hull.positions.size() * columns),
                      std::vector<uint8_t>(hull.triangles.size(), kOpen)};
    for (size_t v = 0; v < hull.positions.size(); ++v) {
        std::copy_n(&field.score[v * labels], labels, &tagged.rows[v * columns]);
        tagged.rows[v * columns + labels] = underside[v];
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
    std::vector<std::vector<uint32_t>> along(mesh.positions.size());
    for (const auto& [edge, count] : edgeUses(mesh.triangles))
        if (count == 1) along[edge.first].push_back(edge.second), along[edge.second].push_back(edge.first);
    std::vector<std::array<uint32_t, 2>> out(mesh.positions.size(), {UINT32_MAX, UINT32_MAX});
    for (size_t v = 0; v < along.size(); ++v)
        if (along[v].size() == 2) out[v] = {along[v][0], along[v][1]};
    return out;
}

/** Moves inner vertices towards their neighbours' mean within their tangent planes, and border vertices along the border. */
void relax(SurfaceMesh& mesh, const std::vector<std::vector<uint32_t>>& neighbours, const std::vector<std::array<uint32_t, 2>>& border,
           const std::vector<uint8_t>& onBorder) {
    const std::vector<Vec3f> normals = vertexNormals(mesh.positions, mesh.triangles);
    std::vector<Vec3f> next = mesh.positions;
    for (size_t v = 0; v < next.size(); ++v) {
        if (neighbours[v].empty()) continue;
        if (onBorder[v]) {
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

/** Smooths borders along their length without shrinking them (Taubin 1995, λ|μ), and relaxes inner vertices within their tangent planes so
 *  that triangles are well shaped. */
void smoothPiece(SurfaceMesh& mesh, double lengthM) {
    const auto border = borderNeighbours(mesh);
    const auto neighbours = vertexNeighbours(mesh.positions.size(), mesh.triangles);
    std::vector<uint8_t> onBorder(mesh.positions.size(), 0);
    for (const auto& [edge, count] : edgeUses(mesh.triangles))
        if (count == 1) onBorder[edge.first] = onBorder[edge.second] = 1;
    double edge = 0, edges = 0;
    for (size_t v = 0; v < border.size(); ++v)
        if (border[v][0] != UINT32_MAX) edge += glm::length(mesh.positions[border[v][0]] - mesh.positions[v]), edges += 1;
    // n rounds of λ = 0.5 smooth over about √n edges.
    const double perEdge = edges > 0 && edge > 0 ? lengthM * edges / edge : 0;
    const int rounds = std::clamp(2 * int(std::ceil(perEdge * perEdge)), 10, 60);
    for (int round = 0; round < rounds; ++round) {
        for (const float step : {0.5f, -0.53f}) {
            std::vector<Vec3f> next = mesh.positions;
            for (size_t v = 0; v < border.size(); ++v)
                if (border[v][0] != UINT32_MAX)
                    next[v] += step * (0.5f * (mesh.positions[border[v][0]] + mesh.positions[border[v][1]]) - mesh.positions[v]);
            mesh.positions = std::move(next);
        }
        relax(mesh, neighbours, border, onBorder);
    }
}

/** Leaves out triangles of connected pieces below an area. Keeps all vertices. */
SurfaceMesh withoutSmallPieces(const SurfaceMesh& mesh, double minAreaM2) {
    VertexSets pieces(mesh.positions.size(), mesh.triangles);
    std::vector<double> area(mesh.positions.size(), 0);
    const auto areaOf = [&](const Triangle& t) {
        return 0.5 * glm::length(glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]));
    };
    for (const Triangle& t : mesh.triangles) area[pieces.find(t.x)] += areaOf(t);
    SurfaceMesh out{mesh.positions, {}};
    for (const Triangle& t : mesh.triangles)
        if (area[pieces.find(t.x)] >= minAreaM2) out.triangles.push_back(t);
    return out;
}

/** Closes border loops shorter than a length by a fan around their middle. */
void closeHoles(SurfaceMesh& mesh, double lengthM) {
    std::map<uint32_t, uint32_t> next;  // along the border, against the direction of its triangles
    std::map<std::pair<uint32_t, uint32_t>, int> uses;
    std::vector<uint8_t> branched(mesh.positions.size(), 0);  // borders meet here
    for (const Triangle& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) ++uses[std::pair(t[k], t[(k + 1) % 3])];
    for (const auto& [edge, count] : uses)
        if (!uses.contains({edge.second, edge.first}) && !next.emplace(edge.second, edge.first).second) branched[edge.second] = 1;
    std::vector<uint8_t> visited(mesh.positions.size(), 0);
    for (const auto& [seed, unused] : next) {
        std::vector<uint32_t> loop;
        double length = 0;
        bool simple = true;
        for (uint32_t v = seed; !visited[v] && simple;) {
            visited[v] = 1;
            loop.push_back(v);
            const auto to = next.find(v);
            simple = !branched[v] && to != next.end();
            if (!simple) break;
            length += glm::length(mesh.positions[to->second] - mesh.positions[v]);
            v = to->second;
        }
        if (!simple || loop.size() < 3 || length > lengthM || next.at(loop.back()) != seed) continue;
        Vec3f middle(0);
        for (uint32_t v : loop) middle += mesh.positions[v] / float(loop.size());
        const auto centre = uint32_t(mesh.positions.size());
        mesh.positions.push_back(middle);
        for (size_t i = 0; i < loop.size(); ++i) mesh.triangles.push_back({loop[i], loop[(i + 1) % loop.size()], centre});
    }
}

/** The parts of the hull that belong to garment `column`, and the strip below its neighbours. */
SurfaceMesh takePiece(const TaggedMesh& labelled, uint32_t column, uint32_t none, double minAreaM2, const PieceOptions& options) {
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
    piece = withoutSmallPieces(piece, minAreaM2);
    const std::vector<Vec3f> normals = vertexNormals(strip.mesh.positions, strip.mesh.triangles);
    std::vector<uint32_t> oldIndex;
    piece = withoutUnused(piece, &oldIndex);
    closeHoles(piece, std::numbers::pi * options.holeM);
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

std::vector<float> hemUndersides(const SurfaceMesh& hull, const LabelField& field, const ScalarField& hullField,
                                 const ClosestSurface& bodySurface) {
    const std::vector<Vec3f> normals = vertexNormals(hull.positions, hull.triangles);
    const auto neighbours = vertexNeighbours(hull.positions.size(), hull.triangles);
    const std::vector<float> areas = vertexAreas(hull);
    /** Height of the air above a vertex: inside the hull, and not near the body. */
    const auto airAbove = [&](size_t v) {
        float height = 0;
        while (height < kDeepAirM) {
            const Vec3f above = hull.positions[v] + Vec3f(0, height + kAirStepM, 0);
            if (hullField(above) > 0 || bodySurface.find(above, kTouchM).found()) break;
            height += kAirStepM;
        }
        return height;
    };
    std::vector<float> air(hull.positions.size(), 0), score(hull.positions.size(), 0);
    for (size_t v = 0; v < air.size(); ++v)
        if (normals[v].y < 0) air[v] = airAbove(v);
    std::vector<uint8_t> visited(air.size(), 0);
    for (uint32_t seed = 0; seed < air.size(); ++seed) {
        if (visited[seed] || air[seed] < kLeastAirM) continue;
        std::vector<uint32_t> patch{seed};
        visited[seed] = 1;
        double area = 0, deep = 0;
        std::vector<size_t> around(field.columns(), 0);  // edges to vertices of each label
        for (size_t i = 0; i < patch.size(); ++i) {
            area += areas[patch[i]];
            if (air[patch[i]] >= kDeepAirM) deep += areas[patch[i]];
            for (uint32_t n : neighbours[patch[i]]) {
                if (air[n] < kLeastAirM) ++around[field.best(n)];
                if (!visited[n] && air[n] >= kLeastAirM) visited[n] = 1, patch.push_back(n);
            }
        }
        // A ledge from a shirt's hem to trousers is not open: the trousers go on there.
        std::vector<size_t> clothes(around.begin() + 1, around.end());
        std::sort(clothes.begin(), clothes.end(), std::greater<>());
        const bool ledge = clothes.size() > 1 && clothes[1] * 4 > clothes[0];
        if (deep < kDeepShare * area || ledge) continue;
        for (uint32_t v : patch) score[v] = normals[v].y / kDown;
    }
    return score;
}

GarmentPieces takeGarments(const SurfaceMesh& hull, LabelField field, std::span<const float> underside, const PieceOptions& options) {
    const std::vector<float> areas = vertexAreas(hull);
    const double total = std::accumulate(areas.begin(), areas.end(), 0.0);
    const size_t columns = field.columns();
    std::vector<double> voted(columns, 0);
    for (size_t v = 0; v < areas.size(); ++v) voted[field.best(v)] += areas[v];
    std::vector<double> minArea(columns, options.minPieceShare * total);
    minArea[0] = 0.25 * std::numbers::pi * options.holeM * options.holeM;
    removeIslands(hull, field, minArea);
    TaggedMesh labelled = cutLabels(hull, field, underside);

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
        labelled = cutLabels(hull, field, underside);
    }
    for (GarmentDecision& decision : out.decisions) {
        if (!decision.kept) continue;
        const auto column = uint32_t(&decision - out.decisions.data()) + 1;
        GarmentPiece piece{column, takePiece(labelled, column, uint32_t(columns), minArea[column], options)};
        decision.areaM2 = extentOf(labelled, column).areaM2;
        decision.triangles = uint32_t(piece.mesh.triangles.size());
        decision.reason = formatText("{} triangles, {} m²", decision.triangles, std::round(100 * decision.areaM2) / 100);
        out.pieces.push_back(std::move(piece));
    }
    return out;
}

}  // namespace dpl
