// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/scene_light.h"

namespace dpl {
namespace {

constexpr float kLeastLength = 1e-12f;  // of a normal before it is made unit

Vec3f unitOrUp(const Vec3f& v) {
    const float length = glm::length(v);
    return length > kLeastLength ? v / length : Vec3f(0, 1, 0);
}

}  // namespace

void RestNormals::compute(std::span<const Vec3f> positions, std::span<const Triangle> triangles, std::vector<Vec3f>& normals) const {
    // A place has no larger number than any of its vertices. So the sums of the places fit before the normals of the vertices, and made
    // from behind, each normal overwrites only a sum that is needed no more.
    std::vector<Vec3f>& sums = normals;
    sums.assign(positions.size(), Vec3f(0));
    for (const Triangle& t : triangles) {
        const Vec3f area = glm::cross(positions[t.y] - positions[t.x], positions[t.z] - positions[t.x]);
        for (int k = 0; k < 3; ++k) sums[merged_.placeOf[t[k]]] += area;
    }
    for (size_t v = normals.size(); v-- > 0;) normals[v] = unitOrUp(sums[merged_.placeOf[v]]);
}

std::vector<Vec3f> restVertexNormals(const MeshData& mesh) {
    std::vector<Vec3f> normals;
    RestNormals(mesh).compute(mesh.restPositions, mesh.triangles, normals);
    return normals;
}

void lightFactors(const MeshData& mesh, const LightData& light, std::span<const Vec3f> normals, std::span<const Mat3x4f> worldFromRest,
                  Jobs& jobs, std::vector<float>& factors) {
    factors.resize(normals.size());
    jobs.forRange(normals.size(), 2048, [&](size_t begin, size_t end, uint32_t) {
        for (size_t v = begin; v < end; ++v) {
            const Vec3f posed = unitOrUp(turnedNormal(normals[v], mesh.jointIndices[v], mesh.jointWeights[v], worldFromRest));
            factors[v] = irradianceOn(light, posed) / irradianceOn(light, normals[v]);
        }
    });
}

}  // namespace dpl
