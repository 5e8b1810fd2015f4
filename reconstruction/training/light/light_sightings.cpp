// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/light/light_sightings.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/subject/surface/mesh_raster.h"
#include "reconstruction/training/light/priors.h"
#include "sdk/avatar/scene_light.h"
#include "sdk/core/task.h"

namespace dpl {
namespace {

constexpr double kLeastCosine = 0.3;                           // between a normal and the way to the eye
constexpr int kEdgePx = 3;                                     // nearer to the outline a pixel may show the background
constexpr double kLeastBrightness = 8, kMostBrightness = 250;  // of 255: darker pixels are noise, brighter ones clipped
constexpr double kLeastPixels = 0.5, kMostPixels = 10;         // that show a vertex; more do not make its place any surer

/** Whether the person is all around a pixel. */
bool isInside(const ImageGrey8& mask, uint32_t x, uint32_t y) {
    const int w = int(mask.widthPx), h = int(mask.heightPx);
    for (const auto& [dx, dy] : {std::pair{-kEdgePx, 0}, {kEdgePx, 0}, {0, -kEdgePx}, {0, kEdgePx}}) {
        const int px = int(x) + dx, py = int(y) + dy;
        if (px < 0 || py < 0 || px >= w || py >= h || !isPerson(mask.pixels[size_t(py) * size_t(w) + size_t(px)])) return false;
    }
    return true;
}

/** The brightness that each vertex shows in a picture: x weighted brightness, y weight in pixels. */
std::vector<Vec2d> brightnessOf(const SeenSurface& surface, const Camerad& camera, const FramePicture& picture) {
    std::vector<Vec2d> sums(surface.positions.size(), Vec2d(0));
    const MeshRaster raster = rasteriseMesh(surface.positions, surface.triangles, camera);
    const Vec3d eye = camera.eye();
    for (size_t pixel = 0; pixel < raster.triangle.size(); ++pixel) {
        if (raster.triangle[pixel] == kNoTriangle) continue;
        if (!isInside(picture.mask, uint32_t(pixel % raster.widthPx), uint32_t(pixel / raster.widthPx))) continue;
        const Triangle& t = surface.triangles[raster.triangle[pixel]];
        const double cosine = frontCosine(surface.positions, t, eye);
        const uint8_t* rgb = &picture.image.pixels[pixel * 3];
        const double brightness = (double(rgb[0]) + rgb[1] + rgb[2]) / 3;
        if (cosine < kLeastCosine || brightness < kLeastBrightness || brightness > kMostBrightness) continue;
        const Vec2f uv = raster.barycentric[pixel];
        const double shares[3] = {1.0 - uv.x - uv.y, uv.x, uv.y};
        for (int k = 0; k < 3; ++k) sums[t[k]] += shares[k] * cosine * Vec2d(brightness, 1);
    }
    return sums;
}

}  // namespace

void addLightSightings(const SeenSurface& surface, const Camerad& camera, bool moving, const FramePicture& picture,
                       std::vector<LightSighting>& sightings) {
    const std::vector<Vec2d> sums = brightnessOf(surface, camera, picture);
    for (uint32_t v = 0; v < sums.size(); ++v) {
        if (sums[v].y < kLeastPixels) continue;
        const double mean = sums[v].x / sums[v].y;
        // The variance of a logarithm is that of the brightness over its square.
        const double weight = surface.trust[v] * std::min(sums[v].y, kMostPixels) * (mean / 255) * (mean / 255);
        const Vec3f& normal = surface.normals[v];
        if (!(glm::length(normal) > 1e-3f)) continue;
        sightings.push_back({v, moving, float(std::log(mean)), float(weight), glm::normalize(normal)});
    }
}

Result<std::vector<LightSighting>> lightSightings(std::span<const JointData> joints, const MeshData& mesh,
                                                  std::span<const TrainFrame> frames, Jobs& jobs) {
    const std::vector<Vec3f> rest = restVertexNormals(mesh);
    const size_t skin = mesh.layers.empty() ? rest.size() : mesh.layers.front().vertexCount;
    std::vector<double> trust(rest.size(), 1.0);
    std::fill(trust.begin() + std::ptrdiff_t(skin), trust.end(), priors::kClothLightTrust);
    std::vector<LightSighting> sightings;
    std::vector<Vec3f> positions, normals(rest.size());
    std::vector<Mat3x4f> worldFromRest;
    for (size_t f = 0; f < frames.size(); ++f) {
        DPL_RETURN_IF_ERROR(taskAt(double(f) / double(frames.size()), "looking at the light"));
        const TrainFrame& frame = frames[f];
        if (frame.kind == FrameKind::StaticCloseup) continue;
        DPL_TRY(const auto picture, frame.picture.get());
        jointTransforms(joints, frame.pose, worldFromRest);
        dpl::skin(mesh, worldFromRest, jobs, positions);
        for (size_t v = 0; v < normals.size(); ++v)
            normals[v] = turnedNormal(rest[v], mesh.jointIndices[v], mesh.jointWeights[v], worldFromRest);
        addLightSightings({positions, normals, trust, mesh.triangles}, frame.camera, frame.kind == FrameKind::Dynamic, *picture, sightings);
    }
    return sightings;
}

}  // namespace dpl
