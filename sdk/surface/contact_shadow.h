// SPDX-License-Identifier: Apache-2.0
// The contact shadow: how much of the sky a posed surface hides from the floor close below it, as a small picture of alpha on the floor
// (docs/reference/surface.md).
//
//   vertices ─► (across, along, height) of the floor ─► lowest surface of 4 × 4 places of each pixel ─► a blot a pixel, wider with height
#pragma once

#include <array>
#include <span>
#include <vector>

#include "sdk/math/types.h"

namespace dpl {

constexpr uint32_t kShadowSidePx = 64;
constexpr float kShadowReachM = 0.3f;              // of the surface from the floor; farther parts cast nothing
constexpr float kShadowBlurM = 0.04f;              // radius of the blot of what lies on the floor; it grows by the height
constexpr float kShadowLeastM = 1;                 // side of the smallest picture
constexpr uint32_t kShadowPlaces = 4;              // a side of a pixel
constexpr double kShadowStep = 1.189207115002721;  // 2^¼: sides are kShadowLeastM times powers of it, so that a walk rarely changes them

/** A plane: dot(up, p) = height. */
struct ShadowFloor {
    Vec3d up{0, 1, 0};  // unit
    double height = 0;  // metres
};

/** alpha: row by row, 255: no light of the sky. The outermost pixels are 0. */
struct ContactShadow {
    std::array<uint8_t, size_t(kShadowSidePx) * kShadowSidePx> alpha{};
    uint8_t darkest = 0;        // largest alpha; 0: nothing is near the floor
    Vec3d corner{0};            // outer corner of the first pixel, on the floor, metres
    Vec3d across{0}, along{0};  // from it along the first row, and along the first column, to the ends of the picture
};

/** Makes contact shadows. It keeps its buffers, so another one of the same mesh allocates nothing. One thread at a time. */
class ContactShadowCaster {
public:
    /** Mesh and floor are of one space. `about`: a point that the picture lies below when nothing is near the floor. leftOut: one a
     * triangle, or empty; what is not 0 casts nothing. The same input gives the same bytes. */
    void cast(std::span<const Vec3f> positions, std::span<const Triangle> triangles, const ShadowFloor& floor, const Vec3d& about,
              ContactShadow& shadow, std::span<const uint8_t> leftOut = {});

private:
    struct Blot {
        float x, y, share, radius;  // pixels
    };
    void keepNear(std::span<const Triangle> triangles, std::span<const uint8_t> leftOut);
    void drawLowest(const Vec2f& corner, float pixelM);
    void gatherBlots(float pixelM);

    std::vector<Vec3f> onFloor_;  // V: across, along, height
    std::vector<Triangle> near_;  // triangles near the floor
    std::vector<float> lowest_;   // distance from the floor at the places of all pixels, at most kShadowReachM
    std::vector<Blot> blots_;
    std::vector<float> sum_;
};

}  // namespace dpl
