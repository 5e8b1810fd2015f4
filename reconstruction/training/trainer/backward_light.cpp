// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/backward_light.h"

#include "reconstruction/training/trainer/sh_backward.h"
#include "sdk/avatar/scene_light.h"

namespace dpl {

void backwardLight(const MeshData& mesh, const LightData& light, std::span<const Vec3f> normals, const PosedMesh& posed,
                   std::span<float> gLight, std::vector<Vec3f>& gNormals) {
    float weights[kIrradianceCoefficients + 1] = {};
    std::copy(light.irradiance.begin(), light.irradiance.end(), weights + 1);
    gNormals.assign(gLight.size(), Vec3f(0));
    for (size_t v = 0; v < gLight.size(); ++v) {
        if (gLight[v] == 0) continue;
        const float drawn = posed.light()[v], scene = posed.sceneLight()[v];
        if (!(drawn > kMinLight && drawn < kMaxLight)) {
            gLight[v] = 0;
            continue;
        }
        const Vec3f turned = turnedNormal(normals[v], mesh.jointIndices[v], mesh.jointWeights[v], posed.worldFromRest());
        const float length = glm::length(turned);
        const Vec3f n = turned / length;
        const float atRest = irradianceOn(light, normals[v]), irradiance = scene * atRest;
        if (length > 1e-6f && irradiance > float(kMinIrradiance) && irradiance < float(kMaxIrradiance)) {
            const Vec3f slope = gLight[v] * drawn / (scene * atRest) * shBasisGradient(n, 2, weights);
            gNormals[v] = (slope - glm::dot(slope, n) * n) / length;
        }
        gLight[v] *= scene;
    }
}

}  // namespace dpl
