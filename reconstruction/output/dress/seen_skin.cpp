// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/dress/seen_skin.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "reconstruction/subject/surface/body_places.h"
#include "reconstruction/subject/surface/mesh_raster.h"
#include "reconstruction/subject/surface/orbit_camera.h"
#include "sdk/avatar/humanoid.h"

namespace dpl {
namespace {

constexpr uint32_t kSidePx = 640;
constexpr uint32_t kAzimuths = 12;
constexpr double kElevations[] = {-0.5, 0, 0.7};  // from below too: legs inside a skirt
constexpr double kStraight = 0.6;                 // least cosine to the normal at which the middle of a small triangle counts
constexpr double kBiasM = 0.002;                  // the depth at the nearest pixel is that of a triangle beside it

// Of the face, in distances between the eyes from their middle: to the outer ends of the brows, above the brows, below the lower lip.
constexpr float kFaceAcross = 1.05f, kFaceAbove = 0.6f, kFaceBelow = 1.45f;

// Skin has a stain where its colour, less that of the skin around, points to the colour of cloth near it: by a share of the way, and by so
// much at least. On a draft dark hair left spots at the temples with 0.2 of the way.
constexpr float kStain = 0.1f, kLeastStain = 0.04f;
constexpr float kSameColour = 0.8f;    // least cosine between the two directions
constexpr float kStainReachM = 0.05f;  // between the middles of the two triangles

/** Whether a raster of the mesh hides a point of it with this unit normal from the camera. */
bool isHidden(const Vec3d& point, const Vec3d& normal, const Camerad& camera, const MeshRaster& raster) {
    const Vec3d view = camera.toView(point), toEye = camera.eye() - point;
    const double cosine = glm::dot(normal, toEye) / glm::length(toEye);
    if (!(view.z > 0) || !(cosine > kStraight)) return true;
    const Vec2d px = camera.pixelOf(view);
    if (!(px.x >= 0 && px.y >= 0 && px.x < raster.widthPx && px.y < raster.heightPx)) return true;
    const float depth = raster.depthM[size_t(px.y) * raster.widthPx + size_t(px.x)];
    return view.z > double(depth) + kBiasM + recedingM(cosine, view.z, camera);
}

}  // namespace

Marks shownTriangles(const SurfaceMesh& mesh, const MeshData& body, const Marks& covered, Jobs& jobs) {
    Vec3f low(1e30f), high(-1e30f);
    for (const Vec3f& p : body.restPositions) low = glm::min(low, p), high = glm::max(high, p);
    const std::vector<Vec3f> normals = restNormals(body), middles = restMiddles(body);
    constexpr size_t kViews = kAzimuths * std::size(kElevations);
    std::vector<Marks> ofView(kViews, Marks(mesh.triangles.size(), 0));
    jobs.forBlocks(kViews, [&](size_t view, uint32_t) {
        const double azimuth = 2 * std::numbers::pi * double(view % kAzimuths) / kAzimuths;
        const Camerad camera = orbitBox(low, high, azimuth, kElevations[view / kAzimuths], kSidePx);
        const MeshRaster raster = rasteriseMesh(mesh.positions, mesh.triangles, camera);
        Marks& shown = ofView[view];
        for (const uint32_t t : raster.triangle)
            if (t != kNoTriangle) shown[t] = 1;
        for (size_t t = 0; t < body.triangles.size(); ++t) {
            if (shown[t] || covered[t]) continue;
            shown[t] = !isHidden(Vec3d(middles[t]), Vec3d(normals[t]), camera, raster);
        }
    });
    Marks shown(mesh.triangles.size(), 0);
    for (const Marks& view : ofView)
        for (size_t t = 0; t < shown.size(); ++t) shown[t] |= view[t];
    return shown;
}

Marks capturedTriangles(const CaptureMapData& map, const MeshData& body) {
    Marks captured(body.triangles.size(), 1);
    if (map.empty()) return captured;
    const std::vector<uint32_t> joints = jointOfTriangles(body);
    const std::vector<Vec3f> normals = restNormals(body);
    for (size_t t = 0; t < captured.size(); ++t) captured[t] = map.sides[joints[t] * kCaptureSides + size_t(sideOf(normals[t]))].pixelM > 0;
    return captured;
}

Marks faceTriangles(std::span<const JointData> joints, const MeshData& body) {
    const std::vector<std::string> bones = humanoidBones(joints);
    const auto left = std::find(bones.begin(), bones.end(), "leftEye"), right = std::find(bones.begin(), bones.end(), "rightEye");
    const bool eyes = left != bones.end() && right != bones.end();
    Vec3f middle(0);
    float between = 0;
    if (eyes) {
        const Vec3f a = joints[size_t(left - bones.begin())].restPosition, b = joints[size_t(right - bones.begin())].restPosition;
        middle = 0.5f * (a + b), between = glm::length(a - b);
    }
    const std::vector<BodyPlace> places = placesOf(joints, body);
    const std::vector<Vec3f> middles = restMiddles(body);
    Marks face(body.triangles.size(), 0);
    for (size_t t = 0; t < face.size(); ++t) {
        if (places[t] != BodyPlace::Face) continue;
        const Vec3f at = middles[t] - middle;
        face[t] = !eyes || (std::abs(at.x) < kFaceAcross * between && at.y < kFaceAbove * between && at.y > -kFaceBelow * between);
    }
    return face;
}

Marks clothColoured(const LayerPart& body, const Marks& edge, std::span<const Vec3f> skin, std::span<const LayerPart> clothes) {
    struct Patch {
        Vec3f middle, colour;
    };
    std::vector<Patch> cloth;
    for (const LayerPart& part : clothes) {
        const std::vector<Vec4f> colours = splatColours(part);
        const std::vector<Vec3f> middles = restMiddles(part.mesh);
        for (size_t t = 0; t < colours.size(); ++t)
            if (colours[t].w > 0) cloth.push_back({middles[t], Vec3f(colours[t]) / colours[t].w});
    }
    const std::vector<Vec4f> colours = splatColours(body);
    const std::vector<Vec3f> middles = restMiddles(body.mesh);
    Marks marked(edge.size(), 0);
    for (size_t t = 0; t < edge.size(); ++t) {
        if (!edge[t] || !(colours[t].w > 0)) continue;
        const Vec3f off = Vec3f(colours[t]) / colours[t].w - skin[t], middle = middles[t];
        marked[t] = std::any_of(cloth.begin(), cloth.end(), [&](const Patch& patch) {
            const Vec3f away = patch.middle - middle, toCloth = patch.colour - skin[t];
            const float differ = glm::length(toCloth);
            if (glm::dot(away, away) > kStainReachM * kStainReachM || !(differ > 0)) return false;
            const float towards = glm::dot(off, toCloth) / differ;
            return towards > std::max(kStain * differ, kLeastStain) && towards > kSameColour * glm::length(off);
        });
    }
    return marked;
}

}  // namespace dpl
