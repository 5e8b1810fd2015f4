// SPDX-License-Identifier: Apache-2.0
// Level of detail of a frame (docs/reference/level-of-detail.md): the size of a pixel on each subject gives the number of its splats that
// are drawn, within one budget for all.
#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/format/coded_splats.h"
#include "sdk/math/camera.h"
#include "sdk/math/detail.h"
#include "sdk/visibility/general_detail.h"

namespace dpl {

/** Most splats of all subjects of a frame together; 0: no limit. */
struct SplatLimits {
    uint32_t drawn = 0;  // kept and fading
    uint32_t kept = 0;   // with their full opacity
    bool operator==(const SplatLimits&) const = default;
};

/** What the host asks for. */
struct DetailOptions {
    float splatsPerPixel = 0;  // wanted on surface that fills a pixel; 0: all splats at any distance
    uint32_t splatBudget = 0;  // for all subjects of a frame together; 0: no limit
    SplatLimits limits;        // of a governor
    bool off() const { return splatsPerPixel == 0 && splatBudget == 0 && limits.drawn == 0 && limits.kept == 0; }
};

/** Fills splats.groups (measureGroups). The areas of face and hands are then multiplied by 3 and 2, so that they keep more splats than
 * other surface, and all areas divided by one number so that their sum stays. Joints are found by humanoidBones; without them no surface is
 * favoured. The avatar must have passed checkAvatarPosable. */
void measureDetail(const AvatarData& avatar, CodedSplats& splats);

/** Constants of an avatar for level of detail, made at load. Immutable afterwards; any thread. */
class DetailSubject {
public:
    DetailSubject() = default;
    /** splats.groups must be filled (measureDetail). */
    DetailSubject(const AvatarData& avatar, const CodedSplats& splats);

    /** Smallest size of a pixel on the posed surface, metres, over the views: at the smallest view depth that the surface may have, but at
     * least kDetailNearestM. Continuous in pose and views. worldFromRest: jointTransforms. Views and result are in the avatar's own space
     * and metres; scale: metres of the world that one of these takes. Pose correctives are not counted and may carry the surface a little
     * nearer. */
    double finestPixelM(std::span<const Mat3x4f> worldFromRest, std::span<const Cameraf> views, float scale = 1) const;
    /** Upper bound of the splats drawn at a wanted density (1/m²); continuous, and rises with it. */
    double drawnAtMost(double perM2) const;
    /** The largest density at which no more than this many splats are drawn; that of one splat a group if even these are more. */
    double densityWithin(uint32_t splats) const;
    /** The level of detail that draws no more than this many splats; that of one splat a group if even these are more. 0: all splats. */
    SplatDetail detailWithin(uint32_t splats) const;
    uint32_t splatCount() const { return splatCount_; }
    float drawnShare(const SplatDetail& detail) const {
        return splatCount_ == 0 ? 1.0f : float(drawnAtMost(double(detail.perM2)) / splatCount_);
    }
    /** Factor of the SH coefficients above band 0 at a wanted density. */
    float shShare(float perM2) const { return detailShShare(std::min(perM2 * meanAreaM2_, 1.0f)); }
    /** Upper bound of the growth of any splat at a wanted density. */
    float largestGrowth(float perM2) const;

private:
    struct Ball {  // around the rest positions of all vertices that hang on a joint
        uint32_t joint = 0;
        Vec3f centre{0};
        float radiusM = 0;
    };
    struct Bend {  // piece of the curve drawnAtMost: its value at perM2, and the slope from there on
        double perM2 = 0, drawn = 0, slope = 0;
    };
    std::vector<Ball> balls_;
    std::vector<Bend> bends_;
    uint32_t splatCount_ = 0;
    float smallestAreaM2_ = INFINITY, meanAreaM2_ = 0, largestGain_ = 0;
};

/** Surface nearer than this, in metres of the world, counts as this near. Otherwise an avatar that touches the camera would take the whole
 * budget. */
constexpr double kDetailNearestM = 0.25;

/** One subject of a scene set: either `avatar` or `general` is set. */
struct DetailMember {
    const DetailSubject* avatar = nullptr;
    std::span<const Mat3x4f> worldFromRest;  // jointTransforms of this frame's pose
    GeneralDetailSubject* general = nullptr;
    std::span<const Cameraf> views;  // of the frame, in the subject's own space and metres; at most two
    float scale = 1;                 // metres of the world that a metre of the subject takes
    // Set by chooseDetails.
    double pixelM = 1;            // of an avatar: finestPixelM
    SplatDetail detail;           // of an avatar
    GeneralDetail generalDetail;  // of general splats
    float share = 1;              // detail share: upper bound of drawn splats over all
};

/** Upper bounds over all subjects of a frame, before culling. */
struct DetailTotals {
    uint64_t drawn = 0;                        // kept and fading splats
    uint64_t kept = 0;                         // those that keep their full opacity
    uint64_t wantedDrawn = 0, wantedKept = 0;  // the same without limits
};

/** Chooses the detail of all subjects of a frame: splatsPerPixel on each one's finest pixel. When the budget is too small, splatsPerPixel
 * is lowered for all alike; one splat a group stays for any budget. limits lower it further. While limits.kept falls from all splats
 * on, the picture changes continuously; with limits.drawn or splatBudget it would jump, because a fading splat counts as drawn. Each member
 * has all views of the frame, so that both eyes see the same splats. Allocates nothing. */
DetailTotals chooseDetails(const DetailOptions& options, std::span<DetailMember> members);

}  // namespace dpl
