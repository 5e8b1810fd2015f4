// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "reconstruction/subject/sample/builtin_parts.h"

namespace dpl {
namespace {

/** The joint that a point with x ≥ 0 follows before weights are smoothed. `part` selects the limb. Planes at its joints divide it. */
uint8_t owner(BodyPart part, const Vec3f& p, const std::vector<JointData>& joints) {
    auto at = [&](int j) { return joints[j].restPosition; };
    // Is p beyond joint b, along the mean direction of the bones a-b and b-c?
    auto past = [&](const Vec3f& a, const Vec3f& b, const Vec3f& c) {
        return glm::dot(p - b, glm::normalize(b - a) + glm::normalize(c - b)) > 0;
    };
    auto spine = [&] {
        if (p.y < 0.985f) return kPelvis;
        if (p.y < 1.100f) return kSpine1;
        if (p.y < 1.205f) return kSpine2;
        return kSpine3;
    };
    // The leg's solid reaches above the groin crease; the part above belongs to the spine and pelvis.
    auto belowGroin = [&] { return p.y < 0.828f + 0.62f * std::clamp(p.x, 0.0f, 0.20f) + (p.z < 0 ? 0.10f * p.z : 0.0f); };
    switch (part) {
        case BodyPart::Head: {
            const float neckPlane = p.y - (1.470f - 0.25f * (p.z + 0.03f)), headPlane = p.y - (1.555f - 0.45f * (p.z + 0.03f));
            if (headPlane > 0 || (p.y > 1.520f && p.z > 0.052f)) return kHead;
            return neckPlane > 0 ? kNeck : kSpine3;
        }
        case BodyPart::Torso: {
            if (p.y > 1.47f - 0.3f * p.x && p.x < 0.075f) return p.y > 1.475f ? kNeck : kSpine3;
            // The shoulder girdle: a wedge around the collarbone and shoulder blade.
            if (p.y > 1.30f && p.x > 0.060f + 0.30f * std::max(0.0f, 1.40f - p.y)) {
                const Vec3f q = p - at(kLeftShoulder);
                return glm::dot(q, glm::normalize(Vec3f(0.90f, -0.42f, 0))) > 0.012f ? kLeftShoulder : kLeftCollar;
            }
            if (p.y < 0.98f && belowGroin()) return kLeftHip;
            return spine();
        }
        case BodyPart::Leg: {
            if (p.y > 0.75f) return belowGroin() ? kLeftHip : spine();
            if (!past(at(kLeftHip), at(kLeftKnee), at(kLeftAnkle))) return kLeftHip;
            const auto foot = leftFootChain();
            // A slanted plane through the ankle separates shin and foot.
            if (glm::dot(p - foot[0], glm::normalize(Vec3f(0, -0.80f, 0.60f))) < -0.004f && p.y > 0.05f) return kLeftKnee;
            Vec3f forward = foot[2] - foot[0];
            forward.y = 0;
            return glm::dot(p - foot[1], glm::normalize(forward)) > 0.004f ? kLeftFoot : kLeftAnkle;
        }
        case BodyPart::Arm: {
            const Vec3f q = p - at(kLeftShoulder);
            if (glm::dot(q, glm::normalize(Vec3f(0.90f, -0.42f, 0))) < 0.012f) return p.y > 1.36f ? kLeftCollar : kSpine3;
            if (!past(at(kLeftShoulder), at(kLeftElbow), at(kLeftWrist))) return kLeftShoulder;
            const HandFrame hand = leftHandFrame();
            return glm::dot(p - hand.wrist, hand.along) > 0 ? kLeftWrist : kLeftElbow;
        }
        case BodyPart::Palm: {
            const HandFrame hand = leftHandFrame();
            return glm::dot(p - hand.wrist, hand.along) > 0 ? kLeftWrist : kLeftElbow;
        }
        default: {
            const Finger finger = Finger(int(part) - int(BodyPart::Index));
            const auto c = leftFingerChain(finger);
            const Vec3f base = finger == kThumb ? c[0] + (c[0] - c[1]) : leftHandFrame().wrist;
            if (!past(base, c[0], c[1])) return kLeftWrist;
            if (!past(c[0], c[1], c[2])) return leftFingerJoint(finger, 0);
            return past(c[1], c[2], c[3]) ? leftFingerJoint(finger, 2) : leftFingerJoint(finger, 1);
        }
    }
}

/** Rounds of diffusion that smooth the weights at a rest position. Each spreads by about 0.6 edge lengths. */
int roundsAt(const Vec3f& world) {
    const Vec3f p(std::abs(world.x), world.y, world.z);
    if (p.x > 0.60f) return 6;                     // fingers
    if (p.x > 0.50f) return 12;                    // wrist
    if (p.y > 1.50f) return p.z > 0.05f ? 4 : 16;  // face (bends little), neck
    if (p.y < 0.15f) return 10;                    // ankle, toes
    if (p.y < 0.65f) return 12;                    // knee
    if (p.x > 0.30f) return 9;                     // elbow
    return 20;                                     // shoulders, spine, hips
}

}  // namespace

std::vector<float> bodyWeights(const BodyField& field, const SurfaceMesh& mesh, const std::vector<JointData>& joints, Jobs& jobs) {
    const size_t count = mesh.positions.size(), jointCount = joints.size();
    std::vector<float> weights(count * jointCount, 0.0f), next;
    std::vector<int> rounds(count);
    jobs.forRange(count, 256, [&](size_t begin, size_t end, uint32_t) {
        for (size_t v = begin; v < end; ++v) {
            const Vec3f& p = mesh.positions[v];
            uint8_t joint = owner(field.part(p), {std::abs(p.x), p.y, p.z}, joints);
            if (p.x < 0) joint = mirroredJoint(joint);
            weights[v * jointCount + joint] = 1;
            rounds[v] = roundsAt(p);
        }
    });
    const auto neighbours = vertexNeighbours(count, mesh.triangles);
    next = weights;
    for (int round = 0; round < 20; ++round) {
        jobs.forRange(count, 256, [&](size_t begin, size_t end, uint32_t) {
            for (size_t v = begin; v < end; ++v) {
                if (round >= rounds[v]) continue;
                float* out = &next[v * jointCount];
                const float* self = &weights[v * jointCount];
                // Nearer neighbours weigh more, so that uneven edge lengths do not distort the blend.
                float total = 0;
                for (uint32_t n : neighbours[v]) total += 1 / (glm::length(mesh.positions[n] - mesh.positions[v]) + 1e-4f);
                for (size_t j = 0; j < jointCount; ++j) out[j] = 0.4f * self[j];
                for (uint32_t n : neighbours[v]) {
                    const float share = 0.6f / ((glm::length(mesh.positions[n] - mesh.positions[v]) + 1e-4f) * total);
                    const float* other = &weights[n * jointCount];
                    for (size_t j = 0; j < jointCount; ++j) out[j] += share * other[j];
                }
            }
        });
        // A vertex after its last round must hold the same values in both arrays.
        std::swap(weights, next);
        for (size_t v = 0; v < count; ++v)
            if (round >= rounds[v])
                continue;
            else if (round + 1 == rounds[v])
                std::copy_n(&weights[v * jointCount], jointCount, &next[v * jointCount]);
    }
    return weights;
}

void cutWeights(const std::vector<float>& dense, size_t jointCount, std::vector<glm::u16vec4>& indices, std::vector<glm::u8vec4>& weights) {
    const size_t count = dense.size() / jointCount;
    indices.assign(count, glm::u16vec4(0));
    weights.assign(count, glm::u8vec4(0));
    for (size_t v = 0; v < count; ++v) {
        const float* w = &dense[v * jointCount];
        uint16_t best[4] = {0, 0, 0, 0};
        float value[4] = {0, 0, 0, 0};
        for (size_t j = 0; j < jointCount; ++j)
            for (int k = 0; k < 4; ++k)
                if (w[j] > value[k]) {
                    for (int m = 3; m > k; --m) value[m] = value[m - 1], best[m] = best[m - 1];
                    value[k] = w[j], best[k] = uint16_t(j);
                    break;
                }
        const float sum = value[0] + value[1] + value[2] + value[3];
        int left = 255, unorm[4];
        for (int k = 3; k >= 1; --k) {
            unorm[k] = sum > 0 ? int(255 * value[k] / sum + 0.5f) : 0;
            left -= unorm[k];
        }
        unorm[0] = left;
        for (int k = 0; k < 4; ++k) {
            weights[v][k] = uint8_t(unorm[k]);
            indices[v][k] = unorm[k] > 0 ? best[k] : uint16_t(0);
        }
    }
}

}  // namespace dpl
