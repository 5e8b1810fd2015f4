// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/dress/body_change.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "reconstruction/output/dress/splat_fill.h"
#include "reconstruction/subject/garments/garment_cover.h"
#include "reconstruction/subject/surface/mesh_raster.h"
#include "reconstruction/subject/surface/orbit_camera.h"
#include "reconstruction/training/trainer/init.h"

namespace dpl {
namespace {

constexpr uint32_t kSidePx = 640;
constexpr uint32_t kAzimuths = 12;
constexpr double kElevations[] = {-0.5, 0, 0.7};  // from below too: legs inside a skirt
constexpr int kEdgeRings = 3;                     // of seen skin beside clothes whose colour may be the clothes'

/** 1 for each triangle of the body, the mesh's first ones, that shows from some side at rest. The views depend on the body alone. */
Marks seenTriangles(const SurfaceMesh& mesh, const MeshData& body, Jobs& jobs) {
    const size_t bodyTriangles = body.triangles.size();
    Vec3f low(1e30f), high(-1e30f);
    for (const Vec3f& p : body.restPositions) low = glm::min(low, p), high = glm::max(high, p);
    constexpr size_t kViews = kAzimuths * std::size(kElevations);
    std::vector<Marks> ofView(kViews, Marks(bodyTriangles, 0));
    jobs.forBlocks(kViews, [&](size_t view, uint32_t) {
        const double azimuth = 2 * std::numbers::pi * double(view % kAzimuths) / kAzimuths;
        const Camerad camera = orbitBox(low, high, azimuth, kElevations[view / kAzimuths], kSidePx);
        for (const uint32_t t : rasteriseMesh(mesh.positions, mesh.triangles, camera).triangle)
            if (t < bodyTriangles) ofView[view][t] = 1;
    });
    Marks seen(bodyTriangles, 0);
    for (const Marks& view : ofView)
        for (size_t t = 0; t < bodyTriangles; ++t) seen[t] |= view[t];
    return seen;
}

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
    const std::vector<Vec3f> normals = vertexNormals(body.restPositions, body.triangles);
    Marks covered(body.triangles.size(), 0);
    jobs.forRange(covered.size(), 1024, [&](size_t begin, size_t end, uint32_t) {
        for (size_t t = begin; t < end; ++t) {
            const Triangle& c = body.triangles[t];
            const Vec3f centre = (body.restPositions[c.x] + body.restPositions[c.y] + body.restPositions[c.z]) / 3.0f;
            const Vec3f normal = glm::normalize(normals[c.x] + normals[c.y] + normals[c.z] + Vec3f(1e-12f));
            for (const GarmentCover& cover : covers) covered[t] |= cover.heightOf(centre, normal).has_value();
        }
    });
    return covered;
}

Marks grown(Marks marked, const Neighbours& neighbours, int rings) {
    for (int ring = 0; ring < rings; ++ring) {
        Marks next = marked;
        for (size_t t = 0; t < marked.size(); ++t)
            if (marked[t])
                for (const uint32_t other : neighbours[t]) next[other] = 1;
        marked = std::move(next);
    }
    return marked;
}

}  // namespace

BodyChange changeBody(const AvatarData& before, size_t kept, std::span<LayerPart> worn, Jobs& jobs) {
    LayerPart& body = worn.front();
    const size_t count = body.mesh.triangles.size();
    const Neighbours neighbours = triangleNeighbours(body.mesh);
    std::vector<SurfaceMesh> oldClothes, keptClothes, newClothes;
    for (size_t layer = 1; layer < before.mesh.layers.size(); ++layer) oldClothes.push_back(takeLayer(before, layer).surface());
    for (size_t i = 1; i < worn.size(); ++i) (i < kept ? keptClothes : newClothes).push_back(worn[i].surface());
    const Marks belowOld = coveredBy(body.mesh, oldClothes, jobs), belowKept = coveredBy(body.mesh, keptClothes, jobs),
                belowNew = coveredBy(body.mesh, newClothes, jobs);
    const Marks seenBefore = seenTriangles({before.mesh.restPositions, before.mesh.triangles}, body.mesh, jobs);
    const Marks seenNow = seenTriangles(joined(worn), body.mesh, jobs);
    BodyChange change;
    Marks hidden(count), changed(count);
    for (size_t t = 0; t < count; ++t) {
        hidden[t] = belowOld[t] || !seenBefore[t];
        changed[t] = !belowKept[t] && (belowOld[t] || belowNew[t] || (seenNow[t] && !seenBefore[t]));
    }

    const Marks shown = grown(seenNow, neighbours, kRingsBelowClothes);
    const Marks distrusted = grown(std::move(hidden), neighbours, kEdgeRings);
    const Marks near = grown(std::move(changed), neighbours, kRingsBelowClothes);
    Marks fill(count, 0), empty(count, 0);
    for (size_t t = 0; t < count; ++t) {
        if (belowKept[t] || !near[t] || (shown[t] && !distrusted[t])) continue;
        (shown[t] ? fill : empty)[t] = 1;
        change.clearedTriangles += !shown[t] && body.splats.triangleStart[t] != body.splats.triangleStart[t + 1];
    }
    change.filledTriangles = fillSplats(fill, empty, distrusted, neighbours, body);
    change.noSkin = change.filledTriangles == 0 && std::find(fill.begin(), fill.end(), 1) != fill.end();
    return change;
}

}  // namespace dpl
