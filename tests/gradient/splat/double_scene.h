// A small skinned, splatted scene rendered in double, pixel by pixel, from the formulas: the function that gradients are checked on.
#pragma once

#include <algorithm>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/math/binding.h"
#include "sdk/math/projection.h"
#include "sdk/math/sh.h"

namespace dpl::test {

struct DoubleScene {
    // Constant.
    std::vector<JointData> joints;
    MeshData mesh;                        // weights, triangles; restPositions are the bind mesh (D is taken from them)
    uint32_t shDegree = 1;
    std::vector<uint32_t> triangle;       // per splat, ascending
    std::vector<uint8_t> flags;
    std::vector<double> sizeFloorM;       // per triangle
    Camerad camera;
    double kappa = 0.3;
    std::vector<Quatd> rotations;
    Vec3d rootTranslation{0};
    std::vector<double> pixelWeights;     // 5 a pixel: premultiplied r, g, b, alpha, cloth
    // Variable.
    std::vector<double> rows;             // per splat: u, v, φ, ln s1, ln s2, opacity logit, sh
    std::vector<Vec3d> rest;
    std::vector<Vec3d> jointTurn;         // R_j ← exp(ω_j) R_j
    Vec3d rootShift{0}, cameraTurn{0}, cameraShift{0};

    size_t rowLength() const { return 6 + shCoefficientCount(shDegree) * 3; }
};

inline Mat3d turnMatrix(const Vec3d& w) {
    const double angle = glm::length(w);
    return angle > 0 ? glm::mat3_cast(glm::angleAxis(angle, w / angle)) : Mat3d(1);
}

/** Σ pixelWeights · channels. */
inline double renderLoss(const DoubleScene& s) {
    std::vector<Mat3d> rotation(s.joints.size());
    std::vector<Vec3d> offset(s.joints.size());
    for (size_t j = 0; j < s.joints.size(); ++j) {
        const Mat3d local = turnMatrix(s.jointTurn[j]) * glm::mat3_cast(s.rotations[j]);
        const Vec3d p(s.joints[j].restPosition), shift = p - local * p;
        if (s.joints[j].parent < 0) {
            rotation[j] = local, offset[j] = shift + s.rootTranslation + s.rootShift;
        } else {
            const size_t k = size_t(s.joints[j].parent);
            rotation[j] = rotation[k] * local, offset[j] = rotation[k] * shift + offset[k];
        }
    }
    std::vector<Vec3d> posed(s.rest.size(), Vec3d(0));
    for (size_t v = 0; v < s.rest.size(); ++v)
        for (int i = 0; i < 4; ++i) {
            const size_t j = s.mesh.jointIndices[v][i];
            posed[v] += double(s.mesh.jointWeights[v][i]) / 255.0 * (rotation[j] * s.rest[v] + offset[j]);
        }
    Camerad camera = s.camera;
    const Mat3d turn = turnMatrix(s.cameraTurn);
    camera.viewFromWorldRotation = turn * camera.viewFromWorldRotation;
    camera.viewFromWorldTranslation = turn * camera.viewFromWorldTranslation + s.cameraShift;
    const Vec3d eye = camera.eye();
    struct Record {
        Footprint<double> f;
        double opacity, cloth;
        Vec3d colour;
    };
    std::vector<Record> records;
    for (size_t i = 0; i < s.triangle.size(); ++i) {
        const double* row = s.rows.data() + i * s.rowLength();
        const Triangle& corner = s.mesh.triangles[s.triangle[i]];
        const auto bind = restTriangle(Vec3d(s.mesh.restPositions[corner.x]), Vec3d(s.mesh.restPositions[corner.y]), Vec3d(s.mesh.restPositions[corner.z]));
        const auto frame = poseTriangle(bind, posed[corner.x], posed[corner.y], posed[corner.z]);
        if (!frame.valid) continue;
        const double floor2 = s.sizeFloorM[s.triangle[i]] * s.sizeFloorM[s.triangle[i]];
        Vec3d a1, a2;
        splatAxes(frame, row[2], std::sqrt(std::exp(2 * row[3]) + floor2), std::sqrt(std::exp(2 * row[4]) + floor2), a1, a2);
        const Vec3d centre = splatCentre(frame, Vec2d(row[0], row[1]));
        const Mat3d& r = camera.viewFromWorldRotation;
        Record record;
        record.f = projectSplat(camera, JacobianClamp<double>(camera), camera.toView(centre), r * a1, r * a2, s.kappa);
        if (!record.f.visible) continue;
        record.opacity = record.f.compensation * nearFade(record.f.depthM) / (1 + std::exp(-row[5]));
        if (s.flags[i] & kSplatSingleFace) record.opacity *= singleFaceGate(frame.normal, centre, eye);
        record.cloth = s.flags[i] & kSplatCloth ? 1 : 0;
        record.colour = shColour(row + 6, s.shDegree, glm::transpose(frame.worldFromRest) * glm::normalize(centre - eye));
        records.push_back(record);
    }
    std::stable_sort(records.begin(), records.end(), [](const Record& a, const Record& b) { return a.f.depthM < b.f.depthM; });
    double loss = 0;
    for (uint32_t y = 0; y < camera.heightPx; ++y)
        for (uint32_t x = 0; x < camera.widthPx; ++x) {
            double t = 1, out[5] = {};
            for (const Record& p : records) {
                if (t <= kMinTransmittance) break;
                const double dx = x + 0.5 - p.f.centrePx.x, dy = y + 0.5 - p.f.centrePx.y;
                const double sigma = 0.5 * (p.f.conicA * dx * dx + p.f.conicC * dy * dy) + p.f.conicB * dx * dy;
                const double alpha = std::min(kMaxAlpha, p.opacity * std::exp(-sigma));
                if (alpha < kMinAlpha) continue;
                const double w = alpha * t;
                out[0] += w * p.colour.x, out[1] += w * p.colour.y, out[2] += w * p.colour.z, out[4] += w * p.cloth;
                t *= 1 - alpha;
            }
            out[3] = 1 - t;
            for (int c = 0; c < 5; ++c) loss += s.pixelWeights[(size_t(y) * camera.widthPx + x) * 5 + size_t(c)] * out[c];
        }
    return loss;
}

}  // namespace dpl::test
