// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/dress/body_change.h"

#include <algorithm>

#include "reconstruction/output/dress/seen_skin.h"
#include "reconstruction/output/dress/splat_fill.h"
#include "reconstruction/subject/garments/garment_cover.h"
#include "reconstruction/subject/surface/body_places.h"
#include "reconstruction/subject/surface/mesh_raster.h"
#include "reconstruction/subject/surface/orbit_camera.h"
#include "reconstruction/training/trainer/init.h"

namespace dpl {
namespace {

constexpr int kEdgeRings = 3;  // of seen skin beside clothes whose colour may be the clothes'

SurfaceMesh joined(std::span<const LayerPart> parts) {
    SurfaceMesh out;
    for (const LayerPart& part : parts) {
        const auto first = uint32_t(out.positions.size());
        out.positions.insert(out.positions.end(), part.mesh.restPositions.begin(), part.mesh.restPositions.end());
        for (const Triangle& t : part.mesh.triangles) out.triangles.push_back(t + first);
    }
    return out;
}

/** 1 for each triangle of the body that lies below one of the garments. */
Marks coveredBy(const MeshData& body, const std::vector<SurfaceMesh>& garments, Jobs& jobs) {
    const std::vector<GarmentCover> covers(garments.begin(), garments.end());
    const std::vector<Vec3f> normals = vertexNormals(body.restPositions, body.triangles), middles = restMiddles(body);
    Marks covered(body.triangles.size(), 0);
    jobs.forRange(covered.size(), 1024, [&](size_t begin, size_t end, uint32_t) {
        for (size_t t = begin; t < end; ++t) {
            const Triangle& c = body.triangles[t];
            const Vec3f normal = glm::normalize(normals[c.x] + normals[c.y] + normals[c.z] + Vec3f(1e-12f));
            for (const GarmentCover& cover : covers) covered[t] |= cover.heightOf(middles[t], normal).has_value();
        }
    });
    return covered;
}

}  // namespace

BodyChange changeBody(const AvatarData& before, size_t kept, std::span<LayerPart> worn, Jobs& jobs) {
    LayerPart& body = worn.front();
    const size_t count = body.mesh.triangles.size();
    const Neighbours neighbours = triangleNeighbours(body.mesh);
    std::vector<SurfaceMesh> oldClothes, keptClothes, newClothes;
    std::vector<LayerPart> takenOff;
    for (size_t layer = 1; layer < before.mesh.layers.size(); ++layer) {
        LayerPart part = takeLayer(before, layer);
        oldClothes.push_back(part.surface());
        const auto stays = [&](const LayerPart& other) { return other.name == part.name; };
        if (std::none_of(worn.begin() + 1, worn.begin() + long(kept), stays)) takenOff.push_back(std::move(part));
    }
    for (size_t i = 1; i < worn.size(); ++i) (i < kept ? keptClothes : newClothes).push_back(worn[i].surface());
    const Marks belowOld = coveredBy(body.mesh, oldClothes, jobs), belowKept = coveredBy(body.mesh, keptClothes, jobs),
                belowNew = coveredBy(body.mesh, newClothes, jobs);
    Marks belowAny = belowKept;
    for (size_t t = 0; t < count; ++t) belowAny[t] |= belowNew[t];
    const Marks seenBefore = shownTriangles({before.mesh.restPositions, before.mesh.triangles}, body.mesh, belowOld, jobs);
    BodyChange change;
    change.shown = shownTriangles(joined(worn), body.mesh, belowAny, jobs);
    const Marks seenNow(change.shown.begin(), change.shown.begin() + long(count));
    Marks hidden(count), changed(count);
    for (size_t t = 0; t < count; ++t) {
        hidden[t] = belowOld[t] || !seenBefore[t];
        changed[t] = !belowKept[t] && (belowOld[t] || belowNew[t] || (seenNow[t] && !seenBefore[t]));
    }

    const Marks shown = grown(seenNow, neighbours, kRingsBelowClothes);
    const Marks near = grown(std::move(changed), neighbours, kRingsBelowClothes);
    const Marks distrusted = grown(hidden, neighbours, kEdgeRings);
    const std::vector<Vec3f> around = coloursAround(body, distrusted, neighbours);
    // What pictures saw stays, but for skin beside the old clothes that has taken their colour, and never in the face.
    const Marks captured = capturedTriangles(before.captureMap, body.mesh), face = faceTriangles(before.joints, body.mesh);
    Marks edge(count);
    for (size_t t = 0; t < count; ++t) edge[t] = distrusted[t] && seenBefore[t] && (belowOld[t] || !face[t]);
    const Marks stained = clothColoured(body, edge, around, takenOff);
    Marks fill(count, 0), empty(count, 0);
    for (size_t t = 0; t < count; ++t) {
        const bool photographed = seenBefore[t] && captured[t] && body.splats.triangleStart[t] != body.splats.triangleStart[t + 1];
        const bool keeps = !distrusted[t] || (photographed && !stained[t]);
        if (belowKept[t] || !near[t] || (shown[t] && keeps)) continue;
        (shown[t] ? fill : empty)[t] = 1;
        change.clearedTriangles += !shown[t] && body.splats.triangleStart[t] != body.splats.triangleStart[t + 1];
    }
    change.filledTriangles = fillSplats(fill, empty, distrusted, around, body);
    change.noSkin = change.filledTriangles == 0 && std::find(fill.begin(), fill.end(), 1) != fill.end();
    return change;
}

}  // namespace dpl
