// SPDX-License-Identifier: Apache-2.0
// The user at the time of a picture: where the head and the joints of the hands are, seen in a mirror or from another space.
#pragma once

#include <bitset>

#include "platform/openxr/poses.h"

namespace dpl::xr {

/** The 26 joints of a hand (XrHandJointEXT). The -z of a joint points along its bone to the finger tip, y out of the back of the hand. */
struct Hand {
    XrPosef joints[XR_HAND_JOINT_COUNT_EXT]{};
    uint32_t located = 0;  // bit n: the pose of joint n is known

    bool has(uint32_t joint) const { return located >> joint & 1; }
};

/** The 70 joints of a body (XrBodyJointFB), without legs. */
struct Body {
    XrPosef joints[XR_BODY_JOINT_COUNT_FB]{};
    std::bitset<XR_BODY_JOINT_COUNT_FB> located;
    XrPosef rest[XR_BODY_JOINT_COUNT_FB]{};  // of the same person, in a space of its own
    uint32_t skeleton = 0;                   // counts the rest poses that the runtime has told; 0: none yet
};

struct User {
    XrPosef head = kIdentityPose;  // looks along -z, y up
    Hand hands[2];                 // left, right; without XR_EXT_hand_tracking no joint is located
    Body body;                     // without XR_FB_body_tracking no joint is located
};

/** Whether a runtime knows a joint: flags and pose are valid, and the pose lies within 1 km. Makes the pose's rotation exact. */
bool isLocated(XrSpaceLocationFlags flags, XrPosef& pose);

/** A user of space b in space a. */
User moved(const XrPosef& aFromB, const User& user);

/** A plane. normal: unit, towards the user. */
struct Mirror {
    XrVector3f point{0, 0, 0}, normal{0, 0, 1};
};

/** The image of a pose. Its position is reflected about the plane. A mirror turns left into right, so the image's x axis is the image of
 * -x; its y and z axes are the images of y and z. So the image of a head looks out of the mirror, and that of a left hand is a right hand.
 *  mirrored(mirrored(x)) is x. */
XrPosef mirrored(const Mirror& mirror, const XrPosef& pose);
/** The image of a user: poses as above, and the left hand is the image of the right one. It has no body. */
User mirrored(const Mirror& mirror, const User& user);

/** Where a user's body stands: below the head, its +z where the body faces. The body turns only when the head has turned more than 50
 *  degrees away from it, so looking around does not turn it. */
class Stance {
public:
    /** In the space of the user's poses, whose y points up. Call it once a frame. */
    XrPosef of(const User& user);

private:
    float yawRad_ = 0;
    bool known_ = false;
};

}  // namespace dpl::xr
