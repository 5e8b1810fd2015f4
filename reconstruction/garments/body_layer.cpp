// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/garments/body_layer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "reconstruction/shape/large_steps.h"

namespace dpl {
namespace {

constexpr double kFadeM = 0.015;       // smoothing of the border between skin and clothes
constexpr double kPushSpreadM = 0.02;  // how far neighbours of a pushed vertex follow
constexpr float kReachM = 0.05f;       // a garment farther off does not push
constexpr float kCovers = 0.2f;        // least cosine between the normals of a garment and of the skin that it covers
constexpr int kRounds = 6;

/** Mean weighted by the smoother's kernel: M⁻²(values) / M⁻²(weights). */
std::vector<Vec3f> spread(const LargeSteps& smooth, const std::vector<Vec3f>& values, const std::vector<Vec3f>& weights, float epsilon) {
    std::vector<Vec3f> u(smooth.size()), sum(values.size()), weight(values.size());
    smooth.backward(values, u, 0);
    smooth.offsets(u, sum, 0);
    smooth.backward(weights, u, 0);
    smooth.offsets(u, weight, 0);
    for (size_t v = 0; v < sum.size(); ++v) sum[v] /= std::max(0.0f, weight[v].x) + epsilon;
    return sum;
}

/** Marks the edges of open meshes: a point found there is beside the garment, not below it. */
std::vector<std::array<bool, 3>> borderEdges(const SurfaceMesh& mesh) {
    std::map<std::pair<uint32_t, uint32_t>, int> uses;
    const auto key = [](uint32_t a, uint32_t b) { return std::pair(std::min(a, b), std::max(a, b)); };
    for (const Triangle& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) ++uses[key(t[k], t[(k + 1) % 3])];
    std::vector<std::array<bool, 3>> out(mesh.triangles.size());
    for (size_t i = 0; i < mesh.triangles.size(); ++i)
        for (int k = 0; k < 3; ++k) out[i][size_t(k)] = uses[key(mesh.triangles[i][k], mesh.triangles[i][(k + 1) % 3])] == 1;
    return out;
}

}  // namespace

Result<std::vector<Vec3f>> skinOffsets(const MeshData& body, std::span<const Vec3f> offsets, std::span<const float> skin) {
    DPL_TRY(const LargeSteps smooth, LargeSteps::create(body.restPositions, body.triangles, kFadeM));
    std::vector<Vec3f> share(skin.size()), ones(skin.size(), Vec3f(1));
    for (size_t v = 0; v < skin.size(); ++v) share[v] = Vec3f(skin[v] > 0.5f ? 1.0f : 0.0f);
    share = spread(smooth, share, ones, 1e-6f);
    std::vector<Vec3f> out(offsets.begin(), offsets.end());
    for (size_t v = 0; v < out.size(); ++v) out[v] *= std::clamp(2 * share[v].x - 1, 0.0f, 1.0f);
    return out;
}

Result<std::vector<Vec3f>> pushBelow(std::span<const Vec3f> posedBody, std::span<const Triangle> triangles,
                                     std::span<const SurfaceMesh> garments, float depthM) {
    DPL_TRY(const LargeSteps smooth, LargeSteps::create(posedBody, triangles, kPushSpreadM));
    std::vector<ClosestSurface> surfaces;
    std::vector<std::vector<std::array<bool, 3>>> borders;
    for (const SurfaceMesh& garment : garments) {
        surfaces.emplace_back(garment.positions, garment.triangles);
        borders.push_back(borderEdges(garment));
    }
    std::vector<Vec3f> at(posedBody.begin(), posedBody.end());
    const std::vector<Vec3f> normals = vertexNormals(at, triangles);  // of the body before pushing, which is the smoother one
    for (int round = 0; round < kRounds; ++round) {
        std::vector<Vec3f> push(at.size(), Vec3f(0)), pushed(at.size(), Vec3f(0));
        bool any = false;
        for (size_t v = 0; v < at.size(); ++v)
            for (size_t g = 0; g < surfaces.size(); ++g) {
                const SurfacePoint point = surfaces[g].findFacing(at[v], normals[v], kCovers, kReachM);
                if (!point.found()) continue;
                bool beside = false;
                for (int k = 0; k < 3; ++k) beside |= borders[g][point.triangle][size_t(k)] && point.barycentric[(k + 2) % 3] < 1e-3f;
                const Vec3f normal = surfaces[g].normalAt(point);
                const float above = glm::dot(at[v] - point.position, normal);
                if (beside && point.distanceM > std::abs(above) + 0.001f) continue;
                const float need = above + depthM;
                if (need <= 0 || need <= glm::length(push[v])) continue;
                push[v] = -need * normal;
                pushed[v] = Vec3f(1);
                any = true;
            }
        if (!any) break;
        // Neighbours follow in the first round only. Later rounds move what still lies too high, by as much as it needs.
        const std::vector<Vec3f> follow = round == 0 ? spread(smooth, push, pushed, 0.05f) : push;
        for (size_t v = 0; v < at.size(); ++v) at[v] += pushed[v].x > 0 ? push[v] : follow[v];
    }
    for (size_t v = 0; v < at.size(); ++v) at[v] -= posedBody[v];
    return at;
}

}  // namespace dpl
