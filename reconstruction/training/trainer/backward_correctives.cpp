// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/backward_correctives.h"

#include <algorithm>
#include <cmath>

#include "sdk/avatar/motion_state.h"

namespace dpl {

void backwardSceneLight(const PosedMesh& posed, std::span<float> gLight) {
    for (size_t v = 0; v < posed.sceneLight().size(); ++v) {
        const float drawn = posed.light()[v];
        gLight[v] *= drawn > kMinLight && drawn < kMaxLight ? posed.sceneLight()[v] : 0.0f;
    }
}

void gatherNodes(const PoseCorrectiveData& c, std::span<const Vec4f> nodes, std::span<const Vec3f> gRest, std::span<const float> gLight,
                 std::vector<Vec4f>& gNodes) {
    gNodes.assign(c.nodeCount, Vec4f(0));
    for (size_t v = 0; v < gRest.size(); ++v) {
        Vec4f g(gRest[v], gLight[v]);
        if (g == Vec4f(0)) continue;
        const glm::u8vec4 weight = c.nodeWeights[v];
        float light = 0;
        for (int i = 0; i < 4; ++i)
            if (weight[i] != 0) light += float(weight[i]) * nodes[c.nodeIndices[v][i]].w;
        light = 1 + light * (1.0f / 255.0f);
        if (!(light > kMinLight && light < kMaxLight)) g.w = 0;
        for (int i = 0; i < 4; ++i)
            if (weight[i] != 0) gNodes[c.nodeIndices[v][i]] += float(weight[i]) * (1.0f / 255.0f) * g;
    }
}

void addCorrectivePoseGradient(const PoseCorrectiveData& c, const Pose& pose, std::span<const Vec4f> gNodes, std::span<Vec3d> rotation) {
    const size_t features = c.joints.size() * 6;
    std::vector<double> k(c.modeCount, 0.0), gk(c.columnCount(), 0.0), onMode(c.modeCount, 0.0), column(features), away(features);
    double off2 = 0;
    for (size_t j = 0; j < c.joints.size(); ++j) {
        correctiveFeature(Quatd(pose.localRotations[c.joints[j]]), column.data() + j * 6);
        for (size_t f = j * 6; f < j * 6 + 6; ++f) away[f] = column[f] - double(c.mean[f]), off2 += away[f] * away[f];
        for (uint32_t i = 0; i < c.modeCount; ++i)
            for (size_t f = j * 6; f < j * 6 + 6; ++f) k[i] += double(c.modes[i * features + f]) * away[f];
    }
    for (uint32_t i = 0; i < c.columnCount(); ++i)
        for (uint32_t n = 0; n < c.nodeCount; ++n) gk[i] += double(glm::dot(gNodes[n], c.nodes[size_t(n) * c.columnCount() + i]));
    double length2 = 0, along = 0;
    for (uint32_t i = 0; i < c.modeCount; ++i) {
        double mode2 = 0;
        for (size_t f = 0; f < features; ++f) mode2 += double(c.modes[i * features + f]) * double(c.modes[i * features + f]);
        onMode[i] = mode2 > 0 ? k[i] / mode2 : 0.0;
        length2 += k[i] * k[i], along += k[i] * gk[i], off2 -= k[i] * onMode[i];
    }
    double shortened = 1;
    if (const double length = std::sqrt(length2);
        length > double(c.reach)) {  // k was shortened to length `reach`, so only the gradient orthogonal to k passes
        shortened = double(c.reach) / length;
        for (uint32_t i = 0; i < c.modeCount; ++i) gk[i] = shortened * (gk[i] - along / length2 * k[i]);
    }
    double gOff2 = 0;  // ∂loss/∂(off²), through fade = reachOffModes / off
    if (const double off = std::sqrt(std::max(0.0, off2)); off > double(c.reachOffModes)) {
        const double fade = double(c.reachOffModes) / off;
        gOff2 = -0.5 * fade / off2 * shortened * along;
        for (uint32_t i = 0; i < c.modeCount; ++i) gk[i] *= fade;
    }
    if (!c.motion.empty()) addMotionGradient(c.motion, pose, std::span(gk).subspan(c.modeCount), rotation);
    for (size_t j = 0; j < c.joints.size(); ++j) {
        double g[6] = {};
        for (uint32_t i = 0; i < c.modeCount; ++i)
            for (size_t f = 0; f < 6; ++f) g[f] += (gk[i] - 2 * gOff2 * onMode[i]) * double(c.modes[i * features + j * 6 + f]);
        for (size_t f = 0; f < 6; ++f) g[f] += 2 * gOff2 * away[j * 6 + f];
        addFeatureGradient(Quatd(pose.localRotations[c.joints[j]]), g, rotation[c.joints[j]]);
    }
}

}  // namespace dpl
