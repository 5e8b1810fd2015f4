// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/garments/resting_hands.h"

#include <algorithm>
#include <array>

#include "reconstruction/subject/garments/body_follow.h"
#include "reconstruction/subject/garments/body_parts.h"

namespace dpl {
namespace {

enum Part : uint8_t { kElsewhere, kLeftUpper, kLeftLower, kRightUpper, kRightLower };  // of the arms; lower: forearm and hand

constexpr float kOneSided = 0.5f;  // length of the mean normal; half a tube has 0.64

constexpr Part upperOf(uint8_t lower) {
    return lower == kLeftLower ? kLeftUpper : kRightUpper;
}
constexpr bool isLower(uint8_t part) {
    return part == kLeftLower || part == kRightLower;
}

/** The part that moves most of each triangle. */
std::vector<uint8_t> armsOfTriangles(const MeshData& body, std::span<const JointData> joints) {
    return partsOfTriangles(body, partsOfJoints(joints, {{"leftUpperArm", kLeftUpper},
                                                         {"rightUpperArm", kRightUpper},
                                                         {"leftLowerArm", kLeftLower},
                                                         {"leftHand", kLeftLower},
                                                         {"rightLowerArm", kRightLower},
                                                         {"rightHand", kRightLower}}));
}

/** Vertices of `piece` on a forearm or hand that it does not clothe. parts: of the arm that each vertex lies on. */
std::vector<uint32_t> underRestingHands(const SurfaceMesh& piece, std::span<const uint8_t> parts) {
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

/** Whether cloth on a forearm and hand goes round it: then its normals cancel. */
bool isSleeve(const SurfaceMesh& piece, std::span<const uint8_t> parts, uint8_t lower) {
    Vec3f sum(0);
    float area = 0;
    for (const Triangle& t : piece.triangles) {
        if (parts[t.x] != lower || parts[t.y] != lower || parts[t.z] != lower) continue;
        const Vec3f normal = glm::cross(piece.positions[t.y] - piece.positions[t.x], piece.positions[t.z] - piece.positions[t.x]);
        sum += normal, area += glm::length(normal);
    }
    return glm::length(sum) < kOneSided * area;
}

std::vector<uint8_t> partsBelow(std::span<const SurfacePoint> below, std::span<const uint8_t> ofTriangle) {
    std::vector<uint8_t> parts;
    for (const SurfacePoint& point : below) parts.push_back(ofTriangle[point.triangle]);
    return parts;
}

/** wornBodyBelow(). ofTriangle: armsOfTriangles() of the body. */
std::vector<SurfacePoint> wornBelow(const SurfaceMesh& piece, const MeshData& body, std::span<const Vec3f> posedBody,
                                    std::span<const uint8_t> ofTriangle) {
    std::vector<SurfacePoint> below = bodyBelow(piece, ClosestSurface(posedBody, body.triangles));
    const std::vector<uint32_t> touched = underRestingHands(piece, partsBelow(below, ofTriangle));
    if (touched.empty()) return below;
    std::vector<uint32_t> armless;  // numbers of triangles that no arm moves
    std::vector<Triangle> triangles;
    for (uint32_t t = 0; t < ofTriangle.size(); ++t)
        if (ofTriangle[t] == kElsewhere) armless.push_back(t), triangles.push_back(body.triangles[t]);
    if (armless.empty()) return below;
    const std::vector<SurfacePoint> others = bodyBelow(piece, ClosestSurface(posedBody, triangles));
    for (const uint32_t v : touched) {
        below[v] = others[v];
        below[v].triangle = armless[others[v].triangle];
    }
    return below;
}

}  // namespace

std::vector<SurfacePoint> wornBodyBelow(const SurfaceMesh& piece, const MeshData& body, std::span<const JointData> joints,
                                        std::span<const Vec3f> posedBody) {
    return wornBelow(piece, body, posedBody, armsOfTriangles(body, joints));
}

WornPiece withArmsApart(const SurfaceMesh& piece, const MeshData& body, std::span<const JointData> joints,
                        std::span<const Vec3f> posedBody) {
    const std::vector<uint8_t> ofTriangle = armsOfTriangles(body, joints);
    WornPiece worn{piece, wornBelow(piece, body, posedBody, ofTriangle)};
    const std::vector<uint8_t> parts = partsBelow(worn.below, ofTriangle);
    std::array<bool, 5> sleeve{};
    for (const uint8_t lower : {kLeftLower, kRightLower}) sleeve[lower] = isSleeve(piece, parts, lower);
    const auto touches = [&](uint32_t arm, uint32_t other) {
        return sleeve[parts[arm]] && parts[other] != parts[arm] && parts[other] != upperOf(parts[arm]);
    };
    std::vector<uint32_t> twinOf(piece.positions.size(), 0);  // 0: none
    for (Triangle& t : worn.mesh.triangles) {
        const Triangle was = t;
        for (int c = 0; c < 3; ++c)
            for (const int other : {(c + 1) % 3, (c + 2) % 3}) {
                if (!touches(was[c], was[other]) || t[other] != was[other]) continue;
                uint32_t& twin = twinOf[was[c]];
                if (twin == 0) {
                    twin = uint32_t(worn.mesh.positions.size());
                    worn.mesh.positions.push_back(piece.positions[was[c]]);
                    worn.below.push_back(worn.below[was[other]]);
                }
                t[c] = twin;
            }
    }
    return worn;
}

}  // namespace dpl
