// SPDX-License-Identifier: Apache-2.0
// An avatar, or general splats, in the viewer: its clips, what was bent by hand, and where it stands.
#pragma once

#include <doppel/doppel.hpp>
#include <filesystem>

#include "apps/viewer/face.h"
#include "apps/viewer/joint_regions.h"
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
        std::filesystem::path from;  // the motion file, absolute; empty: the avatar's own file
    };

    static Result<ViewedSubject> of(doppel::Avatar avatar, std::string file);

    bool isAvatar() const { return !joints.empty(); }  // general splats have no joints
    /** Reads the list of clips again and plays the last one. from: the motion file of those that are new. */
    Status takeNewClip(const std::filesystem::path& from = {});
    /** Plays another clip, or the rest pose, from nowS on. Two clips cross-fade. */
    void play(std::optional<uint32_t> other, double nowS);
    /** Stands it upright, turned and moved, then poses it: the clip at the time that the clock says, and the angles on top. General
     *  splats have no pose. nowS: seconds of any clock that never goes back, for cross-fades. */
    Status pose(const Playback& clock, double nowS);
    /** Where it stands, world, metres. */
    Vec3d place() const { return {asideM + movedM.x, 0, movedM.y}; }
    /** Around its rest box as it stands, in the world. */
    WorldBox box() const;
    /** How near an eye may come to `point` before it magnifies what the scan saw more than so many times (dplGetNearestDistance), metres.
     *  0 for splats and for files without a capture map. */
    double nearestM(const Vec3d& point, const Vec3d& eye, double focalPx, double magnification) const;

    doppel::Avatar avatar;
    std::string file;            // without folders
    std::filesystem::path path;  // of it, absolute; empty: the subject has no file of its own
    bool comparable = false;     // its folder has cameras and poses of its scan
    DplAvatarInfo info{};
    DplFileAxes axes{};  // of its file
    std::vector<Clip> clips;
    std::optional<uint32_t> clip;     // nothing: the rest pose
    std::vector<std::string> joints;  // names
    std::vector<BodyRegion> regions;  // of each joint
    std::vector<Vec3f> byHandDeg;     // for each joint
    FaceByHand face;                  // nothing of it: the avatar's face does not move
    float clothStiffness = 1;         // of dplSetClothStiffness
    bool shown = true;
    double asideM = 0;    // along +X of the world
    Vec2f movedM{0};      // by hand, along +X and +Z of the world
    float turnedDeg = 0;  // about the vertical: a quarter turn takes +Z to +X
    Mat3d upright{1};     // world from avatar space: a quarter turn

private:
    explicit ViewedSubject(doppel::Avatar owned) : avatar(std::move(owned)) {}
    /** Seconds for a cross-fade. */
    static constexpr double kFadeS = 0.3;
    Mat3d stand() const;
    Status poseByClips(const Playback& clock, double nowS);

    std::optional<uint32_t> fadesFrom_;
    double fadeBeganS_ = 0;
    std::vector<float> rotations_;
};

/** Distance along +X of each of `count` avatars, in a row around the origin. */
std::vector<double> placesInRow(size_t count);

/** The same for the avatar whose box is nearest to the point. */
double nearestM(const std::vector<ViewedSubject>& subjects, const Vec3d& point, const Vec3d& eye, double focalPx, double magnification);

/** The box around all of them; a person's if there are none. */
WorldBox boxOf(const std::vector<ViewedSubject>& subjects);

}  // namespace dpl
