// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/garments/tuck_body.h"

#include <algorithm>
#include <utility>

#include "reconstruction/subject/garments/priors.h"
#include "reconstruction/subject/shape/closest_surface.h"
#include "reconstruction/subject/shape/implicit_mesh.h"
#include "reconstruction/subject/surface/clothed_layers.h"
#include "sdk/avatar/posed_mesh.h"
#include "sdk/math/merge_vertices.h"

namespace dpl {
namespace {

constexpr float kLeastM = 0.001f;  // shorter moves change nothing that one sees
constexpr float kReachM = 0.05f;   // a vertex deeper in the body than this has met another limb
constexpr int kRounds = 3;         // the body's closest point changes with the body
constexpr int kFadeRings = 4;      // of triangles, over which neighbours follow and the border to seen skin fades

/** Rings of triangles from each vertex of the body to seen skin: 0 on it, at most kFadeRings. */
std::vector<int> ringsFromSeen(std::span<const Triangle> body, std::span<const uint8_t> seen,
                               const std::vector<std::vector<uint32_t>>& neighbours) {
    std::vector<int> rings(neighbours.size(), kFadeRings);
    std::vector<uint32_t> front;
    for (size_t t = 0; t < body.size(); ++t)
        for (int c = 0; c < 3 && seen[t]; ++c)
            if (std::exchange(rings[body[t][c]], 0) != 0) front.push_back(body[t][c]);
    for (int ring = 1; ring < kFadeRings; ++ring) {
        std::vector<uint32_t> next;
        for (const uint32_t v : front)
            for (const uint32_t n : neighbours[v])
                if (rings[n] > ring) rings[n] = ring, next.push_back(n);
        front = std::move(next);
    }
    return rings;
}

/** For each place of the body, how deep garments lie below it in its worst pose, with clearance; 0 where none does. placeOf: of vertices.
 */
std::vector<float> worstDepths(const AvatarData& avatar, std::span<const uint32_t> placeOf, uint32_t placeCount,
                               std::span<const Pose> poses, Jobs& jobs) {
    const LayerData& layer = *bodyLayer(avatar.mesh);
    const std::span<const Triangle> body = std::span(avatar.mesh.triangles).subspan(layer.firstTriangle, layer.triangleCount);
    const std::vector<uint32_t> garments = garmentVertices(avatar.mesh);
    const std::vector<RestTriangle<float>> bind = restTriangles(avatar.mesh);
    std::vector<float> worst(placeCount, 0.0f);
    PosedMesh posed;
    ClosestSurface surface(avatar.mesh.restPositions, body);
    std::vector<SurfacePoint> sunk(garments.size());
    for (const Pose& pose : poses) {
        posed.pose({avatar.joints, avatar.mesh, avatar.correctives, bind}, pose, jobs);
        surface.move(posed.positions());
        jobs.forRange(garments.size(), 256, [&](size_t begin, size_t end, uint32_t) {
            for (size_t i = begin; i < end; ++i) {
                const Vec3f& p = posed.positions()[garments[i]];
                sunk[i] = surface.find(p, kReachM);
                if (sunk[i].found() && !surface.isInside(p, sunk[i])) sunk[i] = {};
            }
        });
        for (const SurfacePoint& point : sunk)
            for (int c = 0; c < 3 && point.found(); ++c) {
                float& depth = worst[placeOf[body[point.triangle][c]]];
                depth = std::max(depth, point.distanceM + priors::kClothClearanceM);
            }
    }
    return worst;
}

/** How far each vertex may move inwards: at most priors::kTuckM, fading towards seen skin, and at most half way to the middle of a thin
 * part such as a toe, which would turn inside out. */
std::vector<float> limits(std::span<const Vec3f> at, std::span<const Triangle> body, std::span<const Vec3f> normals,
                          std::span<const int> rings) {
    const ClosestSurface surface(at, body);
    std::vector<float> limit(at.size());
    for (size_t v = 0; v < at.size(); ++v) {
        limit[v] = priors::kTuckM * float(rings[v]) / float(kFadeRings);
        // Twice as deep, the closest skin is still the vertex's own unless the part is thin.
        while (limit[v] > kLeastM && surface.signedDistance(at[v] - 2 * limit[v] * normals[v], priors::kTuckM * 2) > -1.6f * limit[v])
            limit[v] /= 2;
        if (limit[v] <= kLeastM) limit[v] = 0;
    }
    return limit;
}

/** Raises each value to the mean of its neighbours. */
void followNeighbours(std::vector<float>& values, const std::vector<std::vector<uint32_t>>& neighbours) {
    const std::vector<float> last = values;
    for (size_t v = 0; v < values.size(); ++v) {
        float mean = 0;
        for (const uint32_t n : neighbours[v]) mean += last[n] / float(neighbours[v].size());
        values[v] = std::max(values[v], mean);
    }
}

}  // namespace

size_t tuckBody(AvatarData& avatar, std::span<const uint8_t> seen, std::span<const Pose> poses, Jobs& jobs) {
    MeshData& mesh = avatar.mesh;
    const LayerData* layer = bodyLayer(mesh);
    if (!layer || garmentVertices(mesh).empty() || poses.empty()) return 0;
    // Vertices at one position move as one, or the skin would tear at seams.
    const auto [placeOf, placeCount] = mergeVertices(mesh.restPositions);
    const std::vector<Vec3f> before = mesh.restPositions;
    std::vector<Vec3f> atPlace(placeCount);
    for (size_t v = 0; v < before.size(); ++v) atPlace[placeOf[v]] = before[v];
    std::vector<Triangle> body;
    for (const Triangle& t : std::span(mesh.triangles).subspan(layer->firstTriangle, layer->triangleCount))
        body.push_back({placeOf[t.x], placeOf[t.y], placeOf[t.z]});
    const auto neighbours = vertexNeighbours(placeCount, body);
    const std::vector<int> rings = ringsFromSeen(body, seen.subspan(layer->firstTriangle, layer->triangleCount), neighbours);
    const std::vector<Vec3f> normals = vertexNormals(atPlace, body);
    const std::vector<float> limit = limits(atPlace, body, normals, rings);
    std::vector<float> tuck(placeCount, 0.0f);
    for (int round = 0; round < kRounds; ++round) {
        const std::vector<float> deeper = worstDepths(avatar, placeOf, placeCount, poses, jobs);
        for (size_t p = 0; p < placeCount; ++p) tuck[p] += deeper[p];
        for (int ring = 0; ring < kFadeRings; ++ring) followNeighbours(tuck, neighbours);
        for (size_t p = 0; p < placeCount; ++p) tuck[p] = std::min(tuck[p], limit[p]);
        for (size_t v = 0; v < before.size(); ++v) mesh.restPositions[v] = before[v] - tuck[placeOf[v]] * normals[placeOf[v]];
    }
    size_t moved = 0;
    for (const uint32_t place : placeOf) moved += tuck[place] > 0;
    return moved;
}

}  // namespace dpl
