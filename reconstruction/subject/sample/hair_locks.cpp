// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/sample/hair_locks.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/subject/sample/field.h"
#include "reconstruction/subject/sample/random.h"
#include "reconstruction/subject/sample/skeleton.h"
#include "reconstruction/subject/sample/subject.h"

namespace dpl {
namespace {

constexpr double kTau = 6.283185307179586;
constexpr uint64_t kRootStream = 8400;
constexpr uint32_t kSides = 5;  // corners of a lock's cross-section
constexpr uint32_t kShortNodes = 4, kLongNodes = 13;
constexpr float kShortSpacingM = 0.0062f, kLongSpacingM = 0.0115f;  // least distance between roots
constexpr double kTexturePitchM = 0.0137,
                 kTextureSqueeze = 0.35;  // between the pieces of two locks; along a lock, which makes strands longer
constexpr int kTries = 40000;             // of roots; far more than find a place

/** A corner of the cross-section, on the unit circle; the first is on the side that faces away from the body. */
Vec2d cornerOf(uint32_t k) {
    const double angle = kTau * (double(k) / kSides + 0.25);
    return {std::cos(angle), std::sin(angle)};
}

/** Half the width of a lock as a share of its widest, `s` from 0 at the root to 1 at the tip. */
double taper(Hairstyle style, double s) {
    return style == Hairstyle::Long ? (0.75 + 0.25 * std::min(1.0, 4 * s)) * (1 - std::pow(s, 3.0)) : 1 - std::pow(s, 1.4);
}

Vec3f rootOf(const Subject& subject, const HairLock& lock) {
    const Triangle& f = subject.mesh.triangles[lock.rootTriangle];
    const auto& at = subject.mesh.restPositions;
    return lock.rootWeights.x * at[f.x] + lock.rootWeights.y * at[f.y] + lock.rootWeights.z * at[f.z];
}

/** Roots at random places, none nearer to another than `spacingM`. */
std::vector<HairLock> chooseRoots(const Subject& subject, const LayerData& layer, float spacingM) {
    Random random(subject.seed, kRootStream);
    const auto& at = subject.mesh.restPositions;
    std::vector<double> areaUpTo;
    for (uint32_t t = 0; t < layer.triangleCount; ++t) {
        const Triangle& f = subject.mesh.triangles[layer.firstTriangle + t];
        areaUpTo.push_back((areaUpTo.empty() ? 0 : areaUpTo.back()) +
                           double(glm::length(glm::cross(at[f.y] - at[f.x], at[f.z] - at[f.x]))));
    }
    std::vector<HairLock> locks;
    std::vector<Vec3f> roots;
    for (int i = 0; i < kTries; ++i) {
        HairLock lock;
        const double place = random.uniform() * areaUpTo.back();
        lock.rootTriangle =
            layer.firstTriangle + uint32_t(std::upper_bound(areaUpTo.begin(), areaUpTo.end() - 1, place) - areaUpTo.begin());
        const float along = float(std::sqrt(random.uniform())), across = float(random.uniform());
        lock.rootWeights = {1 - along, along * (1 - across), along * across};
        const Vec3f root = rootOf(subject, lock);
        if (std::any_of(roots.begin(), roots.end(), [&](const Vec3f& other) { return glm::distance(root, other) < spacingM; })) continue;
        roots.push_back(root);
        locks.push_back(std::move(lock));
    }
    return locks;
}

}  // namespace

uint32_t HairLocks::verticesPerLock() const {
    return (nodesPerLock - 1) * kSides + 1;
}

void sowLocks(Subject& subject, Hairstyle style) {
    MeshData& mesh = subject.mesh;
    LayerData& layer = mesh.layers.back();
    HairLocks& hair = subject.hair;
    hair.style = style;
    hair.nodesPerLock = style == Hairstyle::Long ? kLongNodes : kShortNodes;
    hair.locks = chooseRoots(subject, layer, style == Hairstyle::Long ? kLongSpacingM : kShortSpacingM);
    hair.firstVertex = uint32_t(mesh.restPositions.size()), hair.firstTriangle = uint32_t(mesh.triangles.size());
    for (const HairLock& lock : hair.locks) {
        const uint32_t first = uint32_t(mesh.restPositions.size()), tip = first + hair.verticesPerLock() - 1;
        const uint32_t anchor = subject.anchor[mesh.triangles[lock.rootTriangle].x];
        for (uint32_t v = first; v <= tip; ++v) {
            mesh.restPositions.push_back(rootOf(subject, lock));
            mesh.jointIndices.push_back({kHead, 0, 0, 0});
            mesh.jointWeights.push_back({255, 0, 0, 0});
            subject.canonical.push_back(Vec3f(0));
            subject.anchor.push_back(anchor);
        }
        for (uint32_t ring = 0; ring + 1 < hair.nodesPerLock; ++ring)
            for (uint32_t k = 0; k < kSides; ++k) {
                const uint32_t a = first + ring * kSides + k, b = first + ring * kSides + (k + 1) % kSides;
                if (ring + 2 == hair.nodesPerLock) {
                    mesh.triangles.push_back({a, b, tip});
                } else {
                    mesh.triangles.push_back({a, b, b + kSides});
                    mesh.triangles.push_back({a, b + kSides, a + kSides});
                }
            }
    }
    layer.vertexCount = uint32_t(mesh.restPositions.size()) - layer.firstVertex;
    layer.triangleCount = uint32_t(mesh.triangles.size()) - layer.firstTriangle;
}

void dressLocks(Subject& subject) {
    const HairLocks& hair = subject.hair;
    MeshData& mesh = subject.mesh;
    std::vector<LockNode> nodes;
    for (const HairLock& lock : hair.locks) nodes.insert(nodes.end(), lock.rest.begin(), lock.rest.end());
    std::vector<Vec3d> at(mesh.restPositions.begin(), mesh.restPositions.end());
    placeLocks(hair, nodes, at);
    const float neckY = subject.joints[kNeck].restPosition.y;
    uint32_t v = hair.firstVertex;
    for (size_t i = 0; i < hair.locks.size(); ++i)
        for (uint32_t k = 0; k < hair.verticesPerLock(); ++k, ++v) {
            const HairLock& lock = hair.locks[i];
            const uint32_t ring = k / kSides;
            mesh.restPositions[v] = Vec3f(at[v]);
            // Each lock has a piece of texture of its own, whose strands run along it.
            const double s = double(ring) / (hair.nodesPerLock - 1), place = kTexturePitchM * double(i);
            subject.canonical[v] =
                Vec3f(place + lock.halfWidthM * taper(hair.style, s) * cornerOf(k % kSides).x, -kTextureSqueeze * s * lock.lengthM, place);
            if (!hair.swing()) continue;
            // What hangs over shoulders and back stays there when a head turns a little.
            const uint8_t head = uint8_t(255 * ramp(float(lock.rest[ring].at.y), neckY - 0.04f, neckY + 0.10f) + 0.5f);
            mesh.jointIndices[v] = {kHead, kSpine3, 0, 0};
            mesh.jointWeights[v] = {head, 255 - head, 0, 0};
        }
}

void placeLocks(const HairLocks& hair, std::span<const LockNode> nodes, std::vector<Vec3d>& vertices) {
    Vec3d* out = vertices.data() + hair.firstVertex;
    const uint32_t count = hair.nodesPerLock;
    for (size_t i = 0; i < hair.locks.size(); ++i) {
        const HairLock& lock = hair.locks[i];
        const LockNode* node = &nodes[i * count];
        for (uint32_t n = 0; n + 1 < count; ++n) {
            const Vec3d along = node[n + 1].at - node[n > 0 ? n - 1 : 0].at;
            const Vec3d across = glm::normalize(glm::cross(along, node[n].facing)), up = glm::normalize(glm::cross(across, along));
            const double s = double(n) / (count - 1), size = taper(hair.style, s);
            for (uint32_t k = 0; k < kSides; ++k) {
                const Vec2d corner = size * cornerOf(k);
                *out++ = node[n].at + lock.halfWidthM * corner.x * across + lock.halfThicknessM * corner.y * up;
            }
        }
        *out++ = node[count - 1].at;
    }
}

}  // namespace dpl
