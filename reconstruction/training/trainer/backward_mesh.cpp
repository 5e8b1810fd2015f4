// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/backward_mesh.h"

#include <algorithm>

namespace dpl {

VertexIncidence::VertexIncidence(std::span<const Triangle> triangles, size_t vertexCount) : offset(vertexCount + 1, 0) {
    for (const Triangle& t : triangles)
        for (int c = 0; c < 3; ++c) ++offset[t[c] + 1];
    for (size_t v = 0; v < vertexCount; ++v) offset[v + 1] += offset[v];
    corners.resize(triangles.size() * 3);
    std::vector<uint32_t> next(offset.begin(), offset.end() - 1);
    for (size_t t = 0; t < triangles.size(); ++t)
        for (int c = 0; c < 3; ++c) corners[next[triangles[t][c]]++] = uint32_t(t * 3 + size_t(c));
}

void backwardSkin(const MeshData& mesh, std::span<const JointData> joints, const PosedMesh& posed, std::span<const Vec3f> gPosed,
                  Jobs& jobs, std::vector<Vec3f>& gRest, PoseGradient<double>& pose) {
    constexpr size_t kGrain = 2048;
    const std::span<const Vec3f> rest = posed.rest();
    const std::span<const Mat3x4f> worldFromRest = posed.worldFromRest();
    const size_t count = rest.size(), blocks = (count + kGrain - 1) / kGrain, jointCount = joints.size();
    gRest.resize(count);
    std::vector<JointWrench<float>> partial(blocks * jointCount);
    jobs.forBlocks(blocks, [&](size_t block, uint32_t) {
        JointWrench<float>* wrench = partial.data() + block * jointCount;
        for (size_t v = block * kGrain; v < std::min(count, (block + 1) * kGrain); ++v) {
            const Vec3f g = gPosed[v];
            if (g == Vec3f(0)) {
                gRest[v] = Vec3f(0);
                continue;
            }
            const glm::u8vec4 w8 = mesh.jointWeights[v];
            const float weights[4] = {float(w8.x) / 255.0f, float(w8.y) / 255.0f, float(w8.z) / 255.0f, float(w8.w) / 255.0f};
            gRest[v] = backwardSkinVertex(rest[v], g, mesh.jointIndices[v], weights, worldFromRest.data(), wrench);
        }
    });
    std::vector<JointWrench<double>> wrench(jointCount);
    std::vector<Mat3x4d> transforms(jointCount);
    for (size_t j = 0; j < jointCount; ++j) transforms[j] = Mat3x4d(worldFromRest[j]);
    for (size_t block = 0; block < blocks; ++block)
        for (size_t j = 0; j < jointCount; ++j) {
            wrench[j].force += Vec3d(partial[block * jointCount + j].force);
            wrench[j].torque += Vec3d(partial[block * jointCount + j].torque);
        }
    backwardJoints<double>(joints, transforms, wrench, pose);
}

}  // namespace dpl
