// SPDX-License-Identifier: Apache-2.0
// An avatar, or general splats, in the viewer: its clips, what was bent by hand, and where it stands.
#pragma once

#include <doppel/doppel.hpp>

#include "apps/viewer/orbit_camera.h"
#include "apps/viewer/playback.h"
#include "sdk/core/result.h"

namespace dpl {

/** Turns by these angles about x, then y, then z of avatar space, degrees. */
Quatf rotationOfAngles(const Vec3f& degrees);

struct ViewedSubject {
    struct Clip {
        std::string name;
        double durationS = 0;
    };

    static Result<ViewedSubject> of(doppel::Avatar avatar, std::string file);

    bool isAvatar() const { return !joints.empty(); }  // general splats have no joints
    /** Reads the list of clips again and plays the last one. */
    Status takeNewClip();
    /** Stands it upright and moved aside, then poses it: the clip at timeS, and the angles on top. General splats have no pose. */
    Status pose(double timeS);
    /** Of its rest box and its place, in the world. */
    WorldBox box() const;
    /** How near an eye may come to `point` before it magnifies what the scan saw more than so many times (dplGetNearestDistance), metres.
     *  0 for splats and for files without a capture map. */
    double nearestM(const Vec3d& point, const Vec3d& eye, double focalPx, double magnification) const;

    doppel::Avatar avatar;
    std::string file;  // without folders
    DplAvatarInfo info{};
    DplFileAxes axes{};  // of its file
    std::vector<Clip> clips;
    std::optional<uint32_t> clip;     // nothing: the rest pose
    std::vector<std::string> joints;  // names
    std::vector<Vec3f> byHandDeg;     // for each joint
    float clothStiffness = 1;         // of dplSetClothStiffness
    double asideM = 0;                // along +X of the world
    Mat3d upright{1};                 // world from avatar space: a quarter turn

private:
    explicit ViewedSubject(doppel::Avatar owned) : avatar(std::move(owned)) {}
    std::vector<float> rotations_;
};

/** Distance along +X of each of `count` avatars, in a row around the origin. */
std::vector<double> placesInRow(size_t count);

/** The same for the avatar whose box is nearest to the point. */
double nearestM(const std::vector<ViewedSubject>& subjects, const Vec3d& point, const Vec3d& eye, double focalPx, double magnification);

/** The box around all of them; a person's if there are none. */
WorldBox boxOf(const std::vector<ViewedSubject>& subjects);

}  // namespace dpl
