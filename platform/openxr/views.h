// SPDX-License-Identifier: Apache-2.0
// Where the eyes are in a frame. Internal to this room.
#pragma once

#include "platform/openxr/display.h"

namespace dpl::xr {

/** Asks for the views of a display time and makes their poses valid. Returns null, or why nothing can be drawn this time (static text). */
Result<const char*> locateViews(Calls& calls, XrSession session, const Display& display, XrSpace world, XrTime time,
                                XrView (&views)[kMaxViews]);

/** The pose in the middle of the first two eyes, or of the only view. views: from locateViews. */
XrPosef headOf(const XrView* views, uint32_t count);

/** The cameras of a group. `views` of that group, from locateViews. */
Status camerasOf(const XrView* views, const GroupImages& images, GroupFrame& frame);

}  // namespace dpl::xr
