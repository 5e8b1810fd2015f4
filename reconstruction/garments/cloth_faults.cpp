// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/distill/penetration.h"

#include <algorithm>

#include "reconstruction/shape/closest_surface.h"
#include "sdk/avatar/posed_mesh.h"

namespace dpl {
namespace {

constexpr float kReachM = 0.1f;

}  // namespace

double garmentPenetration(const AvatarData& avatar, std::span<const Pose> poses, Jobs& jobs) {
    const MeshData& mesh = avatar.mesh;
    const auto body = std::find_if(mesh.layers.begin(), mesh.layers.end(), [](const LayerData& layer) { return layer.role == "body"; });
    std::vector<uint32_t> clothes;
    for (const LayerData& layer : mesh.layers)
        for (uint32_t v = 0; layer.role == "garment" && v < layer.vertexCount; ++v) clothes.push_back(layer.firstVertex + v);
    if (body == mesh.layers.end() || body->triangleCount == 0 || clothes.empty()) return 0;
    const std::span<const Triangle> skin(mesh.triangles.data() + body->firstTriangle, body->triangleCount);
    const std::vector<RestTriangle<float>> bind = restTriangles(mesh);
    PosedMesh posed;
    std::vector<uint8_t> inside(clothes.size());
    size_t count = 0;
    for (const Pose& pose : poses) {
        posed.pose({avatar.joints, mesh, avatar.correctives, bind}, pose, jobs);
        const ClosestSurface surface(posed.positions(), skin);
        jobs.forRange(clothes.size(), 256, [&](size_t begin, size_t end, uint32_t) {
            for (size_t i = begin; i < end; ++i) inside[i] = surface.signedDistance(posed.positions()[clothes[i]], kReachM) < 0;
        });
        count += size_t(std::count(inside.begin(), inside.end(), uint8_t(1)));
    }
    return poses.empty() ? 0 : double(count) / double(clothes.size() * poses.size());
}

}  // namespace dpl
