// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/garments/garment_cover.h"

#include <cmath>

#include "reconstruction/subject/shape/edge_uses.h"

namespace dpl {
namespace {

constexpr float kReachM = 0.05f;  // a garment farther off covers nothing
constexpr float kCovers = 0.2f;   // least cosine between the normals of a garment and of the surface that it covers

/** Marks the edges of open meshes, and the corners that lie on one: a point found there is beside the garment, not below it. Other
 *  triangles than those with a border edge have such corners too. */
std::vector<GarmentCover::Border> bordersOf(const SurfaceMesh& mesh) {
    const std::map<Edge, int> uses = edgeUses(mesh.triangles);
    std::vector<bool> onBorder(mesh.positions.size(), false);
    for (const auto& [edge, count] : uses)
        if (count == 1) onBorder[edge.first] = onBorder[edge.second] = true;
    std::vector<GarmentCover::Border> out(mesh.triangles.size());
    for (size_t i = 0; i < mesh.triangles.size(); ++i)
        for (int k = 0; k < 3; ++k) {
            const uint32_t corner = mesh.triangles[i][k];
            out[i].edge[size_t(k)] = uses.at(edgeOf(corner, mesh.triangles[i][(k + 1) % 3])) == 1;
            out[i].corner[size_t(k)] = onBorder[corner];
        }
    return out;
}

}  // namespace

GarmentCover::GarmentCover(const SurfaceMesh& garment) : surface_(garment.positions, garment.triangles), borders_(bordersOf(garment)) {}

std::optional<GarmentCover::Height> GarmentCover::heightOf(const Vec3f& point, const Vec3f& normal) const {
    const SurfacePoint found = surface_.findFacing(point, normal, kCovers, kReachM);
    if (!found.found()) return {};
    bool beside = false;
    const Border& border = borders_[found.triangle];
    for (int k = 0; k < 3; ++k)
        beside |= (border.edge[size_t(k)] && found.barycentric[(k + 2) % 3] < 1e-3f) ||
                  (border.corner[size_t(k)] && found.barycentric[k] > 1 - 1e-3f);
    const Vec3f up = surface_.normalAt(found);
    const float above = glm::dot(point - found.position, up);
    if (beside && found.distanceM > std::abs(above) + 0.001f) return {};
    return Height{above, up};
}

}  // namespace dpl
