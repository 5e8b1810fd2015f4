// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/correctives/corrective_strain.h"

#include <cmath>
#include <random>

#include "sdk/avatar/posed_mesh.h"
#include "sdk/core/percentile.h"

namespace dpl {
namespace {

constexpr int kPoses = 64;
constexpr double kMaxTurnRad = 1.05;

/** Uniform in [−1, 1). Equal on every machine, unlike the distributions of std. */
double signedUniform(std::mt19937& random) {
    return double(random()) * 0x1p-31 - 1;
}

Pose randomPose(const AvatarData& avatar, std::mt19937& random) {
    Pose pose = Pose::rest(avatar.joints.size());
    for (const uint32_t joint : avatar.correctives.joints) {
        Vec3d axis(0);
        do axis = {signedUniform(random), signedUniform(random), signedUniform(random)};
        while (glm::dot(axis, axis) > 1 || glm::dot(axis, axis) < 1e-4);
        pose.localRotations[joint] = Quatf(glm::angleAxis(kMaxTurnRad * signedUniform(random), glm::normalize(axis)));
    }
    return pose;
}

}  // namespace

CorrectiveStrain correctiveStrain(const AvatarData& avatar, Jobs& jobs) {
    CorrectiveStrain stress;
    if (avatar.correctives.empty()) return stress;
    const std::vector<RestTriangle<float>> bind = restTriangles(avatar.mesh);
    std::mt19937 random(1);
    PosedMesh posed;
    std::vector<float> offsets, strains, lights;
    const auto& rest = avatar.mesh.restPositions;
    for (int p = 0; p < kPoses; ++p) {
        posed.pose({avatar.joints, avatar.mesh, avatar.correctives, bind}, randomPose(avatar, random), jobs);
        for (size_t v = 0; v < rest.size(); ++v)
            offsets.push_back(glm::length(posed.rest()[v] - rest[v])), lights.push_back(std::abs(posed.light()[v] - 1));
        for (const Triangle& t : avatar.mesh.triangles)
            for (int c = 0; c < 3; ++c) {
                const uint32_t a = t[c], b = t[(c + 1) % 3];
                if (a > b) continue;  // visits each edge once, because its two triangles run along it in opposite directions
                const float length = glm::length(rest[a] - rest[b]);
                if (length > 1e-4f) strains.push_back(glm::length((posed.rest()[a] - rest[a]) - (posed.rest()[b] - rest[b])) / length);
            }
    }
    const auto extreme = [](std::vector<float>& values) { return double(percentile(std::move(values), 0.99)); };
    stress.offsetMm = 1e3 * extreme(offsets), stress.strainPercent = 100 * extreme(strains), stress.lightPercent = 100 * extreme(lights);
    return stress;
}

}  // namespace dpl
