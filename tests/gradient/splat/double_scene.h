// SPDX-License-Identifier: Apache-2.0
// A small skinned scene with splats, drawn by the referee (apps/reference). Its loss is the function whose gradients the trainer must
// match. Skinning is written out here because finite differences need poses in double precision.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "apps/reference/reference_renderer.h"
#include "sdk/math/camera.h"
#include "sdk/math/sh.h"

namespace dpl::test {

struct DoubleScene {
    // Constant.
    std::vector<JointData> joints;
    MeshData mesh;  // restPositions: the bind mesh, which defines the rest frame of each triangle
    uint32_t shDegree = 1;
    std::vector<uint32_t> triangle;  // per splat, ascending
    std::vector<uint8_t> flags;
    std::vector<double> sizeFloorM;  // per triangle
    Camerad camera;
    double kappa = 0.3;
    std::vector<Quatd> rotations;
    Vec3d rootTranslation{0};
    PoseCorrectiveData correctives;    // its nodes are the initial values of `nodes`
    MotionMemory before;               // what the motion modes remember of earlier poses
    LightData light;                   // of the scene; as training does, the variables below do not change what it gives
    std::vector<Vec3f> normals;        // at rest; with `light` only
    std::vector<double> pixelWeights;  // 5 per pixel: premultiplied r, g, b, alpha, cloth
    // Variable.
    std::vector<double> rows;   // per splat: u, v, φ, ln s1, ln s2, opacity logit, sh
    std::vector<double> nodes;  // M × K × 4: offset, brightness
    std::vector<Vec3d> rest;
    std::vector<Vec3d> jointTurn;  // R_j ← exp(ω_j) R_j
    Vec3d rootShift{0};

