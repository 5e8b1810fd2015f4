// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/garment_collision.h"
#include "reconstruction/subject/garments/priors.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/subject/surface/clothed_layers.h"
#include "reconstruction/training/trainer/backward_mesh.h"

namespace dpl {
namespace {

constexpr size_t kGrain = 256;    // vertices a job
constexpr float kReachM = 0.05f;  // deeper inside, the nearest skin is that of another limb or of the other side
constexpr float kDepthM = 0.01f;  // depth at which a vertex is pulled as hard as the picture pulls

std::span<const Triangle> bodyTriangles(const MeshData& mesh) {
    const LayerData* body = bodyLayer(mesh);
    return body ? std::span(mesh.triangles).subspan(body->firstTriangle, body->triangleCount) : std::span<const Triangle>();
}

}  // namespace

GarmentCollision::GarmentCollision(const MeshData& mesh) : body_(mesh.restPositions, bodyTriangles(mesh)) {
    if (!bodyTriangles(mesh).empty()) garmentVertices_ = garmentVertices(mesh);
}

double GarmentCollision::pull(const MeshData& mesh, const PosedMesh& posedMesh, std::span<const Vec3f> pictureGradient, float factor,
                              Jobs& jobs, std::vector<Vec3f>& gradient) {
    const std::span<const Vec3f> posed = posedMesh.positions(), rest = posedMesh.rest();
    gradient.assign(rest.size(), Vec3f(0));
    double square = 0, pulled = 0;
    for (const uint32_t v : garmentVertices_)
        if (const double g2 = double(glm::dot(pictureGradient[v], pictureGradient[v])); g2 > 0 && std::isfinite(g2)) square += g2, ++pulled;
    if (pulled == 0) return 0;
    const float stiffness = factor * float(std::sqrt(square / pulled)) / kDepthM;
    body_.move(posed);
    std::vector<double> energy((garmentVertices_.size() + kGrain - 1) / kGrain, 0.0);
    jobs.forBlocks(energy.size(), [&](size_t block, uint32_t) {
        for (size_t i = block * kGrain; i < std::min(garmentVertices_.size(), (block + 1) * kGrain); ++i) {
            const uint32_t v = garmentVertices_[i];
            const SurfacePoint skin = body_.find(posed[v], kReachM);
            if (!skin.found()) continue;
            const Vec3f away = posed[v] - skin.position;
            const bool inside = body_.isInside(posed[v], skin);
            const float missing = priors::kClothClearanceM - (inside ? -skin.distanceM : skin.distanceM);
            if (missing <= 0) continue;
            const Vec3f outward = skin.distanceM > 1e-6f ? (inside ? -away : away) / skin.distanceM : body_.normalAt(skin);
            const glm::u8vec4 w8 = mesh.jointWeights[v];
            const float weights[4] = {float(w8.x) / 255.0f, float(w8.y) / 255.0f, float(w8.z) / 255.0f, float(w8.w) / 255.0f};
            gradient[v] = backwardSkinVertex<float>(rest[v], -stiffness * missing * outward, mesh.jointIndices[v], weights,
                                                    posedMesh.worldFromRest().data(), nullptr);
            energy[block] += 0.5 * double(stiffness) * missing * missing;
        }
    });
    double sum = 0;
    for (const double e : energy) sum += e;
    return sum;
}

}  // namespace dpl
