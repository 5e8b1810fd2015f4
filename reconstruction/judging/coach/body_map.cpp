// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/coach/body_map.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>

#include "reconstruction/judging/coach/edge_blur.h"
#include "reconstruction/subject/surface/mesh_raster.h"
#include "sdk/core/percentile.h"
#include "sdk/core/task.h"
#include "sdk/math/skinning.h"

namespace dpl {
namespace {

constexpr double kLongSidePx = 384;  // of the depth picture that tells what is hidden
constexpr double kSteepest = 0.242;  // cosine of 76°: a pixel is then four times as long on the surface
constexpr double kStraight = 0.5;    // cosine of 60°
constexpr double kBiasM = 0.005;     // the depth picture shows a triangle's neighbours, not its centroid

/** The largest size of a pixel on the plane with this unit normal through `p`, view space: 1 / the least singular value of the derivative
 * of the projection along the plane. */
double largestPixel(const Camerad& c, const Vec3d& p, const Vec3d& normal) {
    const Vec3d s = std::abs(normal.z) < 0.9 ? Vec3d(0, 0, 1) : Vec3d(1, 0, 0);
    const Vec3d u = glm::normalize(glm::cross(normal, s)), v = glm::cross(normal, u);
    const auto along = [&](const Vec3d& d) { return Vec2d(c.fx * (d.x - d.z * p.x / p.z) / p.z, c.fy * (d.y - d.z * p.y / p.z) / p.z); };
    const Vec2d a = along(u), b = along(v);
    const double sum = glm::dot(a, a) + glm::dot(b, b), det = a.x * b.y - a.y * b.x;
    const double least2 = 0.5 * (sum - std::sqrt(std::max(0.0, sum * sum - 4 * det * det)));
    return 1 / std::sqrt(std::max(1e-12, least2));
}

std::optional<float> blurOfPicture(const FramePicture& picture) {
    std::vector<float> sigmas;
    for (const EdgeBlur& edge : edgeBlurs(picture.image, picture.mask)) sigmas.push_back(edge.sigmaPx);
    return blurOf(std::move(sigmas));
}

Camerad smallCamera(const Camerad& camera) {
    const double longer = std::max(camera.widthPx, camera.heightPx);
    return longer > kLongSidePx ? camera.scaled(kLongSidePx / longer) : camera;
}

}  // namespace

std::vector<Sight> lookAt(std::span<const Vec3f> positions, std::span<const Triangle> triangles, const Camerad& camera,
                          const ImageGrey8* mask) {
    const Camerad small = smallCamera(camera);
    const MeshRaster raster = rasteriseMesh(positions, triangles, small);
    std::vector<Sight> out(triangles.size());
    const Vec3d eye = camera.eye();
    for (size_t t = 0; t < triangles.size(); ++t) {
        const Vec3d a(positions[triangles[t].x]), b(positions[triangles[t].y]), c(positions[triangles[t].z]);
        const Vec3d middle = (a + b + c) / 3.0, view = camera.toView(middle);
        if (!(view.z > 0.05)) continue;
        const Vec3d cross = glm::cross(b - a, c - a), toEye = eye - middle;
        const double doubleArea = glm::length(cross);
        if (!(doubleArea > 1e-14)) continue;
        const Vec3d normal = cross / doubleArea;
        const double cosine = glm::dot(normal, toEye) / glm::length(toEye);
        if (!(cosine > kSteepest)) continue;
        const Vec2d px = camera.pixelOf(view), seen = small.pixelOf(view);
        if (!(px.x >= 0 && px.y >= 0 && px.x < camera.widthPx && px.y < camera.heightPx)) continue;
        if (mask && !isPerson(mask->pixels[size_t(px.y) * mask->widthPx + size_t(px.x)])) continue;
        const size_t x = std::min<size_t>(size_t(seen.x), raster.widthPx - 1), y = std::min<size_t>(size_t(seen.y), raster.heightPx - 1);
        if (view.z > double(raster.depthM[y * raster.widthPx + x]) + kBiasM + 1.5 * recedingM(cosine, view.z, small)) continue;
        out[t] = {float(largestPixel(camera, view, camera.viewFromWorldRotation * normal)), cosine > kStraight};
    }
    return out;
}

void addPicture(std::vector<SeenTriangle>& map, std::span<const Sight> sights, float blurPx) {
    for (size_t t = 0; t < map.size(); ++t) {
        const float pixelM = sights[t].pixelM;
        if (!(pixelM > 0)) continue;
        SeenTriangle& to = map[t];
        const float detail = detailSizeM(pixelM, blurPx);
        if (!to.seen() || detail < to.detailM) to.pixelM = pixelM, to.blurPx = blurPx, to.detailM = detail;
        to.views += sights[t].straight;
    }
}

Result<std::vector<SeenTriangle>> mapBody(const MeshData& surface, std::span<const JointData> joints,
                                          std::span<const PosedPicture> pictures, Jobs& jobs) {
    struct Measured {
        std::vector<Sight> sights;
        std::optional<float> blurPx;
        Status read;
    };
    std::vector<Measured> measured(pictures.size());
    std::atomic<bool> cancelled{false};
    std::atomic<size_t> done{0};
    jobs.forBlocks(pictures.size(), [&](size_t i, uint32_t worker) {
        if (cancelled) return;
        std::vector<Mat3x4f> worldFromRest;
        jointTransforms(joints, pictures[i].pose, worldFromRest);
        std::vector<Vec3f> positions(surface.restPositions.size());
        for (size_t v = 0; v < positions.size(); ++v)
            positions[v] = skinVertex(surface.restPositions[v], surface.jointIndices[v], surface.jointWeights[v], worldFromRest.data());
        const auto picture = pictures[i].picture.get();
        if (!picture) {
            measured[i].read = picture.error();
            return;
        }
        const ImageGrey8& mask = (*picture)->mask;
        measured[i] = {
            lookAt(positions, surface.triangles, pictures[i].camera, mask.pixels.empty() ? nullptr : &mask), blurOfPicture(**picture), {}};
        const size_t count = ++done;
        if (worker == 0 && !taskAt(double(count) / double(pictures.size()), formatText("{} still pictures", pictures.size())))
            cancelled = true;
    });
    if (cancelled) return fail(Code::Cancelled, "stopped after {} of {} pictures", done.load(), pictures.size());

    for (const Measured& m : measured) DPL_RETURN_IF_ERROR(m.read);
    std::vector<float> known;
    for (const Measured& m : measured)
        if (m.blurPx) known.push_back(*m.blurPx);
    const float usual = percentile(known, 0.5);
    std::vector<SeenTriangle> map(surface.triangles.size());
    for (const Measured& m : measured) addPicture(map, m.sights, m.blurPx.value_or(usual));
    return map;
}

}  // namespace dpl
