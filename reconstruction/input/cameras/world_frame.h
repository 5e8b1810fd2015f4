// SPDX-License-Identifier: Apache-2.0
// Turns the world of found cameras, whose scale, origin and axes are arbitrary, into Doppel's: metres, +Y up, the floor at y = 0, the
// subject at the origin facing +Z (docs/reference/cameras.md).
#pragma once

#include <optional>
#include <span>
#include <string>

#include "reconstruction/input/cameras/align_cameras.h"

namespace dpl {

/** Places of the standing subject, in the world of the cameras; each may be unknown. */
struct StandingPoints {
    std::optional<Vec3d> headTop, shoulderL, shoulderR, hipL, hipR, ankleL, ankleR;  // L: the subject's own left
};

struct WorldEvidence {
    std::span<const Camerad> stills;  // of the walk round the subject
    std::span<const Vec3d> points;    // of the background
    StandingPoints subject;
    double heightM = 0;  // of the subject, head top to floor; 0: unknown
};

struct WorldFrame {
    Similarity worldFromCameras;
    bool metric = false;      // the scale follows from heightM. Otherwise a subject of kAssumedHeightM is assumed
    bool floorFound = false;  // up is the floor's normal. Otherwise it is the mean of the cameras' own up, good to a degree or two
    bool facingFound = false;
};

/** nullopt without two cameras that look at something, or when up cannot be told (cameras that look straight down). */
std::optional<WorldFrame> findWorldFrame(const WorldEvidence& evidence);

/** The normal, towards `up`, and a point of the floor: the plane of most points below all `stills`. nullopt when fewer than 60 points lie
 * on one within 15 degrees of level. */
struct FloorPlane {
    Vec3d normal{0, 1, 0}, point{0};
    size_t points = 0;
};
std::optional<FloorPlane> findFloor(std::span<const Vec3d> points, std::span<const Camerad> stills, const Vec3d& up);

constexpr double kAssumedHeightM = 1.7;

}  // namespace dpl
