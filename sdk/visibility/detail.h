// SPDX-License-Identifier: Apache-2.0
// Level of detail of a frame (docs/adr/0010): how large a pixel is on each avatar that is drawn, and how many of its splats that leaves,
// all of them within one budget.
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

/** What the host asks for. */
struct DetailOptions {
    float splatsPerPixel = 0;  // wanted of each avatar's surface that fills a pixel; 0: all its splats, however far it is
    uint32_t splatBudget = 0;  // of all that is drawn together; 0: no limit
    bool off() const { return splatsPerPixel == 0 && splatBudget == 0; }
};

/** Fills splats.groups: measureGroups, and the areas of face and hands are counted larger than they are, so that these keep three and two
 * times the splats of other surface; all areas together stay what they are. Joints by humanoidBones; an avatar without these has none to
 * favour. The avatar must be fit to be drawn. */
void measureDetail(const AvatarData& avatar, CodedSplats& splats);

/** What an avatar is to all that, made when it is loaded. */
class DetailSubject {
public:
    DetailSubject() = default;
    /** splats: with groups. */
    DetailSubject(const AvatarData& avatar, const CodedSplats& splats);

    /** Size of a pixel, metres, at the nearest point that the posed surface may have, in the view that sees it finest: along the axis of
     * that view, at least at kDetailNearestM. Moves continuously with pose and views. worldFromRest: jointTransforms. Pose correctives may
     * carry the surface a little nearer. */
    double finestPixelM(std::span<const Mat3x4f> worldFromRest, std::span<const Cameraf> views) const;
    /** Splats that are drawn at most at a wanted density; continuous and rising with it. */
    double drawnAtMost(double perM2) const;
    uint32_t splatCount() const { return splatCount_; }
    float drawnShare(const SplatDetail& detail) const {
        return splatCount_ == 0 ? 1.0f : float(drawnAtMost(double(detail.perM2)) / splatCount_);
    }
    /** Of the SH beyond coefficient 0 at a density; no growth of a splat there is larger than largestGrowth. */
    float shShare(float perM2) const { return detailShShare(std::min(perM2 * meanAreaM2_, 1.0f)); }
    float largestGrowth(float perM2) const;

private:
    struct Ball {  // in the rest pose, about all vertices that hang on a joint
        uint32_t joint = 0;
        Vec3f centre{0};
        float radiusM = 0;
    };
    struct Bend {  // of drawnAtMost: from this density on
        double perM2 = 0, drawn = 0, slope = 0;
    };
    std::vector<Ball> balls_;
    std::vector<Bend> bends_;
    uint32_t splatCount_ = 0;
    float smallestAreaM2_ = INFINITY, meanAreaM2_ = 0, largestGain_ = 0;
};

constexpr double kDetailNearestM =
    0.25;  // nearer surface counts as this near, so that whom the camera touches does not take the whole budget

/** One of those that a frame draws together: an avatar, or general splats. */
struct DetailMember {
    const DetailSubject* avatar = nullptr;
    std::span<const Mat3x4f> worldFromRest;  // jointTransforms of this frame's pose
    GeneralDetailSubject* general = nullptr;
    double pixelM = 1;            // of an avatar: finestPixelM
    SplatDetail detail;           // what is chosen, for an avatar
    GeneralDetail generalDetail;  // ... for general splats
    float share = 1;              // of its splats that are drawn at most
};

/** Sets the last four of each: splatsPerPixel on its finest pixel, and less of that for all alike when the budget is too small. One splat
 * of 128 neighbours is kept, whatever the budget. For all views of the frame at once (two at most), so that both eyes see the same splats.
 * Gives how many are drawn at most. Allocates nothing. */
uint64_t chooseDetails(const DetailOptions& options, std::span<const Cameraf> views, std::span<DetailMember> members);

}  // namespace dpl
