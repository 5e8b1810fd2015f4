// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/garments/garment_cover.h"

#include <cmath>

#include "reconstruction/subject/shape/edge_uses.h"

namespace dpl {
namespace {

constexpr float kReachM = 0.05f;  // a garment farther off covers nothing
constexpr float kCovers = 0.2f;   // least cosine between the normals of a garment and of the surface that it covers

/** Marks the edges of open meshes: a point found there is beside the garment, not below it. */
std::vector<std::array<bool, 3>> borderEdges(const SurfaceMesh& mesh) {
    const std::map<Edge, int> uses = edgeUses(mesh.triangles);
    std::vector<std::array<bool, 3>> out(mesh.triangles.size());
    for (size_t i = 0; i < mesh.triangles.size(); ++i)
        for (int k = 0; k < 3; ++k) out[i][size_t(k)] = uses.at(edgeOf(mesh.triangles[i][k], mesh.triangles[i][(k + 1) % 3])) == 1;
    return out;
}

}  // namespace

GarmentCover::GarmentCover(const SurfaceMesh& garment) : surface_(garment.positions, garment.triangles), borders_(borderEdges(garment)) {}

std::optional<GarmentCover::Height> GarmentCover::heightOf(const Vec3f& point, const Vec3f& normal) const {
    const SurfacePoint found = surface_.findFacing(point, normal, kCovers, kReachM);
    if (!found.found()) return {};
    bool beside = false;
    for (int k = 0; k < 3; ++k) beside |= borders_[found.triangle][size_t(k)] && found.barycentric[(k + 2) % 3] < 1e-3f;
    const Vec3f up = surface_.normalAt(found);
    const float above = glm::dot(point - found.position, up);
    if (beside && found.distanceM > std::abs(above) + 0.001f) return {};
    return Height{above, up};
}

}  // namespace dpl
