// SPDX-License-Identifier: Apache-2.0
// Brightness of each vertex in the light of the scene, by its posed normal. docs/reference/light.md
#pragma once

#include <span>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/core/jobs.h"
#include "sdk/format/avatar_data.h"
#include "sdk/math/merge_vertices.h"
#include "sdk/math/skinning.h"

namespace dpl {

/** Normals of a mesh at rest. Vertices that are at one place when it is made share a normal, so light has no seams. */
class RestNormals {
public:
    explicit RestNormals(const MeshData& mesh) : merged_(mergeVertices(mesh.restPositions)) {}

    /** Unit normals weighted by area, V, resized. A vertex without area gets +Y. positions: V; triangles: those of the mesh. */
    void compute(std::span<const Vec3f> positions, std::span<const Triangle> triangles, std::vector<Vec3f>& normals) const;

private:
    MergedVertices merged_;
};
std::vector<Vec3f> restVertexNormals(const MeshData& mesh);

/** factors: V, resized; irradiance on the posed normal over that on the normal at rest. normals: V, of RestNormals. */
void lightFactors(const MeshData& mesh, const LightData& light, std::span<const Vec3f> normals, std::span<const Mat3x4f> worldFromRest,
                  Jobs& jobs, std::vector<float>& factors);

/** A normal turned by the mean of its joints, not of unit length. */
inline Vec3f turnedNormal(const Vec3f& normal, const glm::u16vec4& joints, const glm::u8vec4& weights,
                          std::span<const Mat3x4f> worldFromRest) {
    return Mat3f(blendedTransform(joints, weights, worldFromRest.data())) * normal;
}

/** Irradiance on a unit normal, over its mean. */
template <class T>
inline T irradianceOn(const LightData& light, const Vec3<T>& normal) {
    const auto& c = light.irradiance;
    return Formulas<T>::irradianceOn(normal, Vec3<T>(T(c[0]), T(c[1]), T(c[2])), Vec3<T>(T(c[3]), T(c[4]), T(c[5])),
                                     Vec2<T>(T(c[6]), T(c[7])));
}

}  // namespace dpl