    size_t rowLength() const { return 6 + shCoefficientCount(shDegree) * 3; }
};

inline Mat3d turnMatrix(const Vec3d& w) {
    const double angle = glm::length(w);
    return angle > 0 ? glm::mat3_cast(glm::angleAxis(angle, w / angle)) : Mat3d(1);
}

/** The coefficients of the motion modes: angles by the traces of R·Sᵀ, or what is held where that is more; then lags. */
inline std::vector<double> motionOf(const MotionModeData& m, const std::vector<Mat3d>& local, const MotionMemory& before) {
    std::vector<double> inputs{0}, k;
    double distance2 = 0;
    for (size_t j = 0; j < m.joints.size(); ++j) {
        const Vec4f& q = m.still[j];
        const Mat3d turn = local[m.joints[j]] * glm::transpose(glm::mat3_cast(Quatd(q.w, q.x, q.y, q.z)));
        const double angle = std::acos(0.5 * (turn[0][0] + turn[1][1] + turn[2][2] - 1));
        distance2 += angle * angle;
        inputs.push_back(std::clamp(angle - double(m.rangeRad[j].x), 0.0, double(m.rangeRad[j].y)));
    }
    const double from = double(m.movedFromRad), to = double(m.movedToRad);
    const double t = std::clamp((std::sqrt(distance2) - from) / (to - from), 0.0, 1.0);
    inputs[0] = t * t * (3 - 2 * t);
    std::vector<double> features;
    for (size_t i = 0; i < m.heldCount(); ++i) features.push_back(std::max(before.held[i], inputs[i % inputs.size()]));
    for (size_t i = 0; i < m.lagCount(); ++i) {
        const size_t number = i % 6;
        const Mat3d& turned = local[m.joints[i % m.turnCount() / 6]];
        const double u = turned[int(number / 3)][int(number % 3)] - (number == 0 || number == 4 ? 1 : 0);
        features.push_back(before.lagged[i] - before.earlier[i / m.turnCount()] * u);
    }
    const float* mode = m.modes.data();
    for (const MotionGroupData& g : m.groups) {
        double length2 = 0;
        for (uint32_t c = 0; c < g.columnCount; ++c) {
            k.push_back(0);
            for (const double feature : features) k.back() += double(*mode++) * feature;
            length2 += k.back() * k.back();
        }
        for (size_t c = 1; c <= g.columnCount && length2 > 0; ++c) k[k.size() - c] *= std::min(1.0, double(g.reach) / std::sqrt(length2));
    }
    return k;
}

/** Offset (metres) and change of brightness of every vertex, motion modes included (docs/reference/correctives.md): k = modes·(first two
 * columns of R − identity − mean), limited by reach and reachOffModes, distributed by node weights. */
inline std::vector<glm::dvec4> correction(const DoubleScene& s, const std::vector<Mat3d>& local) {
    const PoseCorrectiveData& c = s.correctives;
    std::vector<glm::dvec4> out(s.rest.size(), glm::dvec4(0));
    if (c.empty()) return out;
    std::vector<double> k(c.modeCount, 0.0);
    double length2 = 0;
    for (uint32_t i = 0; i < c.modeCount; ++i) {
        for (size_t j = 0; j < c.joints.size(); ++j)
            for (int f = 0; f < 6; ++f) {
                const double feature = local[c.joints[j]][f / 3][f % 3] - (f / 3 == f % 3 ? 1 : 0);
                k[i] += double(c.modes[i * c.mean.size() + j * 6 + size_t(f)]) * (feature - double(c.mean[j * 6 + size_t(f)]));
            }
        length2 += k[i] * k[i];
    }
    double off = 0;
    for (size_t j = 0; j < c.joints.size(); ++j)
        for (int f = 0; f < 6; ++f) {
            const double d = local[c.joints[j]][f / 3][f % 3] - (f / 3 == f % 3 ? 1 : 0) - double(c.mean[j * 6 + size_t(f)]);
            off += d * d;
        }
    for (uint32_t i = 0; i < c.modeCount; ++i) {
        double mode = 0;
        for (size_t f = 0; f < c.mean.size(); ++f) mode += double(c.modes[i * c.mean.size() + f]) * double(c.modes[i * c.mean.size() + f]);
        off -= k[i] * k[i] / mode;
    }
    double shorten = std::min(1.0, double(c.reach) / std::sqrt(length2));
    if (off > 0) shorten *= std::min(1.0, double(c.reachOffModes) / std::sqrt(off));
    for (double& x : k) x *= shorten;
    if (!c.motion.empty())
        for (const double x : motionOf(c.motion, local, s.before)) k.push_back(x);
    for (size_t v = 0; v < out.size(); ++v)
        for (int n = 0; n < 4; ++n)
            for (uint32_t i = 0; i < c.columnCount(); ++i) {
                const double* node = s.nodes.data() + (size_t(c.nodeIndices[v][n]) * c.columnCount() + i) * 4;
                out[v] += double(c.nodeWeights[v][n]) / 255.0 * k[i] * glm::dvec4(node[0], node[1], node[2], node[3]);
            }
    return out;
}

/** The light of the scene on a vertex in the pose before any turn. */
inline double lightOn(const DoubleScene& s, size_t vertex) {
    Vec3d turned(0);
    for (int i = 0; i < 4; ++i) {
        Vec3d normal(s.normals[vertex]);
        for (int32_t j = s.mesh.jointIndices[vertex][i]; j >= 0; j = s.joints[size_t(j)].parent) normal = s.rotations[size_t(j)] * normal;
        turned += double(s.mesh.jointWeights[vertex][i]) / 255.0 * normal;
    }
    return referenceIrradiance(s.light, glm::normalize(turned)) / referenceIrradiance(s.light, Vec3d(s.normals[vertex]));
}

/** Draws the scene and returns Σ pixelWeights · channels. */
inline double renderLoss(const DoubleScene& s) {
    std::vector<Mat3d> rotation(s.joints.size()), locals(s.joints.size());
    std::vector<Vec3d> offset(s.joints.size());
    for (size_t j = 0; j < s.joints.size(); ++j) {
        const Mat3d local = locals[j] = turnMatrix(s.jointTurn[j]) * glm::mat3_cast(s.rotations[j]);
        const Vec3d p(s.joints[j].restPosition), shift = p - local * p;
        if (s.joints[j].parent < 0) {
            rotation[j] = local, offset[j] = shift + s.rootTranslation + s.rootShift;
        } else {
            const size_t k = size_t(s.joints[j].parent);
            rotation[j] = rotation[k] * local, offset[j] = rotation[k] * shift + offset[k];
        }
    }
    const std::vector<glm::dvec4> corrected = correction(s, locals);
    std::vector<Vec3d> posed(s.rest.size(), Vec3d(0));
    for (size_t v = 0; v < s.rest.size(); ++v)
        for (int i = 0; i < 4; ++i) {
            const size_t j = s.mesh.jointIndices[v][i];
            posed[v] += double(s.mesh.jointWeights[v][i]) / 255.0 * (rotation[j] * (s.rest[v] + Vec3d(corrected[v])) + offset[j]);
        }
    ReferenceScene scene;
    scene.rest.assign(s.mesh.restPositions.begin(), s.mesh.restPositions.end());
    scene.posed = posed;
    scene.triangles.assign(s.mesh.triangles.begin(), s.mesh.triangles.end());
    scene.shDegree = s.shDegree;
    for (const glm::dvec4& c : corrected) scene.light.push_back(1 + c.w);
    for (size_t v = 0; v < s.normals.size(); ++v) scene.light[v] = std::clamp(scene.light[v] * lightOn(s, v), 0.2, 3.0);
    for (size_t i = 0; i < s.triangle.size(); ++i) {
        const double* row = s.rows.data() + i * s.rowLength();
        const double floor2 = s.sizeFloorM[s.triangle[i]] * s.sizeFloorM[s.triangle[i]];
        ReferenceBoundSplat splat;
        splat.triangle = s.triangle[i], splat.flags = s.flags[i];
        splat.uv = {row[0], row[1]}, splat.phi = row[2];
        splat.scaleM = {std::sqrt(std::exp(2 * row[3]) + floor2), std::sqrt(std::exp(2 * row[4]) + floor2)};
        splat.opacity = 1 / (1 + std::exp(-row[5]));
        splat.sh.assign(row + 6, row + s.rowLength());
        scene.splats.push_back(std::move(splat));
    }
    const ReferenceImage image = renderReference(scene, referenceCamera(s.camera), {.kappaPx2 = s.kappa});
    double loss = 0;
    for (size_t i = 0; i < image.alpha.size(); ++i) {
        const double* w = s.pixelWeights.data() + i * 5;
        loss += w[0] * image.rgb[i * 3] + w[1] * image.rgb[i * 3 + 1] + w[2] * image.rgb[i * 3 + 2] + w[3] * image.alpha[i] +
                w[4] * image.cloth[i];
    }
    return loss;
}

}  // namespace dpl::test
