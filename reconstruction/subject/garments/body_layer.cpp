// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/garments/body_layer.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/subject/garments/garment_cover.h"
#include "reconstruction/subject/shape/smooth_mean.h"

namespace dpl {
namespace {

constexpr double kFadeM = 0.015;       // smoothing of the border between skin and clothes
constexpr double kPushSpreadM = 0.02;  // how far neighbours of a pushed vertex follow
constexpr int kRounds = 6;

}  // namespace

Result<std::vector<Vec3f>> skinOffsets(const MeshData& body, std::span<const Vec3f> offsets, std::span<const float> skin) {
    DPL_TRY(const LargeSteps smooth, LargeSteps::create(body.restPositions, body.triangles, kFadeM));
    std::vector<Vec3f> share(skin.size());
    for (size_t v = 0; v < skin.size(); ++v) share[v] = Vec3f(skin[v] > 0.5f ? 1.0f : 0.0f);
    share = smoothMean(smooth, share, std::vector<float>(skin.size(), 1.0f), 1e-6f);
    std::vector<Vec3f> out(offsets.begin(), offsets.end());
    for (size_t v = 0; v < out.size(); ++v) out[v] *= std::clamp(2 * share[v].x - 1, 0.0f, 1.0f);
    return out;
}

Result<std::vector<Vec3f>> pushBelow(std::span<const Vec3f> posedBody, std::span<const Triangle> triangles,
                                     std::span<const SurfaceMesh> garments, float depthM) {
    DPL_TRY(const LargeSteps smooth, LargeSteps::create(posedBody, triangles, kPushSpreadM));
    std::vector<GarmentCover> covers(garments.begin(), garments.end());
    std::vector<Vec3f> at(posedBody.begin(), posedBody.end());
    const std::vector<Vec3f> normals = vertexNormals(at, triangles);  // of the body before pushing, which is the smoother one
    for (int round = 0; round < kRounds; ++round) {
        std::vector<Vec3f> push(at.size(), Vec3f(0));
        std::vector<float> pushed(at.size(), 0.0f);
        bool any = false;
        for (size_t v = 0; v < at.size(); ++v)
            for (const GarmentCover& cover : covers) {
                const auto height = cover.heightOf(at[v], normals[v]);
                const float need = height ? height->aboveM + depthM : 0;
                if (need <= 0 || need <= glm::length(push[v])) continue;
                push[v] = -need * height->normal;
                pushed[v] = 1;
                any = true;
            }
        if (!any) break;
        // Neighbours follow in the first round only. Later rounds move what still lies too high, by as much as it needs.
        const std::vector<Vec3f> follow = round == 0 ? smoothMean(smooth, push, pushed, 0.05f) : push;
        for (size_t v = 0; v < at.size(); ++v) at[v] += pushed[v] > 0 ? push[v] : follow[v];
    }
    for (size_t v = 0; v < at.size(); ++v) at[v] -= posedBody[v];
    return at;
}

}  // namespace dpl
