// SPDX-License-Identifier: Apache-2.0
// What a face does by itself: blinks, small glances, and a stream that has stopped. Formulas and sources: docs/reference/expressions.md.
#pragma once

#include <cstdint>

#include "sdk/avatar/rig.h"
#include "sdk/core/result.h"

namespace dpl {

struct FaceMotion {
    uint32_t seed = 0;    // of the times of blinks and glances
    float blinks = 0;     // 0 to 1: how far the lids close in a blink
    float glances = 0;    // 0 to 1: how far the eyes wander
    float holdS = 0;      // so long a stream's last weights stay; 0: they are no stream's, and stay for good
    int64_t heardNs = 0;  // when the stream gave them
    bool operator==(const FaceMotion&) const = default;
};

constexpr float kMostHoldS = 3600;
constexpr double kFaceFadeS = 0.25;  // of a stream that has stopped

/** InvalidArgument: a number that is not finite or out of its range; the text names it. */
Status checkFaceMotion(const FaceMotion& motion);

/** How far the lids are closed by the blinks of a seed, 0 to 1. A function of its arguments. */
double blinkAt(uint32_t seed, int64_t timeNs);

/** Where the eyes look by the glances of a seed: degrees to the subject's left, and up; at most kFarthestGlanceDeg long. A function of its
 *  arguments. */
Vec2d glanceAt(uint32_t seed, int64_t timeNs);
constexpr double kFarthestGlanceDeg = 5;

/** What a face shows at a time: what was set, less of it once its stream has stopped, and on top what it does by itself. All weights are
 *  held in 0 to 1. A function of its arguments; of a FaceMotion of zeros, `given` itself. The motion has passed checkFaceMotion. */
ExpressionWeights faceAt(const ExpressionWeights& given, const FaceMotion& motion, int64_t timeNs);

}  // namespace dpl
