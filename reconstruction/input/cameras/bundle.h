// SPDX-License-Identifier: Apache-2.0
// Bundle adjustment: cameras, shared intrinsics and points that together explain where pictures show the points
// (docs/reference/cameras.md).
//
//   min Σ ρ( π(f·K, k1, R X + t) − x ),   ρ: Cauchy's loss
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "reconstruction/input/cameras/camera_check.h"
#include "sdk/core/result.h"

namespace dpl {

/** A point as one picture shows it. */
struct BundleObservation {
    uint32_t camera = 0, point = 0;
    Vec2d px{0};  // in the stored picture, lens distortion included
};

/** Everything that is known or sought. */
struct BundleScene {
    std::vector<Camerad> cameras;
    LensDistortion lens;        // of all cameras; k1 and k2 only
    std::vector<Vec3d> points;  // world
    std::vector<BundleObservation> observations;
};

struct BundleSettings {
    bool findFocal = false;   // one factor of all focal lengths
    bool findLens = false;    // k1
    std::vector<bool> fixed;  // cameras that stay, one flag each; empty: none. Points of fixed scenes stay with fixedPoints
    bool fixedPoints = false;
    double lossPx = 1;     // misses far above count little
    double outlierPx = 6;  // after each round, observations that miss by more, and by more than 6 median misses, no longer count
    uint32_t rounds = 3;
    uint32_t stepsPerRound = 40;
};

/** How a bundle adjustment ended. Misses are medians over all observations, px. */
struct BundleEnd {
    double missBeforePx = 0, missAfterPx = 0;
    double focalFactor = 1;    // by which the focal lengths were multiplied
    size_t used = 0;           // observations that count at the end
    std::vector<size_t> seen;  // of each camera: observations that count at the end
    std::string how;           // Ceres' message
};

/** Pixel of a world point in the stored picture: Brown's k1 and k2, then the pinhole. z of the view must be positive. */
Vec2d storedPixel(const Camerad& camera, const LensDistortion& lens, const Vec3d& world);

/** Improves `scene` in place. Where no camera is fixed the first one is held, though it may be wrong, so bring the world back with
 *  alignCameras. Runs on one thread and is deterministic. InvalidArgument: an index is out of range, a number is not finite, or fewer than
 *  ten observations have their point in front of the camera. Internal: Ceres failed; the scene is then unchanged. Cancelled. */
Result<BundleEnd> adjustBundle(BundleScene& scene, const BundleSettings& settings);

}  // namespace dpl
