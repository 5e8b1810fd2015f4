// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/garments/resting_hands.h"

#include <algorithm>
#include <array>

#include "sdk/avatar/humanoid.h"

namespace dpl {
namespace {

enum Part : uint8_t { kElsewhere, kLeftUpper, kLeftLower, kRightUpper, kRightLower };  // of the arms; lower: forearm and hand

constexpr Part upperOf(Part lower) {
    return lower == kLeftLower ? kLeftUpper : kRightUpper;
}
constexpr bool isLower(Part part) {
    return part == kLeftLower || part == kRightLower;
}

/** The part that each joint moves; joints below a named bone belong to it. */
std::vector<Part> partsOfJoints(std::span<const JointData> joints) {
    const std::vector<std::string> bones = humanoidBones(joints);
    std::vector<Part> parts(joints.size(), kElsewhere);
    for (size_t j = 0; j < joints.size(); ++j) {  // parents come first
        if (joints[j].parent >= 0) parts[j] = parts[size_t(joints[j].parent)];
        if (bones[j] == "leftUpperArm") parts[j] = kLeftUpper;
        if (bones[j] == "rightUpperArm") parts[j] = kRightUpper;
        if (bones[j] == "leftLowerArm" || bones[j] == "leftHand") parts[j] = kLeftLower;
        if (bones[j] == "rightLowerArm" || bones[j] == "rightHand") parts[j] = kRightLower;
    }
    return parts;
}

/** The part that moves most of each triangle. */
std::vector<Part> partsOfTriangles(const MeshData& body, std::span<const JointData> joints) {
    const std::vector<Part> ofJoint = partsOfJoints(joints);
    std::vector<Part> parts;
    for (const Triangle& t : body.triangles) {
        std::array<int, 5> weight{};
        for (int c = 0; c < 3; ++c)
            for (int k = 0; k < 4; ++k) weight[ofJoint[body.jointIndices[t[c]][k]]] += body.jointWeights[t[c]][k];
        parts.push_back(Part(std::max_element(weight.begin(), weight.end()) - weight.begin()));
    }
    return parts;
}

}  // namespace

std::vector<uint32_t> clothUnderRestingHands(const SurfaceMesh& piece, std::span<const SurfacePoint> below, const MeshData& body,
                                             std::span<const JointData> joints) {
    const std::vector<Part> ofTriangle = partsOfTriangles(body, joints);
    std::vector<Part> parts;
    for (const SurfacePoint& point : below) parts.push_back(ofTriangle[point.triangle]);
    const auto lowerCount = size_t(std::count_if(parts.begin(), parts.end(), isLower));
    if (lowerCount == 0 || 2 * lowerCount > parts.size()) return {};
    // Cloth on forearm and hand belongs to the arm where a path over cloth on that arm leads to its upper part.
    const auto neighbours = vertexNeighbours(parts.size(), piece.triangles);
    std::vector<uint8_t> worn(parts.size(), 0);
    std::vector<uint32_t> front;
    for (uint32_t v = 0; v < parts.size(); ++v)
        if (parts[v] == kLeftUpper || parts[v] == kRightUpper) worn[v] = 1, front.push_back(v);
    while (!front.empty()) {
        std::vector<uint32_t> next;
        for (const uint32_t v : front)
            for (const uint32_t n : neighbours[v])
                if (!worn[n] && isLower(parts[n]) && (parts[v] == parts[n] || parts[v] == upperOf(parts[n])))
                    worn[n] = 1, next.push_back(n);
        front = std::move(next);
    }
    std::vector<uint32_t> under;
    for (uint32_t v = 0; v < parts.size(); ++v)
        if (isLower(parts[v]) && !worn[v]) under.push_back(v);
    return under;
}

std::vector<uint32_t> trianglesWithoutArms(const MeshData& body, std::span<const JointData> joints) {
    const std::vector<Part> parts = partsOfTriangles(body, joints);
    std::vector<uint32_t> rest;
    for (uint32_t t = 0; t < parts.size(); ++t)
        if (parts[t] == kElsewhere) rest.push_back(t);
    return rest;
}

}  // namespace dpl
