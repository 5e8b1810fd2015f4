// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/texture_views.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "reconstruction/subject/surface/orbit_camera.h"
#include "sdk/avatar/humanoid.h"

namespace dpl {
namespace {

constexpr double kMostSidePx = 4096;
constexpr double kMarginPx = 2;

/** Cameras around something: so many sides at an elevation. */
struct Ring {
    double elevationRad;
    uint32_t sides;
    float weight;
};
constexpr Ring kBodyRings[] = {{-1.1, 4, 0.01f}, {-0.5, 12, 0.03f}, {0.05, 12, 1}, {0.5, 12, 0.03f}, {1.1, 6, 0.01f}};
constexpr Ring kHeadRings[] = {{-0.5, 8, 0.03f}, {0.05, 12, 1}, {0.6, 8, 0.03f}, {1.2, 4, 0.01f}};
constexpr Ring kHandRings[] = {{-1.2, 4, 1}, {-0.5, 8, 1}, {0.2, 8, 1}, {0.9, 6, 1}};
constexpr double kLeastDistanceM = 0.5;  // well beyond where splats fade in
constexpr double kDistance = 3;          // of the eye, in half diagonals of what it looks at

/** The camera of the ring, cut to `points`, whose pixels have pixelM at the middle. */
Cameraf fittedCamera(std::span<const Vec3f> points, const Vec3d& middle, double distanceM, double azimuthRad, double elevationRad,
                     double pixelM) {
    Camerad camera = orbitCamera(middle, distanceM, azimuthRad, elevationRad, 1, 1, 1);
    Vec2d low(std::numeric_limits<double>::max()), high(-std::numeric_limits<double>::max());
    for (const Vec3f& p : points) {
        const Vec3d view = camera.toView(Vec3d(p));
        const Vec2d slope = Vec2d(view.x, view.y) / view.z;
        low = glm::min(low, slope), high = glm::max(high, slope);
    }
    const Vec2d size = high - low;
    const double focal = std::min(distanceM / pixelM, (kMostSidePx - 2 * kMarginPx) / std::max({size.x, size.y, 1e-9}));
    camera.fx = camera.fy = focal;
    camera.cx = kMarginPx - focal * low.x, camera.cy = kMarginPx - focal * low.y;
    camera.widthPx = uint32_t(focal * size.x + 2 * kMarginPx), camera.heightPx = uint32_t(focal * size.y + 2 * kMarginPx);
    return camera.cast<float>();
}

void addRings(std::span<const Vec3f> points, std::span<const Ring> rings, double pixelM, std::vector<TextureView>& views) {
    if (points.empty()) return;
    Vec3f low = points.front(), high = low;
    for (const Vec3f& p : points) low = glm::min(low, p), high = glm::max(high, p);
    const Vec3d middle = 0.5 * (Vec3d(low) + Vec3d(high));
    const double distanceM = std::max(kDistance * 0.5 * double(glm::length(high - low)), kLeastDistanceM);
    for (const Ring& ring : rings)
        for (uint32_t side = 0; side < ring.sides; ++side)
            views.push_back({fittedCamera(points, middle, distanceM, 2 * std::numbers::pi * side / ring.sides, ring.elevationRad, pixelM),
                             float(pixelM), ring.weight});
}

}  // namespace

std::vector<TexturePart> partOfVertices(const AvatarData& avatar) {
    const BoneMap bones = bonesOf(avatar.joints);
    std::vector<TexturePart> partOfJoint(avatar.joints.size(), TexturePart::Other);
    for (const auto& [bone, part] :
         {std::pair{"head", TexturePart::Head}, {"leftHand", TexturePart::LeftHand}, {"rightHand", TexturePart::RightHand}})
        if (const auto joint = findBone(bones, bone)) partOfJoint[*joint] = part;
    for (size_t j = 0; j < partOfJoint.size(); ++j)  // parents come first
        if (const int32_t parent = avatar.joints[j].parent; parent >= 0 && partOfJoint[j] == TexturePart::Other)
            partOfJoint[j] = partOfJoint[parent];
    std::vector<TexturePart> out;
    for (size_t v = 0; v < avatar.mesh.restPositions.size(); ++v) {
        const glm::u8vec4& weights = avatar.mesh.jointWeights[v];
        int most = 0;
        for (int k = 1; k < 4; ++k)
            if (weights[k] > weights[most]) most = k;
        out.push_back(partOfJoint[avatar.mesh.jointIndices[v][most]]);
    }
    return out;
}

std::vector<TextureView> textureViews(std::span<const Vec3f> positions, std::span<const TexturePart> part,
                                      std::span<const float, kTextureParts> pixelM) {
    std::vector<TextureView> views;
    addRings(positions, kBodyRings, pixelM[size_t(TexturePart::Other)], views);
    for (const TexturePart near : {TexturePart::Head, TexturePart::LeftHand, TexturePart::RightHand}) {
        std::vector<Vec3f> points;
        for (size_t v = 0; v < positions.size(); ++v)
            if (part[v] == near) points.push_back(positions[v]);
        if (near == TexturePart::Head)
            addRings(points, kHeadRings, pixelM[size_t(near)], views);
        else
            addRings(points, kHandRings, pixelM[size_t(near)], views);
    }
    return views;
}

}  // namespace dpl
