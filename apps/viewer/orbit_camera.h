// SPDX-License-Identifier: Apache-2.0
// A camera that turns around a point, moved by the mouse.
#pragma once

#include "sdk/math/camera.h"

namespace dpl {

/** A box in the world, metres. */
struct WorldBox {
    Vec3d low{0}, high{0};
};

class OrbitCamera {
public:
    static constexpr double kPortraitFovYRad = 0.6;  // a 34° lens, as for a portrait of a whole person
    static constexpr double kLeastFovYRad = 0.17, kMostFovYRad = 1.4;
    static constexpr double kMinDistanceM = 0.2, kMaxDistanceM = 2000, kMaxElevationRad = 1.5;

    /** Turns by a movement of the mouse, pixels. A movement by the height of the picture turns by half a circle. To the right: the camera
     *  goes to its left, so that the avatar seems to follow the mouse. */
    void orbit(double rightPx, double downPx, double heightPx);
    /** Moves sideways so that what lies at the distance of the middle stays under the mouse. */
    void pan(double rightPx, double downPx, double heightPx);
    /** Nearer by a tenth for each step of the wheel; negative: farther. What lies this far right of and below the middle, at the distance
     * of the middle, stays under the mouse. */
    void zoom(double steps, double rightPx = 0, double downPx = 0, double heightPx = 1);
    /** Moves back to this distance where the camera is nearer. */
    void keepAway(double leastM);
    /** Looks at the middle of the box from the current direction, from so far that it fits at every azimuth. aspect: width through height
     *  of the picture. */
    void frame(const WorldBox& box, double aspect);
    /** Turns around this point from now on, from half as far away. */
    void lookCloserAt(const Vec3d& point);
    /** Another lens, radians from the lowest to the highest row. The camera moves so that what is in the middle keeps its size. */
    void setFovY(double rad);
    /** Turns around the middle, keeping everything else. */
    void setAzimuth(double rad) { azimuthRad_ = rad; }

    /** centreXPx: where the middle lies in the picture. */
    Camerad camera(uint32_t widthPx, uint32_t heightPx, double centreXPx) const;

    double azimuthRad() const { return azimuthRad_; }  // 0: from the front (+Z), positive towards +X
    double elevationRad() const { return elevationRad_; }
    double distanceM() const { return distanceM_; }
    double fovYRad() const { return fovYRad_; }
    const Vec3d& middle() const { return middle_; }

private:
    /** Axes of the view in the world: columns right, down, forward. */
    Mat3d worldFromView() const;
    /** From the middle to what is seen so many pixels from it, at its distance, in a picture of this height. */
    Vec3d offsetM(double rightPx, double downPx, double heightPx) const;

    Vec3d middle_{0, 0.9, 0};
    double azimuthRad_ = 0, elevationRad_ = 0.08, distanceM_ = 4.2, fovYRad_ = kPortraitFovYRad;
};

}  // namespace dpl
