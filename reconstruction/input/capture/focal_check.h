// SPDX-License-Identifier: Apache-2.0
// Whether the focal length of a scan is the one that its pictures were taken with.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "reconstruction/input/cameras/rays.h"

namespace dpl {

struct SeenKeypoint {
    Camerad camera;
    Vec2d px{0};
    double confidence = 0;  // 0 to 1
};
/** One keypoint of a subject that stands still, or of one moment, in all pictures that show it. */
using KeypointTrack = std::vector<SeenKeypoint>;

/** Distances in pixels between each seen keypoint and its track's triangulated point, with all focal lengths multiplied by `factor` and
 *  all eyes and directions as given. Tracks in fewer than four pictures, and points behind a camera, give none. */
std::vector<double> missesPx(std::span<const KeypointTrack> tracks, double factor);

struct FocalEstimate {
    double factor = 1;         // the pictures agree best when focal lengths are multiplied by this
    double missPx = 0;         // median miss there
    double missAsGivenPx = 0;  // median miss at factor 1
};

/** Searches factors from 1/2 to 2. nullopt when fewer than 20 keypoints can be triangulated. When missAsGivenPx is hardly above missPx,
 *  the pictures do not tell: cameras at one distance about one point see a large subject through a short lens nearly as a small one through
 *  a long lens. Close-ups, at another distance, tell. */
std::optional<FocalEstimate> estimateFocalFactor(std::span<const KeypointTrack> tracks);

}  // namespace dpl
