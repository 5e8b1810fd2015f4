// SPDX-License-Identifier: Apache-2.0
// Points of the scene that still pictures with known cameras show, and the cameras of further pictures found from them
// (docs/reference/cameras.md).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "reconstruction/input/cameras/bundle.h"
#include "reconstruction/input/cameras/features.h"

namespace dpl {

/** A still picture with its camera. */
struct StillPicture {
    Camerad camera;
    Features features;
};

/** The `count` cameras that probably see most of what `camera` sees, by direction of view and place. */
std::vector<size_t> nearestTo(const Camerad& camera, std::span<const Camerad> cameras, size_t count);

/** Pairs of cameras that probably see the same: each with its `nearest` nearest by direction of view and place. First index < second. */
std::vector<std::pair<uint32_t, uint32_t>> nearPairs(std::span<const Camerad> cameras, size_t nearest);

struct TrackSettings {
    size_t nearest = 5;                                    // pictures that each is matched with
    std::vector<std::pair<uint32_t, uint32_t>> morePairs;  // pictures that are matched besides; first < second
    double epipolarPx = 3;  // matches farther than this from each other's epipolar line are wrong. Above the error of the cameras
    double missPx = 6;      // a triangulated point misses none of its features by more
};

/** Points and the features that show them. */
struct Tracks {
    BundleScene scene;                               // of the still pictures; each point has two or more observations
    std::vector<Features> seen;                      // per picture: the features that show a point
    std::vector<std::vector<uint32_t>> pointOfSeen;  // their points
    std::vector<uint32_t> matchesOfPicture;          // matches that agree with the cameras
    double epipolarMissPx = 0;                       // median over the accepted matches: as good as the cameras are
};

/** Matches near pictures, joins matches to tracks and triangulates them. Errors: Cancelled. */
Result<Tracks> findTracks(std::span<const StillPicture> pictures, const LensDistortion& lens, const TrackSettings& settings);

/** A camera that was found for a picture. */
struct PlacedCamera {
    Camerad camera;
    size_t inliers = 0;  // features that agree
    double missPx = 0;   // their median miss
};

/** The camera of a picture, from matches with the still pictures: robust perspective-n-point, then least squares, points fixed.
 *  `intrinsics`: the size and intrinsics of the picture. `near`, which may be null: a camera that is probably near, such as that of the
 *  picture before, which saves most of the matching. nullopt when fewer than kFewestInliers features agree. */
std::optional<PlacedCamera> placePicture(const Features& features, const Camerad& intrinsics, const Tracks& tracks,
                                         const Camerad* near = nullptr);

constexpr size_t kFewestInliers = 20;

}  // namespace dpl
