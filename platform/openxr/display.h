// SPDX-License-Identifier: Apache-2.0
// What a headset offers and what a session takes of it: views, their sizes, the blend mode. Internal to this room.
#pragma once

#include <algorithm>

#include "platform/openxr/calls.h"
#include "platform/openxr/session.h"

namespace dpl::xr {

struct Display {
    XrSystemId system = XR_NULL_SYSTEM_ID;
    XrViewConfigurationType views = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
    uint32_t viewCount = 0;
    uint32_t groupCount = 0;
    XrExtent2Di sizes[kMaxGroups]{};  // of the views of each group, pixels
    XrEnvironmentBlendMode blendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
    bool canPassThrough = false;  // by XR_FB_passthrough
    bool tracksHands = false;     // by XR_EXT_hand_tracking
    bool tracksBodies = false;    // by XR_FB_body_tracking

    uint32_t viewsOf(uint32_t group) const { return std::min(kMaxViewsOfGroup, viewCount - group * kMaxViewsOfGroup); }
};

Result<Display> chooseDisplay(const Runtime& runtime, Calls& calls, XrSystemId system, const SessionOptions& options);

/** Asks the display for its rate nearest to wishedHz; 0: asks for none. Returns the rate that the display then has, Hz; 0: unknown. */
float chooseRefreshRate(const Runtime& runtime, Calls& calls, XrSession session, float wishedHz);

}  // namespace dpl::xr
