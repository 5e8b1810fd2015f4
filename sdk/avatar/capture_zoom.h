// SPDX-License-Identifier: Apache-2.0
// How near a camera may come before an avatar shows less than its scan saw.
#pragma once

#include <span>

#include "sdk/format/avatar_data.h"

namespace dpl {

/** The nearest distance, metres, from which a detail that the scan's pictures just showed is drawn over `magnification` pixels.
 *  point: on or in the avatar, world; the joint of the map nearest to it decides. toEye: from there to the eye; its direction tells the
 * side. Between two sides the sizes are mixed by the squares of the cosines; a side that no picture shows counts as the coarsest that one
 * does. 0 without a map. worldFromRest: of every joint in the current pose. */
float nearestDistanceM(const CaptureMapData& map, std::span<const JointData> joints, std::span<const Mat3x4f> worldFromRest,
                       const Vec3f& point, const Vec3f& toEye, float focalPx, float magnification);

}  // namespace dpl
